"""Everything that is built: the FMUs and the SSP, into one folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path

from ..cases import read_cases
from ..component import Component
from .archive import write_files
from .catalogue import components
from .native.fmu import Standard, build_native_fmus
from .python.fmu import build_python_fmu
from .ssp.structure import contact_name, ssp_files
from .target import Target, default_target

SSP_NAME = "curvesqueal.ssp"


def build_fmus(components: Mapping[str, Component], folder: Path, target: Target) -> dict[str, Path]:
    """Build FMUs of components into a folder that exists; return the files by name."""
    release = version("curvesqueal")
    if target.flavour == "native":
        standard = Standard(target.fmi, target.only_scalars)
        return build_native_fmus(components, target.platforms, standard, folder, release)
    return {name: build_python_fmu(c, folder / f"{name}.fmu", release) for name, c in components.items()}


def build_fmu(component: Component, file: Path, target: Target | None = None) -> Path:
    """Build one FMU; `target` defaults to `default_target()`."""
    return build_fmus({file.stem: component}, file.parent, target or default_target())[file.stem]


def build(
    folder: Path,
    target: Target | None = None,
    report: Callable[[Path], None] = lambda _: None,
    only_cases: bool = False,
) -> Path:
    """Build all FMUs and the SSP into `folder`; return the SSP.

    Parameters
    ----------
    folder : created if it does not exist
    target : default: `default_target()`
    report : called with each file when all are written
    only_cases : whether to leave out the FMUs that no case uses
    """
    folder.mkdir(parents=True, exist_ok=True)
    built = components()
    cases = read_cases()
    files = ssp_files(built, cases)
    used = {name for case in cases for name in (case.wheel, case.rail, contact_name(case, cases))}
    chosen = {name: c for name, c in built.items() if name in used or not only_cases}
    fmus = build_fmus(chosen, folder, target or default_target())
    for name in used:
        files[f"resources/{name}.fmu"] = fmus[name].read_bytes()
    ssp = folder / SSP_NAME
    write_files(files, ssp)
    for path in (*fmus.values(), ssp):
        report(path)
    return ssp


def write_system_structure(folder: Path) -> None:
    """Write the SSDs and SSVs of the SSP below `folder`, as the repository keeps them."""
    for name, data in ssp_files(components(), read_cases()).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
