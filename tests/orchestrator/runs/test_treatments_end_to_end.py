"""What an engineer tries on Case 1 by commands alone: a rail, damping and absorbers; what becomes of the squeal."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmus.cache import cache_folder
from fmus.interface import DIRECTIONS
from fmus.modal.modes import Modes, receptance
from fmus.rail.track import track_receptance
from fmus.rail.track_data import TRACKS, read_track
from orchestrator.cli import command_line
from orchestrator.results.file import open_results
from orchestrator.sound.wheelset import block

Command = Callable[..., dict[str, Any]]


@pytest.fixture
def curvesqueal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Return the command line, which returns what it prints as JSON."""

    def call(*arguments: object) -> dict[str, Any]:
        monkeypatch.setattr(sys, "argv", ["curvesqueal", *map(str, arguments), "--json"])
        assert command_line() == 0
        data: dict[str, Any] = json.loads(capsys.readouterr().out)
        return data

    return call


@pytest.mark.slow
def test_damping_silences_case_1_or_moves_its_tone(curvesqueal: Command, tmp_path: Path) -> None:
    """In time: with (3,0) damped by 2 % another mode sings; with all axial modes damped by 5 % none does; 2 s each."""

    def run(name: str, *rules: str) -> dict[str, Any]:
        options = [word for rule in rules for word in ("--damp", rule)]
        return curvesqueal("run", "case1", "--duration", 2, "--out", tmp_path / name, *options)

    moved = run("moved", "(3,0)=2e-2")
    assert moved["squeals"]
    assert abs(moved["tone_hz"] - 1101.0) > 100
    silent = run("silent", "(*,0)=5e-2", "(0,*)=5e-2")
    assert not silent["squeals"]
    data = open_results(Path(moved["results"]))
    assert np.sum(block(data, "wheel", "damping_ratio") == 2e-2) == 2  # both families


@pytest.mark.slow
def test_an_absorber_takes_the_tone_from_its_mode(curvesqueal: Command, tmp_path: Path) -> None:
    """2 kg on (3,0), as an FMU in the wheel's place: nothing sings between the two halves of the split mode."""
    wheel = tmp_path / "w.fmu"
    treat = ["--absorber", "(3,0)", "--mass", 2, "--loss", 0.1, "--out", wheel]
    low, high = curvesqueal("wheel", "treat", "class158", *treat)["split_hz"]
    assert low < 1102 < high
    options = ["--replace", f"wheel={wheel}", "--duration", 2, "--out", tmp_path]
    tone = curvesqueal("run", "case1", *options)["tone_hz"]
    assert not 0.95 * low < tone < 1.05 * high


@pytest.mark.slow
def test_a_wheel_of_ones_own_is_run_and_heard(curvesqueal: Command, tmp_path: Path) -> None:
    """Class158 with its areas as a file: the level of its run is that of class158, known by its frequencies."""
    own = tmp_path / "own.toml"
    curvesqueal("wheel", "build", "class158", "--out", own)
    results = curvesqueal("run", "case1", "--wheel", own, "--duration", 0.6, "--out", tmp_path)["results"]
    levels = [
        curvesqueal("listen", results, "--out", tmp_path / f"{name}.wav", *options)["level_dba"]
        for name, options in (("own", ("--wheel", own)), ("known", ()))
    ]
    assert levels[0] == pytest.approx(levels[1], abs=1e-9)


@pytest.mark.slow
def test_a_rail_by_its_track_is_fitted_built_and_kept(curvesqueal: Command, tmp_path: Path) -> None:
    """`--rail` with the track of soft pads in a file that no cache knows: one FMU, the same one the second time.

    It moves as the track does: 1 dB, as fits of the shipped tracks.
    """
    track = tmp_path / "soft-pads.toml"
    track.write_text(f"# {tmp_path}\n" + (TRACKS / "soft-pads.toml").read_text())
    before = set(cache_folder("rails").glob("*.fmu"))
    run = ["run", "case1", "--rail", track, "--duration", 0.01, "--out", tmp_path]
    data = open_results(Path(curvesqueal(*run)["results"]))
    (fmu,) = set(cache_folder("rails").glob("soft-pads-*.fmu")) - before
    made = fmu.stat().st_ino  # the time says when it was used last
    curvesqueal(*run)
    assert fmu.stat().st_ino == made
    fmu.unlink()
    omega = 2 * np.pi * np.geomspace(50, 3000, 60)
    shape = np.column_stack([block(data, "rail", f"shape_{d}") for d in DIRECTIONS])
    modes = Modes(2 * np.pi * block(data, "rail", "frequency"), block(data, "rail", "damping_ratio"), shape)
    ratio = receptance(omega, modes) / track_receptance(omega, read_track(TRACKS / "soft-pads.toml"))
    for j in (1, 2):  # lateral and vertical; 1 dB rms is what fits of the shipped tracks keep
        assert 20 * np.log10(np.abs(ratio[:, j, j])).std() < 1.0
