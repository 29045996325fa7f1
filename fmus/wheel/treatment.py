"""What damps or moves modes: damping by label and tuned absorbers; modes in, modes out. No files.

Labels are those of the wheels: '(3,0) cosine' is matched by '(3,0)', '(*,0)' and '(3,0) cosine'.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from ..errors import DataError
from ..modal.modes import Modes, receptance

Real = NDArray[np.float64]

_SAME_FREQUENCY = 1e-3


@dataclass(frozen=True)
class Rule:
    """What becomes of damping ratios.

    Attributes
    ----------
    target : pattern of labels, or the name of a component
    factor, added : new = factor * old + added
    """

    target: str
    factor: float
    added: float

    def of(self, zeta: float) -> float:
        """Return the new damping ratio."""
        return self.factor * zeta + self.added


@dataclass(frozen=True)
class Absorber:
    """Tuned absorbers on each wheel, alike and evenly around it, that move along the axle.

    Attributes
    ----------
    label : of the mode that they are tuned to
    mass : of all on one wheel [kg]
    loss_factor : of their springs [-]
    frequency_hz : at which they resonate on a rigid wheel; None: Den Hartog's, f/(1 + mass ratio)
    position : axial motion where they sit over that at the tread [-]
    """

    label: str
    mass: float
    loss_factor: float
    frequency_hz: float | None = None
    position: float = 1.0

    def __post_init__(self) -> None:
        """Check the values."""
        for name in ("mass", "loss_factor", "position"):
            if not 0 < getattr(self, name) < np.inf:
                raise DataError(f"absorber: {name} = {getattr(self, name):g}; must be > 0")
        if self.frequency_hz is not None and not self.frequency_hz > 0:
            raise DataError(f"absorber: frequency = {self.frequency_hz:g} Hz; must be > 0")


@dataclass(frozen=True)
class Treated:
    """A wheel with absorbers.

    Attributes
    ----------
    modes : of wheel and absorbers
    frequency_hz : at which the absorbers resonate on a rigid wheel [Hz]
    mass_ratio : effective mass times the square of the mode's amplitude [-]
    split_hz : frequencies that the mode becomes, a pair for each family [Hz]
    error_db : level of the largest lateral receptance near the mode over that with the absorbers' springs as they are:
        the modes leave out damping that couples them [dB]
    """

    modes: Modes
    frequency_hz: float
    mass_ratio: float
    split_hz: tuple[float, ...]
    error_db: float


def read_rule(text: str) -> Rule:
    """Return the rule of a text: '(3,0)=1e-3' sets, '(3,0)=+1e-4' adds, 'wheel=x2' multiplies.

    >>> read_rule("wheel=x2").of(1e-4)
    0.0002
    """
    match = re.fullmatch(r"(.+)=(x|\+|)([^=x+]+)", text.strip())
    try:
        if match is None:
            raise ValueError
        value = float(match[3])
    except ValueError:
        raise DataError(
            f"damping {text!r}: must be LABEL=RATIO, LABEL=+RATIO or LABEL=xFACTOR, as (3,0)=1e-3"
        ) from None
    if not 0 <= value < np.inf:
        raise DataError(f"damping {text!r}: {value:g}; must be >= 0")
    factor, added = {"": (0.0, value), "+": (1.0, value), "x": (value, 0.0)}[match[2]]
    return Rule(match[1], factor, added)


def matching(labels: Sequence[str], pattern: str) -> list[int]:
    """Return the places of the labels that a pattern means; refuse one that means none.

    >>> matching(["(3,0) cosine", "(30,0)", "(2,0) sine"], "(3,0)")
    [0]
    """
    found = [i for i, label in enumerate(labels) if fnmatchcase(label, pattern) or fnmatchcase(label, f"{pattern} *")]
    if not found:
        known = ", ".join(dict.fromkeys(label for label in labels if label)) or "none"
        raise DataError(f"no mode is called {pattern}; the labels are {known}")
    return found


def damped(modes: Modes, rules: Sequence[Rule]) -> Modes:
    """Return the modes with the damping ratios that rules give, one after the other."""
    zeta = modes.zeta.copy()
    for rule in rules:
        every = list(range(len(modes))) if rule.target == "wheel" else matching(modes.labels, rule.target)
        zeta[every] = [rule.of(value) for value in zeta[every]]
    return Modes(modes.omega, zeta, modes.shape, modes.labels)


def with_absorber(modes: Modes, absorber: Absorber) -> Treated:
    """Return the modes of a wheel with tuned absorbers.

    Notes
    -----
    Absorbers spread evenly move as the n nodal diameters of the mode do: of their mass half counts for n >= 1 (the mean
    of cos^2), in both families alike. For n >= 2 all modes of the same n and family take part, by their axial motion;
    for n = 0 and 1 both wheels move and carry absorbers, which counts twice, and only the mode itself takes part. The
    undamped modes of wheel and absorber are exact. Their damping ratios are the loss factor times the share of the
    energy in the springs, halved, and what the wheel's own modes have: damping that couples modes is left out;
    `error_db` says by how much.
    """
    chosen = matching(modes.labels, absorber.label)
    n = _diameters(modes.labels[chosen[0]])
    if n is None:
        raise DataError(f"absorber: {modes.labels[chosen[0]]!r} has no number of nodal diameters; must be as (3,0)")
    amplitude = max(abs(float(modes.shape[i, 1])) for i in chosen) * absorber.position
    if amplitude == 0:
        raise DataError(f"absorber: {absorber.label} has no axial motion at the tread, so it cannot be absorbed there")
    mass = absorber.mass * (0.5 if n else 1.0) * (1.0 if n >= 2 else 2.0)
    ratio = mass * amplitude**2
    own = float(modes.omega[chosen[0]])
    tuned = 2 * np.pi * absorber.frequency_hz if absorber.frequency_hz is not None else own / (1 + ratio)
    treated, exact, split = modes, [], []
    for family in [i for i in chosen if abs(modes.omega[i] / own - 1) < _SAME_FREQUENCY]:
        group = _group(modes, family, n)
        axial = np.array([_axial(modes, i) for i in group]) * absorber.position
        part = _coupled(modes.keep(group), axial, mass, tuned, absorber)
        exact.append((modes.keep(group), axial))
        split += [float(f) for f in part.omega / (2 * np.pi) if abs(np.log(2 * np.pi * f / own)) < 0.3]
        rest = np.array([not _same(treated, i, modes, group) for i in range(len(treated))], dtype=bool)
        treated = _joined(treated.keep(rest), part)
    errors = [_error_db(treated, modes, group, mass, tuned, absorber.loss_factor, own) for group in exact]
    error = max(errors, key=abs)
    return Treated(treated, tuned / (2 * np.pi), ratio, tuple(split), error)


def _diameters(label: str) -> int | None:
    """Return the number of nodal diameters that a label says."""
    match = re.search(r"\((\d+),|n=(\d+)", label)
    return int(match[1] or match[2]) if match else None


def _family(label: str) -> str:
    return "sine" if label.endswith("sine") and not label.endswith("cosine") else "cosine"


def _group(modes: Modes, mode: int, n: int) -> list[int]:
    """Return the modes that an absorber couples with one."""
    if n < 2:
        return [mode]
    family = _family(modes.labels[mode])
    return [i for i, label in enumerate(modes.labels) if _diameters(label) == n and _family(label) == family]


def _axial(modes: Modes, mode: int) -> float:
    """Return the axial amplitude at the tread, for a sine mode that of its cosine partner."""
    if modes.shape[mode, 1] != 0:
        return float(modes.shape[mode, 1])
    n, near = _diameters(modes.labels[mode]), _SAME_FREQUENCY * modes.omega[mode]
    partner = [
        i for i in range(len(modes))
        if _diameters(modes.labels[i]) == n and abs(modes.omega[i] - modes.omega[mode]) <= near
    ]  # fmt: skip
    return max((float(modes.shape[i, 1]) for i in partner), key=abs, default=0.0)


def _coupled(own: Modes, axial: Real, mass: float, tuned: float, absorber: Absorber) -> Modes:
    """Return the modes of some modes and one absorber."""
    size = len(own) + 1
    stiffness = mass * tuned**2
    stretch = np.append(-axial, 1.0) / np.append(np.ones(len(own)), np.sqrt(mass))  # in mass-normalised coordinates
    K = np.diag(np.append(own.omega**2, 0.0)) + stiffness * np.outer(stretch, stretch)
    squares, vectors = np.linalg.eigh(K)
    omega = np.sqrt(np.maximum(squares, 0.0))
    energy = stiffness * (stretch @ vectors) ** 2
    viscous = (2 * own.zeta * own.omega) @ vectors[:-1] ** 2
    zeta = np.divide(viscous + absorber.loss_factor * energy / np.maximum(omega, 1e-9), 2 * omega, where=omega > 0,
                     out=np.zeros(size))  # fmt: skip
    labels = _labels(own.labels, omega, absorber.label)
    return Modes(omega, zeta, vectors[:-1].T @ own.shape, labels)


def _labels(before: tuple[str, ...], omega: Real, label: str) -> tuple[str, ...]:
    """Return the labels of the coupled modes: those before, and the absorber's beside the mode that it splits."""
    place = next(i for i, text in enumerate(before) if matching(before, label)[0] == i)
    names = list(before)
    names.insert(place + 1, f"{before[place]} absorber")
    return tuple(names[: omega.size])


