"""The command line in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def curvesqueal(*arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command line; fail on a traceback."""
    command = [sys.executable, "-m", "orchestrator", *arguments]
    environment = {**os.environ, "COLUMNS": "100"}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=300, cwd=folder, env=environment
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done
