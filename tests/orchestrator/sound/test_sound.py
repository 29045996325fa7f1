"""The sound file: calibrated, without clicks, without tones that the run does not have."""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import soundfile
import xarray as xr
from synthetic_results import vibrating

from orchestrator.errors import InputError
from orchestrator.sound.levels import sound_of
from orchestrator.sound.wav import RATE_HZ, compressed, pressure_of, write_wav

TONE = 1102.0


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return vibrating({"(3,0)": (TONE, 1.3)})


@pytest.fixture(scope="module")
def written(run: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sound") / "run.wav"
    write_wav(pressure_of(run), path, "a test")
    return path


def test_level_of_the_file_is_that_of_the_radiation_model(run: xr.Dataset, written: Path) -> None:
    """Samples times full scale give the level of the model to 0.05 dB, the fade at the end left out."""
    samples, rate = soundfile.read(written)
    calibration = json.loads(written.with_suffix(".json").read_text())
    assert (rate, samples.size) == (RATE_HZ, 2 * RATE_HZ)
    pascal = samples[rate:-2000] * calibration["full_scale_pa"]
    level = 10 * np.log10(np.square(pascal).mean() / 4e-10)
    sound = sound_of(run)
    assert level == pytest.approx(calibration["level_db"], abs=0.05)
    assert level == pytest.approx(float(sound.bands.sel(band=1000.0)), abs=0.05)


def test_header_tells_the_full_scale(written: Path) -> None:
    calibration = json.loads(written.with_suffix(".json").read_text())
    with soundfile.SoundFile(written) as file:
        assert file.comment.startswith(f"full scale = {calibration['full_scale_pa']:.6g} Pa; level = ")
        assert "7.5 m" in file.title
        assert file.subtype == "PCM_24"


def test_no_clicks(written: Path) -> None:
    """Starts and ends in silence; no two samples are further apart than a sine of this tone can be."""
    samples, rate = soundfile.read(written)
    assert np.abs(samples[[0, -1]]).max() < 1e-4
    largest = np.abs(samples).max()
    assert np.abs(np.diff(samples)).max() < 1.02 * 2 * np.pi * TONE / rate * largest
    assert 0.9 < largest < 1.0


def test_no_aliasing(written: Path) -> None:
    """All but the tone is 80 dB below it, though 50 kHz becomes 48 kHz."""
    samples, rate = soundfile.read(written)
    middle = samples[rate // 2 : rate // 2 + rate] * np.blackman(rate)
    power = np.abs(np.fft.rfft(middle)) ** 2
    near = np.abs(np.fft.rfftfreq(rate, 1 / rate) - TONE) < 10
    assert 10 * np.log10(power[~near].max() / power[near].max()) < -80


def test_pitch_is_exact_at_any_recording_interval(run: xr.Dataset) -> None:
    """7 us steps, every fifth: no simple ratio to 48 kHz, and still the right tone."""
    time = 3.5e-5 * np.arange(40_000)
    odd = run.isel(time=slice(40_000)).assign_coords(time=time)
    values = np.sin(2 * np.pi * TONE * time)
    names = list(odd.data_vars)
    odd = odd.assign({names[k]: ("time", values if k == 20 else 0 * values) for k in range(len(names))})
    samples = pressure_of(odd).samples
    middle = samples[2000:-2000]
    found = np.fft.rfftfreq(1 << 20, 1 / RATE_HZ)[
        np.abs(np.fft.rfft(middle * np.hanning(middle.size), 1 << 20)).argmax()
    ]
    assert found == pytest.approx(TONE, abs=0.05)


def test_compressed_sound_is_the_same_tone(run: xr.Dataset) -> None:
    data = compressed(pressure_of(run), 1.0)
    assert len(data) < 40_000
    samples, rate = soundfile.read(BytesIO(data))
    assert np.fft.rfftfreq(samples.size, 1 / rate)[np.abs(np.fft.rfft(samples)).argmax()] == pytest.approx(TONE, abs=1)


def test_what_cannot_be_heard_is_refused(run: xr.Dataset) -> None:
    with pytest.raises(InputError, match="the wheel does not vibrate, so there is nothing to hear"):
        pressure_of(vibrating({}, 0.2))
    with pytest.raises(InputError, match=r"lasts 0.02 s; a sound needs at least 0.1 s"):
        pressure_of(run.isel(time=slice(1000)))
    with pytest.raises(
        InputError, match=r"recorded at 10000 Hz, too slow for modes up to 64\d\d Hz; .*record-every 15 "
    ):
        pressure_of(run.isel(time=slice(None, None, 5)))
