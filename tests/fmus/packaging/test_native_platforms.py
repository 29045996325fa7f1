"""Native FMUs in hosts that are written in C, and on other platforms."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import lief
import numpy as np
import pytest
from slaves import HEADERS, Slave, binary

from fmus.packaging.build import build_fmu
from fmus.packaging.catalogue import components
from fmus.packaging.native.platforms import PLATFORMS
from fmus.packaging.target import Target

LIBRARIES = {"libc.so.6", "libm.so.6"}


def compile_host(folder: Path, *command: str) -> Path:
    """Compile tests/host.c with a compiler."""
    program = folder / "host"
    source = Path(__file__).parents[2] / "support" / "host.c"
    subprocess.run(
        [*command, "-std=c99", "-O1", "-g", f"-I{HEADERS}", str(source), "-o", str(program)], check=True, timeout=300
    )
    return program


def test_a_host_in_c_runs_without_error_or_leak(native: Path, tmp_path: Path) -> None:
    compiler, valgrind = shutil.which("cc"), shutil.which("valgrind")
    if compiler is None or valgrind is None:
        pytest.skip("needs cc and valgrind")
    program = tmp_path / "host"
    source = Path(__file__).parents[2] / "support" / "host.c"
    command = [
        compiler,
        "-std=c99",
        "-g",
        "-Wall",
        "-Werror",
        f"-I{HEADERS}",
        str(source),
        "-o",
        str(program),
        "-ldl",
        "-lm",
    ]
    subprocess.run(command, check=True, timeout=60)
    library = binary(native / "wheel.fmu", tmp_path)
    guid = fmpy.read_model_description(str(native / "wheel.fmu")).guid
    checked = [valgrind, "--quiet", "--leak-check=full", "--error-exitcode=99", str(program), str(library), guid]
    done = subprocess.run(checked, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    assert np.isfinite(float(done.stdout))


# other platforms


@pytest.fixture(scope="module")
def everywhere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a wheel FMU with the binaries of all platforms."""
    if find_spec("ziglang") is None:
        pytest.skip("needs ziglang")
    folder = tmp_path_factory.mktemp("everywhere")
    return build_fmu(components()["wheel"], folder / "wheel.fmu", Target("native", 2, tuple(PLATFORMS)))


@pytest.mark.slow
def test_one_fmu_holds_binaries_for_all_platforms(everywhere: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(everywhere) as archive:
        found = sorted(n for n in archive.namelist() if n.startswith("binaries/"))
        archive.extractall(tmp_path)
    assert found == [
        "binaries/aarch64-linux/wheel.so",
        "binaries/darwin64/wheel.dylib",
        "binaries/linux64/wheel.so",
        "binaries/win64/wheel.dll",
    ]
    windows = lief.PE.parse(str(tmp_path / "binaries/win64/wheel.dll"))
    assert windows is not None
    imported = {str(i.name).lower() for i in windows.imports}
    assert all(n.startswith(("kernel32", "api-ms-win-crt", "msvcrt", "ucrtbase", "ntdll")) for n in imported)
    exports = windows.get_export()
    assert exports is not None
    assert "fmi2DoStep" in {e.name for e in exports.entries}
    apple = lief.MachO.parse(str(tmp_path / "binaries/darwin64/wheel.dylib"))
    assert apple is not None
    cpus = set()
    for part in (apple.at(i) for i in range(apple.size)):
        assert part is not None
        cpus.add(str(part.header.cpu_type).rsplit(".", 1)[-1])
        assert {library.name for library in part.libraries if "wheel" not in library.name} == {
            "/usr/lib/libSystem.B.dylib"
        }
        exported = {str(s.name) for s in part.exported_symbols} - {"__mh_dylib_header", "___dso_handle"}
        assert "_fmi2DoStep" in exported
        assert all(name.startswith("_fmi2") for name in exported)
    assert cpus == {"X86_64", "ARM64"}
    arm = lief.ELF.parse(str(tmp_path / "binaries/aarch64-linux/wheel.so"))
    assert arm is not None
    assert set(arm.libraries) <= LIBRARIES


@pytest.mark.slow
def test_the_windows_library_runs_under_wine(everywhere: Path, native: Path, tmp_path: Path) -> None:
    """The C host, compiled for Windows: the same last velocity as on this machine, to rounding."""
    wine = shutil.which("wine")
    if wine is None:
        pytest.skip("needs wine")
    source = Path(__file__).parents[2] / "support" / "host.c"
    program = tmp_path / "host.exe"
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu"]
    subprocess.run([*zig, "-std=c99", f"-I{HEADERS}", str(source), "-o", str(program)], check=True, timeout=600)
    library = binary(everywhere, tmp_path, "win64")
    guid = fmpy.read_model_description(str(everywhere)).guid
    environment = {"WINEPREFIX": str(tmp_path / "prefix"), "WINEDEBUG": "-all", "PATH": "/usr/bin:/bin"}
    done = subprocess.run(
        [wine, str(program), str(library), guid], capture_output=True, text=True, check=False, timeout=300,
        env={**environment, "HOME": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    slave = Slave(native / "wheel.fmu")
    for k in range(1000):
        slave.set_inputs(np.array([0.0, 100.0 * np.sin(0.01 * k), 0.0, 0.0]))
        slave.step()
    assert float(done.stdout) == pytest.approx(slave.outputs()[1], rel=1e-12)
    slave.close()
