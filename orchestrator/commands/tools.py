"""What the commands share: options, and refusals in one sentence."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from fmus.errors import DataError

from ..errors import InputError
from ..fmi.instance import Value

screen = Console()
"""What a command prints."""

messages = Console(stderr=True)
"""What it says besides."""

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite a file that is there.")]
Values = Annotated[list[str] | None, typer.Option("--set", help="Parameter, such as contact.mu0=0.35. Repeatable.")]
Replace = Annotated[list[str] | None, typer.Option(help="Other FMU in a place: rail=FILE.fmu. Repeatable.")]
Seed = Annotated[int | None, typer.Option(help="Start from random modal velocities, not from the pulse.")]


@contextmanager
def user_mistakes() -> Iterator[None]:
    """Turn what the components and the file system refuse into an error of the user's input."""
    try:
        yield
    except DataError as error:
        raise InputError(str(error)) from None
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror or error}") from None


def require_free(path: Path, force: bool) -> None:
    """Raise InputError if a file is there that writing would replace."""
    if path.exists() and not force:
        raise InputError(f"{path}: is there already; give another --out, or --force to overwrite it")


def require_suffix(path: Path, suffixes: tuple[str, ...]) -> None:
    """Raise InputError for a file that is not called what it becomes."""
    if path.suffix not in suffixes:
        raise InputError(f"--out {path}: must end with {' or '.join(suffixes)}")


def parse_values(texts: Iterable[str]) -> dict[str, dict[str, Value]]:
    """Return parameter values of texts such as 'contact.mu0=0.35'."""
    values: dict[str, dict[str, Value]] = {}
    for text in texts:
        match = re.fullmatch(r"([^.=\s]+)\.([^=\s]+)=(.+)", text)
        if match is None:
            raise InputError(f"--set {text}: must be COMPONENT.PARAMETER=VALUE, such as contact.mu0=0.35")
        component, name, value = match.groups()
        values.setdefault(component, {})[name] = value
    return values


def parse_sources(texts: Iterable[str]) -> dict[str, Path]:
    """Return replacements of texts such as 'rail=my-rail.fmu'."""
    sources = {}
    for text in texts:
        name, separator, file = text.partition("=")
        if not (name and separator and file):
            raise InputError(f"--replace {text}: must be COMPONENT=FILE.fmu, such as rail=my-rail.fmu")
        sources[name] = Path(file)
    return sources


def say(text: str) -> None:
    """Print a sentence on the error stream, as it is."""
    messages.print(text, markup=False, highlight=False, soft_wrap=True)


def notice(text: str) -> None:
    """Print a note on the error stream."""
    say(f"note: {text}")