def _same(treated: Modes, i: int, modes: Modes, group: list[int]) -> bool:
    return any(treated.labels[i] == modes.labels[g] and treated.omega[i] == modes.omega[g] for g in group)


def _joined(first: Modes, second: Modes) -> Modes:
    """Return the modes of both by frequency."""
    omega = np.concatenate([first.omega, second.omega])
    both = Modes(
        omega,
        np.concatenate([first.zeta, second.zeta]),
        np.concatenate([first.shape, second.shape]),
        (*first.labels, *second.labels),
    )
    return both.keep(np.argsort(omega, kind="stable"))


def _error_db(  # noqa: PLR0913, PLR0917 - what both models are made of
    treated: Modes, modes: Modes, group: tuple[Modes, Real], mass: float, tuned: float, loss_factor: float, own: float
) -> float:
    """Return the level of the largest lateral receptance over that with the springs as they are [dB]."""
    part, axial = group
    if not part.shape[:, 1].any():
        return 0.0
    omega = own * np.geomspace(2 ** (-1 / 6), 2 ** (1 / 6), 4000)
    others = receptance(omega, modes)[:, 1, 1] - receptance(omega, part)[:, 1, 1]
    diagonal = part.omega**2 - omega[:, None] ** 2 + 2j * part.zeta * part.omega * omega[:, None]
    spring = mass * tuned**2 * (1 + 1j * loss_factor)
    dynamic = -(omega**2) * mass * spring / (spring - mass * omega**2)  # force per motion of the absorber's foot
    matrix = dynamic[:, None, None] * np.outer(axial, axial)
    matrix[:, np.arange(len(part)), np.arange(len(part))] += diagonal
    lateral = part.shape[:, 1]
    right = np.broadcast_to(lateral[:, None], (omega.size, len(part), 1))
    exact = others + (lateral @ np.linalg.solve(matrix, right)[:, :, 0].T)
    found = receptance(omega, treated)[:, 1, 1]
    return float(20 * np.log10(np.abs(found).max() / np.abs(exact).max()))
