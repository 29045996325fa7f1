"""Cycles as one JSON object, and as rows of a table."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import numpy as np

from fmus.interface import DIRECTIONS

from .catalogue import Catalogue, Cycle

SCHEMA = 1
"""Version of the JSON object."""

HARMONICS = 12
"""Harmonics that are told."""


def as_json(case: str, found: Catalogue) -> dict[str, Any]:
    """Return everything that is known about the cycles of a system."""
    return {
        "schema": SCHEMA,
        "case": case,
        "units": {"velocity": "m/s, rad/s", "force": "N, N.m", "exponent": "1/s", "level": "dB(A) at 7.5 m"},
        "versions": {name: version(name) for name in ("curvesqueal", "numpy", "numba")},
        "cycles": [cycle_as_json(c) for c in found.cycles],
        "curves": [
            {
                "pole_hz": t.pole.frequency_hz,
                "pole_growth_rate": t.pole.growth_rate,
                "amplitude": t.amplitude.tolist(),
                "growth_rate": t.sigma.tolist(),
                "frequency_hz": t.frequency_hz.tolist(),
                "complete": t.complete,
            }
            for t in found.traces
        ],
        "notes": list(found.notes),
    }


def cycle_as_json(cycle: Cycle) -> dict[str, Any]:
    """Return what is known about one cycle."""
    judged = cycle.stability
    low, high = cycle.normal_force
    return {
        "frequency_hz": cycle.frequency_hz,
        "pole_hz": cycle.pole.frequency_hz,
        "pole_growth_rate": cycle.pole.growth_rate,
        "amplitude": cycle.amplitude,
        "stable": cycle.stable,
        "fate": cycle.fate,
        "kind": None if judged is None else judged.kind,
        "threshold": None if judged is None else judged.threshold,
        "largest_exponent": None if judged is None else judged.largest.real,
        "largest_exponent_hz": None if judged is None else judged.largest_hz,
        "largest_exponent_error": None if judged is None or not np.isfinite(judged.error) else judged.error,
        "sidebands_hz": [] if judged is None else list(judged.sideband_hz),
        "wheel_velocity_rms": cycle.wheel_velocity_rms,
        "rail_velocity_rms": cycle.rail_velocity_rms,
        "normal_force": {"min": low, "max": high},
        "stick": cycle.contact.stick,
        "contact_lost": cycle.contact.lost,
        "level_dba": cycle.level_dba,
        "harmonics": _harmonics(cycle),
        "solution": {
            "harmonics": cycle.balance.truncation.harmonics,
            "samples": cycle.balance.truncation.samples,
            "residual": cycle.residual,
            "rms_change": cycle.rms_change,
        },
    }


def _harmonics(cycle: Cycle) -> list[dict[str, Any]]:
    """Return amplitudes of velocities and of the contact forces, contact axes, at the multiples of the frequency."""
    motion = cycle.motion

    def amplitudes(lines: np.ndarray[Any, Any], k: int, names: tuple[str, ...] = DIRECTIONS) -> dict[str, float]:
        return dict(zip(names, (2 * np.abs(lines[k])).tolist(), strict=True))

    return [
        {
            "number": k,
            "frequency_hz": k * cycle.frequency_hz,
            "wheel": amplitudes(motion.wheel, k),
            "rail": amplitudes(motion.rail, k),
            "force": amplitudes(motion.forces, k, ("lon", "lat", "normal", "spin")),
        }
        for k in range(1, min(HARMONICS + 1, len(motion.forces)))
    ]
