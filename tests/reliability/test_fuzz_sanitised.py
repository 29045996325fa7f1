"""Random calls of the C API of FMUs whose entry points and kernels are compiled with ASan and UBSan: nothing found."""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import pytest
from figures import count, write_figure

COMPILER = shutil.which("gcc") or shutil.which("clang")
FLAGS = ["-std=c11", "-g", "-O1", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
pytestmark = [pytest.mark.slow, pytest.mark.skipif(COMPILER is None, reason="needs a compiler with sanitizers")]


def compiled(fmu: Path, version: int, folder: Path) -> tuple[Path, Path]:
    """Return the program that calls, and the library of the FMU's C sources, both with the sanitizers."""
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder / "fmu")
    library, program = folder / "component.so", folder / "fuzz"
    sources = folder / "fmu" / "sources"
    common = [str(COMPILER), *FLAGS]
    own = ["-shared", "-fPIC", "-I", str(sources), "-o", str(library), str(sources / f"fmi{version}.c"), "-lm"]
    caller = [f"-DFMI={version}", "-w", "-o", str(program), str(Path(__file__).parents[1] / "support" / "fuzz.c")]
    for command in ([*common, *own], [*common, *caller, "-ldl", "-lm"]):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if "cannot find -lasan" in done.stderr or "cannot find -lubsan" in done.stderr:
            pytest.skip("the compiler has no sanitizers")
        assert done.returncode == 0, done.stderr
    return program, library


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", ["wheel", "rail", "contact", "curvesqueal"])
def test_random_calls(request: pytest.FixtureRequest, tmp_path: Path, name: str, version: int) -> None:
    """Every status is one of the standard's, steps are made between the errors, and the sanitizers say nothing."""
    fmu = request.getfixturevalue("native" if version == 2 else "native3") / f"{name}.fmu"
    call_at_random(fmu, version, tmp_path)


def call_at_random(fmu: Path, version: int, folder: Path) -> None:
    """Call an FMU at random, and keep the figures."""
    program, library = compiled(fmu, version, folder)
    about = fmpy.read_model_description(str(fmu))
    calls = count(20_000, 1_000_000)
    token = about.guid if version == 2 else about.instantiationToken
    command = [str(program), str(library), token, str(calls), "1", str(len(about.modelVariables))]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=6000)
    assert done.returncode == 0, done.stderr[-2000:]
    assert not re.search("Sanitizer|runtime error", done.stderr)
    made, fine, steps = map(int, done.stdout.split())
    assert made == calls
    assert steps > calls / 500
    assert fine < calls
    write_figure(
        f"random calls of {fmu.name}, FMI {version}.0, ASan and UBSan in entry points and kernels",
        f"{made:,} calls",
        f"nothing; {fine:,} answered OK, {steps:,} steps",
    )
