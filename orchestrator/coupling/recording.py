"""What a run records besides all outputs: glob patterns in, columns of local variables out.

The outputs are fetched at every step, because the coupling needs them; these only when a row is recorded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..errors import InputError
from ..fmi.file import NUMERIC, Fmu
from ..results.columns import MODAL_VELOCITIES, matches


def recorded(fmus: Mapping[str, Fmu], wanted: Sequence[str] | None) -> list[tuple[str, str]]:
    """Return component and name of the local variables that match a pattern, component by component, in call order.

    Parameters
    ----------
    fmus : FMUs by component name
    wanted : patterns such as 'wheel.modal_velocity_*'; None for `MODAL_VELOCITIES`, where the wheel has them

    Raises
    ------
    InputError
        If a pattern matches no variable that can be recorded, or nothing but texts: a row of results has a fixed size.
    """
    local = [(c, v) for c, fmu in fmus.items() for v in fmu.names("local") if fmu.variables[v].type in NUMERIC]
    outputs = [(c, v) for c, fmu in fmus.items() for v in fmu.names("output") if fmu.variables[v].type in NUMERIC]
    texts = [f"{c}.{name}" for c, fmu in fmus.items() for name, v in fmu.variables.items() if v.type == "String"]
    for pattern in wanted or ():
        found = [name for name in texts if matches(name, pattern)]
        if found and not any(matches(f"{c}.{v}", pattern) for c, v in local + outputs):
            raise InputError(
                f"record {pattern}: {found[0]} is a text; results hold numbers only, a text can be connected but not "
                "recorded"
            )
        if not any(matches(f"{c}.{v}", pattern) for c, v in local + outputs):
            raise InputError(
                f"record {pattern}: matches no output and no local variable that is a number; "
                f"a pattern looks like {MODAL_VELOCITIES}"
            )
    chosen = (MODAL_VELOCITIES,) if wanted is None else wanted
    return [(c, v) for c, v in local if any(matches(f"{c}.{v}", pattern) for pattern in chosen)]


def patterns(texts: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the patterns of a repeatable option; 'none' stands for no pattern at all.

    >>> patterns(["none"]), patterns([]), patterns(["rail.*"])
    ((), None, ('rail.*',))
    """
    if not texts:
        return None
    return () if list(texts) == ["none"] else tuple(texts)
