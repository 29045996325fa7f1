"""The rail components and the files that their modes come from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.component import Instance
from fmus.interface import structure_inputs, structure_outputs
from fmus.modal.data import ModalData, format_modal_data, read_modal_data, write_modal_data
from fmus.modal.modes import Modes, mobility
from fmus.rail.component import DATA, SHIPPED, rail, rigid_rail, shipped_rail

STEP = 5e-6
GOOD = """title = "a rail"
source = "assumed"

[[mode]]
label = "first"
frequency_hz = 79.0
damping_ratio = 0.92
shape = { ver = 0.0621 }
"""


def _finite(lowest: float, largest: float) -> st.SearchStrategy[float]:
    return st.floats(lowest, largest, allow_nan=False, allow_infinity=False)


@st.composite
def modal_data(draw: st.DrawFn) -> ModalData:
    text = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
    shape = st.tuples(*[_finite(-1e6, 1e6)] * 4)
    rows = draw(st.lists(st.tuples(_finite(0, 1e5), _finite(0, 1e3), shape, text), min_size=1, max_size=5))
    modes = Modes(
        omega=2 * np.pi * np.array([row[0] for row in rows]),
        zeta=np.array([row[1] for row in rows]),
        shape=np.array([row[2] for row in rows]),
        labels=tuple(row[3] for row in rows),
    )
    return ModalData(draw(text.filter(str.strip)), draw(text.filter(str.strip)), modes)


@settings(max_examples=100, deadline=None)
@given(data=modal_data())
def test_modal_data_survives_a_file_exactly(data: ModalData, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Reading what was written gives every double back, and writing that again the same text."""
    path = tmp_path_factory.mktemp("modal") / "modes.toml"
    write_modal_data(path, data)
    back = read_modal_data(path)
    assert (back.title, back.source, back.modes.labels) == (data.title, data.source, data.modes.labels)
    np.testing.assert_array_equal(back.modes.omega, data.modes.omega)
    np.testing.assert_array_equal(back.modes.zeta, data.modes.zeta)
    np.testing.assert_array_equal(back.modes.shape, data.modes.shape)
    assert format_modal_data(back) == path.read_text(encoding="utf-8")


@given(omega=_finite(1e-3, 1e6))
def test_unreachable_angular_frequencies_move_by_one_rounding(omega: float) -> None:
    """2 pi f reaches not every double; the nearest one is within one unit in the last place."""
    one = Modes(np.array([omega]), np.zeros(1), np.ones((1, 4)))
    text = format_modal_data(ModalData("t", "s", one))
    line = next(row for row in text.splitlines() if row.startswith("frequency_hz"))
    assert abs(2 * np.pi * float(line.split("=")[1]) - omega) <= np.spacing(omega)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("79.0", "-79.0", r"modes.toml, mode 1 \(first\): frequency_hz must be a number from 0 to 1e\+06; got -79.0"),
        ("0.92", "nan", r"mode 1 \(first\): damping_ratio must be a number from 0 to 1000; got nan"),
        ("0.92", '"much"', r"damping_ratio must be a number from 0 to 1000; got 'much'"),
        ("0.92", "true", r"damping_ratio must be a number from 0 to 1000; got True"),
        ("damping_ratio = 0.92\n", "", r"damping_ratio must be a number from 0 to 1000; got nothing"),
        ("0.0621", "inf", r"shape ver must be a number from -1e\+06 to 1e\+06; got inf"),
        ("ver =", "vert =", r"mode 1 \(first\), shape: 'vert' is unknown; must be one of lat, lon, spin, ver"),
        ("{ ver = 0.0621 }", "0.0621", r"shape must be a table of directions; got 0.0621"),
        ("damping_ratio", "damping", r"mode 1 \(first\): 'damping' is unknown; must be one of area_axial, area"),
        ('"first"', "1", r"modes.toml, mode 1: label must be a text; got 1"),
        ('"assumed"', '""', r"modes.toml: source must be a text; got ''"),
        ('title = "a rail"\n', "", r"modes.toml: title must be a text; got nothing"),
        ("[[mode]]", "[mode]", r"modes.toml: \[\[mode\]\] must be given at least once; got {"),
        ("[[mode]]", "[[modes]]", r"modes.toml: 'modes' is unknown; must be one of mode, source, title"),
        ("[[mode]]", "[[mode", r"modes.toml: not a TOML file"),
    ],
)
def test_a_fault_in_a_file_is_named(old: str, new: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "modes.toml"
    path.write_text(GOOD, encoding="utf-8")
    assert len(read_modal_data(path).modes) == 1
    path.write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_modal_data(path)


def test_no_modes_are_no_modal_data() -> None:
    empty = Modes(np.zeros(0), np.zeros(0), np.zeros((0, 4)))
    with pytest.raises(ValueError, match="at least one mode; got 0"):
        format_modal_data(ModalData("nothing", "test", empty))


def test_the_rail_has_the_ports_of_the_contract() -> None:
    component = rail()
    assert [v.name for v in component.of("input")] == [p.name for p in structure_inputs()]
    assert [v.name for v in component.of("output")] == [p.name for p in structure_outputs()]


@pytest.mark.parametrize("name", SHIPPED)
def test_a_rail_starts_with_the_modes_of_its_file(name: str) -> None:
    start = {v.name: v.start for v in shipped_rail(name).of("parameter")}
    frequencies = np.array([start[n] for n in start if n.startswith("frequency")], dtype=float)
    # Hz to rad/s and back costs a rounding
    expected = read_modal_data(DATA / f"{name}.toml").modes.omega / (2 * np.pi)
    np.testing.assert_allclose(frequencies, expected, rtol=1e-14)


def test_the_rails_have_names_of_their_own() -> None:
    assert [r.name for r in (rail(), shipped_rail("rail-paper"), rigid_rail())] == ["rail", "rail_paper", "rail_rigid"]


def test_the_extra_mode_is_a_dashpot() -> None:
    """Far above its slow pole and below 20 kHz an over-damped mode has the mobility psi^2 / (2 zeta omega)."""
    modes = read_modal_data(DATA / "rail-paper.toml").modes
    extra = modes.keep([label == "ver extra" for label in modes.labels])
    real_part = float(mobility(2 * np.pi * np.array([5e3]), extra)[0, 2, 2].real)
    # 2 %: its stiffness term is (20/5) / (2 zeta) = 1/12 of the damping term here, and enters squared
    assert real_part == pytest.approx(extra.shape[0, 2] ** 2 / (2 * extra.zeta[0] * extra.omega[0]), rel=2e-2)


def test_the_rigid_rail_does_not_move() -> None:
    """Zero velocity, displacement and mobility whatever the force."""
    instance = Instance(rigid_rail())
    instance.initialise()
    assert set(instance.calculated.values()) == {0.0}
    instance.inputs[:] = (1e3, -2e4, 5e4, 7.0)
    for _ in range(3):
        instance.do_step(STEP)
    assert not instance.outputs.any()


def test_the_rigid_rail_has_the_ports_of_the_rail() -> None:
    """Everything but the modal parameters is the same."""
    kinds = ("input", "output", "calculatedParameter")
    assert all(
        [(v.name, v.unit) for v in rigid_rail().of(c)] == [(v.name, v.unit) for v in rail().of(c)] for c in kinds
    )
