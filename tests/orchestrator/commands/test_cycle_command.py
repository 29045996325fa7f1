"""The command `cycle`: what it prints, what it writes, what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator import InputError, cycles, load, plot_cycles
from orchestrator.cli import app


def test_json_tells_what_the_tone_is(tmp_path: Path) -> None:
    """The object of one tone, and its picture."""
    picture = tmp_path / "cycle.png"
    arguments = ["cycle", "case1", "--tone", "1100", "--json", "--out", str(picture)]
    done = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    assert picture.stat().st_size > 10_000
    (tone,) = json.loads(done.stdout)["cycles"]
    assert tone["frequency_hz"] == pytest.approx(1100.3, abs=0.1)
    assert tone["pole_hz"] == pytest.approx(1101.2, abs=0.1)
    assert tone["stable"] is True
    assert tone["largest_exponent"] == pytest.approx(-0.15, abs=0.1)
    assert tone["level_dba"] == pytest.approx(95.5, abs=0.3)
    assert tone["normal_force"]["min"] < 60e3 < tone["normal_force"]["max"]
    # Parseval: the lines that are told hold nearly all of the level
    lateral = sum(line["wheel"]["lat"] ** 2 / 2 for line in tone["harmonics"]) ** 0.5
    assert lateral == pytest.approx(tone["wheel_velocity_rms"]["lat"], rel=1e-4)


@pytest.mark.slow
def test_parameters_and_the_library_mean_the_same() -> None:
    """Twice the creepage makes the tone 6 dB louder: its velocity just reaches that of sliding."""
    plain, double = (
        cycles(load("case1", values=values), tone_hz=1100, with_stability=False).near(1100)
        for values in ({}, {"contact": {"steady_creepage_lat": 0.04}})
    )
    assert double.level_dba is not None
    assert plain.level_dba is not None
    assert double.level_dba - plain.level_dba == pytest.approx(6.0, abs=0.3)
    assert plain.stable is None
    assert plain.fate == "not looked at"


@pytest.mark.slow
def test_another_wheel_and_damping_have_other_tones() -> None:
    """`--wheel`, with its contact stiffness, and `--damp`: the 1100 Hz of `generic840`, and none with much damping."""
    arguments = ["cycle", "case1", "--tone", "1100", "--json", "--no-stability"]
    other = CliRunner().invoke(app, [*arguments, "--wheel", "generic840"], catch_exceptions=False)
    (tone,) = json.loads(other.stdout)["cycles"]
    assert tone["frequency_hz"] == pytest.approx(1099.6, abs=0.1)
    with pytest.raises(InputError, match="case1: no tone"):
        CliRunner().invoke(app, [*arguments, "--damp", "(3,0)=2e-2"], catch_exceptions=False)


@pytest.mark.slow
def test_what_a_tone_breaks_up_into_is_told() -> None:
    """`--torus`: two tones of Case 3's 272 Hz, in words and as JSON."""
    arguments = ["cycle", "case3", "--tone", "272", "--torus"]
    words = CliRunner().invoke(app, arguments, catch_exceptions=False).stdout
    assert "breaks up through sidebands at 148 and 420 Hz into 272 + 148 + 419 Hz" in words
    (tori,) = json.loads(CliRunner().invoke(app, [*arguments, "--json"], catch_exceptions=False).stdout)["tori"]
    assert tori["torus"]["frequencies_hz"] == pytest.approx([271.91, 147.56], abs=0.05)
    assert sum(line["amplitude"] ** 2 / 2 for line in tori["torus"]["lines"]) ** 0.5 == pytest.approx(
        tori["torus"]["wheel_velocity_rms"]["lat"], rel=0.01
    )


@pytest.mark.parametrize("other", [["--no-stability"], ["--against", "contact.mu0=0.1:0.5"]])
def test_two_tones_without_stability_are_refused(other: list[str]) -> None:
    with pytest.raises(InputError, match=f"{other[0]} does not go with it"):
        CliRunner().invoke(app, ["cycle", "case1", "--torus", *other], catch_exceptions=False)


def test_a_tone_that_is_not_there_is_refused() -> None:
    """The nearest ones are named."""
    with pytest.raises(InputError, match=r"no tone near 700 Hz: .*1101\.2 Hz"):
        cycles(load("case1"), tone_hz=700.0)


def test_a_quiet_system_has_no_tone() -> None:
    """Hardly any friction: the nearest pole is named with its growth rate."""
    with pytest.raises(InputError, match=r"no tone: quiet, nearest pole .* Hz with -"):
        cycles(load("case1", values={"contact": {"mu0": 0.002}}))


@pytest.mark.slow
def test_all_tones_are_drawn() -> None:
    """Growth rate against amplitude and levels, with a legend and units."""
    figure = plot_cycles(cycles("case4", with_stability=False), title="case4")
    growth, levels = figure.axes
    assert growth.get_xlabel() == "Amplitude of the first harmonic [m/s]"
    assert "dB(A)" in levels.get_ylabel()
    assert growth.get_legend() is not None
    assert levels.get_title() == "whether they last was not looked at"
