"""The check of rails: what is one passes, what is not is found, and said."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fmus.modal.modes import Modes
from fmus.packaging.python.fmu import build_python_fmu
from fmus.rail.component import rail
from orchestrator.commands.systems.check import as_data
from orchestrator.errors import InputError
from orchestrator.figures.rail_check import write_mobility
from orchestrator.fmi.instance import open_fmu
from orchestrator.probing.rail import Signal, read_mapping
from orchestrator.probing.rail_check import RailReport, check_rail

EXAMPLE = Path(__file__).parents[3] / "examples" / "own_rail"
STEP = 2e-5
"""Four times the usual step: the rail by hand has no fast modes, and the tests take a fourth of the time."""

Variant = Callable[[str, list[tuple[str, str]]], Path]


def statuses(report: RailReport) -> dict[str, str]:
    return {check.name: check.status for check in report.checks}


def detail(report: RailReport, name: str) -> str:
    return next(check.detail for check in report.checks if check.name == name)


@pytest.fixture(scope="module")
def variant(tmp_path_factory: pytest.TempPathFactory) -> Variant:
    """Return a builder of the rail by hand with some of its text changed, under another name."""
    folder = tmp_path_factory.mktemp("variants")

    def build(name: str, changes: list[tuple[str, str]]) -> Path:
        text = (EXAMPLE / "own_rail.py").read_text(encoding="utf-8").replace("OwnRail", name)
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (folder / f"{name}_script.py").write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", f"{name}_script.py"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=60)
        return folder / f"{name}.fmu"

    return build


SLOW = pytest.mark.slow

MAPPING = [str(EXAMPLE / "own_rail.ssd")]


def test_the_shipped_rail_is_one(built: Path, tmp_path: Path) -> None:
    """All demands pass, none is left out; mobility and figure are there."""
    report = check_rail(built / "rail.fmu")
    assert set(statuses(report).values()) == {"pass"}
    assert not report.failed
    path = write_mobility(report, tmp_path / "new")
    assert path is not None
    assert path.name == "rail-mobility.png"
    data = as_data(report)
    assert data["passed"]
    assert len(data["mobility"]["ver"]["imag"]) == len(data["mobility"]["frequency_hz"])


@SLOW
def test_the_rigid_rail_is_one(built: Path, tmp_path: Path) -> None:
    """No motion at all is passive, linear and reciprocal; it can be drawn."""
    report = check_rail(built / "rail-rigid.fmu")
    assert not report.failed
    assert write_mobility(report, tmp_path) is not None


@SLOW
def test_a_rail_with_cross_terms_is_one(tmp_path: Path) -> None:
    modes = Modes(2 * np.pi * np.array([90.0, 600.0]), np.array([0.3, 0.2]), np.array([[0, 0.1, 0.05, 0], [0.05] * 4]))
    fmu = build_python_fmu(rail(modes), tmp_path / "rail.fmu", "0")
    report = check_rail(fmu)
    assert not report.failed
    assert "off its transpose" in detail(report, "reciprocity")


def test_a_rail_with_other_names_needs_a_mapping(variant: Variant) -> None:
    """Without one the names are missing; with that of the SSD it is a rail, which offers neither state nor y."""
    fmu = variant("PlainRail", [])
    report = check_rail(fmu)
    assert statuses(report) == {"names": "fail", "units": "not run", "causality": "not run", "running": "not run"}
    assert report.mobility is None
    assert write_mobility(report, fmu.parent) is None
    report = check_rail(fmu, MAPPING, STEP)
    found = statuses(report)
    assert found.pop("interface mobility") == found.pop("get and set state") == "not offered"
    assert set(found.values()) == {"pass"}
    assert detail(report, "units") == "8 converted"


def test_a_mapping_by_hand_is_that_of_the_ssd(variant: Variant) -> None:
    """Factors for signs and units, since the FMU tells no units: the mobility is 1 / (m s + c + k / s) in SI."""
    fmu = variant("HandRail", [])
    pairs = {"f": ("force", 1e3), "v": ("speed", 1e-3), "u": ("position", 1e-3)}
    axes = {"lon": ("X", 1), "lat": ("Y", -1), "ver": ("Z", -1), "spin": ("Yaw", -1)}
    texts = [
        f"{kind}_{d}={sign * (1 if d == 'spin' else factor)}*{word}{axis}"
        for kind, (word, factor) in pairs.items()
        for d, (axis, sign) in axes.items()
    ]
    report = check_rail(fmu, texts, STEP)
    assert not report.failed
    assert detail(report, "units") == "12 variables without a unit are taken as SI"
    assert report.mobility is not None
    f, Y = report.mobility.frequency_hz, report.mobility.values[:, 2, 2]
    s = report.mobility.shift + 2j * np.pi * f
    # 5e-3 to 1 kHz: aliasing and the midpoint rule take (omega step)^2 / 12, 1.3e-3
    np.testing.assert_allclose(Y[f < 1e3], (1 / (150.0 * s + 1e5 + 1.1e8 / s))[f < 1e3], rtol=5e-3)


FAULTS: dict[str, tuple[list[tuple[str, str]], str, str]] = {
    "GrowingRail": ([('"Z": (150.0, 1.0e5', '"Z": (150.0, -5.0e2')], "passivity", "active: after a pulse the ver"),
    "BrokenRail": ([("h = step_size", "h = step_size / 0")], "running", "doStep returned"),
    "OppositeRail": (
        [
            ("speed * metre", "speed * metre * (-1 if axis == 'Y' else 1)"),
            ("2 * middle - v) / metre", "2 * middle - v) / metre * (-1 if axis == 'Y' else 1)"),
        ],
        "displacement",
        "u_lat is",
    ),
    "HardRail": ([("f - k * u)", "f - k * u * (1 + 1e8 * u * u))")], "linearity", "off"),
    "EagerRail": ([("name + axis, 0.0)", 'name + axis, float(name == "speed"))')], "rest", "without force v_"),
    "StiffRail": ([("h = step_size", "h = 5e-6  # whatever step_size says")], "step sizes", "off"),
}
"""Changes of the rail by hand, the check that each fails, what is said."""


@pytest.mark.parametrize(
    "name", [name if name in ("GrowingRail", "BrokenRail") else pytest.param(name, marks=SLOW) for name in FAULTS]
)
def test_what_is_no_rail_is_found(variant: Variant, name: str) -> None:
    """One fault each in the rail by hand."""
    changes, check, said = FAULTS[name]
    report = check_rail(variant(name, changes), MAPPING, STEP)
    assert statuses(report)[check] == "fail"
    assert said in detail(report, check)


def test_an_active_rail_of_negative_mass_is_found(variant: Variant) -> None:
    """All three constants of the vertical oscillator negative: stable, and it gives what it should take."""
    report = check_rail(
        variant("NegativeRail", [('"Z": (150.0, 1.0e5, 1.1e8)', '"Z": (-150.0, -1.0e5, -1.1e8)')]), MAPPING
    )
    assert [check.name for check in report.failed] == ["passivity", "interface mobility"]
    assert detail(report, "passivity").startswith("active: the ver mobility at ")


def test_units_that_cannot_be_converted_are_said(built: Path) -> None:
    """A velocity where a displacement belongs: wrong unit, and the velocity's own place stays."""
    report = check_rail(built / "rail.fmu", ["u_lat=v_lat"])
    assert statuses(report)["units"] == "fail"
    assert "m/s cannot become m" in detail(report, "units")


