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

GROWTH = 0.01
"""Growth over the length of the responses that counts, as an exponent."""


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


def find_growth(responses: Responses) -> str | None:
    """Return the sentence that says which response grows, or None.

    Notes
    -----
    Growth rates are the poles of the second half of each response, by rotational invariance of its Hankel matrix.
    """
    step = responses.step
    duration = len(responses.velocity) * step
    for j, direction in enumerate(DIRECTIONS):
        own = responses.velocity[:, j, j]
        tail = own[own.size // 2 :]
        if np.abs(tail).max(initial=0.0) <= 1e-4 * np.abs(own).max(initial=0.0):
            continue
        rate = _growth_rate(tail, step)
        if rate * duration > GROWTH:
            window = np.hanning(tail.size)
            peak = int(np.argmax(np.abs(np.fft.rfft(tail * window))))
            frequency = peak / (tail.size * step)
            return f"after a pulse the {direction} velocity grows by {rate:.3g} 1/s, at about {frequency:.0f} Hz"
    return None


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
