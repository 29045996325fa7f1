"""The command `curve`: the reference vehicle's check values as JSON, a table in words, mistakes in one sentence."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from orchestrator.cli import app, command_line

ARGUMENTS = ["curve", "--radius", "150", "--track", "rigid"]


def run(*arguments: str) -> str:
    result = CliRunner().invoke(app, [*ARGUMENTS, *arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_json_has_the_check_values_of_the_reference_vehicle() -> None:
    """Without profile options: cone and arc, balanced speed, R = 150 m; digits as printed."""
    wheels = json.loads(run("--json"))["wheels"]
    found = {place: 1e3 * w["steady_creepage_lat"] for place, w in wheels.items()}
    wanted = {
        "leading_inner": -16.0459, "leading_outer": 22.6806, "trailing_inner": -0.8719, "trailing_outer": 0.8308,
    }  # fmt: skip
    assert found == pytest.approx(wanted, abs=1.01e-4)
    assert wheels["leading_inner"]["normal_load"] == pytest.approx(56758.3, abs=0.06)
    for w in wheels.values():
        for tone in w["unstable"]:
            assert tone.keys() == {"frequency_hz", "growth_rate", "loop_gain", "mode"}


@pytest.mark.slow
def test_a_right_curve_names_the_same_wheels() -> None:
    """Inner and outer, not left and right: a mirrored curve prints the same."""
    left, right = (json.loads(run("--json", "--radius", r))["wheels"] for r in ("150", "-150"))
    for place, wheel in left.items():
        for name in ("steady_creepage_lat", "steady_creepage_lon", "normal_load"):
            assert right[place][name] == pytest.approx(wheel[name], rel=1e-9)


def test_the_table_ends_with_a_sentence() -> None:
    text = run()
    assert "leading inner" in text
    assert "squeal" in text.strip().splitlines()[-1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["--speed", "60", "--cant", "0"],
            "150 m radius: a wheel lifts off its rail; found down to a radius of",
        ),
        (["--radius", "15"], "cant must be given: 10 m/s in a curve of 15 m radius would need 1.02 m"),
        (["--mu", "7"], "must be in the range"),
        (["--rail", "60e1-1:40"], "needs a wheel's"),
    ],
)
def test_mistakes_end_in_one_sentence(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["curvesqueal", *ARGUMENTS, *arguments])
    assert command_line() == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert words in " ".join(captured.err.split())
    assert "Traceback" not in captured.err
