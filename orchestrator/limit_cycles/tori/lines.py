"""Lines k1 w1 + k2 w2 of a motion with two frequencies, and the grid of both phases on which it is sampled."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]
Whole = NDArray[np.int_]


@dataclass(frozen=True)
class Lines:
    """The lines with |k1| / highest[0] + |k2| / highest[1] <= 1, and N1 x N2 samples.

    Attributes
    ----------
    highest : largest |k1| and |k2|
    samples : of the phase of each frequency over 2 pi
    """

    highest: tuple[int, int]
    samples: tuple[int, int]

    @cached_property
    def numbers(self) -> Whole:
        """(M, 2) k1 and k2 of one of every two lines k and -k, (0, 0) first."""
        first, second = (np.arange(-n, n + 1) for n in self.highest)
        k = np.stack(np.meshgrid(first, second, indexing="ij"), -1).reshape(-1, 2)
        inside = np.abs(k / np.array(self.highest)).sum(axis=1) < 1 + 1e-9
        half = (k[:, 1] > 0) | ((k[:, 1] == 0) & (k[:, 0] >= 0))
        kept = k[inside & half]
        return np.asarray(kept[np.lexsort((kept[:, 0], kept[:, 1]))])

    @cached_property
    def place(self) -> dict[tuple[int, int], int]:
        """Where a line is in `numbers`."""
        return {(int(a), int(b)): n for n, (a, b) in enumerate(self.numbers)}

    def index(self, k: Whole) -> tuple[Whole, Whole]:
        """Return where the lines k, (..., 2), are in a transform over the grid."""
        return k[..., 0] % self.samples[0], k[..., 1] % self.samples[1]

    def on_grid(self, lines: Complex) -> Real:
        """Return the samples, (N1 N2, ...), of a motion whose lines `numbers` are given, (M, ...)."""
        spectrum = np.zeros((*self.samples, *lines.shape[1:]), complex)
        spectrum[self.index(-self.numbers)] = lines.conj()
        spectrum[self.index(self.numbers)] = lines
        spectrum[0, 0] = lines[0].real
        samples = np.fft.ifft2(spectrum, axes=(0, 1)).real * (self.samples[0] * self.samples[1])
        return samples.reshape(-1, *lines.shape[1:])

    def transform(self, samples: Real) -> Complex:
        """Return all Fourier coefficients, (N1, N2, ...), of samples (N1 N2, ...)."""
        grid = samples.reshape(*self.samples, *samples.shape[1:])
        return np.asarray(np.fft.fft2(grid, axes=(0, 1)) / (self.samples[0] * self.samples[1]))
