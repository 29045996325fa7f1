"""Nastran results: printed and binary files hold what CalculiX' file of one wheel holds; broken ones are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from nastran_files import Model, write_f06, write_op2

from fmus.measured.shapes.frd import read_frd
from fmus.measured.shapes.nastran_text import number
from fmus.measured.shapes.nodal import at_contact, complete_axes
from fmus.measured.shapes.read import is_shapes, read_shapes
from fmus.measured.units import read_system
from fmus.wheel.imported import ModalChoice, read_modes

SAMPLE = Path(__file__).parent / "data" / "sample.frd"
AXES = {2: "lon", -3: "lat", -1: "ver"}
NODE = 21


@pytest.fixture(scope="module")
def model() -> Model:
    """Return the first eight modes of the quarter model, with a modal mass of 4 kg and not normalised to it."""
    nodal = read_frd(SAMPLE, read_system("m,N"))
    return Model(nodal.frequency_hz[:8], np.full(8, 4.0), nodal.nodes, 2.0 * nodal.shape[:8], nodal.position)


WRITERS: dict[str, Callable[[Path, Model], Path]] = {
    "m.f06": write_f06,
    "m.op2": write_op2,
    "big-endian.op2": lambda path, model: write_op2(path, model, ">"),
    "long-words.op2": lambda path, model: write_op2(path, model, "<", 8),
}


@pytest.mark.parametrize("name", list(WRITERS))
def test_one_wheel_in_the_files_of_two_programs(name: str, model: Model, tmp_path: Path) -> None:
    """Frequencies, shapes, extent, nodal diameters; seven digits or single precision."""
    path = WRITERS[name](tmp_path / name, model)
    head = path.read_bytes()[:4096]
    assert is_shapes(head)
    axes = complete_axes(AXES, name)
    found = at_contact(read_shapes(path, head, "m,N"), NODE, axes)
    wanted = at_contact(read_frd(SAMPLE, read_system("m,N")), NODE, axes)
    np.testing.assert_allclose(found.frequency_hz, wanted.frequency_hz[:8], rtol=1e-6)
    np.testing.assert_allclose(found.shape, wanted.shape[:8], rtol=1e-6)
    assert (found.extent, found.spin_from) == (wanted.extent, wanted.spin_from)
    assert found.diameters.tolist() == wanted.diameters[:8].tolist()


def test_rotations_of_shells_are_taken(model: Model, tmp_path: Path) -> None:
    """A model whose points rotate has its spin from there, in the deck's units: rad per mm becomes rad per m."""
    rotation = np.full((8, model.nodes.size, 3), 0.01)
    shells = model.but(shape=np.concatenate([model.shape, rotation], axis=2))
    axes = complete_axes(AXES, "m")
    for path in (write_f06(tmp_path / "m.f06", shells), write_op2(tmp_path / "m.op2", shells)):
        nodal = read_shapes(path, path.read_bytes()[:4096], "mm,N")
        found = at_contact(nodal, NODE, axes)
        assert found.spin_from == "rotations"
        tonnes = 4.0 * 1000.0  # 4 t, the mass unit of mm, N and s
        np.testing.assert_allclose(found.shape[:, 3], -1000.0 * 0.01 / np.sqrt(tonnes) * found.extent.factor, rtol=1e-6)


def test_a_whole_wheel_comes_from_nastran(model: Model, tmp_path: Path) -> None:
    """A point moves and its wheel is imported by content, whatever the file is called; damping must be said."""
    rotation = np.full((8, 1, 3), 0.01)
    one = np.full((8, 1, 3), 0.02)
    shape = np.concatenate([one, rotation], axis=2)
    whole = model.but(nodes=np.array([NODE]), shape=shape, position={NODE: np.zeros(3)})
    path = write_op2(tmp_path / "wheel.dat", whole)
    modes = read_modes(path, ModalChoice(None, AXES, "m,N", (1e-4,))).modes
    np.testing.assert_allclose(modes.shape[1], [0.01, -0.01, -0.01, -0.005], rtol=1e-6)
    with pytest.raises(ValueError, match=r"wheel.dat: has no damping; give it with the option damping"):
        read_modes(path, ModalChoice(None, AXES, "m,N"))
    with pytest.raises(ValueError, match=r"wheel.dat: does not say its units; give them with the option units"):
        read_modes(path, ModalChoice(None, AXES))


