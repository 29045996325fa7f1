"""What is recorded besides the outputs, and what it must add up to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus.interface import DIRECTIONS
from fmus.modal.parameters import modal_velocities
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.results.file import Column, ResultsFile, open_results
from orchestrator.system.model import System
from orchestrator.system.reader import read_system


@pytest.fixture(scope="module")
def case1(built: Path) -> System:
    return read_system(built / "curvesqueal.ssp")


def record(system: System, path: Path, **how: object) -> Master:
    """Run a system into a results file."""
    settings = Settings(5e-6, 1e-3, **how)  # type: ignore[arg-type]
    with Master(assemble(system), settings) as master:
        with ResultsFile(path, master.signals(), {"case": "test"}) as results:
            master.run(results)
        return master


def test_modal_velocities_add_up_to_the_velocity_of_the_contact_point(case1: System, tmp_path: Path) -> None:
    """V = sum of shape times modal velocity, in every direction and row, to rounding."""
    master = record(case1, tmp_path / "r.nc", record_every=3)
    wheel = master.parameters["wheel"]
    with open_results(tmp_path / "r.nc") as data:
        names = modal_velocities("wheel", data.data_vars)
        assert len(names) == 122
        assert data[names[0]].attrs["units"] == "kg^(1/2).m/s"
        assert np.allclose(data["time"], [*(1.5e-5 * np.arange(67)), 1e-3], rtol=1e-12)  # every third, and the last
        modal = np.stack([data[name].to_numpy() for name in names]).astype(float)
        for d in DIRECTIONS:
            default = master.assembly.fmus["wheel"].variables
            shape = [float(wheel.get(v, default[v].start)) for v in sorted(default) if v.startswith(f"shape_{d}_")]
            velocity = data[f"wheel.v_{d}"].to_numpy()
            scale = np.abs(np.array(shape)[:, None] * modal).sum(axis=0).max()
            assert np.array(shape) @ modal == pytest.approx(velocity, abs=1e-12 * scale)


def test_outputs_do_not_depend_on_what_is_recorded_besides(case1: System, tmp_path: Path) -> None:
    """The same run with and without further columns: the same numbers to the last bit, energies included."""
    record(case1, tmp_path / "all.nc", record_every=7)
    record(case1, tmp_path / "none.nc", record_every=7, record=())
    with open_results(tmp_path / "all.nc") as more, open_results(tmp_path / "none.nc") as plain:
        assert modal_velocities("wheel", plain.data_vars) == []
        for name in plain.data_vars:
            assert np.array_equal(more[name], plain[name]), name


@pytest.mark.parametrize("size", [10, 8_000, 20_000, 200_000])
@pytest.mark.parametrize("count", [1, 39, 161])
def test_rows_stand_where_the_header_says(tmp_path: Path, size: int, count: int) -> None:
    """Headers of any size: with many signals or long attributes the library leaves the file longer than the header."""
    signals = [Column(f"c.signal_{i:03d}", "m/s", "a signal") for i in range(count)]
    rows = np.arange(3.0 * count).reshape(3, count)
    with ResultsFile(tmp_path / "r.nc", signals, {"title": "Kurvenquietschen, 2°", "long": "x" * size}) as file:
        file.append(np.array([0.1, 0.2, 0.3]), rows)
    with open_results(tmp_path / "r.nc") as data:
        assert data["time"].to_numpy() == pytest.approx([0.1, 0.2, 0.3], abs=0)
        assert np.array_equal(np.stack([data[n] for n in data.data_vars], axis=1), rows)


def test_patterns_choose(case1: System, tmp_path: Path) -> None:
    """Two components at once, each with its own references."""
    record(case1, tmp_path / "r.nc", record=("rail.modal_velocity_*", "wheel.modal_velocity_01?"))
    with open_results(tmp_path / "r.nc") as data:
        assert len(modal_velocities("wheel", data.data_vars)) == 10
        rail = np.stack([data[name].to_numpy() for name in modal_velocities("rail", data.data_vars)])
        assert np.abs(rail).max() > 0


def test_pattern_without_a_match_is_refused(case1: System) -> None:
    with pytest.raises(
        InputError, match=r"record wheel\.velocity_\*: matches no output and no local variable that is a number"
    ):
        Master(assemble(case1), Settings(5e-6, 1e-3, record=("wheel.velocity_*",)))
