"""A generic state-space FMU of FMI 3.0, built with the host's C compiler: x' = A x + B u, y = C x + D u, as arrays.

It steps exactly with the input held. `fault` makes it misbehave at step `fault_step`, for tests of the master.
"""

from __future__ import annotations

import shutil
import subprocess
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import fmpy
import numpy as np
import pytest
from numpy.typing import NDArray

COMPILER = shutil.which("cc")

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the FMI 3.0 test FMUs")

FAULTS = ("none", "discard", "error", "fatal", "nan", "end", "crash", "hang")
"""What `fault` can be, by number."""

TOKEN = "{9f2b7c52-state-space}"

VARIABLES = (
    "u",
    "y",
    "A",
    "B",
    "C",
    "D",
    "x0",
    "steps",
    "positive",
    "enable",
    "single",
    "fault",
    "fault_step",
    "order",
)
"""By value reference, 1 first."""

SOURCE = (Path(__file__).parent / "fmi3_state_space.c").read_text()


@dataclass(frozen=True)
class StateSpace:
    """The matrices, as an FMU has them as start values."""

    A: Any
    B: Any
    C: Any
    D: Any = None

    def matrices(self) -> tuple[NDArray[np.float64], ...]:
        """Return A, B, C and D as arrays."""
        A, B, C = (np.atleast_2d(np.asarray(x, dtype=float)) for x in (self.A, self.B, self.C))
        D = np.zeros((len(C), B.shape[1])) if self.D is None else np.atleast_2d(np.asarray(self.D, dtype=float))
        return A, B, C, D


def state_space_fmu(
    folder: Path, name: str, system: StateSpace, fixed_step: float | None = None, keeps_state: bool = True
) -> Path:
    """Build an FMU of a state space; inputs `u`, outputs `y`, parameters `A`, `B`, `C`, `D`, initial state `x0`."""
    A, B, C, D = system.matrices()
    n, m, p = len(A), B.shape[1], len(C)
    build = folder / f"{name}.build"
    library = build / "binaries" / fmpy.platform_tuple / f"{name}.so"
    library.parent.mkdir(parents=True)
    defines = {"N": n, "M": m, "P": p, "TOKEN": f'"{TOKEN}"'}
    header = "".join(f"#define {key} {value}\n" for key, value in defines.items())
    header += "".join(
        f"#define {key}_START {_braces(value)}\n" for key, value in zip("ABCD", (A, B, C, D), strict=True)
    )
    source = build / f"{name}.c"
    source.write_text(header + SOURCE + _stubs())
    headers = Path(fmpy.__file__).parent / "c-code"
    command = [
        str(COMPILER),
        "-shared",
        "-fPIC",
        "-O1",
        "-w",
        "-I",
        str(headers),
        str(source),
        "-o",
        str(library),
        "-lm",
    ]
    subprocess.run(command, check=True, capture_output=True)
    description = _description(name, (A, B, C, D), fixed_step, keeps_state)
    (build / "modelDescription.xml").write_bytes(b'<?xml version="1.0" encoding="UTF-8"?>' + tostring(description))
    fmu = folder / f"{name}.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        for path in (build / "modelDescription.xml", library):
            archive.write(path, path.relative_to(build).as_posix())
    return fmu


def _braces(values: NDArray[np.float64]) -> str:
    return "{" + ", ".join(repr(float(x)) for x in values.ravel()) + "}"


def _stubs() -> str:
    """Return the functions that the library has to export and nobody calls."""
    import inspect  # noqa: PLC0415 - only here

    from fmpy.fmi3 import FMU3Slave  # noqa: PLC0415

    names = [name for name, _ in inspect.getmembers(FMU3Slave) if name.startswith("fmi3")]
    return "".join(
        f"EXPORT fmi3Status {name}() {{ return fmi3Error; }}\n" for name in names if f"{name}(" not in SOURCE
    )


