"""What kind of FMU to build: flavour, version of FMI, platforms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import DataError
from .native.linker import find_compiler
from .native.platforms import PLATFORMS, this_platform

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
        DataError
            If they cannot be.
        """
        if self.flavour not in ("native", "python"):
            raise DataError(f"flavour {self.flavour!r}: must be native or python")
        if self.fmi not in (2, 3):
            raise DataError(f"FMI {self.fmi}: must be 2 or 3")
        if self.only_scalars and self.fmi != 3:
            raise DataError(f"FMI {self.fmi} has no arrays, all is scalars; must be FMI 3 for scalars only")
        if self.flavour == "python":
            self._check_python()
            return
        if not self.platforms:
            object.__setattr__(self, "platforms", (this_platform(),))
        for name in self.platforms:
            if name not in PLATFORMS:
                raise DataError(f"platform {name!r}: must be one of {', '.join(PLATFORMS)}")
            if find_compiler(name) is None:
                raise DataError(f"platform {name}: there is no C compiler for it; the package ziglang brings one")

    def _check_python(self) -> None:
        if self.fmi != 2:
            raise DataError("Python FMUs: PythonFMU writes FMI 2 only; native FMUs have FMI 3")
        if this_platform() not in PYTHON_PLATFORMS:
            raise DataError(f"Python FMUs: PythonFMU has no binary for {this_platform()}; {_ZIG_HELPS}")
        if self.platforms:
            raise DataError(f"Python FMUs: run on {' and '.join(PYTHON_PLATFORMS)} only; leave the platforms out")

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
    DataError
        If neither is possible here.
    """
    here = this_platform()
    if here in PLATFORMS and find_compiler(here) is not None:
        return Target("native")
    return Target("python")


def targets(flavour: str | None, fmi: int, platforms: Sequence[str], only_scalars: bool = False) -> tuple[Target, ...]:
    """Return the targets that a user asks for: a flavour, 'all' for both, None for the default.

    Raises
    ------
    DataError
        If one of them cannot be built here.
    """
    if flavour == "all":
        return Target("native", fmi, tuple(platforms), only_scalars), Target("python")
    if flavour is None:
        default = default_target()
        if default.flavour == "python" and (fmi != 2 or platforms or only_scalars):
            raise DataError(f"native FMUs: {_ZIG_HELPS}")
        flavour = default.flavour
    return (Target(flavour, fmi, tuple(platforms), only_scalars),)
