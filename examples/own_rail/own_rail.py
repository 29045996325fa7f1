"""A rail by hand: a damped mass on a spring in each direction; x forward, y to the field side, z down; kN, mm, mm/s."""

import ctypes

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

# PythonFMU 0.7.0 gives back this script's namespace once too often per instance: keep one reference for each.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))

RAIL = {  # mass, damping, stiffness: kg, N s/m, N/m; for yaw kg m2, N m s, N m
    "X": (300.0, 3.0e5, 3.0e7),
    "Y": (60.0, 6.0e4, 2.0e7),
    "Z": (150.0, 1.0e5, 1.1e8),
    "Yaw": (0.5, 1.5e3, 1.0e6),
}


class OwnRail(Fmi2Slave):
    """Inputs force*, outputs speed* and position*; each axis is integrated by the implicit midpoint rule."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for axis in RAIL:
            for name, causality in (("force", "input"), ("speed", "output"), ("position", "output")):
                setattr(self, name + axis, 0.0)
                self.register_variable(Real(name + axis, causality=Fmi2Causality[causality]))

    def do_step(self, _time, step_size):
        """Advance each axis; the midpoint rule neither makes nor loses energy, so the rail stays passive."""
        h = step_size
        for axis, (m, c, k) in RAIL.items():
            force, speed, position = (getattr(self, name + axis) for name in ("force", "speed", "position"))
            newton, metre = (1.0, 1.0) if axis == "Yaw" else (1e3, 1e-3)
            f, v, u = force * newton, speed * metre, position * metre
            middle = (m * v + h / 2 * (f - k * u)) / (m + h / 2 * c + h**2 / 4 * k)
            setattr(self, "speed" + axis, (2 * middle - v) / metre)
            setattr(self, "position" + axis, (u + h * middle) / metre)
        return True
