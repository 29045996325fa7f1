"""The cycles of an assembled system: modes, contact law and radiating areas are those of its FMUs."""

from __future__ import annotations

from collections.abc import Callable

from ..coupling.assembly import Assembly
from ..errors import InputError
from ..stability.linear_model import model_of_assembly
from .catalogue import NEAR, Catalogue, find_cycles
from .level import Radiator
from .model import SquealModel


def model_of(assembly: Assembly, step: float) -> SquealModel:
    """Return the wheel, rail and contact of an assembled system.

    Parameters
    ----------
    step : communication step, at which a structure that shows no modes is identified [s]
    """
    return SquealModel.of(model_of_assembly(assembly, step))


def cycles_of(
    assembly: Assembly,
    step: float,
    *,
    tone_hz: float | None = None,
    with_stability: bool = True,
    down_to: float = NEAR,
    report: Callable[[str, int, int], None] = lambda _what, _done, _all: None,
) -> Catalogue:
    """Return the cycles of a system; parameters as of `model_of` and `find_cycles`.

    Raises
    ------
    InputError
        If there is no cycle, none at the frequency asked for, or the system's behaviour is not known.
    """
    model = model_of(assembly, step)
    found = find_cycles(
        model, tone_hz=tone_hz, with_stability=with_stability, down_to=down_to,
        radiator=Radiator.of(model.wheel), report=report,
    )  # fmt: skip
    if not found.cycles:
        raise InputError(found.quiet_words())
    if tone_hz is not None:
        found.near(tone_hz)
    return found
