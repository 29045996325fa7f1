"""Our SSP in ecos, a co-simulation tool that is not ours, in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.system.reader import read_system

H = 5e-6
STEPS = 2000

SCRIPT = """
import json, sys
from ecospy import EcosSimulation
with EcosSimulation(ssp_path=sys.argv[1], step_size=float(sys.argv[2])) as simulation:
    assert simulation.init(parameter_set="initialValues")
    simulation.step(int(sys.argv[3]))
    names = json.loads(sys.argv[4])
    print("RESULT" + json.dumps([simulation.get_real(name) for name in names]))
    simulation.terminate()
"""


@pytest.mark.slow
def test_ecos_runs_the_ssp_and_agrees_with_our_jacobi(built: Path) -> None:
    """Ecos couples by Jacobi, so the same FMUs with our `jacobi` must give its numbers.

    It makes no exchange after the initialisation; the run starts from rest, where that changes nothing.
    """
    ssp = built / "curvesqueal.ssp"
    with Master(assemble(read_system(ssp)), Settings(H, STEPS * H, "jacobi")) as master:
        master.run()
        names = [f"{component}::{variable}" for component, variable in master.outputs]
        ours = master.plan.y.copy()
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(ssp), str(H), str(STEPS), json.dumps(names)],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    if "libtbb" in done.stderr:
        pytest.skip("ecospy needs the Debian package libtbb12")
    line = next((text for text in done.stdout.splitlines() if text.startswith("RESULT")), None)
    assert line is not None, done.stderr[-2000:]
    theirs = np.array(json.loads(line.removeprefix("RESULT")))
    compared = [i for i, name in enumerate(names) if name.endswith(("_lat", "_ver", "normal_force"))]
    scale = abs(ours[compared])
    assert scale.max() > 1e4
    assert (abs(theirs - ours)[compared] <= 1e-6 * np.maximum(scale, 1e-12)).all()
