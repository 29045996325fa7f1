"""Master algorithms as data: who steps when, with which inputs, and how often. No FMI calls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..errors import InputError
from .dependencies import Coupling, Order, Stages

__all__ = ["ALGORITHMS", "Algorithm", "Coupling", "find_algorithm", "stages"]


def simultaneous(coupling: Coupling) -> Stages:
    """Everybody steps at once, each with the outputs of the step before."""
    return [list(coupling.feeds)]


def independent_first(coupling: Coupling) -> Stages:
    """Components without algebraic dependence step first, the others after those that they depend on.

    Raises
    ------
    InputError
        For an algebraic loop, with its members and the one way out that they leave.
    """
    order = Order.of(coupling)
    if order.loops:
        members = order.loops[0]
        stuck = [name for name in members if name not in coupling.repeatable]
        way = (
            f"{stuck[0]} cannot get and set its state, so a step cannot be repeated until they agree; "
            "use the algorithm jacobi"
            if stuck
            else "use the algorithm iterative, which repeats the step until they agree"
        )
        raise InputError(
            f"algebraic loop: the outputs of {', '.join(members)} depend on each other within a step; {way}"
        )
    return order.stages


def loops_together(coupling: Coupling) -> Stages:
    """As `independent_first`; the members of an algebraic loop step together, for an iteration to solve."""
    return Order.of(coupling).stages


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
