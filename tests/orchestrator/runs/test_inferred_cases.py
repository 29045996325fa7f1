"""The inferred cases in the time domain: the paper's tones, levels alike, contact kept; commands that take them."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.paper.time_domain import Facts, as_published, facts_of
from orchestrator.published.cases import CASES, INFERRED
from orchestrator.results.file import open_results
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario

DURATION_S = 4.0
"""Long enough: the slowest growth, 8.6 1/s in Case 4, takes 1.2 s from the pulse."""


@pytest.fixture(scope="module")
def facts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Facts]:
    folder = tmp_path_factory.mktemp("inferred")
    found = {}
    for case, twin in zip(CASES, INFERRED, strict=True):
        results = run_scenario(Scenario(twin, duration=DURATION_S), folder, Report()).results
        with open_results(results) as data:
            found[case] = facts_of(data)
    return found


@pytest.mark.slow
def test_tones_are_the_paper_s(facts: dict[str, Facts]) -> None:
    """From the pulse, within 1 %, in limit cycles that last."""
    for case, f in facts.items():
        assert as_published(case, f.cycle), (case, f.cycle.frequency_hz)
        assert f.cycle.steady


@pytest.mark.slow
def test_levels_are_alike_and_contact_is_kept(facts: dict[str, Facts]) -> None:
    """Within 3 dB, as asked; the paper says "quite similar". The normal force never falls to zero."""
    levels = [f.sound.level_dba for f in facts.values()]
    assert max(levels) - min(levels) < 3.0
    for f in facts.values():
        assert f.cycle.contact_lost == 0
        assert f.cycle.normal_force is not None
        assert f.cycle.normal_force[0] > 0.5 * 60e3


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [("coupling",), ("stability",), ("competition", "--runs", "2", "--duration", "0.05")], ids=lambda c: c[0]
)
def test_commands_take_them(command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, [command[0], "inferred1", *command[1:], "--json"])
    assert done.exit_code == 0, done.output
    assert '"' in done.stdout
