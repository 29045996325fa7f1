"""A rail from measurement: files read, active data refused, passive modes out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS
from fmus.modal.modes import Modes, mobility, receptance
from fmus.rail.measured import Measurement, measured_modes, read_csv, read_uff, require_passive

pyuff = pytest.importorskip("pyuff")

F = np.geomspace(25.0, 4000.0, 60)
TRUTH = Modes(
    omega=2 * np.pi * np.array([150.0, 200.0, 80.0, 600.0, 300.0]),
    zeta=np.array([0.4, 0.3, 0.5, 0.1, 0.6]),
    shape=np.array([[0.04, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.05, 0], [0, 0, 0.09, 0], [0, 0, 0, 0.4]]),
)
POWER = {"receptance": 0, "mobility": 1, "accelerance": 2}
NUMERATOR = {"receptance": 8, "mobility": 11, "accelerance": 12}
UFF_CODE = {"lon": 1, "lat": 2, "ver": 3, "spin": 6}


def _point(quantity: str, frequency_hz: NDArray[np.float64] = F) -> dict[str, NDArray[np.complex128]]:
    alpha = receptance(2 * np.pi * frequency_hz, TRUTH)
    factor = (2j * np.pi * frequency_hz) ** POWER[quantity]
    return {d: alpha[:, j, j] * factor for j, d in enumerate(DIRECTIONS)}


def _write_csv(path: Path, quantity: str) -> None:
    values = _point(quantity)
    lines = ["frequency_hz," + ",".join(f"{d}_real,{d}_imag" for d in values)]
    for i, f in enumerate(F.tolist()):
        parts = [repr(float(part)) for v in values.values() for part in (v[i].real, v[i].imag)]
        lines.append(",".join([repr(f), *parts]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write_uff(path: Path, quantity: str, f: NDArray[np.float64], ordinate: int | None = None) -> None:
    file = pyuff.UFF(str(path))
    functions = [(-UFF_CODE[d], -UFF_CODE[d], values) for d, values in _point(quantity, f).items()]
    cross = (2, 3, np.ones(f.size, dtype=complex))
    for response, reference, values in [*functions, cross]:
        file.write_sets(
            pyuff.prepare_58(
                func_type=4, rsp_node=7, rsp_dir=response, ref_node=7, ref_dir=reference, data=values, x=f, binary=0,
                rsp_ent_name="rail", ref_ent_name="rail", abscissa_spacing=0, abscissa_spec_data_type=18,
                ordinate_spec_data_type=NUMERATOR[quantity] if ordinate is None else ordinate,
                orddenom_spec_data_type=13,
            ),
            "add",
        )  # fmt: skip


@pytest.mark.parametrize("quantity", list(POWER))
def test_csv_holds_what_it_says(quantity: str, tmp_path: Path) -> None:
    """Receptance, mobility and accelerance of one rail are the same measurement."""
    path = tmp_path / "rail.csv"
    _write_csv(path, quantity)
    measurement = read_csv(path, quantity)
    for direction, expected in _point("receptance").items():
        # two complex powers
        np.testing.assert_allclose(measurement.receptance[direction], expected, rtol=1e-14)


@pytest.mark.parametrize("quantity", list(POWER))
def test_uff_holds_what_it_says(quantity: str, tmp_path: Path) -> None:
    """Written by pyuff as ASCII with 11 to 13 digits, cross functions left out, 0 Hz dropped."""
    path = tmp_path / "rail.uff"
    f = np.linspace(20.0, 2000.0, 100)
    _write_uff(path, quantity, f)
    measurement = read_uff(path, quantity)
    np.testing.assert_allclose(measurement.frequency_hz, f, rtol=1e-5)  # abscissae have 6 digits in the file
    for direction, expected in _point("receptance", f).items():
        # 1e-4: six digits in abscissae and values
        np.testing.assert_allclose(measurement.receptance[direction], expected, rtol=1e-4)


def test_a_spectrum_from_0_hz_begins_at_its_first_line(tmp_path: Path) -> None:
    path = tmp_path / "rail.uff"
    f = np.linspace(0.0, 2000.0, 101)
    _write_uff(path, "receptance", f)
    assert read_uff(path, "receptance").frequency_hz[0] == pytest.approx(20.0)


def test_uff_of_another_quantity_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rail.uff"
    _write_uff(path, "accelerance", np.linspace(20.0, 2000.0, 100))
    with pytest.raises(ValueError, match=r"rail.uff, data set 1: holds accelerance; must be mobility, as asked for"):
        read_uff(path, "mobility")
    _write_uff(tmp_path / "silent.uff", "accelerance", np.linspace(20.0, 2000.0, 100), ordinate=0)
    assert set(read_uff(tmp_path / "silent.uff", "accelerance").receptance) == set(DIRECTIONS)


def test_a_text_that_is_no_universal_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rail.uff"
    path.write_text("frequency_hz\n1\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"rail.uff: "):
        read_uff(path, "mobility")


def test_axes_can_be_mapped(tmp_path: Path) -> None:
    """A laboratory whose y is vertical and whose z is lateral."""
    path = tmp_path / "rail.uff"
    _write_uff(path, "receptance", np.linspace(20.0, 2000.0, 100))
    plain, mapped = read_uff(path, "receptance"), read_uff(path, "receptance", {2: "ver", 3: "lat"})
    assert set(mapped.receptance) == {"lat", "ver"}
    np.testing.assert_array_equal(mapped.receptance["ver"], plain.receptance["lat"])


def test_a_modal_measurement_is_found_again() -> None:
    """Data without noise: the fit stops at half the promised 0.5 dB and 3 degrees, in four directions."""
    modes, quality = measured_modes(Measurement(F, _point("receptance")))
    assert list(quality) == list(DIRECTIONS)
    for error in quality.values():
        assert error["rms_db"] <= 0.25
        assert error["rms_degrees"] <= 1.5
        assert error["active_degrees"] == 0.0
    assert (modes.zeta > 0).all()


def test_noisy_data_give_a_passive_rail_with_its_quality() -> None:
    """5 % of noise: what is left is the noise, 0.05 / sqrt(2) in each part, 0.3 dB and 2 degrees."""
    rng = np.random.default_rng(3)
    noise = 1 + 0.05 / np.sqrt(2) * (rng.standard_normal(F.size) + 1j * rng.standard_normal(F.size))
    data = {"ver": _point("receptance")["ver"] * noise}
    modes, quality = measured_modes(Measurement(F, data), most_modes=4, largest_active_degrees=10.0)
    assert list(quality) == ["ver"]
    # 1.3: the noise of 60 samples scatters
    assert quality["ver"]["rms_db"] < 1.3 * 0.31
    assert quality["ver"]["rms_degrees"] < 1.3 * 2.03
    Y = mobility(2 * np.pi * np.geomspace(0.1, 1e5, 500), modes)
    assert (Y[:, 2, 2].real > 0).all()
    assert not Y[:, 1, 1].any()


def test_active_data_are_refused_at_their_frequency() -> None:
    """A phase error that grows with frequency, as a time delay makes it, turns the mobility active."""
    data = {"ver": _point("receptance")["ver"] * np.exp(-1j * np.radians(40.0) * F / F[-1])}
    with pytest.raises(
        ValueError, match=r"ver mobility at \d+(\.\d+)? Hz has a phase of -\d+\.\d degrees; must be within"
    ):
        measured_modes(Measurement(F, data))
    phase = np.degrees(np.angle(1j * data["ver"]))
    worst = float(F[np.argmin(phase)])
    with pytest.raises(ValueError, match=f"at {worst:g} Hz"):
        require_passive(Measurement(F, data))


def test_a_sign_error_is_refused() -> None:
    """A force taken with the wrong sign."""
    with pytest.raises(ValueError, match=r"lat mobility at .* must be within \+-90"):
        require_passive(Measurement(F, {"lat": -_point("receptance")["lat"]}))


def test_faults_of_the_data_are_named() -> None:
    good = _point("receptance")["ver"]
    broken = good.copy()
    broken[4] = np.nan
    swapped = F.copy()
    swapped[[3, 4]] = swapped[[4, 3]]
    cases = [
        (F, {}, "no direction; must be at least one of lon, lat, ver, spin"),
        (F, {"z": good}, "direction 'z'; must be one of lon, lat, ver, spin"),
        (-F, {"ver": good}, "frequency 1 is -25 Hz; must be finite and > 0"),
        (swapped, {"ver": good}, r"Hz comes after .* Hz; frequencies must increase"),
        (F, {"ver": broken}, r"ver at .* Hz is \(?nan.*; must be finite and not 0"),
        (F, {"ver": good[:-1]}, "59 values in ver for 60 frequencies"),
    ]
    for f, data, message in cases:
        with pytest.raises(ValueError, match=message):
            Measurement(f, data)
    with pytest.raises(ValueError, match="10 frequencies; must be at least 20"):
        measured_modes(Measurement(F[:10], {"ver": good[:10]}))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("f,ver_real,ver_imag\n1,2,3\n", "rail.csv: column 'frequency_hz' is missing"),
        ("frequency_hz,ver_real\n1,2\n", "rail.csv: column 'ver_imag' is missing"),
        ("frequency_hz,ver_real,ver_imag\n1,2,x\n", "rail.csv, line 2: every value must be a number"),
        ("frequency_hz\n1\n", "rail.csv: measurement: no direction"),
    ],
)
def test_faults_of_a_csv_are_named(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "rail.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_csv(path, "mobility")


def test_an_unknown_quantity_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rail.csv"
    _write_csv(path, "mobility")
    with pytest.raises(ValueError, match="quantity is 'admittance'; must be one of receptance, mobility, accelerance"):
        read_csv(path, "admittance")
