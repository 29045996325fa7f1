"""Master algorithms as data: who steps when, with which inputs, and how often. No FMI calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from ..errors import InputError


@dataclass(frozen=True)
class Coupling:
    """What an algorithm needs to know of a system.

    Attributes
    ----------
    feeds : for each component the components that its inputs come from
    feedthrough : for each component whether its outputs depend on its inputs within a step; None: it does not tell
    told : stage of a component as an annotation of the system gives it, 0 first; components may be missing
    """

    feeds: Mapping[str, frozenset[str]]
    feedthrough: Mapping[str, bool | None]
    told: Mapping[str, int] = field(default_factory=dict)

    def between(self, name: str) -> bool:
        """Return whether a component is fed by all others, which is where a coupling element stands."""
        return len(self.feeds) > 2 and self.feeds[name] == frozenset(self.feeds) - {name}

    def dependent(self) -> list[str]:
        """Return the components whose outputs depend on their inputs within a step.

        What the FMU tells counts; if it tells nothing, the annotation (a later stage than 0); else whether it stands
        between the others.
        """
        return [name for name in self.feeds if self._depends(name)]

    def _depends(self, name: str) -> bool:
        feedthrough = self.feedthrough[name]
        if feedthrough is not None:
            return feedthrough
        if name in self.told:
            return self.told[name] > 0
        return self.between(name)

    def guesses(self) -> list[str]:
        """Return a sentence for each component that was put last because it stands between the others."""
        return [
            f"{name} does not declare its dependencies; it stands between the others, so it steps last"
            for name in self.feeds
            if self.feedthrough[name] is None and name not in self.told and self.between(name)
        ]


Stages = list[list[str]]


def simultaneous(coupling: Coupling) -> Stages:
    """Everybody steps at once, each with the outputs of the step before."""
    return [list(coupling.feeds)]


def independent_first(coupling: Coupling) -> Stages:
    """Components without algebraic dependence step first, the others after those that feed them.

    Raises
    ------
    InputError
        For an algebraic loop, with its members.
    """
    order, loop = _sort(coupling)
    if loop:
        raise InputError(
            f"algebraic loop: the outputs of {', '.join(loop)} depend on each other within a step; "
            "use the algorithm iterative or jacobi"
        )
    return order


def loops_together(coupling: Coupling) -> Stages:
    """As `independent_first`; the members of an algebraic loop step together, for an iteration to solve."""
    order, loop = _sort(coupling)
    return (
        order if not loop else [*order, loop, *_after(coupling, [*(name for stage in order for name in stage), *loop])]
    )


def _after(coupling: Coupling, done: list[str]) -> Stages:
    """Return the stages of what is left; if that holds another loop, all of it is one stage."""
    left = [name for name in coupling.feeds if name not in done]
    ready = [name for name in left if not coupling.feeds[name] & set(left)]
    if not left:
        return []
    return [ready, *_after(coupling, [*done, *ready])] if ready else [left]


def _sort(coupling: Coupling) -> tuple[Stages, list[str]]:
    """Return the stages and what is left over: the components of algebraic loops and those that wait for them."""
    dependent = coupling.dependent()
    order: Stages = [[name for name in coupling.feeds if name not in dependent]]
    waiting = dependent
    while waiting:
        ready = [name for name in waiting if not coupling.feeds[name] & set(waiting)]
        if not ready:
            break
        order.append(ready)
        waiting = [name for name in waiting if name not in ready]
    return [stage for stage in order if stage], _only_loops(coupling, waiting)


def _only_loops(coupling: Coupling, waiting: list[str]) -> list[str]:
    """Return the waiting components without those that wait for a loop but feed none of it."""
    kept = list(waiting)
    while True:
        feeding = [name for name in kept if any(name in coupling.feeds[other] for other in kept)]
        if feeding == kept:
            return kept
        kept = feeding


@dataclass(frozen=True)
class Algorithm:
    """A master algorithm.

    Attributes
    ----------
    description : what it does, in a sentence
    order : puts the components into stages; in a stage all get their inputs, then all step, then all give outputs
    simultaneous : whether nobody sees outputs of the same step
    share : share of the values at the end of the step in what a component without feedthrough gets over the step; the
        rest are those at its start. A component with feedthrough always gets the latest
    sweeps : how often a step is repeated at most, until the exchanged values converge; 1: no rollback
    tolerance : change of the exchanged values, relative to their size, at which they have converged
    """

    description: str
    order: Callable[[Coupling], Stages]
    simultaneous: bool = False
    share: float = 0.0
    sweeps: int = 1
    tolerance: float = 1e-9


ALGORITHMS: dict[str, Algorithm] = {
    "staggered": Algorithm(
        "what has no feedthrough steps first with held inputs, the rest after it with the new outputs",
        independent_first,
    ),
    "jacobi": Algorithm("everybody steps at once with the outputs of the step before", simultaneous, simultaneous=True),
    "iterative": Algorithm(
        "as staggered, but a step is repeated with the mean of old and new inputs until they converge",
        loops_together,
        share=0.5,
        sweeps=50,
    ),
}


def find_algorithm(name: str) -> Algorithm:
    """Return the algorithm of a name."""
    if name not in ALGORITHMS:
        raise InputError(f"algorithm {name!r}: must be one of {', '.join(ALGORITHMS)}")
    return ALGORITHMS[name]


def stages(algorithm: str, coupling: Coupling) -> Sequence[Sequence[str]]:
    """Return the stages of one step by the name of the algorithm."""
    return find_algorithm(algorithm).order(coupling)
