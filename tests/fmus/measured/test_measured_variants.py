"""Twenty ways to store one point function: each is read as what it is, or refused with what it holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from frf_files import MM_N, PLAIN, RECEPTANCE, SI, noisy, write_uff, write_variant

from fmus.measured.choice import Choice, read_axes
from fmus.measured.read import read_measured

SAME = {
    "csv-plain": Choice("mobility"),
    "csv-bom": Choice("mobility"),
    "csv-semicolon": Choice("mobility"),
    "csv-dc": Choice("mobility"),
    "uff-plain": Choice(),
    "uff-binary": Choice(),
    "uff-ufb-suffix": Choice(),
    "uff-y-up": Choice(axes={2: "ver"}),
    "uff-signs-opposite": Choice(),
    "uff-units-mm": Choice(),
    "uff-units-mm-mn": Choice(),
    "uff-label-mm": Choice(),
    "uff-label-g": Choice(),
    "uff-with-coherence": Choice(),
    "uff-coherence-first": Choice(),
}
"""What has to be said about each file that holds the function."""

REFUSED = {
    "uff-two-nodes": r"m.uff: driving points at nodes 7 \(data set 2 \(line 7\)\), 9 \(data set 3 .*; choose one",
    "uff-only-coherence": r"m.uff: holds no frequency response; holds .*data set 2 \(line 7\): coherence at 7:\+z",
    "uff-time-history": r"m.uff: holds no frequency response; holds .*data set 2 \(line 7\): time response",
    "uff-denominator": r"m.uff, data set 2 \(line 7\): the denominator is no force but m/s2",
}


@pytest.mark.parametrize("name", list(SAME))
def test_the_same_function_comes_out(name: str, tmp_path: Path) -> None:
    (found,) = read_measured(write_variant(tmp_path, name), SAME[name])
    assert (found.response, found.reference) == ("ver", "ver")
    # 1e-9: text has 11 to 17 digits, and two complex powers
    np.testing.assert_allclose(found.receptance, RECEPTANCE, rtol=1e-9)
    assert (found.coherence is not None) == ("coherence" in name)


@pytest.mark.parametrize("name", list(REFUSED))
def test_what_holds_no_such_function_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=REFUSED[name]):
        read_measured(write_variant(tmp_path, name))


def test_noisy_data_are_read_as_they_are(tmp_path: Path) -> None:
    """What is good of them is the fit's business."""
    f, accelerance = noisy()
    (found,) = read_measured(write_variant(tmp_path, "csv-noise"), Choice("accelerance"))
    np.testing.assert_allclose(-((2 * np.pi * f) ** 2) * found.receptance, accelerance, rtol=1e-12)


def test_a_node_can_be_chosen(tmp_path: Path) -> None:
    path = write_variant(tmp_path, "uff-two-nodes")
    (found,) = read_measured(path, Choice(node=9))
    np.testing.assert_allclose(found.receptance, 1.01 * RECEPTANCE, rtol=1e-9)
    with pytest.raises(ValueError, match=r"m.uff: no driving point at node 8; has 7 \(data set 2 \(line 7\)\), 9"):
        read_measured(path, Choice(node=8))


def test_what_was_used_is_said(tmp_path: Path) -> None:
    (found,) = read_measured(write_variant(tmp_path, "uff-units-mm"), Choice(start_hz=100, stop_hz=1000))
    assert found.used == {
        "set": "m.uff, data set 2 (line 7)", "point": "7:+z due to 7:+z", "direction": "ver", "quantity": "mobility",
        "units": "0.001 m per 1 N, data set 164 (line 1); the axis label '(m/s)/(N)' says otherwise",
        "factor": 0.001, "sign": 1.0, "from_hz": 100.0, "to_hz": 1000.0,
    }  # fmt: skip
    assert found.frequency_hz.size == 181


@pytest.mark.parametrize(
    ("name", "choice", "message"),
    [
        ("uff-plain", Choice("accelerance"), "holds mobility; the option quantity says accelerance"),
        ("uff-label-mm", Choice(units="m/s/N"), "the option units, m/s/N, is 1 in SI; axis label .* says 0.001"),
        ("uff-units-mm", Choice(units="m,N"), "the option units, m,N, is 1 in SI; data set 164 .* says 0.001"),
        ("uff-plain", Choice(units="m/N"), "holds mobility; the option units says receptance"),
        ("csv-plain", Choice(), "m.csv: does not say whether it is a receptance, mobility or accelerance"),
        ("uff-plain", Choice(start_hz=5000), r"has 20 to 4000 Hz; no line lies in the band asked for"),
        ("uff-plain", Choice(axes={1: "ver"}), r"in the axes asked for; holds .*frequency response at 7:\+z due to"),
    ],
)
def test_a_contradiction_is_refused(name: str, choice: Choice, message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        read_measured(write_variant(tmp_path, name), choice)


def test_a_file_without_units_needs_them(tmp_path: Path) -> None:
    """Neither data set 164 nor labels: the user says them, as a ratio or as length and force."""
    bare = {"ordinate_axis_units_lab": "NONE", "orddenom_axis_units_lab": "NONE"}
    path = write_uff(tmp_path / "m.uff", [{**bare, "data": 1000 * PLAIN["data"]}], None)
    with pytest.raises(ValueError, match=r"data set 1 \(line 1\): does not say its units; give them"):
        read_measured(path)
    for units in ("mm/s/N", "mm,N"):
        (found,) = read_measured(path, Choice(units=units))
        np.testing.assert_allclose(found.receptance, RECEPTANCE, rtol=1e-9)


def test_an_unknown_denominator_is_no_force(tmp_path: Path) -> None:
    bare = {"ordinate_axis_units_lab": "", "orddenom_axis_units_lab": "", "orddenom_spec_data_type": 0}
    path = write_uff(tmp_path / "m.uff", [bare], SI)
    with pytest.raises(ValueError, match="does not say that its denominator is a force"):
        read_measured(path)
    assert read_measured(path, Choice(units="m/s/N"))


def test_units_that_contradict_themselves_are_refused(tmp_path: Path) -> None:
    """Code 1 is SI; its factors are 1."""
    path = write_uff(tmp_path / "m.uff", [{}], {**MM_N, "units_code": 1})
    with pytest.raises(
        ValueError, match=r"units code 1 means 1 per metre and 1 per newton, the factors are 1000 and 1"
    ):
        read_measured(path)


def test_an_own_sign_turns_a_cross_function(tmp_path: Path) -> None:
    """A file whose z points downwards: lateral motion due to a vertical force changes its sign, a point does not."""
    cross = {"rsp_dir": 2}
    plain = write_uff(tmp_path / "a.uff", [{}, cross])
    for axes, sign in (("3=ver", 1), ("-3=ver", -1)):
        point, other = read_measured(plain, Choice(axes=read_axes(["2=lat", axes])))
        assert (point.words, other.words) == ("ver", "lat due to ver")
        np.testing.assert_allclose(point.receptance, RECEPTANCE, rtol=1e-9)
        np.testing.assert_allclose(other.receptance, sign * RECEPTANCE, rtol=1e-9)


@pytest.mark.parametrize("text", ["9=lat", "3=up", "lat", "0=lon", "3=spin", "4=lat"])
def test_bad_axes_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=f"axis {text}: "):
        read_axes([text])
