"""The identified wheelset as data: `class158.toml` and `class158-identification.toml` in `fmus/wheel/data`.

The same sources make the same files.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.component import Instance
from fmus.contact.component import contact
from fmus.contact.parameters import P
from fmus.creep.hertz import ellipse
from fmus.modal.data import ModalData, format_modal_data, read_modal_data
from fmus.modal.modes import Modes
from fmus.rail.component import DATA as RAIL
from fmus.rail.track_data import TRACKS, read_track
from fmus.wheel.class158 import IDENTIFICATION, MODES, PRIOR
from fmus.wheel.wheelset import read_wheelset

from ..published.table4 import CASES, CELL_MODES, read_paper_table
from ..stability.loop import linear_contact, of_track
from .fit import FREE_MODES, RIGID, Amplitudes, Identification, assess, identify, with_amplitudes
from .growth import FittedRail

Real = NDArray[np.float64]

STIFFNESS = 2.35e9
"""Stiffness of the contact spring that the wheelset is identified with, chosen from the trade-off [N/m]."""

TRADE_OFF = (1.2e9, 1.4e9, 2.0e9)
"""Softer springs that the fit is repeated with, besides that of Table 1 [N/m]."""

TITLE = "Class 158 wheelset, contact amplitudes identified from Table 4"
SOURCE = (
    "Ding, Squicciarini and Thompson (2016), Table 4: natural frequencies, and by "
    "`python -m orchestrator.identification` the contact amplitudes of the modes that say so. "
    "All else is the generic 840 mm wheelset, generic840.toml."
)


def table1_stiffness() -> float:
    """Return the stiffness of the contact spring by Hertz from the semi-axes and the load of Tables 1 and 3 [N/m]."""
    p = Instance(contact()).parameters
    axes = float(p[P.semi_axis_lon]), float(p[P.semi_axis_lat])
    young = read_track(TRACKS / "default.toml").section.young_modulus
    return ellipse(*axes, float(p[P.normal_load]), young, float(p[P.poisson_ratio])).stiffness


def prior_modes() -> Modes:
    """Return the modes of the finite elements that the identification starts from."""
    return read_wheelset(PRIOR).modes


def fitted_rail() -> FittedRail:
    """Return the default track and its modal equivalent."""
    return FittedRail(of_track(read_track(TRACKS / "default.toml")), read_modal_data(RAIL / "rail.toml").modes)


def shipped_amplitudes() -> Amplitudes:
    """Return the amplitudes of the wheelset that is shipped."""
    turn = linear_contact().turn
    prior, shipped = prior_modes(), read_modal_data(MODES).modes
    shape = shipped.shape @ turn.T
    free = [shipped.labels.index(f"{name} cosine") for name in FREE_MODES]
    sign = np.where(shape[free, 1] < 0, -1.0, 1.0)
    heavy = shipped.labels.index(f"{RIGID[0]} cosine")
    factor = float(shape[heavy, 2] / (prior.shape[heavy] @ turn.T)[2])
    return Amplitudes(sign * shape[free, 1], sign * shape[free, 2], factor)


def assess_shipped() -> Identification:
    """Return the shipped amplitudes with their crossings and standard deviations."""
    return assess(prior_modes(), fitted_rail(), read_paper_table(), STIFFNESS, shipped_amplitudes())


def write_wheel(folder: Path = MODES.parent) -> Identification:
    """Write the modal data file of the shipped amplitudes with their standard deviations; return them."""
    best = assess_shipped()
    fitted = with_amplitudes(prior_modes(), best.amplitudes, linear_contact().turn)
    (folder / MODES.name).write_text(_with_sources(fitted, best), encoding="utf-8", newline="\n")
    return best


def write_identification(folder: Path = MODES.parent, report: Callable[[str], None] = lambda _: None) -> None:
    """Write both files into `folder`: the wheelset, and what other fits come to.

    Parameters
    ----------
    report : called with a line of text after each fit

    Notes
    -----
    The fit has many minima. The shipped amplitudes, whose origin docs/stability.md tells, are kept. The trade-off
    descends from them with the softer spring, then with each still softer one from the outcome before; a search from
    nothing and the prediction from Cases 1 and 2 know nothing of them.
    """
    modes, rail, paper = prior_modes(), fitted_rail(), read_paper_table()

    def fit(stiffness: float, cases: tuple[int, ...] = CASES, start: Amplitudes | None = None) -> Identification:
        outcome = identify(modes, rail, paper, stiffness, cases, start)
        report(summary(outcome))
        return outcome

    best = write_wheel(folder)
    report(summary(best))
    others = [best]
    for stiffness in sorted({*TRADE_OFF, table1_stiffness()}, reverse=True):
        others.append(fit(stiffness, start=others[-1].amplitudes))
    others.sort(key=lambda outcome: outcome.hertz_stiffness)
    text = _report(best, fit(STIFFNESS), fit(STIFFNESS, (1, 2)), others)
    (folder / IDENTIFICATION.name).write_text(text, encoding="utf-8", newline="\n")


def summary(fit: Identification) -> str:
    """Return one line about a fit."""
    paper = read_paper_table()
    right = int(((fit.gain > 1) == paper.unstable).sum())
    cells = f"{right} of {paper.gain.size} cells"
    return f"K_H {fit.hertz_stiffness:.4g} N/m, cases {fit.cases}: {cells}, rms ln(gain) {log_error(fit):.4f}"


def log_error(fit: Identification, cases: tuple[int, ...] = (1, 2, 3, 4)) -> float:
    """Return the rms of ln(gain/paper gain) over the crossings that both have."""
    paper = read_paper_table()
    both = paper.unstable & (fit.gain > 1) & np.isin(np.arange(1, 5), cases)[:, None]
    return float(np.sqrt(np.mean(np.log(fit.gain[both] / paper.gain[both]) ** 2)))


def _with_sources(modes: Modes, fit: Identification) -> str:
    """Return the modal data file, each identified mode with its own source."""
    tables = format_modal_data(ModalData(TITLE, SOURCE, modes)).split("[[mode]]\n")
    n = len(FREE_MODES)
    for k, name in enumerate(FREE_MODES):
        i = modes.labels.index(f"{name} cosine")
        tables[i + 1] = tables[i + 1].rstrip("\n") + (
            f'\nsource = "identified from Table 4; contact axes, standard deviations: lateral '
            f"{fit.amplitudes.lateral[k]:.5f} +- {fit.amplitudes.lateral[k] * fit.deviation[k]:.5f}, normal "
            f'{fit.amplitudes.normal[k]:.5f} +- {fit.deviation[n + k]:.5f} kg^-1/2"\n\n'
        )
    for name in RIGID:
        i = modes.labels.index(f"{name} cosine")
        tables[i + 1] = tables[i + 1].rstrip("\n") + (
            f'\nsource = "identified from Table 4: normal amplitude {fit.amplitudes.mass_factor:.4f} times that of the '
            f'finite elements, standard deviation {100 * fit.deviation[-1]:.0f} %"\n\n'
        )
    return "[[mode]]\n".join(tables).rstrip("\n") + "\n"


def _report(best: Identification, searched: Identification, blind: Identification, others: list[Identification]) -> str:
    """Return the file about the identification."""
    paper = read_paper_table()
    lines = [
        "# How class158.toml was found; written by `python -m orchestrator.identification`.",
        "",
        "[hertz_stiffness]",
        f"value = {best.hertz_stiffness!r}",
        'unit = "N/m"',
        'source = "chosen from the trade-off below; the paper gives none"',
        "",
        "[fit]",
        f"rms_ln_gain = {log_error(best):.4f}",
        f"cells_right = {int(((best.gain > 1) == paper.unstable).sum())}",
        "",
        "# The same fit from a search that knows nothing of the shipped amplitudes.",
        "[search]",
        f"rms_ln_gain = {log_error(searched):.4f}",
        f"cells_right = {int(((searched.gain > 1) == paper.unstable).sum())}",
        "",
        "# Fitted to Cases 1 and 2 only; what that predicts for Cases 3 and 4, 0 where stable.",
        "[prediction]",
        f"rms_ln_gain_fitted = {log_error(blind, (1, 2)):.4f}",
        f"cells_right = {int(((blind.gain > 1) == paper.unstable)[2:].sum())}",
        f"cells = {list(CELL_MODES)!r}".replace("'", '"'),
        f"gain_case3 = {_numbers(blind.gain[2])}",
        f"gain_case4 = {_numbers(blind.gain[3])}",
    ]
    for other in others:
        lines += [
            "",
            "[[trade_off]]",
            f"hertz_stiffness = {other.hertz_stiffness:.4e}",
            f"rms_ln_gain = {log_error(other):.4f}",
            f"cells_right = {int(((other.gain > 1) == paper.unstable).sum())}",
            f"mass_factor = {other.amplitudes.mass_factor:.3f}",
        ]
    return "\n".join(lines) + "\n"


def _numbers(values: Real) -> str:
    return "[" + ", ".join(f"{value:.3f}" for value in values) + "]"
