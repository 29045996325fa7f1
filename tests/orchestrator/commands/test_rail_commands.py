"""The commands `rail ...` and `check`: files, tables, JSON, refusals."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from fmus.interface import DIRECTIONS
from fmus.modal.data import ModalData, read_modal_data, write_modal_data
from fmus.modal.modes import Modes, mobility, receptance
from fmus.rail import shipped as making
from fmus.rail.fit import error_frequencies, fit_errors
from fmus.rail.track import track_receptance
from fmus.rail.track_data import TRACKS, read_track
from orchestrator.cli import rails as rail_app
from orchestrator.commands.systems.check import check
from orchestrator.errors import InputError
from orchestrator.fmi.instance import open_fmu
from orchestrator.probing.rail import impulse_responses, read_mapping
from orchestrator.probing.rail_passivity import estimate_mobility

check_app = typer.Typer()
check_app.command()(check)

F = np.geomspace(25.0, 4000.0, 60)
TRUTH = Modes(
    omega=2 * np.pi * np.array([80.0, 600.0, 200.0]),
    zeta=np.array([0.5, 0.1, 0.3]),
    shape=np.array([[0, 0, 0.05, 0], [0, 0, 0.09, 0], [0, 0.1, 0, 0]]),
    labels=("a", "b", "c"),
)


def call(app: typer.Typer, *arguments: object) -> str:
    """Return what a command prints; raise what it raises."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def write_mobility_csv(path: Path, directions: Sequence[str], delay: float = 0.0, scale: float = 1.0) -> None:
    """Write mobilities of the true rail, all of them late by `delay` seconds."""
    Y = scale * mobility(2 * np.pi * F, TRUTH) * np.exp(-2j * np.pi * F * delay)[:, None, None]
    lines = ["frequency_hz," + ",".join(f"{d}_real,{d}_imag" for d in directions)]
    for i, f in enumerate(F.tolist()):
        values = [Y[i, DIRECTIONS.index(d), DIRECTIONS.index(d)] for d in directions]
        lines.append(",".join([repr(f), *(f"{float(v.real)!r},{float(v.imag)!r}" for v in values)]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_fit_writes_the_file_whose_errors_it_prints(tmp_path: Path) -> None:
    """The JSON has the four directions and nothing else, and is what the file gives when it is read back."""
    path = tmp_path / "new" / "slab.toml"
    errors: dict[str, Any] = json.loads(call(rail_app, "fit", "slab", "--method", "paper", "--out", path, "--json"))
    assert list(errors) == list(DIRECTIONS)
    omega = 2 * np.pi * error_frequencies()
    assert omega.size == 200
    target = track_receptance(omega, read_track(TRACKS / "slab.toml"))
    assert errors == fit_errors(omega, target, read_modal_data(path).modes)


def test_fit_prints_the_numbers_of_the_documentation(tmp_path: Path) -> None:
    """`docs/rail.md`: paper's method, vertical 2.7 dB and 13 degrees with 3 modes."""
    text = call(rail_app, "fit", "default", "--method", "paper", "--out", tmp_path / "rail.toml")
    row = next(line for line in text.splitlines() if "│ ver" in line)
    assert [cell.strip() for cell in row.split("│")[3:6]] == ["2.71", "13.2", "3"]


@pytest.mark.slow
def test_the_accurate_fit_of_a_shipped_track_reaches_the_goal(tmp_path: Path) -> None:
    """0.5 dB and 3 degrees in every direction with at most 8 modes."""
    errors = json.loads(call(rail_app, "fit", "soft-pads", "--out", tmp_path / "rail.toml", "--json"))
    for error in errors.values():
        assert error["rms_db"] <= 0.5
        assert error["rms_degrees"] <= 3.0
        assert error["modes"] <= 8


def test_a_file_that_is_there_is_kept_unless_forced(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("precious", encoding="utf-8")
    fitting = ("fit", "default", "--method", "paper", "--out", path)
    with pytest.raises(InputError, match=r"mine.toml: is there already; give another --out, or --force"):
        call(rail_app, *fitting)
    assert path.read_text(encoding="utf-8") == "precious"
    call(rail_app, *fitting, "--force")
    assert len(read_modal_data(path).modes)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nowhere",), "nowhere: neither a track file nor one of bs113a, default, rail-dampers, slab, soft-pads"),
        (("default", "--method", "best"), "method is 'best'; must be one of accurate, paper"),
        (("default", "--method", "paper", "--modes", "3"), "most_modes goes with method 'accurate'"),
        (("default", "--out", "rail.json"), r"--out .*rail.json: must end with .toml"),
    ],
)
def test_fit_refuses_what_it_cannot_do(
    arguments: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=message):
        call(rail_app, "fit", *arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('pad_stiffness = { value = ', 'pad_stiffness = { value = -', "pad_stiffness = -.* must be > 0"),
        ('loss_factor = { value = 0.02', 'loss_factor = { value = 0.7', "loss_factor = 0.7; must be at most 0.5"),
        ("title", "titel", "title must be a text"),
    ],
)  # fmt: skip
def test_a_track_with_a_fault_is_refused(old: str, new: str, message: str, tmp_path: Path) -> None:
    text = (TRACKS / "default.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "track.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=f"^track.toml: .*{message}"):
        call(rail_app, "fit", path, "--out", tmp_path / "rail.toml")


