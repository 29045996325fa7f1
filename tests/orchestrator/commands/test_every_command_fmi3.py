"""The system built of FMI 3.0, and one of mixed versions, through every command: the same answers as from FMI 2.0."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.cli import command_line
from orchestrator.fmi.file import Value
from orchestrator.results.file import open_results
from orchestrator.runs.run import Keeping, Report, resume, run_scenario
from orchestrator.runs.scenario import Scenario

pytestmark = pytest.mark.slow

OF_THE_FILES = {
    *("case", "system", "title", "results", "picture", "figure", "runs", "out", "wav", "calibration", "file", "path"),
    *("wall_s", "fmi_version", "sha256", "identity", "run", "size", "report", "guid", "source", "levels"),
}
"""What differs between two files of the same content: names, times, sums."""

Tell = Callable[..., Any]


@pytest.fixture(scope="module")
def systems(native: Path, native3: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the system of FMI 2.0, of 3.0, and with the rail and the wheel alone of 3.0, as `export` writes it."""
    folder = tmp_path_factory.mktemp("mixed")
    found = {"2": native / "curvesqueal.ssp", "3": native3 / "curvesqueal.ssp"}
    for name in ("rail", "wheel"):
        found[name] = folder / f"{name}.ssp"
        told("export", str(found["2"]), str(found[name]), "--replace", f"{name}={native3 / name}.fmu")
    return found


def told(*arguments: str) -> None:
    """Run the command line in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["curvesqueal", *arguments])
        assert command_line() == 0, arguments


@pytest.fixture
def tell(capsys: pytest.CaptureFixture[str]) -> Tell:
    """Return what a command prints as JSON."""

    def run(*arguments: str) -> Any:
        capsys.readouterr()
        told(*arguments, "--json")
        return json.loads(capsys.readouterr().out)

    return run


def leaves(data: Any, place: str = "") -> Iterator[tuple[str, Value | None]]:
    """Return each value in plain data with its place, without what is of the files."""
    if isinstance(data, dict):
        for key, value in data.items():
            if key not in OF_THE_FILES:
                yield from leaves(value, f"{place}/{key}")
    elif isinstance(data, list):
        for k, value in enumerate(data):
            yield from leaves(value, f"{place}/{k}")
    else:
        yield place, data


def assert_same(found: Any, expected: Any) -> None:
    """Both say the same things; numbers to 1e-9, those that are sums of large ones to 1e-6 of 1."""
    one, two = dict(leaves(found)), dict(leaves(expected))
    assert one.keys() == two.keys()
    for place, value in two.items():
        if isinstance(value, float) and math.isfinite(value):
            assert one[place] == pytest.approx(value, rel=1e-9, abs=1e-6), place
        else:
            assert one[place] == value, place


def numbered(text: str) -> str:
    """Return a text with the elements of arrays as FMI 2.0 spells them: a[3] is a_003."""
    return re.sub(r"\[(\d+)\]", lambda number: f"_{int(number[1]):03d}", text)


@pytest.mark.parametrize("kind", ["3", "rail", "wheel"])
@pytest.mark.parametrize(
    "command", [("coupling",), ("stability",), ("cycle", "--tone", "1100"), ("run", "--duration", "0.02")]
)
def test_a_command_says_the_same(
    command: tuple[str, ...], kind: str, systems: dict[str, Path], tell: Tell, tmp_path: Path
) -> None:
    name, *options = command
    options += ["--out", str(tmp_path)] if name == "run" else []
    assert_same(tell(name, str(systems[kind]), *options), tell(name, str(systems["2"]), *options))


@pytest.mark.parametrize("kind", ["3", "rail", "wheel"])
def test_a_resumed_run_is_that_of_fmi_2(kind: str, systems: dict[str, Path], tmp_path: Path) -> None:
    """Stopped after a third and resumed: every column of the run of FMI 2.0 to 1e-12 of its largest value."""

    def stop(progress: Any) -> None:
        if progress.steps > progress.total / 3:
            raise KeyboardInterrupt

    path = tmp_path / "checkpoint"
    with pytest.raises(KeyboardInterrupt):
        run_scenario(Scenario(str(systems[kind]), duration=0.02), tmp_path / kind, Report(stop), Keeping(path, 0.0))
    whole = run_scenario(Scenario(str(systems["2"]), duration=0.02), tmp_path / "2", Report())
    with open_results(resume(path, Report()).results) as found, open_results(whole.results) as expected:
        assert found.sizes == expected.sizes
        columns = {numbered(str(name)): found[name].to_numpy() for name in found.data_vars}
        for name in expected.data_vars:
            column, values = columns[str(name)], expected[name].to_numpy()
            np.testing.assert_allclose(column, values, rtol=0, atol=1e-12 * max(np.abs(values).max(), 1e-300))


@pytest.mark.parametrize("kind", ["3", "rail", "wheel"])
def test_the_exported_system_and_its_sound_are_those_of_fmi_2(
    kind: str, systems: dict[str, Path], tell: Tell, tmp_path: Path
) -> None:
    heard = {}
    for name in ("2", kind):
        again = tmp_path / f"again-{name}.ssp"
        told("export", str(systems[name]), str(again), "--set", "contact.mu0=0.35")
        heard[name] = tell("listen", str(again), "--duration", "0.3", "--out", str(tmp_path / f"{name}.wav"))
    assert_same(heard[kind], heard["2"])


def test_the_report_says_the_same(systems: dict[str, Path], tmp_path: Path) -> None:
    """All its words and numbers, but names of files, dates and checksums."""
    pages = {}
    for name in ("2", "3"):
        run = run_scenario(Scenario(str(systems[name]), duration=0.2), tmp_path / name, Report())
        told("report", str(run.results), "--out", str(tmp_path / name))
        page = (tmp_path / name / "report.html").read_text(encoding="utf-8")
        words = numbered(re.sub(r"<(script|style).*?</\1>|<[^>]*>", " ", page, flags=re.DOTALL)).split()
        pages[name] = [w for w in words if not re.search(r"[0-9a-f]{8}|/|:\d\d|\d{4}-\d\d", w)]
    assert pages["3"] == pages["2"]


def test_check_and_info_say_the_same(native: Path, native3: Path, tell: Tell, tmp_path: Path) -> None:
    checks = [tell("check", str(folder / "rail.fmu"), "--out", str(tmp_path)) for folder in (native, native3)]
    rows = [{check["name"]: check["status"] for check in found["checks"]} for found in checks]
    assert rows[0] == rows[1]
    variables = []
    for folder in (native, native3):
        described = tell("info", str(folder / "rail.fmu"))
        variables.append({numbered(v["name"]): (v["unit"], v.get("start")) for v in described["variables"]})
    assert {n: v for n, v in variables[1].items() if n != "time"} == variables[0]


def test_a_competition_ends_at_the_same_tone(systems: dict[str, Path], tell: Tell, tmp_path: Path) -> None:
    ends = [
        tell("competition", str(systems[kind]), "--runs", "1", "--duration", "0.05", "--start-mode", "1100",
             "--jobs", "1", "--out", str(tmp_path / kind))
        for kind in ("2", "3")
    ]  # fmt: skip
    assert_same(ends[1], ends[0])
