"""The radiation model against closed forms and the numbers its source gives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic_results import generic, mode_number, vibrating

from fmus.modal.data import ModalData, write_modal_data
from orchestrator.errors import InputError
from orchestrator.sound.levels import sound_of
from orchestrator.sound.radiation import (
    LOUD,
    Radiation,
    axial_ratio,
    modal_spectra,
    power_per_velocity,
    radial_ratio,
    radiation_damping,
    sound_power,
)
from orchestrator.sound.wheelset import wheelset_of


def test_axial_motion_begins_to_radiate_at_the_published_frequencies() -> None:
    """The ratio is 1/2 at c kappa(n)/(2 pi r): 247 to 950 Hz for n = 0 to 6 and r = 0.42 m."""
    for n, corner in enumerate((247.0, 376.0, 501.0, 621.0, 735.0, 845.0, 950.0)):
        assert float(axial_ratio(corner, n, Radiation())) == pytest.approx(0.5, abs=0.01)


def test_a_table_of_modes_with_areas_sounds_as_the_wheel_that_it_is(tmp_path: Path) -> None:
    """Generic840 as modal data with its areas: the level of the wheelset file; without them, within what is said."""
    known, results, path = generic(), vibrating({"(3,0)": (1102.0, 1.0)}, duration=1.0), tmp_path / "own.toml"
    areas = np.column_stack([known.area_axial, known.area_radial])
    write_modal_data(path, ModalData("own", "made up", known.modes, areas))
    wanted = sound_of(results, "generic840").power_db
    assert sound_of(results, str(path)).power_db == pytest.approx(wanted, abs=1e-9)
    assert wheelset_of(results, str(path)).title == "own; areas as its file has them"
    write_modal_data(path, ModalData("own", "made up", known.modes))
    assert sound_of(results, str(path)).power_db == pytest.approx(wanted, abs=0.5)
    assert "areas estimated from labels, (n,0) within 0.5 dB" in wheelset_of(results, str(path)).title


@pytest.mark.parametrize("n", [0, 2, 5])
def test_slopes_are_those_of_multipoles(n: int) -> None:
    """Far below its corner axial motion rises by 2n + 4 powers of the frequency, radial motion by 2n + 2."""
    low = np.array([2.0, 4.0])
    axial, radial = axial_ratio(low, n, Radiation()), radial_ratio(low, n, Radiation())
    assert np.log2(axial[1] / axial[0]) == pytest.approx(2 * n + 4, abs=0.01)
    assert np.log2(radial[1] / radial[0]) == pytest.approx(2 * n + 2, abs=0.01)


@given(st.floats(1, 20_000), st.integers(0, 8), st.floats(0.5, 2), st.floats(0.1, 1))
def test_ratios_lie_between_0_and_1(frequency: float, n: int, factor: float, radius: float) -> None:
    how = Radiation(axial_factor=factor, radial_factor=factor, radius=radius)
    assert 0 <= axial_ratio(frequency, n, how) <= 1
    assert 0 <= radial_ratio(frequency, n, how) <= 1


def test_a_single_mode_radiates_what_the_formula_says() -> None:
    """W = rho c (sigma_a A_a + sigma_r A_r) q'^2 and p^2 = W rho c/(4 pi d^2), with q'^2 half the squared amplitude."""
    i, amplitude, wheelset, how = mode_number("(3,0)"), 1.3, generic(), Radiation(distance=5.0)
    sound = sound_of(vibrating({"(3,0)": (1102.0, amplitude)}), radiation=how)
    sigma_a, sigma_r = axial_ratio(1102.0, 3, how), radial_ratio(1102.0, 3, how)
    power = 1.2 * 343 * (sigma_a * wheelset.area_axial[i] + sigma_r * wheelset.area_radial[i]) * amplitude**2 / 2
    assert sound.power_db == pytest.approx(10 * np.log10(power / 1e-12), abs=0.01)
    level = 10 * np.log10(power * 1.2 * 343 / (4 * np.pi * 25) / 4e-10)
    assert float(sound.bands.sel(band=1000.0)) == pytest.approx(level, abs=0.01)
    assert sound.level_dba == pytest.approx(level + 0.3, abs=0.1)
    assert sound.narrow.attrs["units"] == "Pa^2"


@pytest.mark.parametrize(("label", "frequency", "dba"), [("(3,0)", 1102.0, 94.0), ("(4,0)", 1976.2, 95.0)])
def test_squeal_is_as_loud_as_estimated(label: str, frequency: float, dba: float) -> None:
    """0.135 m/s rms at the contact: about 122 dB of power, 94 or 95 dB(A) at 7.5 m, from another wheel mesh."""
    shape = abs(generic().modes.shape[mode_number(label), 1])
    sound = sound_of(vibrating({label: (frequency, 0.135 * np.sqrt(2) / shape)}))
    assert sound.power_db == pytest.approx(122.0, abs=1.0)
    assert sound.level_dba == pytest.approx(dba, abs=1.0)
    assert sound.low_dba <= sound.level_dba <= sound.high_dba


def test_modes_add_by_power() -> None:
    """Two modes at one frequency: the sum of what each radiates, whatever their phase."""
    both = {"(3,0)": (1500.0, 1.0), "(4,0)": (1500.0, -1.0)}
    powers = [
        float(sound_power(modal_spectra(vibrating(tones)), generic()).sum())
        for tones in (both, {"(3,0)": both["(3,0)"]}, {"(4,0)": both["(4,0)"]})
    ]
    assert powers[0] == pytest.approx(powers[1] + powers[2], rel=1e-6)


def test_sum_over_wave_numbers_equals_the_sum_over_modes() -> None:
    """Two routes to the same power."""
    spectra = modal_spectra(vibrating({"(2,0)": (418.0, 1.0), "(4,1)": (3900.0, 0.5)}))
    frequency = np.asarray(spectra["frequency"])
    modes = enumerate(np.asarray(spectra))
    one_by_one = sum(power_per_velocity(frequency, generic(), i, Radiation()) @ own for i, own in modes)
    assert float(sound_power(spectra, generic()).sum()) == pytest.approx(float(one_by_one), rel=1e-9)


def test_radiation_damping_is_radiated_power_over_energy() -> None:
    """A mode that only radiates loses 2 zeta omega q'^2, its energy being q'^2: zeta = rho c sigma A/(2 omega)."""
    how, i = Radiation(), mode_number("(3,0)")
    omega = generic().modes.omega[i]
    power = 1.2 * 343 * (
        axial_ratio(1102.0, 3, how) * generic().area_axial[i] + radial_ratio(1102.0, 3, how) * generic().area_radial[i]
    )  # fmt: skip
    assert radiation_damping(generic())[i] == pytest.approx(power / (2 * omega), rel=1e-12)


@given(st.floats(20, 20_000), st.floats(0.5, 3), st.floats(0.2, 2), st.integers(0, 100))
def test_no_mode_radiates_more_than_its_damping_takes(f: float, share: float, factor: float, mode: int) -> None:
    """Whatever the coefficients, at any frequency: 2 zeta omega q'^2 is all there is."""
    how = Radiation(radial_share=share, axial_factor=factor, radial_factor=factor)
    modes = generic().modes
    assert power_per_velocity(f, generic(), mode, how) <= 2 * modes.zeta[mode] * modes.omega[mode] * (1 + 1e-12)


