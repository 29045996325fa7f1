"""The command `resume`: a checkpoint in, the rest of its run out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...runs import run as running
from ..progress import run_bar
from ..tools import Json, notice
from .run import CheckpointEvery, Csv
from .told import tell


def resume(
    checkpoint: Annotated[Path, typer.Argument(help="File that `run --checkpoint` wrote.")],
    csv: Csv = False,
    checkpoint_every: CheckpointEvery = running.Keeping.every,
    json: Json = False,
) -> None:
    """Go on with a run from its checkpoint, to the bit as if it had never stopped; the results file grows."""
    with run_bar() as progress:
        outcome = running.resume(checkpoint, running.Report(progress, notice, csv), checkpoint_every)
    tell(outcome, json)
