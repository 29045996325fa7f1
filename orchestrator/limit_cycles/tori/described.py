"""What cycles break up into, as JSON and in words."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from ..level import Radiator
from .search import BreakUp
from .torus import Torus

_TOLD = 6


def break_up_as_json(found: BreakUp, radiator: Radiator | None) -> dict[str, Any]:
    """Return what is known about what a cycle breaks up into; no numbers of two tones that were not solved."""
    torus = found.torus
    return {
        "cycle_hz": found.cycle.frequency_hz,
        "words": found.words,
        "tried": list(found.tried),
        "torus": None if torus is None else _torus_as_json(torus, radiator),
    }


def _torus_as_json(torus: Torus, radiator: Radiator | None) -> dict[str, Any]:
    """Return the numbers of two tones at once."""
    low, high = torus.normal_force
    return {
        "frequencies_hz": list(torus.frequencies_hz),
        "wheel_velocity_rms": torus.wheel_velocity_rms,
        "rail_velocity_rms": torus.rail_velocity_rms,
        "normal_force": {"min": low, "max": high},
        "level_dba": None if radiator is None else torus.level_dba(radiator),
        "lines": [asdict(line) for line in torus.lines],
        "solution": {
            "lines": len(torus.state.forces),
            "samples": list(torus.balance.lines.samples),
            "residual": torus.residual,
            "rms_change": torus.rms_change,
        },
    }


def torus_words(torus: Torus, radiator: Radiator | None) -> str:
    """Return frequencies, level, force and strongest lines of two tones at once."""
    (f1, f2), (low, high) = torus.frequencies_hz, torus.normal_force
    wheel, rail = torus.wheel_velocity_rms["lat"], torus.rail_velocity_rms["lat"]
    level = "" if radiator is None else f", {torus.level_dba(radiator):.1f} dB(A)"
    lines = ", ".join(f"{line.frequency_hz:.1f} ({line.level_db:.1f})" for line in torus.lines[:_TOLD])
    return (
        f"two tones {f1:.2f} + {f2:.2f} Hz: wheel {wheel:.4f}, rail {rail:.4f} m/s lateral rms, normal "
        f"{low / 1e3:.1f}-{high / 1e3:.1f} kN{level}; lines in Hz (dB): {lines}"
    )
