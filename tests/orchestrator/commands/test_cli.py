"""The command line as a user meets it: real processes, exit codes, one sentence for each mistake."""

from __future__ import annotations

import json
import sys
import zipfile
from itertools import pairwise
from pathlib import Path

import pytest
from command_line import curvesqueal
from PIL import Image

from fmus.interface import DIRECTIONS
from orchestrator.cli import command_line
from orchestrator.results.file import open_results


@pytest.fixture(scope="module")
def case1(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, object]]:
    folder = tmp_path_factory.mktemp("run")
    done = curvesqueal("run", "case1", "--duration", "0.05", "--json", "--csv", "--picture", "--out", str(folder))
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_run_prints_one_json_object(case1: tuple[Path, dict[str, object]]) -> None:
    _, data = case1
    assert data["case"] == "case1"
    assert data["steps"] == 10_000
    assert data["step_s"] == 5e-6
    assert data["duration_s"] == pytest.approx(0.05)
    assert isinstance(data["wall_s"], float)
    assert isinstance(data["dominant_frequency_hz"], float)
    for key in ("wheel_velocity_rms", "rail_velocity_rms", "energy_into_structures"):
        assert set(data[key]) == set(DIRECTIONS)  # type: ignore[call-overload]
    assert set(data["energy_residual"]) == {"lon", "lat", "normal", "spin"}  # type: ignore[call-overload]
    assert set(data["wheel_velocity_rms_contact"]) == {"plane", "normal"}  # type: ignore[call-overload]
    assert data["completed"] is True
    # steady sliding at 0.2 m/s under nearly mu N: 60 kN x 0.277 x 0.2 m/s over 0.05 s; the vibration adds little
    assert data["energy_dissipated"] == pytest.approx(60e3 * 0.3 * 0.9221199 * 0.2 * 0.05, rel=0.01)
    assert abs(sum(data["energy_residual"].values())) < 1e-3  # type: ignore[attr-defined]
    assert 0 < data["max_growth_rate_error"] < 5  # type: ignore[operator]
    assert "makes no stable mode unstable" in str(data["spurious_growth"])


def test_run_leaves_results_csv_and_picture(case1: tuple[Path, dict[str, object]]) -> None:
    folder, data = case1
    with open_results(Path(str(data["results"]))) as results:
        assert results.sizes["time"] == 2501
        attributes = results.attrs
        assert json.loads(attributes["parameters"])["contact"]["falling_ratio"] == 0.1
        assert set(json.loads(attributes["fmus"])) == {"wheel", "rail", "contact"}
        assert {"curvesqueal", "python", "numpy"} <= set(json.loads(attributes["versions"]))
    assert len((folder / "case1.csv").read_text().splitlines()) == 2502
    with Image.open(str(data["picture"])) as picture:
        assert picture.width > 1000


def test_a_picture_can_be_had_later_and_is_not_replaced_by_itself(case1: tuple[Path, dict[str, object]]) -> None:
    """The same picture to the pixel, since both are drawn from the file."""
    folder, data = case1
    arguments = ["picture", str(data["results"]), "--out", str(folder / "later.png")]
    assert (curvesqueal(*arguments).returncode, curvesqueal(*arguments).returncode) == (0, 1)
    with Image.open(folder / "later.png") as later, Image.open(str(data["picture"])) as first:
        assert later.tobytes() == first.tobytes()


def test_a_second_run_does_not_overwrite_the_first(case1: tuple[Path, dict[str, object]]) -> None:
    folder, data = case1
    before = Path(str(data["results"])).read_bytes()
    done = curvesqueal("run", "case1", "--duration", "0.001", "--json", "--out", str(folder))
    assert json.loads(done.stdout)["results"].endswith("case1-2.nc")
    assert Path(str(data["results"])).read_bytes() == before


