"""A PythonFMU FMU `y = k u + b` with parameters of every type, and SSP archives of it, for tests of systems."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pythonfmu.builder import FmuBuilder

from orchestrator.coupling.assembly import Assembly, assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.system.reader import read_system

BLOCK = '''
import ctypes
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String

# PythonFMU 0.7.0 releases this namespace once per instance without owning it
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class {name}(Fmi2Slave):
    """y = n (k u + b) if on, else 0; s is text; m is a whole number that y does not depend on."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.k, self.b, self.n, self.on, self.s, self.m = 0.0, 0.0, 1.0, 0.0, 1, True, "", 0
        fixed = dict(causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed)
        discrete = Fmi2Variability.discrete
        self.register_variable(Real("u", causality=Fmi2Causality.input, start=0.0))
        self.register_variable(Integer("m", causality=Fmi2Causality.input, variability=discrete, start=0))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.register_variable(Integer("steps", causality=Fmi2Causality.output, variability=discrete))
        self.register_variable(Real("k", start=1.0, **fixed))
        self.register_variable(Real("b", start=0.0, **fixed))
        self.register_variable(Integer("n", start=1, **fixed))
        self.register_variable(Boolean("on", start=True, **fixed))
        self.register_variable(String("s", start="", **fixed))
        self.steps = 0

    def do_step(self, current_time, step_size):
        self.steps += 1
        self.y = self.n * (self.k * self.u + self.b) if self.on else 0.0
        return True
