"""Rails that people bring, from end to end: `check`, `run --replace` and by SSD, against our rail of the same modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from modal_rails import FINITE_ELEMENTS, array_names, array_rail, c_rail, python_rail, system_with
from table_fmus import COMPILER

from fmus.modal.data import ModalData, read_modal_data
from fmus.modal.modes import Modes
from fmus.rail.component import DATA
from orchestrator.commands.structures.rail_files import write_rail
from orchestrator.errors import InputError
from orchestrator.probing.rail_check import check_rail
from orchestrator.results.file import open_results
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario

pytestmark = [pytest.mark.slow, pytest.mark.skipif(COMPILER is None, reason="no C compiler for the rails")]

DURATION = 0.02
"""The pulse of Case 1, 1 ms, and what follows; 4000 steps."""

CHECK_STEP = 2e-5
"""Four times the usual step, for a fourth of the time."""

TOLERANCE = 1e-9
"""Of the largest value: rounding of other formulas for the same exact step, 1e-13, through 4000 coupled steps."""


def dense(count: int) -> Modes:
    """Return modes from 40 Hz to 8 kHz of 5 % damping, in turn lateral and vertical, as finite elements have them."""
    shape = np.zeros((count, 4))
    shape[::2, 1] = shape[1::2, 2] = np.sqrt(1.6 / count)
    return Modes(2 * np.pi * 40.0 * 200.0 ** (np.arange(count) / count), np.full(count, 0.05), shape)


DEFAULT = read_modal_data(DATA / "rail.toml").modes


@dataclass(frozen=True)
class Brought:
    """A rail that somebody brings: its modes, how it is made, the names of its variables."""

    modes: Modes
    make: Callable[[Path, str, Modes], Path]
    names: dict[str, str] | None = None


RAILS = {
    "CRail": Brought(DEFAULT, c_rail),
    "PythonRail": Brought(DEFAULT, python_rail),
    "ArrayRail": Brought(DEFAULT, array_rail, array_names()),
    "DenseRail": Brought(dense(500), c_rail),
    "FiniteElementRail": Brought(DEFAULT, partial(c_rail, units=FINITE_ELEMENTS)),
}


def motion(scenario: Scenario, folder: Path) -> dict[str, np.ndarray]:
    """Return what wheel and rail do."""
    with open_results(run_scenario(scenario, folder, Report(picture=False)).results) as data:
        found = {f"wheel.{kind}": np.asarray(data[f"wheel.{kind}"]) for kind in ("v_lat", "v_ver", "u_lat", "u_ver")}
        return {**found, **{k: np.asarray(data[k]) for k in ("contact.rail_f_lat", "contact.rail_f_ver")}}


@pytest.fixture(scope="module")
def ours(native: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[Modes], dict[str, np.ndarray]]:
    """Return what our own rail of some modes does in Case 1."""
    folder = tmp_path_factory.mktemp("ours")
    known: dict[int, dict[str, np.ndarray]] = {}

    def of(modes: Modes) -> dict[str, np.ndarray]:
        if len(modes) not in known:
            rail = folder / f"own{len(modes)}.fmu"
            write_rail(ModalData("rail", "constructed", modes), rail, rail.stem)
            scenario = Scenario(str(native / "curvesqueal.ssp"), duration=DURATION, sources={"rail": rail})
            known[len(modes)] = motion(scenario, folder)
        return known[len(modes)]

    return of


def assert_equal(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, rtol=0, atol=TOLERANCE * np.abs(values).max(), err_msg=name)


@pytest.mark.parametrize("name", RAILS)
def test_a_rail_that_somebody_brings_is_ours(
    name: str, native: Path, tmp_path: Path, ours: Callable[[Modes], dict[str, np.ndarray]]
) -> None:
    brought = RAILS[name]
    rail = brought.make(tmp_path, name, brought.modes)
    ssd = system_with(tmp_path, native / "curvesqueal.ssp", rail, brought.names)
    mapping = [f"{name}={variable}" for name, variable in (brought.names or {}).items()]
    for texts in (mapping, [str(ssd)])[: 1 if brought.names is None else 2]:
        assert [f"{c.name}: {c.detail}" for c in check_rail(rail, texts, CHECK_STEP).failed] == []
    expected = ours(brought.modes)
    assert_equal(motion(Scenario(str(ssd), duration=DURATION), tmp_path), expected)
    swapped = Scenario(str(native / "curvesqueal.ssp"), duration=DURATION, sources={"rail": rail})
    if brought.names is None:
        assert_equal(motion(swapped, tmp_path), expected)
    else:
        with pytest.raises(InputError, match="rail"):
            motion(swapped, tmp_path)
