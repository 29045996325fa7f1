"""Small co-simulation FMUs that do what a table says, of FMI 2.0 and 3.0, and their twins in plain Python.

One library per version of FMI is compiled for all of them (`table_slave.c`); an FMU brings its table as a resource.
"""

from __future__ import annotations

import inspect
import re
import shutil
import subprocess
import zipfile
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

COMPILER = shutil.which("cc")
SOURCE = Path(__file__).parent / "table_slave.c"
WHOLE_SLOTS = 256
"""Slots from here on hold whole numbers."""

UNITS = {"m": 1.0, "mm": 0.001, "km": 1000.0}
"""Factors to metres."""

_FINE = ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "SetDebugLogging")


@dataclass(frozen=True)
class Var:
    """A variable of an FMU; `size` is 0 for a scalar, else the length of an array of FMI 3.0."""

    name: str
    reference: int
    type: str
    causality: str
    slot: int
    start: float | None = None
    size: int = 0
    unit: str = ""
    alias: str = ""

    @property
    def count(self) -> int:
        """Number of its elements."""
        return max(self.size, 1)

    @property
    def elements(self) -> list[str]:
        """Names of its elements, as the master has them."""
        return [f"{self.name}[{k + 1}]" for k in range(self.size)] if self.size else [self.name]

    @property
    def kind(self) -> str:
        """Real, Integer or Boolean."""
        if self.type in ("Real", "Float64", "Float32"):
            return "Real"
        return self.type if self.type in ("Boolean", "String") else "Integer"


@dataclass(frozen=True)
class Rule:
    """What a step ('s') or a look at the outputs ('o') makes of a slot; kind r, w or b as in the slave."""

    when: str
    kind: str
    target: int
    keep: float = 0.0
    add: float = 0.0
    rate: float = 0.0
    terms: tuple[tuple[int, float], ...] = ()


@dataclass(frozen=True)
class Table:
    """An FMU: its variables, what it does, and what it says of itself.

    Attributes
    ----------
    depends : by output, the inputs that it declares to depend on; an output that is missing is silent
    source, token, xml, more : another slave, its GUID, a whole model description, further resources
    """

    name: str
    fmi: int
    variables: tuple[Var, ...]
    rules: tuple[Rule, ...]
    depends: dict[str, tuple[str, ...]] = field(default_factory=dict)
    flags: str = 'canHandleVariableCommunicationStepSize="true"'
    states: bool = True
    source: Path = SOURCE
    token: str = "g"
    xml: str = ""
    more: dict[str, str] = field(default_factory=dict)

    def of(self, *causalities: str) -> list[Var]:
        """Return the variables of some causalities."""
        return [v for v in self.variables if v.causality in causalities]

    def write(self, folder: Path) -> Path:
        """Write the FMU."""
        path = folder / f"{self.name}.fmu"
        place = fmpy.platform if self.fmi == 2 else fmpy.platform_tuple
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", self.xml or (self._xml2() if self.fmi == 2 else self._xml3()))
            if self.source == SOURCE:
                archive.writestr("resources/model.txt", self._table())
            for name, text in self.more.items():
                archive.writestr(f"resources/{name}", text)
            archive.write(library(self.fmi, self.source), f"binaries/{place}/table{fmpy.sharedLibraryExtension}")
        return path

    def _table(self) -> str:
        places = sorted({(v.reference, v.slot, v.count) for v in self.variables})
        lines = [str(len(places)), *(f"{r} {slot} {n}" for r, slot, n in places)]
        starts = [(v.slot + k, v.start) for v in self.variables if v.start is not None for k in range(v.count)]
        lines += [str(len(starts)), *(f"{slot} {float(x)!r}" for slot, x in starts), str(len(self.rules))]
        for r in self.rules:
            terms = " ".join(f"{slot} {weight!r}" for slot, weight in r.terms)
            target = r.target % WHOLE_SLOTS
            lines.append(f"{r.when} {r.kind} {target} {r.keep!r} {r.add!r} {r.rate!r} {len(r.terms)} {terms}")
        return "\n".join(lines)

    def _units(self) -> str:
        used = sorted({v.unit for v in self.variables if v.unit})
        units = "".join(f'<Unit name="{u}"><BaseUnit m="1" factor="{UNITS[u]!r}"/></Unit>' for u in used)
        return f"<UnitDefinitions>{units}</UnitDefinitions>" if used else ""

    def _states(self) -> str:
        name = "canGetAndSetFMUstate" if self.fmi == 2 else "canGetAndSetFMUState"
        return f'{name}="true"' if self.states else ""

    def _xml2(self) -> str:
        rows = ""
        for v in self.variables:
            start = "" if v.start is None else f' start="{_text(v)}"'
            unit = f' unit="{v.unit}"' if v.unit else ""
            rows += (
                f'<ScalarVariable name="{v.name}" valueReference="{v.reference}" causality="{v.causality}" '
                f'variability="{_variability(v)}"><{v.type}{start}{unit}/></ScalarVariable>'
            )
        index = {v.name: k + 1 for k, v in enumerate(self.variables)}
        told = {name: _depends([str(index[n]) for n in needed]) for name, needed in self.depends.items()}
        outputs = "".join(f'<Unknown index="{index[v.name]}"{told.get(v.name, "")}/>' for v in self.of("output"))
        unknowns = "".join(f'<Unknown index="{index[v.name]}"/>' for v in self.of("output"))
        return (
            '<?xml version="1.0" encoding="UTF-8"?>'
            f'<fmiModelDescription fmiVersion="2.0" modelName="{self.name}" guid="{self.token}">'
            f'<CoSimulation modelIdentifier="table" {self._states()} {self.flags}/>{self._units()}'
            f"<ModelVariables>{rows}</ModelVariables><ModelStructure><Outputs>{outputs}</Outputs><InitialUnknowns>"
            f"{unknowns}</InitialUnknowns>"
            "</ModelStructure></fmiModelDescription>"
        )

    def _xml3(self) -> str:
        rows = ""
        for v in self.variables:
            if v.alias:
                continue
            start = "" if v.start is None else f' start="{" ".join([_text(v)] * v.count)}"'
            unit = f' unit="{v.unit}"' if v.unit else ""
            inside = f'<Dimension start="{v.size}"/>' if v.size else ""
            if v.type == "String" and v.start is not None:
                start, inside = "", '<Start value="none"/>'
            inside += "".join(f'<Alias name="{a.name}"/>' for a in self.variables if a.alias == v.name)
            rows += (
                f'<{v.type} name="{v.name}" valueReference="{v.reference}" causality="{v.causality}" '
                f'variability="{_variability(v)}"{start}{unit}>{inside}</{v.type}>'
            )
        rows += '<Float64 name="time" valueReference="255" causality="independent" variability="continuous"/>'
        reference = {v.name: str(v.reference) for v in self.variables}
        main = [v for v in self.of("output") if not v.alias]
        told = {name: _depends([reference[n] for n in needed]) for name, needed in self.depends.items()}
        outputs = "".join(f'<Output valueReference="{v.reference}"{told.get(v.name, "")}/>' for v in main)
        outputs += "".join(f'<InitialUnknown valueReference="{v.reference}"/>' for v in main)
        return (
            f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="3.0" modelName="{self.name}" '
            f'instantiationToken="{self.token}"><CoSimulation modelIdentifier="table" {self._states()} {self.flags}/>'
            f"{self._units()}"
            f"<ModelVariables>{rows}</ModelVariables><ModelStructure>{outputs}"
            "</ModelStructure></fmiModelDescription>"
        )


