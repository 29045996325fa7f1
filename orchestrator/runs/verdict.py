"""The answer of a run, worked out once and shown everywhere: does it squeal, which mode, how loud, how sure."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.modal.parameters import modal_velocities

from ..errors import InputError
from ..results.file import open_results
from ..results.samples import Samples
from ..signals.limit_cycle import SQUEAL_VELOCITY, limit_cycle
from ..signals.spectra import regular
from ..signals.summary import Summary
from ..sound.levels import Sound, sound_of
from ..sound.wheelset import wheelset_of
from ..stability.scheme import Spurious

if TYPE_CHECKING:
    from ..coupling.settings import Progress

NEAR = 0.1
"""A mode takes part in a tone if its natural frequency is within this part of it: contact and rail move a mode by some
per cent, and the nearest family of the wheel is further away than that."""

SHORT_HZ = 10.0
"""Resolution of the level of a run that is too short for the usual one [Hz]."""

ENERGY_SHARE = 0.01
"""Part of the energy into wheel and rail that the coupling may add or take before its figures are doubted."""


@dataclass(frozen=True)
class Verdict:
    """What a run says.

    Attributes
    ----------
    squeals : whether the wheel's lateral velocity in the second half is above 1 mm/s rms, half a per cent of the
        sliding velocity of the paper's cases; None where there is no wheel
    tone_hz : dominant frequency of it [Hz]; None where it does not squeal, or not at a tone
    mode : of the wheel, such as "(3,0)"; None where it does not squeal or the wheel is not known
    level_dba, level_dba_band : A-weighted level at 7.5 m and the band of its doubtful coefficients [dB(A)]; None where
        it is not known
    steady : whether the level has stopped to change
    trust : "good", "doubtful" or "unknown"
    reasons : why it is not good, one sentence each
    sentence : all of that in words
    irregular : whether it squeals without a line spectrum; None where that is not known
    """

    squeals: bool | None
    tone_hz: float | None
    mode: str | None
    level_dba: float | None
    level_dba_band: tuple[float, float] | None
    steady: bool | None
    trust: str
    reasons: tuple[str, ...]
    sentence: str
    irregular: bool | None = None

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data."""
        band = None if self.level_dba_band is None else list(self.level_dba_band)
        return {
            "squeals": self.squeals,
            "tone_hz": self.tone_hz,
            "mode": self.mode,
            "level_dba": self.level_dba,
            "level_dba_band": band,
            "steady": self.steady,
            "irregular": self.irregular,
            "trust": {"verdict": self.trust, "reasons": list(self.reasons)},
            "verdict": self.sentence,
        }


def verdict(path: Path, data: Samples, summary: Summary, progress: Progress, spurious: Spurious) -> Verdict:
    """Return the verdict on a run.

    Parameters
    ----------
    path, data : its results file, and what is in it
    """
    if "wheel.v_lat" not in data:
        trust, reasons = _trust(progress, spurious)
        said = "no wheel in the results, so it is not known whether it squeals"
        return Verdict(None, None, None, None, None, None, trust, reasons, said)
    cycle = limit_cycle(data)
    growing = None if cycle.squeals else spurious.fastest
    trust, reasons = _trust(progress, spurious, growing is not None)
    sound = _sound(path) if cycle.squeals else None
    band = None if sound is None else (sound.low_dba, sound.high_dba)
    level = None if sound is None else sound.level_dba
    irregular = cycle.irregular if cycle.squeals else None
    tone = cycle.frequency_hz if cycle.squeals and not irregular else None
    mode = None if tone is None else _mode(data, tone)
    growth = growing[1] if growing else summary.growth_rate
    parts = [
        f"squeals irregularly, without a tone (strongest line {cycle.frequency_hz:.0f} Hz)"
        if irregular
        else _words(cycle.squeals, tone, mode, growth, growing and growing[0])
    ]
    if level is not None and band is not None:
        parts.append(f"{level:.0f} dB(A) at 7.5 m ({band[0]:.0f} to {band[1]:.0f})")
    if cycle.squeals:
        parts.append("steady" if cycle.steady else f"not steady: its level changes by {cycle.unsteadiness:.0%}")
    parts.append(f"trust: {trust}{''.join(f'; {reason}' for reason in reasons)}")
    return Verdict(cycle.squeals, tone, mode, level, band, cycle.steady, trust, reasons, ", ".join(parts), irregular)


def _words(squeals: bool, tone: float | None, mode: str | None, growth: float | None, at_hz: float | None) -> str:
    """Return the answer; `at_hz`: where the growth is, if that is known."""
    if squeals:
        return f"squeals at {tone:.1f} Hz" + (f", wheel mode {mode}" if mode else "")
    if growth is not None and growth > 0:
        where = "" if at_hz is None else f"{at_hz:.0f} Hz "
        return f"does not squeal yet: {where}grows by {growth:.3g} 1/s and is below {1e3 * SQUEAL_VELOCITY:g} mm/s"
    return f"does not squeal: the wheel's lateral velocity stays below {1e3 * SQUEAL_VELOCITY:g} mm/s"


def _sound(path: Path) -> Sound | None:
    """Return the sound of a run, coarser for a short one; None where it is not known."""
    with open_results(path) as data:
        for resolution in (2.0, SHORT_HZ):
            try:
                return sound_of(data, resolution_hz=resolution)
            except InputError:
                continue
    return None


def _mode(data: Samples, tone_hz: float) -> str | None:
    """Return the wheel mode near a tone that moves most, without its family; None where the wheel is not known."""
    try:
        modes = wheelset_of(data).modes
    except InputError:
        return None
    names = modal_velocities("wheel", data)
    near = np.flatnonzero(np.abs(modes.omega / (2 * np.pi * tone_hz) - 1) < NEAR)
    if len(names) != len(modes.labels) or not near.size:
        return None
    data = regular(data)  # of a last row after a fault the modal velocities are not known
    half = data.sizes["time"] // 2
    squares = [float(np.square(np.asarray(data[names[i]][half:], dtype=float)).mean()) for i in near]
    label: str = modes.labels[near[int(np.argmax(squares))]]
    return label.split(" ", maxsplit=1)[0]


def energy_share(progress: Progress) -> float | None:
    """Return the energy that the coupling added over the vibration energy that wheel and rail took [-].

    What they took they dissipated, or it is in them at the end. None where nothing went into them.
    """
    into = sum(abs(energy) for energy in progress.energy_into.values())
    return sum(progress.energy_residual.values()) / into if into > 0 else None


def _trust(progress: Progress, spurious: Spurious, grows: bool = False) -> tuple[str, tuple[str, ...]]:
    """Return how far the numbers can be trusted, and why not further; `grows`: what is silent now will not stay so."""
    reasons = []
    if grows:
        reasons.append("the run ends before it is seen what that grows to; take a longer one")
    if spurious.invented:
        reasons.append(f"the scheme makes {spurious.invented} stable modes unstable; take a smaller step")
    share = energy_share(progress)
    if share is not None and abs(share) > ENERGY_SHARE:
        did = "added" if share > 0 else "took"
        reasons.append(f"the coupling {did} {abs(share):.1%} of the energy that went into wheel and rail")
    if reasons:
        return "doubtful", tuple(reasons)
    if spurious.largest is None:
        return "unknown", (f"the error of the scheme is {spurious.sentence}",)
    return "good", ()
