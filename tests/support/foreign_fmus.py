"""Small FMUs of FMI 2.0 that a master must get right: a slave in C, and what its step does as a statement."""

from __future__ import annotations

import re
import subprocess
import tempfile
import zipfile
from collections.abc import Iterable
from pathlib import Path

import fmpy
import numpy as np
from table_fmus import COMPILER

HERE = Path(__file__).parent
ANY_STEP = 'canHandleVariableCommunicationStepSize="true"'


def variable(name: str, reference: int, causality: str, kind: str = "Real", start: object = None) -> str:
    """Return the description of a variable."""
    variability = "tunable" if causality == "parameter" else "continuous" if kind == "Real" else "discrete"
    told = "" if start is None else f' start="{start}"'
    return (
        f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
        f'variability="{variability}"><{kind}{told}/></ScalarVariable>'
    )


Y = variable("y", 1, "output")
U = variable("u", 0, "input", start=0)


def foreign_fmu(
    path: Path,
    variables: str,
    *,
    step: str = "",
    init: str = "",
    create: str = "",
    attributes: str = ANY_STEP,
    before: str = "",
    depends: str | None = None,
    more: dict[str, str] | None = None,
    ends: bool = False,
) -> Path:
    """Compile a slave whose calls do these statements into an FMU.

    Parameters
    ----------
    attributes : of the element CoSimulation
    before : elements before ModelVariables
    depends : dependencies of every output; None: not told
    more : further files
    ends : whether a discarded step is the end of the simulation (fmi2Terminated)
    """
    name = re.sub(r"\W", "_", path.stem)
    told = "" if depends is None else f' dependencies="{depends}"'
    tags = re.findall(r"<ScalarVariable [^>]*>", variables)
    outputs = [k + 1 for k, tag in enumerate(tags) if 'causality="output"' in tag]
    told_outputs = "".join(f'<Unknown index="{k}"{told}/>' for k in outputs)
    unknowns = "".join(f'<Unknown index="{k}"/>' for k in outputs)
    xml = (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="g-{name}">'
        f'<CoSimulation modelIdentifier="{name}" {attributes}/>{before}<ModelVariables>{variables}</ModelVariables>'
        f"<ModelStructure><Outputs>{told_outputs}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>"
        "</fmiModelDescription>"
    )
    headers = Path(fmpy.__file__).parent / "c-code"
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(path, "w") as archive:
        library = Path(folder) / f"{name}.so"
        macros = [f"-DSTEP={step}", f"-DINIT={init}", f"-DCREATE={create}"]
        macros += ["-DTERMINATED=1"] if ends else []
        command = [str(COMPILER), "-shared", "-fPIC", "-O1", "-w", "-I", str(headers), *macros]
        subprocess.run([*command, str(HERE / "foreign_slave.c"), "-o", str(library)], check=True, capture_output=True)
        archive.writestr("modelDescription.xml", xml)
        archive.write(library, f"binaries/{fmpy.platform}/{library.name}")
        for file, text in (more or {}).items():
            archive.writestr(file, text)
    return path


class Rows:
    """Takes the rows of a run and keeps them."""

    path = Path()

    def __init__(self) -> None:
        self.times: list[float] = []
        self.parts: list[np.ndarray] = []
        self.rows = 0

    def append(self, time: np.ndarray, rows: np.ndarray) -> None:
        """Keep rows."""
        self.times += time.tolist()
        self.parts.append(rows.copy())
        self.rows += len(time)

    def sync(self) -> None:
        """Do nothing."""

    def columns(self, signals: Iterable[object]) -> dict[str, np.ndarray]:
        """Return the values of each signal by name."""
        table = np.vstack(self.parts)
        return {s.name: s.values(table, k) for k, s in enumerate(signals)}  # type: ignore[attr-defined]