def test_figures_come_with_their_errors(tmp_path: Path) -> None:
    """Three pictures of the default track; the shipped accurate rail keeps its promise, the paper's does not."""
    data = json.loads(call(rail_app, "figures", "--out", tmp_path / "figures", "--json"))
    assert [Path(file).name for file in data["files"]] == ["receptance.png", "figure-3.png", "figure-4.png"]
    assert all(Path(file).stat().st_size > 10_000 for file in data["files"])
    assert all(e["rms_db"] <= 0.5 and e["rms_degrees"] <= 3.0 for e in data["errors"]["accurate"].values())
    with_mode, without = (data["errors"][f"paper, {word} extra mode"] for word in ("with", "without"))
    assert all(with_mode[d]["rms_db"] < without[d]["rms_db"] for d in DIRECTIONS)


def test_a_measured_rail_becomes_an_fmu(tmp_path: Path) -> None:
    """Mobilities from two files; the FMU's own impulse responses give them back within the fit, 1 dB at the worst.

    The directions that were not measured do not move.
    """
    for direction in ("ver", "lat"):
        write_mobility_csv(tmp_path / f"{direction}.csv", [direction])
    files = (tmp_path / "ver.csv", tmp_path / "lat.csv")
    out = tmp_path / "new" / "my-rail.fmu"
    quality = json.loads(call(rail_app, "measured", *files, "--quantity", "mobility", "--out", out, "--json"))
    assert list(quality) == ["lat", "ver"]
    assert all(q["rms_db"] <= 0.5 and q["active_degrees"] == 0 for q in quality.values())
    fmu = open_fmu(out)
    assert fmu.description.modelName == "rail_measured"
    found = estimate_mobility(impulse_responses(fmu, read_mapping([], fmu), 2e-5))
    band = (found.frequency_hz > 30) & (found.frequency_hz < 2400)
    expected = mobility(2 * np.pi * found.frequency_hz[band], TRUTH)
    ratio = np.abs(found.values[band] / np.where(expected == 0, 1, expected))
    for j in (1, 2):
        assert np.abs(20 * np.log10(ratio[:, j, j])).max() < 1.0
    assert not found.values[:, [0, 3]].any()


def test_a_measured_rail_becomes_modal_data(tmp_path: Path) -> None:
    write_mobility_csv(tmp_path / "rail.csv", ["ver"])
    out = tmp_path / "rail.toml"
    text = call(rail_app, "measured", tmp_path / "rail.csv", "--quantity", "mobility", "--out", out, "--modes", 3)
    assert "ver" in text
    data = read_modal_data(out)
    assert "mobility in rail.csv" in data.source
    assert len(data.modes) <= 3
    found, true = (receptance(2 * np.pi * F, modes)[:, 2, 2] for modes in (data.modes, TRUTH))
    assert np.abs(20 * np.log10(np.abs(found / true))).max() < 1.0


