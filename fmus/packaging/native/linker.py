"""Object files and one C file in, a shared library out: by Zig for any platform, by the host's compiler for its own."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from platformdirs import user_cache_path

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
    environment : variables that it needs besides those of this process
    """

    name: str
    command: tuple[str, ...]
    is_zig: bool
    environment: tuple[tuple[str, str], ...] = ()


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


def with_cache(compiler: Compiler, scratch: Path) -> Compiler:
    """Return a compiler that has a place for what it keeps: without a home that can be written, Zig never ends."""
    if not compiler.is_zig or "ZIG_GLOBAL_CACHE_DIR" in os.environ:
        return compiler
    try:
        usual = user_cache_path("zig")
        usual.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=usual):
            return compiler
    except OSError:
        kept_in = str(scratch / "zig")
        return replace(compiler, environment=(("ZIG_GLOBAL_CACHE_DIR", kept_in), ("ZIG_LOCAL_CACHE_DIR", kept_in)))


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
    environment = {**os.environ, **dict(compiler.environment)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{compiler.name} cannot link {output} for {platform.name}: {done.stderr.strip()}")
    keep(key, library.read_bytes())
    return library