@pytest.mark.parametrize("case", ["case2", "case3", "case4"])
def test_all_cases_run(case: str, tmp_path: Path) -> None:
    done = curvesqueal("run", case, "--duration", "0.01", "--json", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["case"] == case
    assert (data["rail_velocity_rms"]["ver"] == 0) == (case in ("case2", "case4"))


def test_table_is_printed_for_people(tmp_path: Path) -> None:
    done = curvesqueal("run", "case1", "--duration", "0.01", "--seed", "3", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    for word in ("dominant frequency", "energy residual", "wheel velocity, rms [m/s", "growth rate", "case1.nc"):
        assert word in done.stdout


def test_rail_can_be_replaced_and_parameters_set(built: Path, tmp_path: Path) -> None:
    done = curvesqueal(
        "run", str(built / "curvesqueal.ssp"), "--duration", "0.005", "--step", "1e-5", "--algorithm", "jacobi",
        "--replace", f"rail={built / 'rail-rigid.fmu'}", "--set", "contact.mu0=0.35", "--json", "--out", str(tmp_path),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert (data["steps"], data["algorithm"]) == (500, "jacobi")
    assert data["rail_velocity_rms"]["lat"] == 0
    assert "jacobi delays the contact force" in done.stderr
    with open_results(tmp_path / "case1.nc") as results:
        parameters = json.loads(results.attrs["parameters"])
    assert parameters["contact"]["mu0"] == 0.35
    assert parameters["rail"]["step_size"] == 1e-5


def test_build_and_info(tmp_path: Path) -> None:
    done = curvesqueal("build", "--out", str(tmp_path), "--json")
    names = {Path(name).name for name in json.loads(done.stdout)["files"]}
    assert {"wheel.fmu", "rail.fmu", "rail-rigid.fmu", "contact.fmu", "curvesqueal.ssp"} <= names
    shown = curvesqueal("info", str(tmp_path / "contact.fmu"))
    assert "steady_creepage_lat" in shown.stdout
    assert len(shown.stdout.splitlines()) < 130  # a line for each variable or numbered family, no folded descriptions
    assert "lateral velocity" in curvesqueal("info", "--all", str(tmp_path / "contact.fmu")).stdout
    data = json.loads(curvesqueal("info", str(tmp_path / "curvesqueal.ssp"), "--json").stdout)
    assert [c["name"] for c in data["components"]] == ["wheel", "rail", "contact"]
    assert len(data["connections"]) == 20


def test_friction_curves_come_from_the_fmu(tmp_path: Path) -> None:
    """Fig. 5: both rise alike, constant friction stays at mu0, falling friction falls to 0.9 mu0 + ..."""
    done = curvesqueal("friction", "--out", str(tmp_path / "f.png"), "--json")
    data = json.loads(done.stdout)
    gamma, constant, falling = data["creepage"], data["constant friction"], data["falling friction"]
    k = gamma.index(0.02)
    assert constant[k] == pytest.approx(0.3, rel=1e-9)
    assert falling[k] == pytest.approx(0.3 * 0.9221199, rel=1e-6)
    assert constant[0] == 0
    assert max(falling) < 0.3
    assert falling.index(max(falling)) < k
    assert all(a <= b + 1e-12 for a, b in pairwise(constant))
    assert (tmp_path / "f.png").stat().st_size > 10_000


def test_help_is_for_newcomers() -> None:
    done = curvesqueal("--help")
    assert done.returncode == 0
    for command in ("build", "run", "info", "friction"):
        assert command in done.stdout
    assert "Running an FMU runs its code" in done.stdout
    assert "protects against crashes and hangs only" in " ".join(done.stdout.split())


def hostile_zip(path: Path, name: str) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(name, "x")
    return path


def in_process(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Run the command line in this process; return exit code, stdout and stderr. An exception would be a traceback."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["curvesqueal", *arguments])
        code = command_line()
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_user_mistakes_are_one_sentence(
    tmp_path: Path, built: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each ends with a non-zero exit, nothing on stdout, and a sentence on stderr that names the matter."""
    monkeypatch.chdir(tmp_path)
    text = tmp_path / "text.ssp"
    text.write_text("no zip")
    empty = tmp_path / "empty.fmu"
    with zipfile.ZipFile(empty, "w"):
        pass
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(broken, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription")
    escape = hostile_zip(tmp_path / "escape.ssp", "../outside.txt")
    absolute = hostile_zip(tmp_path / "absolute.fmu", "/etc/outside.txt")
    missing = tmp_path / "missing.ssp"
    mistakes = {
        ("run", "case5"): "case5: neither a case (case1, case2, case3, case4, inferred1, inferred2, inferred3, ",
        ("run", str(missing)): "no such SSP file",
        ("run", str(text)): "not a zip archive",
        ("run", str(escape)): "entry '../outside.txt' would be unpacked outside the folder; refused",
        ("info", str(absolute)): "would be unpacked outside the folder; refused",
        ("info", str(empty)): "holds no modelDescription.xml",
        ("info", str(broken)): "modelDescription.xml is not valid",
        ("info", str(tmp_path / "x.txt")): "must be an .fmu, .ssp or .ssd file",
        ("run", "case1", "--step", "-1e-6"): "step = -1e-06 s: must be > 0",
        ("run", "case1", "--duration", "0"): "must be at least one step",
        ("run", "case1", "--algorithm", "euler"): "algorithm 'euler': must be one of staggered, jacobi",
        ("run", "case1", "--set", "contact.mu0"): "--set contact.mu0: must be COMPONENT.PARAMETER=VALUE",
        ("run", "case1", "--set", "contact.mu0=7"): "parameter contact.mu0 = 7: must be in the range 0 to 2",
        ("run", "case1", "--replace", "rail"): "--replace rail: must be COMPONENT=FILE.fmu",
        ("run", "case1", "--replace", f"rail={built / 'contact.fmu'}"): "has no variable",
        ("run", "case1", "--replace", "rail=nothing.fmu"): "nothing.fmu: no such FMU file",
        ("run", "case1", "--duration", "soon"): "--duration",
        ("run",): "Missing argument",
        ("fly",): "No such command",
        ("build", "--out", str(text)): "cannot write there",
    }
    for arguments, sentence in mistakes.items():
        code, out, err = in_process(capsys, *arguments)
        said = " ".join(err.replace("│", " ").split())
        assert code != 0, arguments
        assert out == "", arguments
        assert sentence in said, (arguments, said)
    assert not (tmp_path.parent / "outside.txt").exists()


def test_a_mistake_ends_a_real_process_with_a_sentence(tmp_path: Path) -> None:
    done = curvesqueal("run", "case5", folder=tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith("curvesqueal: case5: neither a case")
