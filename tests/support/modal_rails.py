"""Rails of given modes as other people make them: in C for FMI 2.0 and 3.0, in Python; and systems with them by SSD."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from string import Template

import numpy as np
from pythonfmu.builder import FmuBuilder
from table_fmus import Table

from fmus.interface import DIRECTIONS
from fmus.modal.modes import Modes
from orchestrator.archive import unpack

SOURCE = Path(__file__).parent / "modal_rail.c"

SI = {"f": "N", "v": "m/s", "u": "m"}
FINITE_ELEMENTS = {"f": "kN", "v": "mm/s", "u": "mm"}
"""Units by the first letter of a variable; moments and rotations are SI in both."""

_BASES = {
    "N": 'kg="1" m="1" s="-2"', "kN": 'kg="1" m="1" s="-2" factor="1000"', "m/s": 'm="1" s="-1"',
    "mm/s": 'm="1" s="-1" factor="0.001"', "m": 'm="1"', "mm": 'm="1" factor="0.001"',
    "N.m": 'kg="1" m="2" s="-2"', "rad/s": 'rad="1" s="-1"', "rad": 'rad="1"',
}  # fmt: skip
_SPIN = {"f": "N.m", "v": "rad/s", "u": "rad"}

ARRAYS = {"f": "forces", "v": "velocities", "u": "displacements"}
"""Names of the arrays of FMI 3.0 by the first letter of the contract's names."""


def modes_text(modes: Modes, units: dict[str, str]) -> str:
    """Return the file that the rail in C reads."""
    newton, metre = (1e3, 1e-3) if units is FINITE_ELEMENTS else (1.0, 1.0)
    numbers = np.column_stack([modes.omega / (2 * np.pi), modes.zeta, modes.shape]).tolist()
    rows = [" ".join(repr(x) for x in row) for row in numbers]
    return "\n".join([f"{len(rows)} {newton!r} {metre!r}", *rows]) + "\n"


def c_rail(folder: Path, name: str, modes: Modes, units: dict[str, str] | None = None) -> Path:
    """Write a rail in C of FMI 2.0 with the contract's names; without units it tells none, and is SI."""
    rows = ""
    for kind, (first, causality) in {"f": (1, "input"), "v": (5, "output"), "u": (9, "output")}.items():
        for k, d in enumerate(DIRECTIONS):
            unit = f' unit="{(_SPIN if d == "spin" else units)[kind]}"' if units else ""
            start = ' start="0"' if kind == "f" else ""
            rows += (
                f'<ScalarVariable name="{kind}_{d}" valueReference="{first + k}" causality="{causality}" '
                f'variability="continuous"><Real{start}{unit}/></ScalarVariable>'
            )
    defined = "".join(f'<Unit name="{u}"><BaseUnit {base}/></Unit>' for u, base in _BASES.items())
    unknowns = "".join(f'<Unknown index="{k}" dependencies=""/>' for k in range(5, 13))
    initial = "".join(f'<Unknown index="{k}"/>' for k in range(5, 13))
    xml = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="g">'
        '<CoSimulation modelIdentifier="table" canHandleVariableCommunicationStepSize="true"/>'
        f"{f'<UnitDefinitions>{defined}</UnitDefinitions>' if units else ''}<ModelVariables>{rows}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{initial}</InitialUnknowns></ModelStructure>"
        "</fmiModelDescription>"
    )
    more = {"modes.txt": modes_text(modes, units or SI)}
    return Table(name, 2, (), (), source=SOURCE, xml=xml, more=more).write(folder)


def array_rail(folder: Path, name: str, modes: Modes) -> Path:
    """Write a rail in C of FMI 3.0 whose forces, velocities and displacements are arrays, without units."""
    rows = "".join(
        f'<Float64 name="{array}" valueReference="{reference}" causality="{"input" if kind == "f" else "output"}" '
        f'variability="continuous"{start}><Dimension start="4"/></Float64>'
        for (kind, array), reference, start in zip(ARRAYS.items(), (1, 5, 9), (' start="0 0 0 0"', "", ""), strict=True)
    )
    xml = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="3.0" modelName="{name}" '
        'instantiationToken="g"><CoSimulation modelIdentifier="table" canHandleVariableCommunicationStepSize="true"/>'
        f'<ModelVariables>{rows}<Float64 name="time" valueReference="99" causality="independent" '
        'variability="continuous"/></ModelVariables><ModelStructure><Output valueReference="5" dependencies=""/>'
        '<Output valueReference="9" dependencies=""/><InitialUnknown valueReference="5"/>'
        '<InitialUnknown valueReference="9"/></ModelStructure></fmiModelDescription>'
    )
    more = {"modes.txt": modes_text(modes, SI)}
    return Table(name, 3, (), (), source=SOURCE, xml=xml, more=more).write(folder)


