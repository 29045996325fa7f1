"""How to run a system, and how far a run is."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import floor, inf

from ..errors import InputError
from .algorithms import find_algorithm

MOST_STEPS = 1e15
"""Most steps of a run: beyond 9e15, doubles do not count by one any more."""

LONGEST_TIMEOUT = 1e6
"""Longest time that a call may be given [s]; the system's clocks count milliseconds in 32 bits."""


@dataclass(frozen=True)
class Settings:
    """How to run a system.

    Attributes
    ----------
    step : communication step [s]
    duration : simulated time [s]; shortened to whole steps, see `steps`
    algorithm : name of the master algorithm
    record_every : record after every this many steps
    record : patterns of local variables to record besides the outputs; None: the wheel's modal velocities
    timeout : time that a call of an FMU may take, each FMU in a process of its own [s]; None: all in this process
    """

    step: float
    duration: float
    algorithm: str = "staggered"
    record_every: int = 4
    record: tuple[str, ...] | None = None
    timeout: float | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        if not 0 < self.step < inf:
            raise InputError(f"step = {self.step:g} s: must be > 0")
        if not self.step <= self.duration < inf:
            raise InputError(f"duration = {self.duration:g} s: must be at least one step of {self.step:g} s")
        if self.duration / self.step > MOST_STEPS:
            raise InputError(
                f"duration = {self.duration:g} s in steps of {self.step:g} s: more than {MOST_STEPS:g} steps; refused"
            )
        find_algorithm(self.algorithm)
        if not 1 <= self.record_every <= MOST_STEPS:
            raise InputError(f"record_every = {self.record_every}: must be >= 1 and <= {MOST_STEPS:g}")
        if self.timeout is not None and not 0 < self.timeout <= LONGEST_TIMEOUT:
            raise InputError(f"timeout = {self.timeout:g} s: must be > 0 and <= {LONGEST_TIMEOUT:g}")

    @property
    def steps(self) -> int:
        """Number of whole steps in the duration."""
        wanted = self.duration / self.step
        return round(wanted) if self.whole else floor(wanted)

    @property
    def whole(self) -> bool:
        """Whether the duration is a whole number of steps, but for rounding of its decimals."""
        wanted = self.duration / self.step
        return abs(wanted - round(wanted)) <= min(1e-3, 1e-9 * wanted + 1e-12)

    def stop(self, start: float) -> float:
        """Return the time at which a run that begins at `start` ends: exactly its stop time, or the last whole step."""
        return start + (self.duration if self.whole else self.steps * self.step)


@dataclass
class Progress:
    """How far a run is.

    Attributes
    ----------
    total : steps of the whole run
    steps : steps made
    wall : wall time in the loop [s]
    energy_residual : energy that the scheme adds: by contact direction (lon, lat, normal, spin) from the account of a
        contact that keeps one, else by track direction, as if the forces were meant for the communication points [J]
    energy_into_structures : energy that the forces put into wheel and rail, by track direction [J]
    energy_into : the same by structure (wheel, rail) [J]
    stopped : whether a stop was requested before the end
    ended : sentence that says which component ended the run before its time; None if none did
    sweeps : how often a step was made on average until its values converged; 1 without iteration
    most_sweeps : the same for the step that took most
    """

    total: int
    steps: int = 0
    wall: float = 0.0
    energy_residual: dict[str, float] = field(default_factory=dict)
    energy_into_structures: dict[str, float] = field(default_factory=dict)
    energy_into: dict[str, float] = field(default_factory=dict)
    stopped: bool = False
    ended: str | None = None
    sweeps: float = 1.0
    most_sweeps: int = 1
