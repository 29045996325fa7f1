"""Where an instance of an FMU finds its resources: a folder of its own, so that no other sees what it writes there.

Instances of this project's own FMUs write nothing but compiled kernels, which are worth keeping: they share the folder
that the FMU was unpacked into.
"""

from __future__ import annotations

import shutil
import tempfile
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from .file import Fmu

OWN_TOOL = "curvesqueal"
"""How the generation tool of this project's own FMUs begins."""


@dataclass
class InstanceFolder:
    """A folder that has the resources of an FMU; closing it removes what is only there for one instance."""

    path: Path
    _exit: ExitStack = field(default_factory=ExitStack)

    def close(self) -> None:
        """Remove the folder if it belongs to one instance."""
        self._exit.close()


def instance_folder(fmu: Fmu) -> InstanceFolder:
    """Return the folder for a new instance."""
    resources = fmu.folder / "resources"
    own = (fmu.description.generationTool or "").startswith(OWN_TOOL)
    if own or not resources.is_dir() or not any(resources.iterdir()):
        return InstanceFolder(fmu.folder)
    usual = tempfile.gettempdir()
    plain = usual.isascii() and not set("#%") & set(usual)  # PythonFMU cannot load from other paths
    path = Path(tempfile.mkdtemp(dir=usual if plain else fmu.folder.parent, prefix="curvesqueal-"))
    shutil.copytree(resources, path / "resources")
    folder = InstanceFolder(path)
    folder._exit.callback(shutil.rmtree, path, ignore_errors=True)
    return folder
