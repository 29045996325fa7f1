"""Radiating areas of a wheel that is known by its modes only: labels and amplitudes in, an estimate out.

The areas of the two shipped finite-element wheelsets (curved and straight web, 840 mm) say what to expect. Of modes
(n,0), which squeal, the axial area over the square of the axial amplitude at the tread is the same within 0.5 dB for
n >= 2 and both webs; it grows with the square of the radius. Of others it depends on the web.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..modal.modes import Modes
from .wheelset import Wheelset

Real = NDArray[np.float64]

UNCERTAINTY_DB = {"(n,0)": 0.5, "others": 13.0}
"""Difference of an estimated axial area from the shipped wheelsets': the largest; for others, of 85 in 100."""

_RADIUS = 0.42
_SHARES = {0: 0.687, 1: 0.316}
_SHARE = 0.225
"""Axial area over the square of the axial amplitude of (0,0), (1,0) and (n,0) [m2]."""

_RADIAL = 0.16
"""Radial over axial area of (n,0)."""

_OTHERS = (1.5e-3, 1.0e-3)
"""Axial and radial area of other modes [m2/kg]: mass-normalised shapes spread over a wheel of this size."""

_SAME_FREQUENCY = 1e-3

SAME_LABEL = 0.03
"""Relative distance of frequencies up to which a mode counts as one of a known wheel."""


def given_wheelset(modes: Modes, areas: Real, title: str) -> Wheelset:
    """Return a wheelset whose areas are known, (n, 2) axial and radial [m2/kg]; diameters are those of the labels."""
    return replace(estimated_wheelset(modes, title), area_axial=areas[:, 0], area_radial=areas[:, 1])


def taken_over(modes: Modes, known: Modes, areas: Real, within: float = SAME_LABEL) -> tuple[Real, int]:
    """Return areas of modes, those of a known wheel where they are its modes, else estimated, and how many are known.

    Parameters
    ----------
    modes : labelled
    areas : (n, 2) axial and radial area of the known modes [m2/kg]
    """
    places = same_modes(modes, known, within)
    estimate = estimated_wheelset(modes, "")
    own = np.column_stack([estimate.area_axial, estimate.area_radial])
    own[places >= 0] = areas[places[places >= 0]]
    return own, int((places >= 0).sum())


def estimated_wheelset(modes: Modes, title: str, radius: float = _RADIUS) -> Wheelset:
    """Return a wheelset with estimated areas.

    Parameters
    ----------
    modes : labelled '(n,m) ...' or '... n=2 ...'; others count as n = 1 and not (n,0)
    radius : of the wheel [m]

    Notes
    -----
    A sine mode has the area of its cosine partner: the mode of the same label and frequency that moves laterally. Modes
    called rigid or outside the band do not radiate.
    """
    axial, radial, diameters = np.zeros(len(modes)), np.zeros(len(modes)), np.ones(len(modes), dtype=np.int64)
    labels = modes.labels or ("",) * len(modes)
    for i, label in enumerate(labels):
        match = re.search(r"\((\d+),(\w+)\)|n=(\d+)", label)
        if match:
            diameters[i] = int(match[1] or match[3])
        if label.startswith(("rigid", "outside")):
            continue
        axial[i], radial[i] = _OTHERS
        if match and match[2] == "0":
            share = _SHARES.get(int(diameters[i]), _SHARE) * (radius / _RADIUS) ** 2
            axial[i] = share * _lateral(modes, i, match[0]) ** 2
            radial[i] = _RADIAL * axial[i]
    return Wheelset(modes, diameters, axial, radial, title)


def like(modes: Modes, known: Modes, within: float = SAME_LABEL) -> Modes:
    """Return the modes with the labels of a known wheel, each from the mode nearest in frequency and shape.

    Parameters
    ----------
    within : relative distance of frequencies up to which a label is taken; other modes keep theirs
    """
    places = same_modes(modes, known, within)
    own = modes.labels or ("",) * len(modes)
    labels = tuple(known.labels[k] if k >= 0 else label for k, label in zip(places, own, strict=True))
    return Modes(modes.omega, modes.zeta, modes.shape, labels)


def same_modes(modes: Modes, known: Modes, within: float = SAME_LABEL) -> NDArray[np.int64]:
    """Return which mode of a known wheel each mode is, the nearest in frequency and shape, or -1."""
    found = np.full(len(modes), -1, dtype=np.int64)
    free = np.ones(len(modes), dtype=bool)
    largest = np.maximum(np.abs(known.shape).max(axis=0), 1e-12)
    own, wanted = np.abs(modes.shape) / largest, np.abs(known.shape) / largest
    for k in np.argsort(-wanted.max(axis=1)):
        if known.omega[k] == 0 or known.labels[k].startswith("rigid"):
            continue
        away = np.abs(np.log(np.maximum(modes.omega, 1e-9) / known.omega[k]))
        unlike = np.abs(own - wanted[k]).max(axis=1)
        cost = np.where(free & (away < within), away / within + unlike, np.inf)
        if np.isfinite(cost).any():
            best = int(np.argmin(cost))
            free[best], found[best] = False, k
    return found


def _lateral(modes: Modes, mode: int, name: str) -> float:
    """Return the lateral amplitude of a mode or of its partner of the same name and frequency."""
    near = np.abs(modes.omega - modes.omega[mode]) <= _SAME_FREQUENCY * modes.omega[mode]
    partners = [i for i in np.flatnonzero(near) if modes.labels[i].startswith(name)]
    return float(np.abs(modes.shape[np.array([mode, *partners]), 1]).max())
