"""CalculiX results: what a node must give, which part of a wheelset a file is, and broken files.

`data/sample.frd` (quarter model: half wheelset, half circle) and `data/sample360.frd` (half wheelset, full circle) are
results of CalculiX 2.20 of coarse meshes of the 840 mm wheelset, elements and most nodes left out; the CSV files beside
them say what the contact's node must give.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from fmus.measured.shapes.frd import read_frd
from fmus.measured.shapes.nodal import ContactModes, Extent, at_contact, complete_axes
from fmus.measured.units import read_system
from fmus.wheel.imported import ModalChoice, labelled, missing_parts, read_modes

DATA = Path(__file__).parent / "data"
AXES = {2: "lon", -3: "lat", -1: "ver"}
SI = read_system("m,N")
NODE = {"sample": 21, "sample360": 3}


def contact(name: str) -> ContactModes:
    modes = read_frd(DATA / f"{name}.frd", SI)
    return at_contact(modes, NODE[name], complete_axes(AXES, name))


def expected(name: str) -> dict[str, np.ndarray]:
    with (DATA / f"{name}-expected.csv").open() as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


@pytest.mark.parametrize(
    ("name", "extent"), [("sample", ("cosine", "symmetric")), ("sample360", ("whole", "symmetric"))]
)
def test_the_contact_node_gives_what_it_must(name: str, extent: tuple[str, str]) -> None:
    """Frequencies and shapes to the digits of the file; half the quarter model's, 1/sqrt 2 of the half model's."""
    found, wanted = contact(name), expected(name)
    assert found.extent == Extent(*extent)
    elastic = wanted["frequency_hz"] > 1
    np.testing.assert_allclose(found.frequency_hz[elastic], wanted["frequency_hz"][elastic], rtol=1e-8)
    assert not found.frequency_hz[~elastic].any()
    factor = {"sample": 0.5, "sample360": np.sqrt(0.5)}[name]
    moved = np.column_stack([wanted["frd_uy"], -wanted["frd_uz"], -wanted["frd_ux"]])
    np.testing.assert_allclose(found.shape[:, :3], factor * moved, rtol=1e-12, atol=0)
    if name == "sample":
        np.testing.assert_allclose(
            found.shape[:, :3], np.column_stack([wanted[d] for d in ("lon", "lat", "ver")]), rtol=1e-12
        )


def test_nodal_diameters_are_seen_on_the_circle_of_the_contact() -> None:
    found = contact("sample")
    assert found.diameters.tolist() == expected("sample")["n"].astype(int).tolist()
    labels = labelled(found)
    assert [labels[i] for i in (0, 4, 7, 12, 17)] == [
        "rigid n=1 symmetric cosine", "(2,0) symmetric cosine", "(3,0) symmetric cosine", "(4,0) symmetric cosine",
        "(5,0) symmetric cosine",
    ]  # fmt: skip
    assert labels[11] == "n=2 symmetric cosine #1"


def test_doublets_at_any_angle_are_kept_whole() -> None:
    """Both members of each doublet of the full circle; the sum of squares of a pair does not depend on its angle.

    So its lateral part is the square of the amplitude that the axisymmetric pair has; pairs move with one ratio of
    lateral to vertical motion, within the six digits of the file.
    """
    found = contact("sample360")
    f = found.frequency_hz
    pairs = [i for i in range(15) if f[i] > 0 and f[i + 1] - f[i] < 1e-8 * f[i]]
    assert pairs == [3, 6, 8, 10, 13]
    for i in pairs:
        first, second = found.shape[i, 1:3], found.shape[i + 1, 1:3]
        assert first[0] * second[1] == pytest.approx(first[1] * second[0], rel=1e-3)


def test_a_part_of_a_wheelset_is_refused_with_the_parts_that_are_missing() -> None:
    choice = ModalChoice(21, AXES, "m,N", (1e-3, 1e-2, 1e-4))
    with pytest.raises(ValueError, match=r"sample.frd: is a part of a wheelset; .*\(direction lon is missing\)"):
        read_modes(DATA / "sample.frd", choice)
    with pytest.raises(ValueError, match=r"give the other runs, too: motion across the axle held at mid-axle$"):
        read_modes(DATA / "sample360.frd", ModalChoice(3, AXES, "m,N", (1e-3,)))
    parts = [Extent(circle, axle) for circle in ("cosine", "sine") for axle in ("symmetric", "antisymmetric")]
    assert missing_parts(parts) == ""
    assert missing_parts([Extent()]) == ""
    assert missing_parts(parts[:3]).count("held") == 2


def test_units_of_the_deck_scale_the_shapes(tmp_path: Path) -> None:
    """In mm, N and s the unit of mass is a tonne: shapes are sqrt(1000) times smaller in SI, coordinates 1000 times."""
    one = read_frd(DATA / "sample.frd", SI)
    mm = read_frd(DATA / "sample.frd", read_system("mm,N"))
    np.testing.assert_allclose(mm.shape * np.sqrt(1000), one.shape, rtol=1e-12)
    np.testing.assert_allclose(1000 * mm.position[21], one.position[21], rtol=1e-12)
    with pytest.raises(ValueError, match=r"sample.frd: does not say its units; give them with the option units"):
        read_frd(DATA / "sample.frd", None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: lines[:-3], "ends within a block of displacements; the file is cut off"),
        (lambda lines: lines[:-1], "ends without the line 9999; the file is cut off"),
        (
            lambda lines: [x.replace("1PGM", "1PGM x") for x in lines],
            r"\d+: the generalised mass must be",
        ),
        (
            lambda lines: [x.replace("-1.27249E-02", "-1.27249Q-02") for x in lines],
            r"line \d+: must be a node and three",
        ),
        (lambda lines: [x.replace("MODAL", "     ") for x in lines], "holds no eigenmodes with displacements"),
        (lambda lines: [x[:-1] + "2" if "MODAL" in x else x for x in lines], r"line \d+: the block is binary"),
        (
            lambda lines: [x.replace("1.000000E+00", "0.000000E+00") for x in lines],
            r"frd, line \d+: modal mass is 0",
        ),
    ],
)
def test_broken_results_are_refused(change: object, message: str, tmp_path: Path) -> None:
    path = tmp_path / "sample.frd"
    lines = (DATA / "sample.frd").read_text().splitlines()
    path.write_text("\n".join(change(lines)) + "\n")  # type: ignore[operator]
    with pytest.raises(ValueError, match=message):
        read_frd(path, SI)


def test_axes_must_be_right_handed_and_complete() -> None:
    with pytest.raises(ValueError, match=r"axes lon = \+y, lat = \+z, ver = -x are left-handed; one sign is wrong"):
        complete_axes({2: "lon", 3: "lat", -1: "ver"}, "a.frd")
    with pytest.raises(ValueError, match=r"a.frd: mode shapes have signs, .*; lat is missing"):
        complete_axes({2: "lon", -1: "ver"}, "a.frd")
    nodal = read_frd(DATA / "sample.frd", SI)
    with pytest.raises(ValueError, match=r"sample.frd: node 5 is not in it; has 21 to 2020"):
        at_contact(nodal, 5, complete_axes(AXES, "sample.frd"))
    with pytest.raises(ValueError, match=r"sample.frd: has 58 nodes; say which is the contact"):
        at_contact(nodal, None, complete_axes(AXES, "sample.frd"))
