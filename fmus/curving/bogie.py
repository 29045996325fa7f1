"""A bogie in curves: curve in, what each of its wheels does out. The vehicle component without FMI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..component import Instance
from ..errors import DataError
from .component import INPUTS, vehicle
from .contact_table import ContactTable
from .layout import WHEEL_OUTPUTS, WHEELS, S, W

FAILURES = {
    1: "the equations have no solution that follows from a wider curve",
    2: "a wheel lifts off its rail",
    3: "a wheel climbs its flange, beyond the contact geometry that is known",
}
"""Why there is no steady state, by the value of the component's local variable `failed`."""


@dataclass(frozen=True)
class Curve:
    """A piece of track of constant curvature, and how it is run through.

    Attributes
    ----------
    curvature : 1/radius, positive in a left curve [1/m]
    speed : [m/s]
    cant : height of the outer rail above the inner one [m]
    friction : Coulomb friction coefficient [-]
    """

    curvature: float
    speed: float = 10.0
    cant: float = 0.0
    friction: float = 0.3

    def __post_init__(self) -> None:
        """Check that the component takes these values; on straight track, where no rail is the outer one, no cant."""
        for value, (name, unit, _, low, high, *_) in zip(self.inputs, INPUTS, strict=True):
            if not low <= value <= high:
                raise DataError(f"{name} = {value:g} {unit}: must be in the range {low:g} to {high:g}")

    @property
    def inputs(self) -> tuple[float, float, float, float]:
        """The component's inputs; its cant lifts the right rail, which is the outer one of a left curve."""
        return self.curvature, self.speed, math.copysign(1.0, self.curvature) * self.cant, self.friction


@dataclass(frozen=True)
class WheelState:
    """What a wheel does in a curve, in the axes of the contact component: lateral is to the gauge side.

    Attributes
    ----------
    steady_creepage_lon, steady_creepage_lat, steady_creepage_spin : gamma1, gamma2 [-], gamma6 [1/m]
    normal_load : [N]
    contact_angle : [rad]
    wheel_position, rail_position : of the contact, from tape circle and rail's crown to the field side [m]
    semi_axis_lon, semi_axis_lat : of the contact ellipse [m]
    hertz_stiffness : of the contact spring [N/m]
    creep_force_lon, creep_force_lat : on the wheel, in the contact plane [N]
    friction_utilisation : creep force over friction coefficient times normal force [-]
    lateral_force : on the wheel, to the gauge side [N]
    """

    steady_creepage_lon: float
    steady_creepage_lat: float
    steady_creepage_spin: float
    normal_load: float
    contact_angle: float
    wheel_position: float
    rail_position: float
    semi_axis_lon: float
    semi_axis_lat: float
    hertz_stiffness: float
    creep_force_lon: float
    creep_force_lat: float
    friction_utilisation: float
    lateral_force: float


@dataclass(frozen=True)
class BogieState:
    """A bogie in a curve.

    Attributes
    ----------
    wheels : by `leading_left`, `leading_right`, `trailing_left`, `trailing_right`
    shift : (leading, trailing) axle to the left [m]
    yaw : (leading, trailing) axle against the radial direction, counter-clockwise [rad]
    iterations : of Newton's method
    residual : largest of the equations, relative to the axle load
    """

    wheels: Mapping[str, WheelState]
    shift: tuple[float, float]
    yaw: tuple[float, float]
    iterations: int
    residual: float

    def place(self, curvature: float, wheel: str) -> WheelState:
        """Return the wheel called `leading_inner`, `leading_outer`, `trailing_inner` or `trailing_outer`."""
        axle, _, side = wheel.partition("_")
        left = (side == "inner") == (curvature >= 0)
        return self.wheels[f"{axle}_{'left' if left else 'right'}"]


PLACES = ("leading_inner", "leading_outer", "trailing_inner", "trailing_outer")
"""The wheels of a bogie as a curve names them."""


class Bogie:
    """A bogie on its way through curves; each solution starts from the last one.

    Parameters
    ----------
    parameters : of the vehicle component that differ from those of the reference vehicle
    table : contact geometry; None: cone and arc
    """

    def __init__(self, parameters: Mapping[str, float] | None = None, table: ContactTable | None = None) -> None:
        self.instance = Instance(vehicle("vehicle", parameters, table))
        self._started = False

    def solve(self, curve: Curve) -> BogieState:
        """Return the steady state in a curve.

        Raises
        ------
        DataError
            If there is none; the sentence names the radius that was reached.
        """
        self.instance.inputs[:] = curve.inputs
        self._started = (self._started and self._try(start=False)) or self._try(start=True)
        if not self._started:
            why = FAILURES[int(self.instance.state[S.failed])]
            if curve.curvature == 0:
                raise DataError(f"no steady state on straight track: {why}")
            raise DataError(
                f"no steady state in a curve of {1 / abs(curve.curvature):g} m radius: {why}; "
                f"found down to a radius of {self.instance.state[S.reached]:.4g} m"
            )
        return self._state()

    def _try(self, start: bool) -> bool:
        """Return whether there is a solution that follows from straight track or from the last one."""
        try:
            if start:
                self.instance.initialise()
            else:
                self.instance.do_step(1.0)
        except DataError:
            return False
        return True

    def _state(self) -> BogieState:
        """Return the outputs by name."""
        values = self.instance.outputs.tolist()
        names = W._fields[:WHEEL_OUTPUTS]
        wheels = {
            wheel: WheelState(**dict(zip(names, values[i * WHEEL_OUTPUTS : (i + 1) * WHEEL_OUTPUTS], strict=True)))
            for i, wheel in enumerate(WHEELS)
        }
        y1, yaw1, y2, yaw2, iterations, residual = values[4 * WHEEL_OUTPUTS :]
        return BogieState(wheels, (y1, y2), (yaw1, yaw2), int(iterations), residual)
