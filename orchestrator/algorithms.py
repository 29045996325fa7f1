"""Master algorithms as data: in which order the components of a system step. No FMI calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .errors import InputError


@dataclass(frozen=True)
class Coupling:
    """What an algorithm needs to know of a system.

    Attributes
    ----------
    feeds : for each component the components that its inputs come from
    feedthrough : for each component whether its outputs depend on its inputs within a step; None: it does not tell
    """

    feeds: Mapping[str, frozenset[str]]
    feedthrough: Mapping[str, bool | None]


Stages = list[list[str]]


def jacobi(coupling: Coupling) -> Stages:
    """Everybody steps at once, each with the outputs of the step before. For comparison: it delays every force."""
    return [list(coupling.feeds)]


def staggered(coupling: Coupling) -> Stages:
    """Components without algebraic dependence step first, the others after those that feed them.

    A component that does not tell its dependencies counts as dependent if it is fed by all others, which is where a
    coupling element stands; else as independent.
    """
    dependent = [name for name in coupling.feeds if _depends(coupling, name)]
    stages: Stages = [[name for name in coupling.feeds if name not in dependent]]
    waiting = list(dependent)
    while waiting:
        ready = [name for name in waiting if not coupling.feeds[name] & set(waiting) - {name}]
        if not ready:
            raise InputError(
                f"algebraic loop: the outputs of {', '.join(waiting)} depend on each other within a step; "
                "use --algorithm jacobi"
            )
        stages.append(ready)
        waiting = [name for name in waiting if name not in ready]
    return [stage for stage in stages if stage]


def _depends(coupling: Coupling, name: str) -> bool:
    told = coupling.feedthrough[name]
    if told is not None:
        return told
    return len(coupling.feeds) > 2 and coupling.feeds[name] == frozenset(coupling.feeds) - {name}


ALGORITHMS: dict[str, Callable[[Coupling], Stages]] = {"staggered": staggered, "jacobi": jacobi}


def stages(algorithm: str, coupling: Coupling) -> Sequence[Sequence[str]]:
    """Return the stages of one step by the name of the algorithm."""
    if algorithm not in ALGORITHMS:
        raise InputError(f"algorithm {algorithm!r}: must be one of {', '.join(ALGORITHMS)}")
    return ALGORITHMS[algorithm](coupling)