def _text(v: Var) -> str:
    """Return a start value as XML has it."""
    if v.type == "String":
        return "none"
    if v.kind == "Boolean":
        return "true" if v.start else "false"
    return repr(float(v.start or 0)) if v.kind == "Real" else str(int(v.start or 0))


def _variability(v: Var) -> str:
    if v.causality == "parameter":
        return "tunable"
    return "continuous" if v.kind == "Real" else "discrete"


def _depends(places: list[str]) -> str:
    return f' dependencies="{" ".join(places)}"'


@cache
def library(fmi: int, code: Path = SOURCE) -> Path:
    """Compile the slave for a version of FMI, once."""
    source, folder = code.read_text(), Path(mkdtemp(prefix="table-"))
    pairs = re.findall(r"PAIR\((\w+), fmi" + str(fmi), source)
    there = {f"fmi{fmi}{way}{name}" for name in pairs for way in ("Get", "Set")}
    names = [n for n, _ in inspect.getmembers(FMU2Slave if fmi == 2 else FMU3Slave) if n.startswith(f"fmi{fmi}")]
    stubs = [n for n in names if n not in there and f"{n}(" not in source]
    text = "".join(f"int {n}() {{ return {0 if n[4:] in _FINE else 3}; }}\n" for n in stubs)
    (folder / "stubs.c").write_text(text)
    result = folder / "table.so"
    headers = Path(fmpy.__file__).parent / "c-code"
    subprocess.run(
        [str(COMPILER), "-shared", "-fPIC", "-O1", "-w", "-ffp-contract=off", f"-DFMI={fmi}", "-I", str(headers),
         str(code), str(folder / "stubs.c"), "-o", str(result), "-lm"],
        check=True, capture_output=True,
    )  # fmt: skip
    return result


class Twin:
    """What a table FMU is, in plain Python."""

    def __init__(self, table: Table) -> None:
        self.table = table
        self.slots: dict[int, float | int] = {}
        for v in table.variables:
            for k in range(v.count):
                self.slots.setdefault(v.slot + k, 0.0 if v.kind == "Real" else 0)
                if v.start is not None:
                    self.slots[v.slot + k] = float(v.start) if v.kind == "Real" else int(v.start)
        for rule in table.rules:
            self.slots.setdefault(rule.target, 0.0 if rule.kind == "r" else 0)

    def _apply(self, when: str, h: float) -> None:
        for r in self.table.rules:
            if r.when != when:
                continue
            if r.kind == "r":
                x = r.keep * self.slots[r.target] + r.add + h * r.rate
                for slot, weight in r.terms:
                    x += weight * float(self.slots[slot])
                self.slots[r.target] = x
            elif r.kind == "w":
                n = int(r.add) + (int(self.slots[r.target]) if r.keep else 0)
                n += sum(int(weight) * int(self.slots[slot]) for slot, weight in r.terms)
                self.slots[r.target] = int(np.fmod(n, 100))
            else:
                x = r.add
                for slot, weight in r.terms:
                    x += weight * float(self.slots[slot])
                self.slots[r.target] = int(x > 0)

    def step(self, h: float) -> None:
        """Make a step."""
        self._apply("s", h)

    def get(self, variable: Var) -> list[float | int]:
        """Return the elements of a variable, in its type."""
        self._apply("o", 0.0)
        values = [self.slots[variable.slot + k] for k in range(variable.count)]
        if variable.type == "Float32":
            return [float(np.float32(x)) for x in values]
        if variable.type == "UInt8":
            return [int(x) & 255 for x in values]
        return values

    def set(self, variable: Var, values: list[float | int]) -> None:
        """Set the elements of a variable."""
        for k, x in enumerate(values):
            kept = float(np.float32(x)) if variable.type == "Float32" else x
            self.slots[variable.slot + k] = kept if variable.kind == "Real" else int(kept)
