"""CSV, archives and broken universal files: content decides, and a refusal says file, data set and line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import pyuff
from frf_files import MOBILITY, RECEPTANCE, F, write_csv, write_uff, write_variant
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.measured.choice import Choice
from fmus.measured.read import read_contents, read_measured
from fmus.measured.units import UnitSystem, read_ratio, read_system
from fmus.rail.measured import rail_from_files

HEAD = "frequency_hz,ver_real,ver_imag\n"


def test_units_in_the_header(tmp_path: Path) -> None:
    """In mm/s per N, decimal commas, kHz: the same function, and the header says which."""
    path = tmp_path / "m.txt"
    rows = zip((F / 1000).tolist(), (1000 * MOBILITY.real).tolist(), (1000 * MOBILITY.imag).tolist(), strict=True)
    lines = ["f [kHz];ver_real [mm/s/N];ver_imag [mm/s/N];ver_coherence;remark"]
    lines += [";".join([*(repr(x).replace(".", ",") for x in row), "0,95", "good"]) for row in rows]
    path.write_text("\n".join(lines), encoding="cp1252")
    (found,) = read_measured(path)
    assert (found.used["quantity"], found.used["factor"]) == ("mobility", 0.001)
    np.testing.assert_allclose(found.receptance, RECEPTANCE, rtol=1e-12)
    assert found.coherence is not None
    assert set(found.coherence) == {0.95}


def test_an_archive_holds_complex_arrays(tmp_path: Path) -> None:
    path = tmp_path / "m.npz"
    np.savez(
        path, frequency_hz=F, ver=MOBILITY, lat_ver=2 * MOBILITY, quantity="mobility", ver_coherence=np.ones(F.size)
    )
    point, cross = read_measured(path)
    np.testing.assert_allclose(point.receptance, RECEPTANCE, rtol=1e-12)
    np.testing.assert_allclose(cross.receptance, 2 * RECEPTANCE, rtol=1e-12)
    assert cross.words == "lat due to ver"
    np.savez(path, ver=MOBILITY)
    with pytest.raises(ValueError, match=r"m.npz: array 'frequency_hz' is missing; has ver"):
        read_measured(path)
    np.savez(path, frequency_hz=F, ver=MOBILITY.real)
    with pytest.raises(ValueError, match=r"m.npz: 'ver' is float64 .* must be complex"):
        read_measured(path)
    np.savez(path, frequency_hz=np.array([object()], dtype=object))
    with pytest.raises(ValueError, match=r"m.npz: not a NumPy archive of plain arrays"):
        read_measured(path)


def test_the_suffix_is_only_a_hint(tmp_path: Path) -> None:
    """A universal file called .csv and a table called .uff."""
    write_uff(tmp_path / "a.csv", [{}])
    write_csv(tmp_path / "b.uff", F, MOBILITY)
    for path, choice in ((tmp_path / "a.csv", Choice()), (tmp_path / "b.uff", Choice("mobility"))):
        np.testing.assert_allclose(read_measured(path, choice)[0].receptance, RECEPTANCE, rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "time,ver_real,ver_imag\n1,2,3\n",
            "m.csv, line 1: column 'frequency_hz' is missing; has time, ver_real",
        ),
        ("frequency_hz,ver_real\n1,2\n", "m.csv, line 1: column 'ver_imag' is missing"),
        (HEAD + "1,2,x\n", "m.csv, line 2: ver_imag must be a number; got 'x'"),
        (HEAD + "# a remark\n1,2\n", "m.csv, line 3: ver_imag must be a number; got nothing"),
        (HEAD + "2,1,1\n1,1,1\n", "m.csv, line 3: 1 Hz comes after 2 Hz; frequencies must increase"),
        (HEAD + "1,1,1\n2,nan,1\n", r"m.csv, line 3: ver at 2 Hz is \(nan.*; must be finite and not 0"),
        (HEAD + "-1,1,1\n", "m.csv, line 2: frequency 1 is -1 Hz; must be finite and > 0"),
        (HEAD, "m.csv: no frequency above 0 Hz"),
        ("frequency_hz\n1\n", "m.csv: holds no frequency response; holds frequency_hz"),
        ("frequency,ver_real,ver_imag\n1,2,3\n", "column 'frequency' has no unit; must be frequency_hz or frequency"),
        ("frequency_hz,ver_real [mm/s/N],ver_imag [m/s/N]\n1,2,3\n", "ver_real is in 'mm/s/N', ver_imag is not"),
        ("frequency_hz,ver_real [kg],ver_imag [kg]\n1,2,3\n", "unit 'kg' is no displacement, velocity or acceleration"),
        ("frequency_hz,ver_real [rad/(N*m)],ver_imag [rad/(N*m)]\n1,2,3\n", r"unit 'rad/\(N\*m\)' is not that of ver"),
        ("frequency_hz,frequency_hz\n1,1\n", "m.csv, line 1: two columns 'frequency_hz'; must be one"),
        ("frequency_hz,ver_real,ver_imag,ver_coherence\n1,1,1,2\n", "the coherence at 1 Hz is 2; must be 0 to 1"),
        ("", "m.csv: is empty"),
    ],
)
def test_faults_of_a_table_are_named(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "m.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_measured(path, Choice("receptance") if "[" not in text else None)


def test_a_universal_file_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    """Within a data set, and within its values with a new end."""
    path = write_variant(tmp_path, "uff-plain")
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:100]))
    with pytest.raises(ValueError, match=r"m.uff, data set 2 \(line 7\): has no -1 at its end; the file is cut off"):
        read_measured(path)
    path.write_text("".join([*lines[:100], "    -1\n"]))
    with pytest.raises(ValueError, match=r"m.uff, data set 2 \(line 7\): has 162 values; its header says 797"):
        read_measured(path)
    path.write_text("".join([*lines[:50], "x" * 80 + "\n", *lines[51:]]))
    with pytest.raises(ValueError, match=r"m.uff, data set 2 \(line 7\): is not a readable data set 58 \(function\)"):
        read_measured(path)


def test_the_header_of_a_universal_file_goes_with_what_is_made_of_it(tmp_path: Path) -> None:
    """Data set 151: model, description, program and date; without one, or with one that is broken, nothing is said."""
    path = write_uff(tmp_path / "m.uff", [{}])
    assert "origin" not in read_measured(path)[0].used
    words = {"model_name": "rail 7", "description": "NONE", "db_app": "a logger", "program": "a program"}
    header = {"type": 151, **words, "date_file_written": "01-Nov-25", "time_file_written": "10:00:00"}
    pyuff.UFF(str(path)).write_sets(header, "add")
    assert read_measured(path)[0].used["origin"] == "rail 7, a program, 01-Nov-25"
    data, _ = rail_from_files([path], Choice(), 2)
    assert data.source.endswith("the mobility in m.uff; rail 7, a program, 01-Nov-25 (fmus.rail.measured)")
    text = path.read_text()
    begin = text.index("   151")
    path.write_text(text[:begin] + "   151\n    -1\n")
    assert "origin" not in read_measured(path)[0].used


def test_other_things_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"none.uff: no such file"):
        read_contents(tmp_path / "none.uff")
    (tmp_path / "m.bin").write_bytes(bytes(range(256)))
    with pytest.raises(ValueError, match=r"m.bin: neither text nor one of the binary formats"):
        read_contents(tmp_path / "m.bin")
    real = write_uff(tmp_path / "real.uff", [{"data": np.abs(MOBILITY)}])
    with pytest.raises(ValueError, match="its values are real; a frequency response must be complex"):
        read_contents(real)
    pressure = write_uff(tmp_path / "p.uff", [{"ordinate_spec_data_type": 15}])
    with pytest.raises(ValueError, match="the numerator is of data type 15; must be 8, 11 or 12"):
        read_contents(pressure)


@settings(max_examples=50, deadline=None)
@given(st.floats(1e-3, 1e6), st.floats(1e-3, 1e6), *[st.sampled_from(["lon", "ver", "spin"])] * 2)
def test_a_system_of_units_scales_motion_and_force(length: float, force: float, response: str, reference: str) -> None:
    """Two routes: the whole, and motion and force by themselves."""
    units = UnitSystem(length, force, "made up")
    motion = 1 if response == "spin" else 1 / length
    load = 1 / force * (1 / length if reference == "spin" else 1)
    assert units.factor(response, reference) == pytest.approx(motion / load, rel=1e-12)


def test_units_as_text_and_as_a_system_agree() -> None:
    """1 mm = 0.001 m and 1 lbf = 4.448 N, both ways."""
    for text, system in (("mm/s/N", "mm,N"), ("in/s2/lbf", "in,lbf"), ("m/kN", "m,kN")):
        assert read_system(system).factor("ver", "ver") == pytest.approx(read_ratio(text).factor, rel=1e-9)
    with pytest.raises(ValueError, match="units 'mm,s': 's' is no force"):
        read_system("mm,s")