def test_active_data_are_refused_with_file_and_frequency(tmp_path: Path) -> None:
    """Late by 20 us: 29 degrees at 4 kHz, where the mobility of a mass leads to more than -90."""
    path, out = tmp_path / "late.csv", tmp_path / "rail.fmu"
    write_mobility_csv(path, ["ver"], delay=2e-5)
    with pytest.raises(InputError, match=r"late.csv: ver mobility at 4000 Hz has a phase of -\d+"):
        call(rail_app, "measured", path, "--quantity", "mobility", "--out", out)
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("a.csv", "a.csv", "--quantity", "mobility"), "a.csv: holds ver as .*a.csv does; must be in one file"),
        (("b.csv", "--quantity", "mobility"), "b.csv: no such file"),
        (("a.txt", "--quantity", "mobility"), "a.txt, line 1: column 'frequency_hz' is missing; has nonsense"),
        (("a.csv",), "a.csv: does not say whether it is a receptance, mobility or accelerance"),
        (("a.csv", "--units", "mm/s"), "unit 'mm/s' is no displacement, velocity or acceleration per force"),
        (("soft.csv", "--quantity", "mobility"), "soft.csv: ver receptance reaches .* more than a rail's"),
        (("a.csv", "--quantity", "impedance"), "quantity is 'impedance'; must be one of receptance, mobility"),
        (("a.csv", "--quantity", "mobility", "--axis", "9=lat"), "axis 9=lat: must be CODE=DIRECTION"),
        (("a.csv", "--quantity", "mobility", "--out", "rail.ssd"), r"--out .*rail.ssd: must end with .toml or .fmu"),
        (("a.csv", "--quantity", "mobility", "--modes", "0"), "most_modes = 0; must be at least 1"),
    ],
)
def test_measured_refuses_what_it_cannot_use(
    arguments: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, scale in (("a.csv", 1.0), ("soft.csv", 1000.0)):
        write_mobility_csv(tmp_path / name, ["ver"], scale=scale)
    (tmp_path / "a.txt").write_text("nonsense\n", encoding="utf-8")
    with pytest.raises(InputError, match=message):
        call(rail_app, "measured", *arguments)


def test_build_makes_the_modes_an_fmu(tmp_path: Path) -> None:
    """Its start values are the modes of the file."""
    path, out = tmp_path / "modes.toml", tmp_path / "rail.fmu"
    write_modal_data(path, ModalData("three modes", "made up", TRUTH))
    call(rail_app, "build", path, "--out", out)
    variables = open_fmu(out).variables
    for i in range(3):
        assert float(variables[f"frequency_{i + 1:03d}"].start) == pytest.approx(TRUTH.omega[i] / (2 * np.pi))
        assert float(variables[f"shape_ver_{i + 1:03d}"].start) == TRUTH.shape[i, 2]
    with pytest.raises(InputError, match=r"rail.fmu: is there already"):
        call(rail_app, "build", path, "--out", out)
    with pytest.raises(InputError, match=r"modes.zip: must end with .fmu"):
        call(rail_app, "build", path, "--out", tmp_path / "modes.zip")
    with pytest.raises(InputError, match=r"none.toml: No such file"):
        call(rail_app, "build", tmp_path / "none.toml", "--out", tmp_path / "other.fmu")


def test_regenerate_compares_or_writes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The work itself, which takes minutes, is replaced."""
    written: list[bool] = []
    monkeypatch.setattr(making, "regenerate", lambda: written.append(True))
    monkeypatch.setattr(making, "differences", list)
    call(rail_app, "regenerate", "--check")
    assert not written
    call(rail_app, "regenerate")
    assert written
    monkeypatch.setattr(making, "differences", lambda: ["rail.toml: ver differs", "rail.toml: lat differs"])
    with pytest.raises(InputError, match=r"rail.toml: ver differs; rail.toml: lat differs"):
        call(rail_app, "regenerate", "--check")


def test_check_prints_draws_and_fails_where_it_must(built: Path, tmp_path: Path) -> None:
    out = tmp_path / "figures"
    data = json.loads(call(check_app, built / "rail-rigid.fmu", "--as", "rail", "--out", out, "--step", 2e-5, "--json"))
    assert data["passed"]
    assert data["step_s"] == 2e-5
    assert Path(data["figure"]).is_file()
    result = CliRunner().invoke(check_app, [str(built / "contact.fmu"), "--out", str(tmp_path)])
    assert isinstance(result.exception, InputError)
    assert "contact.fmu: is no rail: names: missing: f_lon" in str(result.exception)
    assert "not run" in result.output
    with pytest.raises(InputError, match="--as wheel: must be rail"):
        call(check_app, built / "wheel.fmu", "--as", "wheel")
