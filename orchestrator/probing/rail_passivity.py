"""Impulse responses of a structure in, its mobility over frequency and signs of an energy source out. No FMUs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import hankel

from fmus.interface import DIRECTIONS

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

BAND_HZ = (10.0, 10e3)
RESOLUTION_HZ = 2.0

REMAINDER = 1e-6
"""What may be left of a response at its end, relative to its largest value, before it is cut."""

DEAD = 1e-4
"""Mobility below this part of its largest is not judged: what is cut off the responses would decide."""

SPARE_DEGREES = 0.3
"""Phase beyond +-90 degrees that is put down to rounding, besides half a step of delay."""

ENERGY = 3e-4
"""Energy taken out that counts, relative to the most that forces put in: some 0.2 % of growth over a response."""

LONGEST_HISTORY = 8000
LANCZOS = 60
"""Steps of the histories of forces that are tried, and steps of Lanczos' iteration."""

AT_REST = 1e-9
"""A velocity below this part of its largest is rest."""


@dataclass(frozen=True)
class Responses:
    """Answers of a structure at rest to a unit force held over the first step.

    Attributes
    ----------
    velocity : (n, 4, 4) at the ends of the steps, [:, j, k] in direction j per force in direction k
    way : (n, 4, 4) displacement from the beginning to the end of each step, NaN where it is not offered
    step : [s]
    """

    velocity: Real
    way: Real
    step: float


@dataclass(frozen=True)
class Mobility:
    """Velocity per force over frequency.

    Attributes
    ----------
    frequency_hz : (m,) equally spaced [Hz]
    values : (m, 4, 4) complex
    shift : the mobility is taken at s = shift + j omega [1/s]; 0 if the responses had settled
    """

    frequency_hz: Real
    values: Complex
    shift: float


