"""What a run left behind, as data and as JSON."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ..coupling.master import Progress, Settings
from ..plain_json import dumps
from ..results.file import open_results
from ..signals.figures_told import FIGURES
from ..signals.summary import Summary
from ..stability.scheme import Spurious
from .verdict import Verdict, energy_share

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr


@dataclass(frozen=True)
class Outcome:
    """What a run left behind.

    Attributes
    ----------
    case : name of the system
    settings, progress, summary : how it was run, how far it came, what came out
    results : the results file
    picture : the picture of histories and spectra; None if none was asked for or it could not be written
    spurious : what the algorithm does to the growth rates
    error : why it ended early; None if it did not
    verdict : whether it squeals, how, and how far that can be trusted
    """

    case: str
    settings: Settings
    progress: Progress
    summary: Summary
    results: Path
    picture: Path | None
    spurious: Spurious
    error: str | None
    verdict: Verdict

    @cached_property
    def data(self) -> xr.Dataset:
        """Everything that was recorded, with units, loaded lazily."""
        return open_results(self.results)


def as_json(outcome: Outcome) -> str:
    """Return an outcome as one JSON object."""
    p = outcome.progress
    data = {
        "case": outcome.case,
        **outcome.verdict.as_data(),
        "steps": p.steps,
        "step_s": outcome.settings.step,
        "duration_s": p.steps * outcome.settings.step,
        "wall_s": p.wall,
        "algorithm": outcome.settings.algorithm,
        "sweeps_per_step": p.sweeps,
        "most_sweeps": p.most_sweeps,
        **{figure.name: figure.value(outcome.summary) for figure in FIGURES},
        "energy_residual": p.energy_residual,
        "energy_into_structures": p.energy_into_structures,
        "energy_into": p.energy_into,
        "energy_residual_share": energy_share(p),
        "max_growth_rate_error": outcome.spurious.largest,
        "spurious_growth": outcome.spurious.sentence,
        "completed": outcome.error is None and not p.stopped,
        "ended": p.ended,
        "error": outcome.error,
        "results": str(outcome.results),
        "picture": None if outcome.picture is None else str(outcome.picture),
    }
    return dumps(data)