def test_causality_is_compared(built: Path) -> None:
    report = check_rail(built / "rail.fmu", ["f_lat=v_lat", "v_lat=f_lat"])
    found = statuses(report)
    assert found["causality"] == "fail"
    assert "v_lat is output of type Real; must be input" in detail(report, "causality")


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["v_lat"], "mapping v_lat: must be NAME=VARIABLE"),
        (["v_up=x"], "the rail's contract has no 'v_up'"),
        (["v_lat=0*x"], "the factor is 0"),
        (["no.ssd"], "no.ssd: no such SSD file"),
    ],
)
def test_a_mapping_that_makes_no_sense_is_refused(built: Path, texts: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        check_rail(built / "rail.fmu", texts)


def test_factors_of_a_mapping(built: Path) -> None:
    found = read_mapping(["v_lat=-vy", "v_ver=1e-3*vz", "u_lat=-0.5*a.b[1]"], open_fmu(built / "rail.fmu"))
    assert found["v_lat"] == Signal("vy", -1.0)
    assert found["v_ver"] == Signal("vz", 1e-3)
    assert found["u_lat"] == Signal("a.b[1]", -0.5)
    assert found["u_ver"] == Signal("u_ver")


def test_a_step_that_makes_no_sense_is_refused(built: Path) -> None:
    with pytest.raises(InputError, match="step 1: must be from 1e-9 to 1e-2 s"):
        check_rail(built / "rail.fmu", step=1.0)
