"""The command `rail regenerate`: the shipped modal rails made anew, or compared with what their methods make."""

from __future__ import annotations

from typing import Annotated

import typer

from ...errors import InputError
from ..tools import screen, user_mistakes


def regenerate(
    check: Annotated[bool, typer.Option("--check", help="Write nothing; fail where the files differ.")] = False,
) -> None:
    """Make the modal data files that the project ships anew. Takes minutes."""
    from fmus.rail import shipped as making  # noqa: PLC0415

    with user_mistakes():
        if not check:
            making.regenerate()
            return
        found = making.differences()
    if found:
        raise InputError("; ".join(found))
    screen.print("the shipped modal rails are what their methods make", highlight=False)