def _description(
    name: str, matrices: Sequence[NDArray[np.float64]], fixed_step: float | None, keeps_state: bool
) -> Element:
    A, B, C, D = matrices
    n, m, p = len(A), B.shape[1], len(C)
    root = Element("fmiModelDescription", fmiVersion="3.0", modelName=name, instantiationToken=TOKEN)
    keeps = str(keeps_state).lower()
    interface = {
        "modelIdentifier": name, "canGetAndSetFMUState": keeps, "canSerializeFMUState": keeps,
        "canHandleVariableCommunicationStepSize": str(fixed_step is None).lower(),
    }  # fmt: skip
    if fixed_step is not None:
        interface["fixedInternalStepSize"] = repr(fixed_step)
    SubElement(root, "CoSimulation", interface)
    variables = SubElement(root, "ModelVariables")

    def add(name: str, kind: str, causality: str, shape: tuple[int | str, ...] = (), **more: str) -> None:
        vr = str(VARIABLES.index(name) + 1)
        variable = SubElement(variables, kind, {"name": name, "valueReference": vr, "causality": causality, **more})
        for size in shape:
            attribute = (
                {"start": str(size)} if isinstance(size, int) else {"valueReference": str(VARIABLES.index(size) + 1)}
            )
            SubElement(variable, "Dimension", attribute)

    def parameter(name: str, values: NDArray[np.float64], shape: tuple[int | str, ...]) -> None:
        text = " ".join(repr(float(x)) for x in values.ravel())
        add(name, "Float64", "parameter", shape, variability="fixed", initial="exact", start=text)

    SubElement(variables, "Float64", name="time", valueReference="0", causality="independent", variability="continuous")
    add("u", "Float64", "input", (m,), start=" ".join(["0"] * m))
    add("y", "Float64", "output", (p,))
    for letter, matrix, shape in zip("ABCD", matrices, ((n, n), (n, m), (p, n), (p, m)), strict=True):
        parameter(letter, matrix, shape)
    parameter("x0", np.zeros(n), ("order",))
    add("steps", "Int32", "output")
    add("positive", "Boolean", "output")
    add("enable", "Boolean", "input", start="true", variability="discrete")
    add("single", "Float32", "output")
    for fault in ("fault", "fault_step"):
        add(fault, "Int32", "parameter", variability="fixed", initial="exact", start="0" if fault == "fault" else "1")
    add("order", "UInt64", "structuralParameter", variability="fixed", start=str(n))
    structure = SubElement(root, "ModelStructure")
    outputs = ("y", "steps", "positive", "single")
    for output in outputs:
        known = "1" if D.any() else ""
        SubElement(structure, "Output", valueReference=str(VARIABLES.index(output) + 1), dependencies=known)
    for output in outputs:
        SubElement(structure, "InitialUnknown", valueReference=str(VARIABLES.index(output) + 1))
    return root


def write_ssd(path: Path, components: dict[str, Path], wires: Sequence[tuple[str, str]], stop: float = 0.01) -> Path:
    """Write an SSD of components and connections such as ("a.y[1]", "b.u[1]")."""
    ends = [end.split(".", 1) for wire in wires for end in wire]
    connectors = {
        name: "".join(
            f'<ssd:Connector name="{variable}" kind="{kind}"/>'
            for kind, side in (("output", 0), ("input", 1))
            for variable in dict.fromkeys(
                ends[2 * i + side][1] for i in range(len(wires)) if ends[2 * i + side][0] == name
            )
        )
        for name in components
    }
    connectors = {name: f"<ssd:Connectors>{text}</ssd:Connectors>" if text else "" for name, text in connectors.items()}
    elements = "".join(
        f'<ssd:Component name="{name}" source="{file.name}">{connectors[name]}</ssd:Component>'
        for name, file in components.items()
    )
    connections = "".join(
        f'<ssd:Connection startElement="{a}" startConnector="{x}" endElement="{b}" endConnector="{y}"/>'
        for (a, x), (b, y) in zip(ends[::2], ends[1::2], strict=True)
    )
    path.write_text(
        '<?xml version="1.0" encoding="UTF-8"?><ssd:SystemStructureDescription version="1.0" name="system" '
        'xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
        'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">'
        f'<ssd:System name="root"><ssd:Elements>{elements}</ssd:Elements>'
        f"{connections and f'<ssd:Connections>{connections}</ssd:Connections>'}</ssd:System>"
        f'<ssd:DefaultExperiment startTime="0" stopTime="{stop}"/></ssd:SystemStructureDescription>'
    )
    return path
