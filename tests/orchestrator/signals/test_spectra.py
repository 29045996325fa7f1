"""Spectra, bands and weighting against closed forms and the tabulated values of the standards."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.errors import InputError
from orchestrator.signals.spectra import (
    NOMINAL_HZ,
    a_weighted,
    a_weighting,
    band_edges,
    level,
    narrow_band,
    third_octaves,
    total,
)

# IEC 61672-1:2013, table 3, 10 Hz to 20 kHz; one decimal, at the exact midband frequencies
A_WEIGHTING_DB = (
    -70.4, -63.4, -56.7, -50.5, -44.7, -39.4, -34.6, -30.2, -26.2, -22.5, -19.1, -16.1, -13.4, -10.9, -8.6, -6.6, -4.8,
    -3.2, -1.9, -0.8, 0.0, 0.6, 1.0, 1.2, 1.3, 1.2, 1.0, 0.5, -0.1, -1.1, -2.5, -4.3, -6.6, -9.3,
)  # fmt: skip

# IEC 61260-1:2014, table E.1: exact midband frequencies of the base-10 system, five digits
MIDBAND_HZ = {
    25: 25.119, 31.5: 31.623, 40: 39.811, 50: 50.119, 63: 63.096, 80: 79.433, 100: 100.00, 125: 125.89, 160: 158.49,
    200: 199.53, 250: 251.19, 315: 316.23, 400: 398.11, 500: 501.19, 630: 630.96, 800: 794.33, 1000: 1000.0,
    1250: 1258.9, 1600: 1584.9, 2000: 1995.3, 2500: 2511.9, 3150: 3162.3, 4000: 3981.1, 5000: 5011.9, 6300: 6309.6,
    8000: 7943.3, 10000: 10000.0,
}  # fmt: skip


def signal(values: np.ndarray, rate: float = 20_000.0) -> xr.DataArray:
    time = np.arange(values.size) / rate
    return xr.DataArray(values, coords={"time": time}, dims="time", name="p", attrs={"units": "Pa"})


def tone(frequency: float, amplitude: float = 1.0, duration: float = 2.0, rate: float = 20_000.0) -> xr.DataArray:
    time = np.arange(round(duration * rate)) / rate
    return signal(amplitude * np.sin(2 * np.pi * frequency * time), rate)


def test_a_weighting_is_the_tabulated_one() -> None:
    """All 34 values of the standard, which are given to 0.1 dB."""
    middle, _, _ = band_edges()
    assert a_weighting(middle) == pytest.approx(A_WEIGHTING_DB, abs=0.051)


def test_midband_frequencies_are_the_tabulated_ones() -> None:
    middle = dict(zip(NOMINAL_HZ, band_edges()[0], strict=True))
    for nominal, exact in MIDBAND_HZ.items():
        assert middle[nominal] == pytest.approx(exact, rel=5e-5)


def test_bands_join_without_gaps() -> None:
    _, low, high = band_edges()
    assert low[1:] == pytest.approx(high[:-1], rel=1e-14)


@given(st.floats(60, 8000), st.floats(0.01, 100))
def test_the_lines_add_up_to_the_mean_square(frequency: float, amplitude: float) -> None:
    """A sine has half its squared amplitude, to 1e-3 for what a window sees of incomplete periods."""
    lines = narrow_band(tone(frequency, amplitude), 1.0)
    assert total(lines) == pytest.approx(amplitude**2 / 2, rel=1e-3)
    assert lines.attrs["units"] == "(Pa)^2"


def test_noise_keeps_its_power_in_bands() -> None:
    """White noise: each band has its share of the frequency axis; the bands add up to what they span."""
    noise = signal(np.random.default_rng(1).standard_normal(400_000))
    lines = narrow_band(noise, 2.0)
    bands = third_octaves(lines, 50.0)
    _, low, high = band_edges()
    wide = {n: (h - b) / 10_000 for n, b, h in zip(NOMINAL_HZ, low, high, strict=True)}
    for nominal, power in zip(bands["band"].to_numpy(), bands.to_numpy(), strict=True):
        if nominal >= 1000:
            assert power == pytest.approx(wide[nominal], rel=0.06)
    assert bands["band"].to_numpy()[[0, -1]].tolist() == [50.0, 8000.0]
    spanned = lines.sel(frequency=slice(low[7] + 1, high[29] - 1)).sum()
    assert total(bands) == pytest.approx(float(spanned), rel=2e-3)


@pytest.mark.parametrize(("frequency", "band"), [(1102.0, 1000.0), (1978.0, 2000.0), (1125.0, 1250.0)])
def test_a_tone_falls_into_its_band(frequency: float, band: float) -> None:
    """1102 Hz belongs to the band at 1 kHz, whose upper edge is 1122 Hz."""
    bands = third_octaves(narrow_band(tone(frequency)))
    assert float(bands.idxmax()) == band
    assert float(bands.sel(band=band)) == pytest.approx(0.5, rel=1e-3)


def test_level_of_one_pascal_is_94_db() -> None:
    """1 Pa rms re 20 uPa, 93.98 dB, and 1 dB less with the A-weighting of 500 Hz and so on."""
    lines = narrow_band(tone(500.0, np.sqrt(2)))
    assert float(level(lines.sum(), 2e-5)) == pytest.approx(93.979, abs=1e-3)
    weighted = level(a_weighted(lines).sum(), 2e-5)
    assert float(weighted) == pytest.approx(93.979 + float(a_weighting(500.0)), abs=1e-3)
    assert weighted.attrs["units"] == "dB"


def test_silence_is_minus_infinity() -> None:
    assert float(level(narrow_band(signal(np.zeros(40_000))).sum(), 2e-5)) == -np.inf


def test_too_short_a_signal_says_what_is_needed() -> None:
    with pytest.raises(
        InputError, match=r"p: lasts 0.5 s, too short for lines 1 Hz apart; that needs 1 s, or ask for 2 Hz"
    ):
        narrow_band(tone(100.0, duration=0.5), 1.0)


def test_lines_too_far_apart_for_a_band_say_what_is_needed() -> None:
    lines = narrow_band(tone(100.0), 8.0)
    with pytest.raises(InputError, match=r"50 Hz: is 11.6 Hz wide, .* at most 3.86 Hz apart \(a signal of 0.259 s\)"):
        third_octaves(lines, 50.0)
    assert third_octaves(lines, 125.0)["band"][0] == 125.0


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (lambda s: s.isel(time=[0, 1, 2, 4, 5]), "samples are .* apart; a spectrum needs equal steps"),
        (lambda s: s.isel(time=slice(2)), "has 2 samples; a spectrum needs at least 3"),
        (lambda s: s.rename(time="t"), "must have one dimension called time"),
    ],
)
def test_what_is_no_signal_is_refused(bad, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=message):
        narrow_band(bad(tone(100.0)), 100.0)


@pytest.mark.parametrize(("resolution", "message"), [(0.0, "must be > 0"), (5000.0, "too coarse .* at most 2500 Hz")])
def test_bad_resolution_is_refused(resolution: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        narrow_band(tone(100.0), resolution)
