"""The inferred wheel as data: `inferred.toml` and `inferred-identification.toml` in `fmus/wheel/data`.

What else Table 4 can be asked is in `experiments.py`: how the misfit depends on the slope, what cases that were not
fitted come out as, and what the printed friction coefficient would need.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.modal.data import ModalData, format_modal_data, read_modal_data
from fmus.wheel.class158 import PRIOR
from fmus.wheel.inferred import IDENTIFICATION, MODES, inferred_law
from fmus.wheel.wheelset import Wheelset, read_wheelset

from ..published.table4 import read_paper_table
from ..stability.cases import ROUND_BODIES
from ..stability.loop import linear_contact
from .data import fitted_rail
from .fit import FREE_MODES, RIGID
from .free import SCALARS, FreeWheel, Prior
from .loci import RADIAL, inferred_model, low_modes
from .misfit import Misfit
from .search import Found, Search, best, deviations, quality, starts

Real = NDArray[np.float64]

SEEDS = tuple(range(16))
TITLE = "wheelset of the inferred cases, identified from Table 4 with slope, friction and damping free"
SOURCE = (
    "Ding, Squicciarini and Thompson (2016), Table 4: natural frequencies, and by "
    "`python -m orchestrator.identification inferred` what the modes say. "
    "All else is the generic 840 mm wheelset, generic840.toml."
)


def finite_elements() -> Wheelset:
    """Return the wheelset that the identification starts from."""
    return read_wheelset(PRIOR)


def inferred_misfit() -> Misfit:
    """Return what a wheel is measured by: Table 4 on the default track, spring of round bodies, finite elements."""
    model = inferred_model(finite_elements(), fitted_rail().mobility, ROUND_BODIES)
    lateral, normal = model.moving.shape[:, : len(FREE_MODES)]
    return Misfit(model, Prior.about(lateral, normal, model.printed.friction), read_paper_table())


def with_free(wheelset: Wheelset, free: FreeWheel) -> Wheelset:
    """Return a wheelset with the amplitudes and the damping of a free wheel."""
    modes, turn = wheelset.modes, linear_contact().turn
    shape, zeta = modes.shape @ turn.T, modes.zeta.copy()
    zeta[low_modes(wheelset)] *= free.low_factor
    for name, lateral, normal in zip(FREE_MODES, free.lateral, free.normal, strict=True):
        i = modes.labels.index(f"{name} cosine")
        sign = -1.0 if shape[i, 1] < 0 else 1.0
        shape[i, 1:3] = sign * lateral, sign * normal
    for name in RIGID:
        shape[modes.labels.index(f"{name} cosine"), 2] *= free.mass_factor
    for family in ("cosine", "sine"):
        zeta[modes.labels.index(f"{RADIAL} {family}")] = free.radial_zeta
    return replace(wheelset, modes=replace(modes, shape=shape @ turn, zeta=zeta))


def shipped_free(misfit: Misfit) -> FreeWheel:
    """Return the free numbers of the wheel and the law that are shipped."""
    turn, printed = misfit.model.contact.turn, misfit.model.printed
    shipped, law, prior = read_modal_data(MODES).modes, inferred_law(), finite_elements()
    at = [shipped.labels.index(f"{name} cosine") for name in FREE_MODES]
    shape = shipped.shape @ turn.T
    sign = np.where(shape[at, 1] < 0, -1.0, 1.0)
    heavy, soft = shipped.labels.index(f"{RIGID[0]} cosine"), int(np.flatnonzero(low_modes(prior))[0])
    return FreeWheel(
        sign * shape[at, 1],
        sign * shape[at, 2],
        mass_factor=float(shape[heavy, 2] / (prior.modes.shape[heavy] @ turn.T)[2]),
        slope_factor=law["saturation_coefficient"] / printed.saturation * printed.friction / law["mu0"],
        friction=law["mu0"],
        radial_zeta=float(shipped.zeta[shipped.labels.index(f"{RADIAL} cosine")]),
        low_factor=float(shipped.zeta[soft] / prior.modes.zeta[soft]),
    )


def identify_inferred(
    misfit: Misfit, seeds: Sequence[int] = SEEDS, report: Callable[[str], None] = lambda _: None
) -> list[Found]:
    """Return where every seed ends, lowest first; `report` is called with a line for each."""
    search = Search(misfit)
    report("seed, cost, what Table 4 and the prior make of it")
    found = list(starts(search, seeds, lambda one: report(summary(search.final(), one))))
    first = best(found)
    return [first, *sorted((one for one in found if one is not first), key=lambda one: (not one.finished, one.cost))]


def summary(misfit: Misfit, found: Found) -> str:
    """Return one line about the end of a start."""
    free = misfit.prior.wheel(found.vector)
    q = quality(misfit, free)
    state = "" if found.finished else ", given up"
    return (
        f"{found.seed}: cost {found.cost:.2f}{state}; {int(q.right.sum())} of {q.right.size} cells, "
        f"rms ln(gain) {q.rms():.4f}, worst {100 * q.worst:.1f} %; s {free.slope_factor:.3f}, mu0 {free.friction:.3f}, "
        f"zeta(2,r) {free.radial_zeta:.2e}, low modes' damping x {free.low_factor:.2f}, mass factor "
        f"{free.mass_factor:.3f}"
    )


def write_inferred(folder: Path, misfit: Misfit, found: Sequence[Found], more: str = "") -> None:
    """Write both files: the wheel of the first start in `found` and how it was found.

    Parameters
    ----------
    found : ends of all starts, the best first
    more : further tables of the second file
    """
    final = Search(misfit).final()
    vector = found[0].vector
    free, width = misfit.prior.wheel(vector), deviations(final, vector) * misfit.prior.width
    (folder / MODES.name).write_text(_wheel_text(free, width), encoding="utf-8", newline="\n")
    text = _report_text(final, found, width) + more
    (folder / IDENTIFICATION.name).write_text(text, encoding="utf-8", newline="\n")


def _wheel_text(free: FreeWheel, width: Real) -> str:
    """Return the modal data file, each mode that was changed with its own source."""
    fe = finite_elements()
    modes = with_free(fe, free).modes
    tables = format_modal_data(ModalData(TITLE, SOURCE, modes)).split("[[mode]]\n")
    n = len(FREE_MODES)
    words: dict[str, list[str]] = {}
    for k, name in enumerate(FREE_MODES):
        words.setdefault(f"{name} cosine", []).append(
            f"identified from Table 4; contact axes, standard deviations: lateral {free.lateral[k]:.5f} +- "
            f"{100 * width[k]:.0f} %, normal {free.normal[k]:.5f} +- {width[n + k]:.5f} kg^-1/2"
        )
    for name in RIGID:
        words[f"{name} cosine"] = [
            f"identified from Table 4: normal amplitude {free.mass_factor:.4f} times that of the finite elements, "
            f"standard deviation {100 * width[2 * n]:.0f} %"
        ]
    for family in ("cosine", "sine"):
        words.setdefault(f"{RADIAL} {family}", []).append(
            f"identified from Table 4: damping ratio, standard deviation {100 * width[2 * n + 3]:.0f} %"
        )
    for i in np.flatnonzero(low_modes(fe)):
        words.setdefault(modes.labels[i], []).append(
            f"damping ratio {free.low_factor:.3f} times the default of TWINS, one factor for all modes with n = 0 "
            f"and 1 identified from Table 4, standard deviation {100 * width[2 * n + 4]:.0f} %"
        )
    for label, said in words.items():
        at = modes.labels.index(label) + 1
        tables[at] = tables[at].rstrip("\n") + f'\nsource = "{"; ".join(said)}"\n\n'
    return "[[mode]]\n".join(tables).rstrip("\n") + "\n"


def _report_text(misfit: Misfit, found: Sequence[Found], width: Real) -> str:
    """Return the file about the identification."""
    vector = found[0].vector
    free = misfit.prior.wheel(vector)
    q = quality(misfit, free)
    law = {"hertz_stiffness": ROUND_BODIES, **free.law(misfit.model.printed)}
    lines = [
        "# How inferred.toml was found; written by `python -m orchestrator.identification inferred`.",
        "",
        "# Parameters of the contact that go with the wheel.",
        "[law]",
        *(f"{name} = {value!r}" for name, value in law.items()),
        "",
        "[fit]",
        f"rms_ln_gain = {q.rms():.4f}",
        f"worst_gain = {q.worst:.4f}",
        f"cells_right = {int(q.right.sum())}",
        f"largest_further_gain = {q.further:.3f}",
        f"cost = {found[0].cost:.3f}",
        f"seed = {found[0].seed}",
        "",
        "# What is free besides amplitudes: standard deviations of ln(value), of the prior and after the fit.",
    ]
    n = len(FREE_MODES)
    for k, name in enumerate(SCALARS):
        lines += [
            f"[free.{name}]",
            f"value = {getattr(free, name)!r}",
            f"prior = {getattr(misfit.prior.middle, name)!r}",
            f"prior_deviation = {float(misfit.prior.width[2 * n + k])!r}",
            f"deviation = {width[2 * n + k]:.3f}",
            "",
        ]
    lines += ["# Every start, lowest cost first; given up are those in which a cell keeps the wrong sign.", ""]
    for one in found:
        lines += [
            "[[start]]",
            f"seed = {one.seed}",
            f"cost = {one.cost:.2f}",
            f"finished = {str(one.finished).lower()}",
        ]
        lines += _numbers(misfit, one.vector)
    return "\n".join(lines).rstrip("\n") + "\n"


def _numbers(misfit: Misfit, vector: Real) -> list[str]:
    """Return what every fit is described by, as lines of TOML, an empty one at the end."""
    free = misfit.prior.wheel(vector)
    q = quality(misfit, free)
    rms = q.rms()
    return [
        f"rms_ln_gain = {rms:.4f}" if np.isfinite(rms) else "rms_ln_gain = nan",
        f"cells_right = {int(q.right.sum())}",
        f"slope_factor = {free.slope_factor:.4f}",
        f"friction = {free.friction:.4f}",
        f"radial_zeta = {free.radial_zeta:.3e}",
        f"mass_factor = {free.mass_factor:.4f}",
        "",
    ]
