"""A system run by the master to its end."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.results.file import ResultsFile
from orchestrator.system.model import System


def run(system: System, settings: Settings, path: Path | None = None) -> tuple[Master, np.ndarray]:
    """Run a system; return the master and its last outputs."""
    with Master(assemble(system), settings) as master:
        if path is None:
            master.run()
        else:
            with ResultsFile(path, master.signals(), {"case": "test"}) as results:
                master.run(results)
        return master, master.plan.y.copy()