def array_names() -> dict[str, str]:
    """Return the elements of the arrays by the contract's names."""
    return {f"{kind}_{d}": f"{array}[{k + 1}]" for kind, array in ARRAYS.items() for k, d in enumerate(DIRECTIONS)}


SCRIPT = Template('''
import ctypes

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from scipy.linalg import expm

ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
DIRECTIONS = ("lon", "lat", "ver", "spin")
OMEGA, ZETA, SHAPE = (np.array(x) for x in $modes)


class $name(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for kind, causality in (("f", "input"), ("v", "output"), ("u", "output")):
            for d in DIRECTIONS:
                setattr(self, f"{kind}_{d}", 0.0)
                self.register_variable(Real(f"{kind}_{d}", causality=Fmi2Causality[causality]))
        self.q = np.zeros((len(OMEGA), 2))
        self.h = 0.0

    def tables(self, h):
        """Of the block (velocity, displacement, force), scaled so that all its numbers are about one."""
        rows = []
        for w, z in zip(OMEGA, ZETA):
            s = max(1.0, w * h)
            block = expm(np.array([[-2 * z * w * h, -w * w * h * h / s, 1], [s, 0, 0], [0, 0, 0]]))
            rows.append([[block[0, 0], block[0, 1] * s / h, block[0, 2] * h],
                         [block[1, 0] * h / s, block[1, 1], block[1, 2] * h * h / s]])
        self.h, self.phi = h, np.array(rows)

    def do_step(self, _time, h):
        if h != self.h:
            self.tables(h)
        force = SHAPE @ [getattr(self, f"f_{d}") for d in DIRECTIONS]
        v, u = self.q.T
        self.q = self.phi[:, :, 0] * v[:, None] + self.phi[:, :, 1] * u[:, None] + self.phi[:, :, 2] * force[:, None]
        for kind, values in zip("vu", self.q.T @ SHAPE):
            for d, x in zip(DIRECTIONS, values):
                setattr(self, f"{kind}_{d}", float(x))
        return True
''')


def python_rail(folder: Path, name: str, modes: Modes) -> Path:
    """Build a rail by PythonFMU that steps by matrix exponentials of its own."""
    script = folder / f"{name}_script.py"
    data = (modes.omega.tolist(), modes.zeta.tolist(), modes.shape.tolist())
    script.write_text(SCRIPT.substitute(name=name, modes=repr(data)))
    return Path(FmuBuilder.build_FMU(script, dest=folder, needsExecutionTool=False))


def system_with(folder: Path, ssp: Path, rail: Path, names: dict[str, str] | None = None) -> Path:
    """Write the system of an SSP with another rail as an SSD that names the rail's variables.

    Parameters
    ----------
    names : variables of the rail by the contract's names, where they differ
    """
    inside = unpack(ssp, "SSP")
    text = (inside / "SystemStructure.ssd").read_text(encoding="utf-8")
    shutil.copytree(inside / "resources", folder / "resources", dirs_exist_ok=True)
    shutil.copy(rail, folder / "resources")
    head, rest = text.split('<ssd:Component name="rail"', 1)
    own, rest = rest.split("</ssd:Component>", 1)
    own = re.sub(r'source="[^"]*"', f'source="resources/{rail.name}"', own, count=1)
    own = re.sub(r"<ssd:(Connectors|ParameterBindings)>.*?</ssd:\1>", "", own, flags=re.DOTALL)
    for name, variable in (names or {}).items():
        rest = rest.replace(
            f'startElement="rail" startConnector="{name}"', f'startElement="rail" startConnector="{variable}"'
        )
        rest = rest.replace(f'endElement="rail" endConnector="{name}"', f'endElement="rail" endConnector="{variable}"')
    ssd = folder / f"{rail.stem}.ssd"
    ssd.write_text(f'{head}<ssd:Component name="rail"{own}</ssd:Component>{rest}', encoding="utf-8")
    return ssd
