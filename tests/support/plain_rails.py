"""Rails as other people write them: PythonFMU scripts with the contract's names, and with one fault each if wanted."""

from __future__ import annotations

from pathlib import Path
from string import Template

from pythonfmu.builder import FmuBuilder

SCRIPT = Template("""
import ctypes
import math
from xml.etree.ElementTree import SubElement
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
UNITS = $units
BASE = {"kN": dict(kg="1", m="1", s="-2", factor="1000"), "mm/s": dict(m="1", s="-1", factor="0.001"),
        "mm": dict(m="1", factor="0.001")}
AXES = {"lat": ($mass, $damping, 4.0e7), "ver": (150.0, 1.0e5, 1.1e8)}


class $name(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.state = {axis: (0.0, 0.0) for axis in AXES}
        for axis in AXES:
            for name, causality in (("$f", "input"), ("$v", "output"), ("u_", "output")):
                setattr(self, name + axis, 0.0)
                self.register_variable(Real(name + axis, causality=Fmi2Causality[causality]))
        self.extra = 0.0
        self.register_variable(Real("extra", causality=Fmi2Causality.input, start=0.0))

    def to_xml(self, *options):
        root = super().to_xml(*(options or ({},)))
        if UNITS:
            definitions = SubElement(root, "UnitDefinitions")
            for name, base in BASE.items():
                SubElement(SubElement(definitions, "Unit", name=name), "BaseUnit", base)
            order = [child.tag for child in root].index("CoSimulation") + 1
            root.remove(definitions)
            root.insert(order, definitions)
            for variable in root.iter("ScalarVariable"):
                unit = UNITS.get(variable.get("name")[0])
                if unit and variable.get("name") != "extra":
                    variable.find("Real").set("unit", unit)
        return root

    def do_step(self, _time, h):
        for axis, (m, c, k) in AXES.items():
            force = $sign * $newton * getattr(self, "$f" + axis) + $push
            v, u = self.state[axis]
            shown = v, u
            middle = (m * v + h / 2 * (force - k * u)) / (m + h / 2 * c + h**2 / 4 * k)
            self.state[axis] = v, u = 2 * middle - v, u + h * middle
            if $late:
                v, u = shown
            setattr(self, "$v" + axis, v / $metre)
            setattr(self, "u_" + axis, $way * u / $metre)
        return True
""")

DEFAULTS = {
    "f": "f_", "v": "v_", "sign": "1.0", "late": "False", "newton": "1.0", "metre": "1.0", "units": "{}",
    "mass": "60.0", "damping": "6.0e4", "push": "0.0", "way": "1.0",
}  # fmt: skip
"""A rail of 60 and 150 kg that moves in lat and ver only, integrated by the midpoint rule, SI."""

KILO = {"newton": "1e3", "metre": "1e-3", "units": '{"f": "kN", "v": "mm/s", "u": "mm"}'}
"""The same in kN, mm/s and mm, as its model description says."""


def plain_rail(folder: Path, name: str, **changes: str) -> Path:
    """Build the rail with some of `DEFAULTS` changed, as NAME.fmu."""
    script = folder / f"{name}_script.py"  # all FMUs of a process share sys.modules
    script.write_text(SCRIPT.substitute({**DEFAULTS, "name": name, **changes}))
    return Path(FmuBuilder.build_FMU(script, dest=folder, needsExecutionTool=False))
