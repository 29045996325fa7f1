"""What the commands share: options, and refusals in one sentence."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from fmus.errors import DataError

from ..errors import InputError
from ..plain_json import dumps
from ..streams import BROKEN
from ..visible import visible


class Screen(Console):
    """A console that shows names from files as they are: no markup, no emoji, nothing that steers the terminal."""

    def __init__(self, **how: Any) -> None:
        super().__init__(markup=False, emoji=False, highlight=False, **how)

    def render_str(self, text: str, **how: Any) -> Text:
        """Return a text to be shown; every text that is printed, also in tables and trees, comes through here."""
        return super().render_str(visible(text), **how)

    def on_broken_pipe(self) -> None:
        """End with the exit code that says so where nobody reads the output; messages may stay unread."""
        self.quiet = True
        if not self.stderr:
            raise SystemExit(BROKEN)

    def print_json(self, *, data: Any) -> None:  # type: ignore[override]
        """Print data as one JSON text; numbers that are not finite are null there."""
        typer.echo(dumps(data))


screen = Screen()
"""What a command prints."""

messages = Screen(stderr=True)
"""What it says besides."""

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite a file that is there.")]
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


def say(text: str) -> None:
    """Print a sentence on the error stream, as it is."""
    messages.print(text, markup=False, highlight=False, soft_wrap=True)


def notice(text: str) -> None:
    """Print a note on the error stream."""
    say(f"note: {text}")
