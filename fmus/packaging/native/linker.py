"""Object files and one C file in, a shared library out: by Zig for any platform, by the host's compiler for its own."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from .kept import keep, kept, key_of
from .platforms import PLATFORMS, Platform, this_platform

FLAGS = (
    "-std=c99",
    "-O2",
    "-g0",
    "-fPIC",
    "-fvisibility=hidden",
    "-shared",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-DNATIVE_KERNELS",
)


@dataclass(frozen=True)
class Compiler:
    """A C compiler.

    Attributes
    ----------
    name : with its version, for the build description
    command : how to call it
    is_zig : whether it takes Zig's targets
    """

    name: str
    command: tuple[str, ...]
    is_zig: bool


@cache
def find_compiler(platform: str) -> Compiler | None:
    """Return a compiler for a platform: Zig if it is installed, else the host's own for its own platform."""
    if find_spec("ziglang") is not None:
        return Compiler(f"zig cc {version('ziglang')}", (sys.executable, "-m", "ziglang", "cc"), True)
    own = next(
        (path for name in (os.environ.get("CC"), "cc", "gcc", "clang") if name and (path := shutil.which(name))), None
    )
    if own is None or platform != this_platform() or platform not in PLATFORMS:
        return None
    first = subprocess.run([own, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
    return Compiler(first, (own,), False)


def link(compiler: Compiler, platform: Platform, sources: Sequence[str], output: str, folder: Path) -> Path:
    """Compile and link `sources` to the shared library `output`, all by their names in `folder`; or take the kept one.

    Relative names and no symbols: the library does not depend on where it was built.

    Raises
    ------
    RuntimeError
        If the compiler fails.
    """
    arguments = [*FLAGS, "-I.", "-o", output, *sources]
    if compiler.is_zig:
        arguments += ["-target", platform.zig]
    if platform.suffix == ".so":
        arguments += ["-lm", "-Wl,--build-id=none", "-Wl,--no-undefined", "-Wl,-z,noexecstack"]
    arguments += ["-s"]
    inputs = [part for path in sorted(folder.iterdir()) for part in (path.name, path.read_bytes())]
    key = key_of([compiler.name, *arguments, *inputs])
    library = folder / output
    content = kept(key)
    if content is not None:
        library.write_bytes(content)
        return library
    command = [*compiler.command, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{compiler.name} cannot link {output} for {platform.name}: {done.stderr.strip()}")
    keep(key, library.read_bytes())
    return library
