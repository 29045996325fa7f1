"""Numbers of a run against signals whose numbers are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.errors import InputError
from orchestrator.signals.summary import dominant_frequency, growth_rate, spectrum
from orchestrator.units import conversion


@given(st.floats(50, 4000), st.floats(0, 6.28))
def test_dominant_frequency_is_found_between_the_bins(frequency: float, phase: float) -> None:
    """A sine of any frequency over 0.5 s: to a thousandth of a bin, though bins are 2 Hz apart."""
    time = np.arange(25_000) * 2e-5
    found = dominant_frequency(np.sin(2 * np.pi * frequency * time + phase), 2e-5)
    assert found == pytest.approx(frequency, abs=2e-3)


def test_silence_has_no_dominant_frequency() -> None:
    assert dominant_frequency(np.zeros(100), 1e-4) is None


@pytest.mark.parametrize("rate", [5.0, 40.0])
def test_growth_rate_of_a_saturating_sine(rate: float) -> None:
    """exp(s t) up to 1, then constant: s is found to 2 %."""
    time = np.arange(150_000) * 2e-5
    envelope = np.minimum(1e-5 * np.exp(rate * time) if rate > 10 else 1e-3 * np.exp(rate * time), 1.0)
    assert growth_rate(envelope * np.sin(2 * np.pi * 1100 * time), 2e-5) == pytest.approx(rate, rel=0.02)


def test_what_decays_has_no_growth_rate() -> None:
    time = np.arange(50_000) * 2e-5
    assert growth_rate(np.exp(-10 * time) * np.sin(2 * np.pi * 300 * time), 2e-5) is None


def test_spectrum_keeps_the_power_of_noise() -> None:
    """Half the sum of squared amplitudes, less the window's noise bandwidth of 1.5 bins, is the mean square."""
    noise = np.random.default_rng(0).standard_normal(100_000)
    _, amplitude = spectrum(noise, 1e-4)
    assert (amplitude**2).sum() / 2 / 1.5 == pytest.approx(1.0, rel=0.02)


@pytest.mark.parametrize(
    ("given_unit", "wanted", "factor", "offset"),
    [("mm", "m", 1e-3, 0.0), ("kN", "N", 1e3, 0.0), ("degC", "K", 1.0, 273.15), (None, "N", 1.0, 0.0),
     ("kN.m", "N.m", 1e3, 0.0), ("kg^(-1/2)", "kg^(-1/2)", 1.0, 0.0)],
)  # fmt: skip
def test_units_are_converted(given_unit: str | None, wanted: str, factor: float, offset: float) -> None:
    assert conversion(given_unit, wanted, "x") == pytest.approx((factor, offset))


def test_units_of_another_kind_are_refused() -> None:
    with pytest.raises(InputError, match="x: the units do not match: N cannot become m/s"):
        conversion("N", "m/s", "x")
    with pytest.raises(InputError, match="x: cannot convert furlongs_per_moon to m/s"):
        conversion("furlongs_per_moon", "m/s", "x")
