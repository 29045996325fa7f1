"""Friction laws and memory in every kind of contact FMU: native, of compiled sources, and in Python."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from slaves import Slave, assert_steps_as

from fmus.component import Instance
from fmus.contact.component import contact
from fmus.contact.friction.named import NAMED, friction_table
from fmus.packaging.build import build_fmu
from fmus.packaging.target import Target

LAWS = {
    "creepage": friction_table([0.0, 0.01, 0.019, 0.021, 0.05], [0.3, 0.28, 0.26, 0.25, 0.2]),
    "velocity": friction_table([0.01, 0.19, 0.21, 0.5], [0.2, 0.26, 0.3, 0.25], "velocity"),
    "de-beer": dict(NAMED["de-beer"].values),
    "polach-dry": dict(NAMED["polach-dry"].values),
    "memory": {"creep_law": 2.0, "steady_creepage_lat": 2e-3, "mobility_lat_lat": 4e-6, "mobility_lon_lon": 2e-6},
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["native", "sources", "python"])
def test_every_build_has_the_friction_laws_of_the_component(kind: str, tmp_path: Path) -> None:
    """Over 200 steps, to 1e-12 of each output's largest value; a law is a matter of parameters, not of the build."""
    if kind == "sources" and shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    file = build_fmu(contact(), tmp_path / "contact.fmu", Target("python" if kind == "python" else "native"))
    if kind == "sources":
        command = [sys.executable, "-m", "fmpy", "compile", str(file)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
        assert done.returncode == 0, done.stderr[-2000:]
        assert b"NATIVE_KERNELS" not in file.read_bytes()
    for values in LAWS.values():
        whole = {
            name: int(v) if name in {"friction_law", "friction_points", "creep_law"} else v
            for name, v in values.items()
        }
        assert_steps_as(Slave(file, whole), Instance(contact(), values), 200)
