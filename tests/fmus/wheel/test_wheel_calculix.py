"""The finite elements of a body of revolution against CalculiX' solids, read as a user's results are."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from calculix_ring import write_ring

from fmus.measured.shapes.frd import read_frd
from fmus.measured.shapes.nodal import Extent, at_contact, complete_axes
from fmus.measured.units import read_system
from fmus.wheel.finite_elements.harmonics import AXIAL, RADIAL, harmonic_modes, make_body
from fmus.wheel.finite_elements.mesh import structured_mesh
from fmus.wheel.finite_elements.section import Material

STEEL = Material(210e9, 0.3, 7850.0)
R, Z = np.linspace(0.15, 0.42, 6), np.linspace(0.71, 0.79, 3)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_a_ring_vibrates_as_in_calculix(tmp_path: Path) -> None:
    """A thick disc, 420 mm outside, 16 elements over half of its circle: elastic modes of n = 0 to 3 below 4 kHz.

    Frequencies within 0.5 % (from above: three nodes follow a quarter of a wave of cos 3 theta within that), amplitudes
    at the rim within 1 % of the largest.
    """
    node = write_ring(tmp_path / "ring.inp", R, Z, 16, STEEL, 14)
    environment = {"OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"}
    subprocess.run(["ccx", "ring"], cwd=tmp_path, check=True, capture_output=True, timeout=300, env=environment)
    axes = complete_axes({2: "lon", -3: "lat", -1: "ver"}, "ring")
    found = at_contact(read_frd(tmp_path / "ring.frd", read_system("m,N")), node, axes)
    assert found.extent == Extent("cosine", "whole")
    assert (found.frequency_hz == 0).sum() == 3  # two translations and a rotation that cos n theta has
    body = make_body(structured_mesh(Z, R), STEEL)
    place = np.hypot(body.basis.doflocs[0] - 0.75, body.basis.doflocs[1] - 0.42) < 1e-9
    compared = 0
    for n in range(4):
        motion = "axial" if n == 0 else "all"
        modes = harmonic_modes(body, n, "free", 4000.0, motion)
        elastic = np.flatnonzero(modes.frequency_hz > 0)
        own = np.flatnonzero((found.diameters == n) & (found.frequency_hz > 0) & (found.frequency_hz < 4000.0))
        for k, mode in zip(elastic, own, strict=False):
            assert 0 <= found.frequency_hz[mode] / modes.frequency_hz[k] - 1 < 5e-3
            u = [float(modes.vectors[place & (body.component == c), k][0]) for c in (AXIAL, RADIAL)]
            shape = found.shape[mode, 1:3]
            largest = max(map(abs, u))
            np.testing.assert_allclose(np.abs(shape), np.abs(u), atol=0.01 * largest)
            assert np.sign(shape[0] * shape[1]) == np.sign(u[0] * u[1]) or min(map(abs, u)) < 0.01 * largest
            compared += 1
    assert compared >= 5