def test_share_of_a_single_mode_is_its_radiation_damping() -> None:
    """(3,0) of the finite elements radiates 99 % of what it dissipates; with loud coefficients all, not more."""
    data = vibrating({"(3,0)": (1102.0, 1.0)})
    i = mode_number("(3,0)")
    share = radiation_damping(generic())[i] / generic().modes.zeta[i]
    assert sound_of(data).radiated_share == pytest.approx(share, abs=2e-3)
    assert 0.985 < share < 1
    loud = Radiation(**{k: v for k, v in LOUD.items() if not k.endswith("_db")})
    assert sound_of(data, radiation=loud).radiated_share == pytest.approx(1.0, abs=1e-6)


def test_the_wheel_has_the_damping_of_the_run() -> None:
    """Twice the damping of the wheel: half the share."""
    data = vibrating({"(3,0)": (1102.0, 1.0)})
    values = json.loads(data.attrs["all_parameters"])
    values["wheel"] |= {f"damping_ratio_{k + 1:03d}": 2 * z for k, z in enumerate(generic().modes.zeta)}
    damped = data.assign_attrs(all_parameters=json.dumps(values))
    ours, theirs = sound_of(data).radiated_share, sound_of(damped).radiated_share
    assert ours is not None
    assert theirs == pytest.approx(ours / 2, rel=1e-6)


def test_twice_the_distance_is_6_db_less() -> None:
    data = vibrating({"(3,0)": (1102.0, 1.0)})
    near, far = (sound_of(data, radiation=Radiation(distance=d)).level_dba for d in (7.5, 15.0))
    assert near - far == pytest.approx(6.0206, abs=1e-3)


def test_the_doubtful_coefficients_matter_less_where_the_ratio_is_one() -> None:
    """Without directivity and ground, 7.8 dB together, the band of 1102 Hz is narrow and that of 418 Hz is not."""
    high, low = (sound_of(vibrating({m: (f, 1.0)})) for m, f in (("(3,0)", 1102.0), ("(2,0)", 418.34)))
    assert high.high_dba - high.low_dba - 7.8 < 1.5
    assert low.high_dba - low.low_dba - 7.8 > 6.0


def test_silence_is_minus_infinity() -> None:
    assert sound_of(vibrating({})).level_dba == -np.inf


def test_wheel_is_recognised_or_named() -> None:
    data = vibrating({})
    assert "generic 840" in wheelset_of(data).title


def test_what_has_no_sound_is_refused() -> None:
    data = vibrating({}, 0.1)
    with pytest.raises(InputError, match=r"holds no modal velocities .* run again and record 'wheel.modal_velocity\*'"):
        wheelset_of(data.drop_vars(list(data.data_vars)))
    other = data.assign_attrs(all_parameters="{}")
    with pytest.raises(InputError, match="its wheel is none of generic840, straight840, class158"):
        wheelset_of(other)
    with pytest.raises(InputError, match="wheel nobody: neither generic840"):
        wheelset_of(data, "nobody")
    with pytest.raises(InputError, match=r"too short for lines 2 Hz apart; that needs 0\.5 s"):
        sound_of(data)
    with pytest.raises(InputError, match=r"distance = 0: must be > 0"):
        Radiation(distance=0.0)