'''

NAMESPACES = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in {
        "ssd": "Description", "ssc": "Common", "ssv": "ParameterValues", "ssm": "ParameterMapping",
        "ssb": "SignalDictionary",
    }.items()
)  # fmt: skip


def block_fmu(folder: Path) -> Path:
    """Build the FMU."""
    name = f"Block_{hashlib.sha256(str(folder).encode()).hexdigest()[:8]}"  # all FMUs share sys.modules
    script = folder / f"{name}.py"
    script.write_text(BLOCK.format(name=name))
    return Path(FmuBuilder.build_FMU(script, dest=folder, needsExecutionTool=False))


def connector(name: str, kind: str, unit: str = "", content: str = "") -> str:
    """Return a Connector element of type Real, or of another content."""
    content = content or (f'<ssc:Real unit="{unit}"/>' if unit else "<ssc:Real/>")
    return f'<ssd:Connector name="{name}" kind="{kind}">{content}</ssd:Connector>'


def component(
    name: str, bindings: str = "", units: tuple[str, str] = ("", ""), source: str = "resources/block.fmu",
    more: str = "", connectors: str = "",
) -> str:  # fmt: skip
    """Return a Component element: a block whose input and output have these units."""
    ports = connectors or connector("u", "input", units[0]) + connector("y", "output", units[1])
    return (
        f'<ssd:Component name="{name}" source="{source}" type="application/x-fmu-sharedlibrary">'
        f"<ssd:Connectors>{ports}</ssd:Connectors>{bound(bindings)}{more}</ssd:Component>"
    )


def bound(bindings: str) -> str:
    """Return a ParameterBindings element around bindings, or nothing."""
    return f"<ssd:ParameterBindings>{bindings}</ssd:ParameterBindings>" if bindings else ""


def parameter_set(values: Mapping[str, object], unit: str = "", units: str = "", version: str = "1.0") -> str:
    """Return a ParameterSet element of Real, Integer, Boolean and String parameters."""
    kinds = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}
    rows = ""
    for name, value in values.items():
        kind = kinds[type(value)]
        text = str(value).lower() if kind == "Boolean" else value
        told = f' unit="{unit}"' if unit and kind == "Real" else ""
        rows += f'<ssv:Parameter name="{name}"><ssv:{kind} value="{text}"{told}/></ssv:Parameter>'
    return (
        f'<ssv:ParameterSet {NAMESPACES} version="{version}" name="set"><ssv:Parameters>{rows}</ssv:Parameters>'
        f"{units}</ssv:ParameterSet>"
    )


def inline(values: Mapping[str, object], unit: str = "", mapping: str = "", prefix: str = "") -> str:
    """Return a ParameterBinding element with values inside."""
    told = f' prefix="{prefix}"' if prefix else ""
    inside = f"<ssd:ParameterValues>{parameter_set(values, unit)}</ssd:ParameterValues>"
    return f"<ssd:ParameterBinding{told}>{inside}{mapping}</ssd:ParameterBinding>"


def wire(start: str, end: str, change: str = "", more: str = "") -> str:
    """Return a Connection element; an end without a dot is a connector of the system."""
    ends = ""
    for which, text in (("start", start), ("end", end)):
        element, _, name = text.rpartition(".")
        ends += f' {which}Element="{element}"' if element else ""
        ends += f' {which}Connector="{name}"'
    return f"<ssd:Connection{ends}{more}>{change}</ssd:Connection>"


def system(elements: str, wires: str = "", connectors: str = "", bindings: str = "", name: str = "root") -> str:
    """Return a System element."""
    ports = f"<ssd:Connectors>{connectors}</ssd:Connectors>" if connectors else ""
    links = f"<ssd:Connections>{wires}</ssd:Connections>" if wires else ""
    parts = f"<ssd:Elements>{elements}</ssd:Elements>" if elements else ""
    return f'<ssd:System name="{name}">{ports}{bound(bindings)}{parts}{links}</ssd:System>'


def description(root: str, name: str = "blocks", version: str = "1.0", more: str = "") -> str:
    """Return an SSD around a System element."""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription {NAMESPACES} version="{version}" '
        f'name="{name}">{root}{more}<ssd:DefaultExperiment startTime="0" stopTime="0.01"/>'
        "</ssd:SystemStructureDescription>"
    )


def archive(path: Path, fmu: Path, ssd: str, files: Mapping[str, str | bytes] | None = None) -> Path:
    """Write an SSP with the block as resources/block.fmu."""
    with zipfile.ZipFile(path, "w") as packed:
        packed.writestr("SystemStructure.ssd", ssd)
        packed.write(fmu, "resources/block.fmu")
        for name, content in (files or {}).items():
            packed.writestr(name, content)
    return path


class Run(NamedTuple):
    """What a run of a system left: its assembly and the last real outputs by name."""

    assembly: Assembly
    outputs: dict[str, float]


def simulate(path: Path, steps: int = 12, variant: str | None = None, algorithm: str = "jacobi") -> Run:
    """Run a system through the master; after as many steps as it has blocks in a row, outputs stand still."""
    assembly = assemble(read_system(path, variant))
    with Master(assembly, Settings(1e-3, steps * 1e-3, algorithm)) as master:
        master.run()
        outputs = zip(master.outputs, np.asarray(master.plan.y).tolist(), strict=True)
        return Run(assembly, {f"{element}.{name}": y for (element, name), y in outputs if name == "y"})


PAIR = wire("m1.y", "m2.u")

FROM_FILE = '<ssd:ParameterBinding source="resources/values.ssv"/>'

ONE, TWO = inline({"b": 3.0}), inline({"k": 2.0, "b": 1.0})

FLAT = system(component("m1", ONE) + component("m2", TWO), PAIR)


def mapping(*entries: tuple[str, str, str]) -> str:
    """Return a ParameterMapping element of sources, targets and transformations."""
    rows = "".join(
        f'<ssm:MappingEntry source="{s}" target="{t}">{change}</ssm:MappingEntry>' for s, t, change in entries
    )
    return f'<ssm:ParameterMapping {NAMESPACES} version="1.0">{rows}</ssm:ParameterMapping>'


INNER = system(
    component("m2", TWO),
    wire("u", "m2.u") + wire("m2.y", "y"),
    connector("u", "input") + connector("y", "output"),
    name="inner",
)

UNITS = (
    '<ssd:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>'
    '<ssc:Unit name="ell"><ssc:BaseUnit m="1" factor="0.5"/></ssc:Unit></ssd:Units>'
)


def outputs(tmp_path: Path, fmu: Path, ssd: str, files: Mapping[str, str | bytes] | None = None) -> dict[str, float]:
    """Write a system and return what it puts out in the end."""
    return simulate(archive(tmp_path / "b.ssp", fmu, ssd, files)).outputs