def turned(model: Model) -> Model:
    return model.but(output_system=3)


def unstable(model: Model) -> Model:
    return model.but(frequency_hz=np.append(-50.0, model.frequency_hz[1:]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (turned, "node 21 has coordinates in system 0 and motion in system 3; must be the basic system"),
        (unstable, "mode 1: eigenvalue is -98696; must be >= 0"),
        (lambda model: model.but(mass=np.zeros(8)), "mode 1: modal mass is 0; must be > 0"),
    ],
)
def test_models_that_cannot_be_a_wheel_are_refused(
    change: Callable[[Model], Model], message: str, model: Model, tmp_path: Path
) -> None:
    for path in (write_f06(tmp_path / "m.f06", change(model)), write_op2(tmp_path / "m.op2", change(model))):
        with pytest.raises(ValueError, match=rf"^{path.name}[:,] {message}"):
            read_shapes(path, path.read_bytes()[:4096], "m,N")


@pytest.mark.parametrize(
    ("there", "other", "message"),
    [
        ("END OF JOB", "END", "m.f06: does not end with END OF JOB; the file is cut off"),
        ("R E A L   E I G E N V E C", "C O M P L E X", "m.f06: holds no real eigenvectors"),
        ("R E A L   E I G E N V A L", "C O M P L E X", "m.f06: holds no table of real eigenvalues"),
        ("N O .          2", "N O .         99", "m.f06: mode 99 has a shape and no eigenvalue"),
        ("4.000000E+00", "************", r"m.f06, line \d+: must be mode, order, eigenvalue"),
        ("N O .          2", "N O .          1", r"m.f06, line \d+: point 21 of mode 1 is there twice"),
        ("      G  ", "      G  x", r"m.f06, line \d+: must be a point, G and three or six numbers"),
        ("GRID*                 21", "GRID*                 2x", r"m.f06, line \d+: must be a GRID entry; got"),
        ("GRID*                 21", "SPOINT                21", r"m.f06: has no coordinates \(GRID\) of node 21; ask"),
    ],
)
def test_broken_printed_results_are_refused(there: str, other: str, message: str, model: Model, tmp_path: Path) -> None:
    path = write_f06(tmp_path / "m.f06", model)
    text = path.read_text()
    assert there in text
    path.write_text(text.replace(there, other))
    with pytest.raises(ValueError, match=message):
        read_shapes(path, text.encode()[:4096], "m,N")


def test_broken_binary_results_are_refused(model: Model, tmp_path: Path) -> None:
    """Every cut is seen; tables that are not there are named."""
    path = write_op2(tmp_path / "m.op2", model)
    data = path.read_bytes()
    for cut in range(200, len(data), len(data) // 37):
        path.write_bytes(data[:cut])
        with pytest.raises(ValueError, match=r"m.op2: (ends within|holds no)"):
            read_shapes(path, data[:4096], "m,N")
    for tables, words in (
        ("LAMA OUGV1", r"m.op2: has no coordinates \(GRID\) of node 21; write GEOM1"),
        ("GEOM1 OUGV1", r"m.op2: holds no table of real eigenvalues with generalised masses"),
        ("GEOM1 LAMA", r"m.op2: holds no real eigenvectors"),
    ):
        write_op2(path, model, tables=tables)
        with pytest.raises(ValueError, match=words):
            read_shapes(path, data[:4096], "m,N")


@pytest.mark.parametrize(("text", "value"), [("1.5-3", 1.5e-3), ("7.", 7.0), ("-.5+2", -50.0), ("2.5D+02", 250.0)])
def test_numbers_as_nastran_writes_them(text: str, value: float) -> None:
    assert number(text) == value


@pytest.mark.parametrize("text", ["", ".", "1", "x", "1.5E"])
def test_what_is_no_number_of_nastran(text: str) -> None:
    with pytest.raises(ValueError, match="is no number"):
        number(text)
