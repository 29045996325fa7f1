"""The squeal loop at frequencies: mobilities of wheel and rail and the linearised contact in, H1 G + H2 out.

The steady forces and creepages are equilibrium; everything here is a fluctuation with time factor exp(+j omega t).
Feedback is positive: the tangential forces make velocities through G, and those make forces through H1 and H2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmus.component import Instance
from fmus.contact.component import contact as contact_component
from fmus.contact.law import creep_forces
from fmus.contact.linearised import STEP, LinearContact, linearise
from fmus.contact.parameters import P
from fmus.errors import DataError
from fmus.modal.modes import Modes, mobility
from fmus.modal.parameters import as_declared
from fmus.rail.track import track_mobility
from fmus.rail.track_data import Track

from ..errors import InputError
from .poles import NORMAL, TANGENTIAL

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mobility = Callable[[Real], Complex]
"""(m,) angular frequencies [rad/s] in, (m, 4, 4) velocity per force in track axes out."""

_CORNER = 0.1
"""Relative difference of slopes beyond which there is no slope; cells that begin to slide one by one stay below."""

_CHUNK = 2000
"""Frequencies that are worked on at a time, so that memory stays small."""


def of_modes(modes: Modes) -> Mobility:
    """Return the mobility of a modal structure."""
    return lambda omega: _in_chunks(omega, lambda part: mobility(part, modes))


def of_track(track: Track) -> Mobility:
    """Return the mobility of the analytical track."""
    return lambda omega: _in_chunks(omega, lambda part: track_mobility(part, track))


def remembered(mobility: Mobility) -> Mobility:
    """Return the same mobility; for the frequencies that it is asked for a second time it does not compute again."""
    kept: dict[bytes, Complex] = {}

    def ask(omega: Real) -> Complex:
        if omega.size < _CHUNK:
            return mobility(omega)
        key = omega.tobytes()
        if key not in kept:
            kept.clear()
            kept[key] = mobility(omega)
        return kept[key]

    return ask


def rigid(omega: Real) -> Complex:
    """Return the mobility of a structure that does not move."""
    return np.zeros((omega.size, 4, 4), dtype=complex)


def _in_chunks(omega: Real, function: Mobility) -> Complex:
    """Return the mobilities at many frequencies."""
    parts = np.array_split(omega, max(1, -(-omega.size // _CHUNK)))
    return np.concatenate([function(part) for part in parts if part.size] or [np.zeros((0, 4, 4), dtype=complex)])


@dataclass(frozen=True)
class Loop:
    """The self-excited vibration loop of Fig. 1 of the paper.

    Attributes
    ----------
    wheel, rail : mobilities in track axes
    contact : the contact linearised at its operating point
    """

    wheel: Mobility
    rail: Mobility
    contact: LinearContact

    def mobility(self, omega: Real) -> Complex:
        """Return the mobility of wheel and rail together in contact axes, without the contact spring, (m, 4, 4)."""
        turn = self.contact.turn
        return np.asarray(turn @ (self.wheel(omega) + self.rail(omega)) @ turn.T)

    def open_loop(self, omega: Real) -> Complex:
        """Return H1 G + H2, (m, 3, 3), in the directions lon, lat, spin.

        Notes
        -----
        The normal force is f_n = -(Y_nt / Y_nn) f_t with the spring's j omega / K in Y_nn. So
        G = Y_tt - Y_tn Y_nt / Y_nn and H2 = -h2 Y_nt / Y_nn.
        """
        Y, Y_nn = self._normal(omega)
        t = TANGENTIAL
        normal_force = -Y[:, None, NORMAL, t] / Y_nn[:, None, None]
        G = Y[:, t][:, :, t] + Y[:, t, NORMAL, None] * normal_force
        return np.asarray(self.contact.H1 @ G + self.contact.h2[:, None] * normal_force)

    def lateral(self, omega: Real) -> Complex:
        """Return the lateral eigenlocus by the scalar formula, (m,).

        Notes
        -----
        With a rail without cross terms and no steady longitudinal creepage or spin, lateral and normal motion are on
        their own: lambda = H22 (Y22 - Y23^2 / Y33) - h2 Y23 / Y33. An independent check of `open_loop`.
        """
        Y, Y_nn = self._normal(omega)
        slope, per_load = self.contact.H1[1, 1], self.contact.h2[1]
        return np.asarray(slope * (Y[:, 1, 1] - Y[:, 1, NORMAL] ** 2 / Y_nn) - per_load * Y[:, 1, NORMAL] / Y_nn)

    def _normal(self, omega: Real) -> tuple[Complex, Complex]:
        """Return the mobility in contact axes and its normal entry with the contact spring."""
        Y = self.mobility(omega)
        return Y, Y[:, NORMAL, NORMAL] + 1j * omega / self.contact.stiffness


def linear_contact(parameters: Mapping[str, float] | None = None) -> LinearContact:
    """Return the contact linearised at its operating point, or say why there is no such thing.

    Parameters
    ----------
    parameters : parameters of the contact that differ from the start values

    Raises
    ------
    InputError
        For a parameter out of range, or an operating point where the slope of the friction law is undefined.
    """
    if parameters is not None:
        parameters = as_declared(parameters)
    try:
        _check_smooth(parameters)
        contact = linearise(parameters)
    except (DataError, ZeroDivisionError) as error:
        raise InputError(f"contact: {error}") from None
    return contact


def _check_smooth(parameters: Mapping[str, float] | None) -> None:
    """Raise ValueError where the lateral creep force has a corner, or falls within the step of the difference.

    The slopes to either side and over a tenth of the step must be one number; at a corner, where the last cell of the
    contact patch begins to slide for instance, linear stability has no meaning.
    """
    instance = Instance(contact_component(), parameters)
    instance.initialise()
    p, d = instance.parameters, instance.derived
    lon, lat, spin = p[P.steady_creepage_lon], p[P.steady_creepage_lat], p[P.steady_creepage_spin]

    def force(change: float) -> float:
        return float(creep_forces(p, d, lon, lat + change, spin, p[P.normal_load])[1])

    steps = (STEP, -STEP, STEP / 10)
    slopes = np.array([(force(step) - force(0.0)) / step for step in steps])
    scale = max(float(np.abs(slopes).max()), float(p[P.mu0] * p[P.normal_load]))
    if not np.isfinite(slopes).all() or np.ptp(slopes) > _CORNER * scale:
        raise DataError(
            f"the slope of the friction law is undefined at steady_creepage_lat = {lat:g}: "
            f"{slopes[1]:.4g} N below, {slopes[0]:.4g} N above, {slopes[2]:.4g} N next to it per unit of creepage"
        )
