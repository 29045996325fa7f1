"""Everything that is built: the FMUs and the SSP, into one folder."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from ..component import Component
from ..contact.component import contact
from ..interface import DEFAULT_STEP
from ..rail.component import discrete_rail, paper_rail, rail, rigid_rail
from ..wheel.component import wheel
from ..wheel.wheelset import DATA, read_wheelset
from .archive import write_files
from .python_fmu import build_python_fmu
from .system_structure import read_cases, ssp_files, system_mobility

SSP_NAME = "curvesqueal.ssp"


def components() -> dict[str, Component]:
    """Return every component that is shipped, by the name of its FMU file without suffix."""
    the_wheel, the_rail = wheel(), rail()
    return {
        "wheel": the_wheel,
        "wheel-generic840": wheel(read_wheelset(DATA / "generic840.toml").modes),
        "rail": the_rail,
        "rail-paper": paper_rail(),
        "rail-rigid": rigid_rail(),
        "rail-discrete": discrete_rail(),
        "contact": contact(system_mobility([the_wheel, the_rail], DEFAULT_STEP)),
    }


def build(folder: Path, report: Callable[[Path], None] = lambda _: None) -> Path:
    """Build all FMUs and the SSP into `folder`; return the SSP.

    Parameters
    ----------
    folder : created if it does not exist
    report : called with each file when it is written
    """
    folder.mkdir(parents=True, exist_ok=True)
    built = components()
    cases = read_cases()
    files = ssp_files(built, cases)
    used = {"wheel", "contact", *(case.rail for case in cases)}
    for name, component in built.items():
        fmu = build_python_fmu(component, folder / f"{name}.fmu", version("curvesqueal"))
        if name in used:
            files[f"resources/{name}.fmu"] = fmu.read_bytes()
        report(fmu)
    ssp = folder / SSP_NAME
    write_files(files, ssp)
    report(ssp)
    return ssp


def write_system_structure(folder: Path) -> None:
    """Write the SSDs and SSVs of the SSP below `folder`, as the repository keeps them."""
    for name, data in ssp_files(components(), read_cases()).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
