"""The modes of a structure at its contact point: frequency response and state space. No files, no FMI, no kernels.

Wheel and rail differ in their data only. A mode is a natural frequency, a damping ratio and a mass-normalised shape at
the contact point in the four directions of the contract (track axes).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import DataError

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Modes:
    """The modes of a structure, as seen at its contact point.

    Attributes
    ----------
    omega : (n,) natural angular frequencies [rad/s], >= 0
    zeta : (n,) modal damping ratios [-], >= 0
    shape : (n, 4) mass-normalised shapes in lon, lat, ver [kg^-1/2] and spin [kg^-1/2/m]
    labels : (n,) names of the modes, may be empty

    Raises
    ------
    DataError
        For wrong shapes, values that are not finite, or a negative frequency or damping ratio.
    """

    omega: Real
    zeta: Real
    shape: Real
    labels: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        n = self.omega.size
        if self.omega.shape != (n,) or self.zeta.shape != (n,) or self.shape.shape != (n, 4):
            raise DataError(
                f"modes: omega {self.omega.shape}, zeta {self.zeta.shape}, shape {self.shape.shape}; "
                "must be (n,), (n,), (n, 4)"
            )
        if self.labels and len(self.labels) != n:
            raise DataError(f"modes: {len(self.labels)} labels for {n} modes")
        for name, values in (("omega", self.omega), ("zeta", self.zeta)):
            bad = np.flatnonzero(~np.isfinite(values) | (values < 0))
            if bad.size:
                raise DataError(f"mode {bad[0] + 1}: {name} = {values[bad[0]]:g}; must be finite and >= 0")
        bad_rows = np.flatnonzero(~np.isfinite(self.shape).all(axis=1))
        if bad_rows.size:
            raise DataError(f"mode {bad_rows[0] + 1}: the shape is not finite")

    def __len__(self) -> int:
        """Return the number of modes."""
        return self.omega.size

    def keep(self, selection: ArrayLike) -> Modes:
        """Return only the selected modes (boolean mask or indices)."""
        index = np.arange(len(self))[np.asarray(selection)]
        labels = tuple(self.labels[i] for i in index) if self.labels else ()
        return Modes(self.omega[index], self.zeta[index], self.shape[index], labels)


def receptance(omega: ArrayLike, modes: Modes) -> Complex:
    """Return displacement per unit force at the contact, by modal summation.

    Parameters
    ----------
    omega : (m,) array_like
        Angular frequencies [rad/s].
    modes : Modes
        The n modes of the component.

    Returns
    -------
    (m, 4, 4) complex array
        Element [:, j, k]: displacement in direction j per unit force in direction k [m/N; rotations rad, moments N m].

    Notes
    -----
    Eq. (1) of the paper, for all pairs of directions.

    Examples
    --------
    A 1 kg mass on a 100 N/m spring is as stiff as its spring at rest:

    >>> one = Modes(np.array([10.0]), np.array([0.01]), np.array([[0, 0, 1.0, 0]]))
    >>> float(receptance([0.0], one)[0, 2, 2].real)
    0.01
    """
    w = np.atleast_1d(np.asarray(omega, dtype=float))[:, None]
    modal = 1.0 / (modes.omega**2 - w**2 + 2j * modes.zeta * modes.omega * w)
    weighted: Complex = (modal[:, :, None] * modes.shape).transpose(0, 2, 1) @ modes.shape
    return weighted


def mobility(omega: ArrayLike, modes: Modes) -> Complex:
    """Return velocity per unit force at the contact, (m, 4, 4); see `receptance`."""
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    return np.asarray(1j * w[:, None, None] * receptance(w, modes))


def state_space(modes: Modes) -> tuple[Real, Real, Real, Real]:
    """Return the state-space matrices of the modes: A, B, C (velocities) and C_d (displacements).

    Returns
    -------
    A : (2n, 2n), B : (2n, 4), C : (4, 2n), C_d : (4, 2n)

    Notes
    -----
    Eqs. (2), (3), (5)-(7) of the paper with the state (q1', ..., qn', q1, ..., qn) that eqs. (5)-(7) need; eq. (4)
    prints another order. C_d is added: the contact spring needs displacements. Modes whose shapes have one direction
    each make the block structure of eqs. (8)-(10).
    """
    n = len(modes)
    A = np.zeros((2 * n, 2 * n))
    A[:n, :n] = np.diag(-2 * modes.zeta * modes.omega)
    A[:n, n:] = np.diag(-(modes.omega**2))
    A[n:, :n] = np.eye(n)
    zero = np.zeros((4, n))
    C = np.hstack([modes.shape.T, zero])
    C_d = np.hstack([zero, modes.shape.T])
    return A, C.T.copy(), C, C_d
