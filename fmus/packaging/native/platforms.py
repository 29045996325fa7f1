"""The platforms that native FMUs are built for, with the names that LLVM, Zig and the two FMI versions give them."""

from __future__ import annotations

import platform as host
import sys
from dataclasses import dataclass


@dataclass(frozen=True)
class Platform:
    """A platform.

    Attributes
    ----------
    name : architecture and system as FMI 3.0 names them, which is also the folder of its binary there
    triple : LLVM's name
    zig : Zig's name, with the oldest C library that the binary runs on
    fmi2_folder : folder of its binary in an FMI 2.0 FMU, where hosts look for it
    suffix : of its shared libraries
    """

    name: str
    triple: str
    zig: str
    fmi2_folder: str
    suffix: str


PLATFORMS = {
    p.name: p
    for p in (
        Platform("x86_64-linux", "x86_64-unknown-linux-gnu", "x86_64-linux-gnu.2.17", "linux64", ".so"),
        Platform("aarch64-linux", "aarch64-unknown-linux-gnu", "aarch64-linux-gnu.2.17", "aarch64-linux", ".so"),
        Platform("x86_64-windows", "x86_64-pc-windows-gnu", "x86_64-windows-gnu", "win64", ".dll"),
        Platform("x86_64-darwin", "x86_64-apple-macosx11.0.0", "x86_64-macos.11.0", "darwin64", ".dylib"),
        Platform("aarch64-darwin", "arm64-apple-macosx11.0.0", "aarch64-macos.11.0", "darwin64", ".dylib"),
    )
}


def this_platform() -> str:
    """Return the name of the platform that this process runs on, whether it is one of `PLATFORMS` or not."""
    machine = host.machine().lower()
    architecture = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system = {"linux": "linux", "win32": "windows", "darwin": "darwin"}.get(sys.platform, sys.platform)
    return f"{architecture}-{system}"
