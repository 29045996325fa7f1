"""Track files and arguments that are refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fmus.rail.track import track_receptance
from fmus.rail.track_data import TRACKS, Track, read_track


def _track(name: str = "default") -> Track:
    return read_track(TRACKS / f"{name}.toml")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("560e6", "-560e6", r"bad.toml: ver support: pad_stiffness = -5.6e\+08 N/m; must be > 0"),
        ("value = 0.02,", "value = 0.9,", r"bad.toml: rail: loss_factor = 0.9; must be at most 0.5"),
        ("value = 0.02,", "value = 0.0,", r"rail: loss_factor = 0 1; must be > 0"),
        ("value = 1.0,", "value = 3.0,", r"lon support: ballast_loss_factor = 3; must be at most 2"),
        ("value = 60.0", "value = nan", r"rail: mass_per_length = nan kg/m; must be > 0"),
        ("value = 60.0", 'value = "60"', r"rail.mass_per_length: value must be a number; got '60'"),
        ('"kg/m"', '"t/m"', r"rail.mass_per_length: unit must be 'kg/m'; got 't/m'"),
        ('source = "steel"', 'source = ""', r"rail.young_modulus: source must be a text; got ''"),
        ("[rail]", "[rial]", r"bad.toml: rail.mass_per_length is missing"),
        ("area =", "areas =", r"rail.areas is unknown; must be one of mass_per_length, "),
        ("value = 150.0", "value = 0.0", r"sleeper_mass = 0 kg and ballast in 3 of 3 directions; must be"),
        ("value = 0.6,", "value = -0.6,", r"spacing = -0.6 m; must be > 0"),
        ("[support]", '[support]\nspan = 3', r"support.span is unknown"),
        ('title = "UIC', 'lateral_model = "web"\ntitle = "UIC', r"lateral_model = 'web'; must be one of"),
        ("[rail]", "[rail", r"bad.toml: not a TOML file"),
    ],
)  # fmt: skip
def test_a_fault_in_a_track_is_named(old: str, new: str, message: str, tmp_path: Path) -> None:
    text = (TRACKS / "default.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "bad.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_track(path)


def test_a_contact_beside_the_head_is_refused() -> None:
    with pytest.raises(ValueError, match=r"contact_offset = 0.2 m; must be on the head, within 0.05"):
        replace(_track(), contact_offset=0.2)


@pytest.mark.parametrize("omega", [[0.0], [-1.0], [np.nan]])
def test_frequencies_must_be_positive(omega: list[float]) -> None:
    with pytest.raises(ValueError, match="must be finite and > 0"):
        track_receptance(omega, _track())


def test_rail_dampers_make_waves_decay_as_their_file_says() -> None:
    """Bending waves of a free rail, k = (m w^2 / (E I (1 + j eta)))^(1/4): 1.7 dB/m more at 1 kHz; 3 % for rounding."""
    decay = []
    for name in ("default", "rail-dampers"):
        rail = _track(name).section
        stiffness = rail.bending_stiffness_ver * (1 + 1j * rail.loss_factor)
        k = (rail.mass_per_length * (2 * np.pi * 1000) ** 2 / stiffness) ** 0.25
        decay.append(-20 * np.log10(np.e) * k.imag)
    assert decay[1] - decay[0] == pytest.approx(1.7, rel=0.03)