def estimate_mobility(responses: Responses) -> Mobility:
    """Return the mobility of a structure from its impulse responses.

    Notes
    -----
    Laplace transform of the velocity over that of the force, both at s = shift + j omega. Displacements make the
    velocity where they are offered, so that what fast modes do between the ends of the steps is not lost. A response
    that has not settled is made to by the shift, which keeps a passive structure passive: Re Y(s) >= 0 for Re s > 0.
    """
    step, offered = responses.step, np.isfinite(responses.way)
    record = np.where(offered, responses.way / step, responses.velocity)
    size = np.abs(record).max(axis=(1, 2), initial=0.0)
    end = size[-max(size.size // 20, 1) :].max() / max(size.max(), np.finfo(float).tiny)
    shift = float(max(np.log(max(end, REMAINDER) / REMAINDER), 0.0) / (size.size * step))
    times = step * np.arange(1, size.size + 1)
    count = 1 << int(np.ceil(np.log2(max(1 / (step * RESOLUTION_HZ), size.size))))
    spectrum = np.fft.rfft(record * np.exp(-shift * times)[:, None, None], count, axis=0)
    frequency_hz: Real = np.arange(count // 2 + 1) / (count * step)
    kept = (frequency_hz >= BAND_HZ[0]) & (frequency_hz <= min(BAND_HZ[1], 0.05 / step))
    s = (shift + 2j * np.pi * frequency_hz[kept])[:, None, None]
    force = -np.expm1(-s * step) / s
    factor = step * np.exp(-1j * s.imag * step) / force * np.where(offered[0], step / force, 1.0)
    return Mobility(frequency_hz[kept], factor * spectrum[kept], shift)


def find_lateness(responses: Responses) -> str | None:
    """Return the sentence that says by how many steps the answers come too late, or None.

    A force held over a step moves whatever can move by the end of that step; what then stands still is told too late.
    """
    own = np.abs(np.einsum("kii->ki", responses.velocity))
    size = own.max(axis=0)
    first = [int(np.argmax(own[:, j] > AT_REST * size[j])) for j in range(4) if size[j] > 0]
    late = min(first, default=0)
    if late == 0:
        return None
    word = "a step" if late == 1 else f"{late} steps"
    return f"late by {word}: after the first step the velocities do not yet answer to its force"


def find_growth(responses: Responses) -> str | None:
    """Return the sentence that says which response grows, or None.

    Notes
    -----
    A response that has not settled grows if there is a history of forces that takes more energy out than it puts in,
    over the length of the response; see `lowest_energy`. Rate and frequency are there for the reader: a fit of
    exponentials may find false ones, so that its rate is told only if the response itself grows about as fast.
    """
    step = responses.step
    for j, direction in enumerate(DIRECTIONS):
        own, exact = responses.velocity[:, j, j], responses.way[:, j, j]
        tail = own[own.size // 2 :]
        if np.abs(tail).max(initial=0.0) <= 1e-4 * np.abs(own).max(initial=0.0):
            continue
        trapezoid = 0.5 * step * (own + np.concatenate([[0.0], own[:-1]]))
        if lowest_energy(exact if np.isfinite(exact).all() else trapezoid) >= -ENERGY:
            continue
        peak = int(np.argmax(np.abs(np.fft.rfft(tail * np.hanning(tail.size)))))
        frequency = peak / (tail.size * step)
        return (
            f"after a pulse the {direction} velocity grows by {_rate(tail, step):.3g} 1/s, at about {frequency:.0f} Hz"
        )
    return None


def _rate(tail: Real, step: float) -> float:
    """Return the growth rate of a response [1/s]: that of its fastest exponential, if its size bears it out."""
    early, late = (float(np.sqrt(np.mean(part**2))) for part in np.array_split(tail, 2))
    seen = float(np.log(late / early) / (0.5 * tail.size * step))
    fitted = _growth_rate(tail, step)
    return fitted if abs(fitted - seen) <= 0.2 * abs(seen) else seen


def lowest_energy(way: Real) -> float:
    """Return the least energy that forces at one point put in, relative to the most; below 0 they take energy out.

    Parameters
    ----------
    way : (n,) what the point moves in each step after a unit force held over the first

    Notes
    -----
    The energy of forces f_k held over n steps is the quadratic form of the symmetric Toeplitz matrix of the ways. For a
    passive structure it is never negative, however many modes it has. Lanczos' values lie between the true extremes: a
    negative one belongs to a history of forces that takes energy out, and is no artefact. Every m-th way will do.
    """
    t = way[:: max(way.size // LONGEST_HISTORY, 1)].copy()
    t[1:] /= 2
    size = 1 << int(np.ceil(np.log2(2 * t.size)))
    spectrum = np.fft.rfft(np.concatenate([t, np.zeros(size + 1 - 2 * t.size), t[:0:-1]])).real
    basis = np.zeros((min(LANCZOS, t.size), t.size))
    tridiagonal = np.zeros((len(basis), len(basis)))
    q = t + 1e-3 * np.abs(t).max() * np.random.default_rng(1).standard_normal(t.size)
    for k in range(len(basis)):
        basis[k] = q / np.linalg.norm(q)
        w = np.fft.irfft(spectrum * np.fft.rfft(basis[k], size), size)[: t.size]
        tridiagonal[k, k] = w @ basis[k]
        for _ in range(2):  # twice is enough against rounding
            w -= basis[: k + 1].T @ (basis[: k + 1] @ w)
        length = float(np.linalg.norm(w))
        if k + 1 == len(basis) or length <= 1e-13 * np.abs(np.diag(tridiagonal)).max():
            break
        tridiagonal[k, k + 1] = tridiagonal[k + 1, k] = length
        q = w
    values = np.linalg.eigvalsh(tridiagonal[: k + 1, : k + 1])
    return float(values[0] / max(values[-1], np.finfo(float).tiny))


def _growth_rate(signal: Real, step: float) -> float:
    """Return the largest growth rate of the exponentials that make up a signal [1/s]."""
    every = max(signal.size // 400, 1)  # aliasing changes frequencies, not growth
    x = signal[::every] / np.abs(signal).max()
    half = x.size // 2
    left, singular, _ = np.linalg.svd(hankel(x[: half + 1], x[half:]), full_matrices=False)
    rank = min(int(np.count_nonzero(singular > 1e-6 * singular[0])), half)
    poles = np.linalg.eigvals(np.linalg.lstsq(left[:-1, :rank], left[1:, :rank], rcond=None)[0])
    return float(np.log(np.abs(poles).max()) / (every * step))


def find_activity(mobility: Mobility, step: float) -> str | None:
    """Return the sentence that says where a mobility is that of an energy source, or None.

    Parameters
    ----------
    mobility : Mobility
    step : float
        [s]; a held force and a velocity at the end of the step are half a step apart, which is not held against it
    """
    f, Y = mobility.frequency_hz, mobility.values
    spare = np.degrees(np.pi * f * step) + SPARE_DEGREES
    worst = (0.0, "")
    for j, direction in enumerate(DIRECTIONS):
        own = Y[:, j, j]
        size = np.abs(own)
        phase = np.degrees(np.angle(own))
        beyond = np.where(size > DEAD * size.max(), np.abs(phase) - 90.0 - spare, -np.inf)
        i = int(np.argmax(beyond))
        if size.max() > 0 and beyond[i] > worst[0]:
            said = f"the {direction} mobility at {f[i]:.0f} Hz has a phase of {phase[i]:.0f} degrees"
            worst = (float(beyond[i]), f"{said}; must be within +-90")
    return worst[1] or _coupled_activity(f, Y, np.sin(np.radians(spare)))


def _coupled_activity(f: Real, Y: Complex, spare: Real) -> str | None:
    """Return where forces in several directions together get energy out, though none alone does."""
    size = np.sqrt(np.abs(np.diagonal(Y, axis1=1, axis2=2)).max(axis=0))
    scale = 1 / np.where(size > 0, size, 1.0)
    scaled = Y * scale[:, None] * scale
    lowest = np.linalg.eigvalsh((scaled + scaled.conj().transpose(0, 2, 1)) / 2)[:, 0]
    excess = lowest + spare * np.linalg.norm(scaled, 2, axis=(1, 2))
    i = int(np.argmin(excess))
    if excess[i] >= 0:
        return None
    return f"forces in several directions at {f[i]:.0f} Hz take energy out: the mobility's real part is not positive"
