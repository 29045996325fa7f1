"""Everything that is built: the FMUs and the SSP, into one folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from ..component import Component
from ..contact.component import contact
from ..interface import DEFAULT_STEP
from ..rail.component import discrete_rail, paper_rail, rail, rigid_rail
from ..system.component import system
from ..wheel.component import wheel
from ..wheel.wheelset import DATA, read_wheelset
from .archive import write_files
from .native.fmu import Standard, build_native_fmus
from .native.linker import find_compiler
from .native.platforms import PLATFORMS, this_platform
from .python_fmu import build_python_fmu
from .system_structure import read_cases, ssp_files, system_mobility

SSP_NAME = "curvesqueal.ssp"

PYTHON_PLATFORMS = ("x86_64-linux", "x86_64-windows")
"""Where PythonFMU has binaries."""


@dataclass(frozen=True)
class Target:
    """What kind of FMU to build.

    Attributes
    ----------
    flavour : 'native' (machine code, no Python on the host) or 'python' (PythonFMU)
    fmi : major version of FMI, 2 or 3; PythonFMU knows 2 only
    platforms : names of `PLATFORMS`; for Python FMUs those that PythonFMU brings
    only_scalars : whether FMI 3 does without arrays, for hosts that know none
    """

    flavour: str
    fmi: int = 2
    platforms: tuple[str, ...] = ()
    only_scalars: bool = False

    def __post_init__(self) -> None:
        """Check that such FMUs can be built here.

        Raises
        ------
        ValueError
            If they cannot be.
        """
        if self.flavour not in ("native", "python"):
            raise ValueError(f"flavour {self.flavour!r}: must be native or python")
        if self.fmi not in (2, 3):
            raise ValueError(f"FMI {self.fmi}: must be 2 or 3")
        if self.only_scalars and self.fmi != 3:
            raise ValueError(f"FMI {self.fmi} has no arrays: all is scalars; leave it out, or choose FMI 3")
        if self.flavour == "python":
            self._check_python()
            return
        if not self.platforms:
            object.__setattr__(self, "platforms", (this_platform(),))
        for name in self.platforms:
            if name not in PLATFORMS:
                raise ValueError(f"platform {name!r}: must be one of {', '.join(PLATFORMS)}")
            if find_compiler(name) is None:
                raise ValueError(f"platform {name}: there is no C compiler for it; the package ziglang brings one")

    def _check_python(self) -> None:
        if self.fmi != 2:
            raise ValueError("Python FMUs: PythonFMU writes FMI 2 only; --flavour native has FMI 3")
        if this_platform() not in PYTHON_PLATFORMS:
            raise ValueError(f"Python FMUs: PythonFMU has no binary for {this_platform()}; {_ZIG_HELPS}")
        if self.platforms:
            raise ValueError(f"Python FMUs: run on {' and '.join(PYTHON_PLATFORMS)} only; leave --platforms out")

    def __str__(self) -> str:
        """Return it in words."""
        if self.flavour == "python":
            return "Python FMUs (PythonFMU), FMI 2"
        compilers = dict.fromkeys(c.name for name in self.platforms if (c := find_compiler(name)))
        standard = f"FMI {self.fmi}{' with scalars only' * self.only_scalars}"
        return f"native FMUs, {standard}, for {', '.join(self.platforms)}, by {', '.join(compilers)}"


_ZIG_HELPS = "a C compiler or the package ziglang makes native FMUs possible"


def default_target() -> Target:
    """Return what is built unless the user says otherwise: native if a compiler is there, else Python.

    Raises
    ------
    ValueError
        If neither is possible here.
    """
    here = this_platform()
    if here in PLATFORMS and find_compiler(here) is not None:
        return Target("native")
    return Target("python")


def components() -> dict[str, Component]:
    """Return every component that is shipped, by the name of its FMU file without suffix."""
    the_wheel, the_rail, rigid = wheel(), rail(), rigid_rail()
    the_contact = contact(system_mobility([the_wheel, the_rail], DEFAULT_STEP))
    first = read_cases()[0]
    return {
        "wheel": the_wheel,
        "wheel-generic840": wheel(read_wheelset(DATA / "generic840.toml").modes),
        "rail": the_rail,
        "rail-paper": paper_rail(),
        "rail-rigid": rigid,
        "rail-discrete": discrete_rail(),
        "contact": the_contact,
        "curvesqueal": system("curvesqueal", the_wheel, the_rail, the_contact, first.contact),
        "curvesqueal-rigid": system("curvesqueal_rigid", the_wheel, rigid, the_contact, first.contact),
    }


def build_fmus(components: Mapping[str, Component], folder: Path, target: Target) -> dict[str, Path]:
    """Build FMUs of components into a folder that exists; return the files by name."""
    release = version("curvesqueal")
    if target.flavour == "native":
        return build_native_fmus(
            components, target.platforms, Standard(target.fmi, target.only_scalars), folder, release
        )
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
    used = {"wheel", "contact", *(case.rail for case in cases)}
    chosen = {name: c for name, c in built.items() if name in used or not only_cases}
    fmus = build_fmus(chosen, folder, target or default_target())
    for name in used:
        files[f"resources/{name}.fmu"] = fmus[name].read_bytes()
    ssp = folder / SSP_NAME
    write_files(files, ssp)
    for path in (*fmus.values(), ssp):
        report(path)
    return ssp


def targets(flavour: str | None, fmi: int, platforms: Sequence[str], only_scalars: bool = False) -> tuple[Target, ...]:
    """Return the targets that a user asks for: a flavour, 'all' for both, None for the default.

    Raises
    ------
    ValueError
        If one of them cannot be built here.
    """
    if flavour == "all":
        return Target("native", fmi, tuple(platforms), only_scalars), Target("python")
    if flavour is None:
        default = default_target()
        if default.flavour == "python" and (fmi != 2 or platforms or only_scalars):
            raise ValueError(f"native FMUs: {_ZIG_HELPS}")
        flavour = default.flavour
    return (Target(flavour, fmi, tuple(platforms), only_scalars),)


def write_system_structure(folder: Path) -> None:
    """Write the SSDs and SSVs of the SSP below `folder`, as the repository keeps them."""
    for name, data in ssp_files(components(), read_cases()).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
