"""What was computed before a fault or an early end is in the results, the last step included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fmi3_fmu import write_ssd
from foreign_fmus import Rows, U, Y, foreign_fmu, variable
from table_fmus import COMPILER

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import SimulationError
from orchestrator.system.reader import read_system

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMUs")

FAULTS = {
    "error": ("return fmi2Error", "b: doStep returned error at t = 0.6 s"),
    "nan": ('m->r[1]=strtod("nan",0)', "b: output y = nan at t = 0.6 s: not a finite number"),
    "end": ("return fmi2Discard", "b ended the simulation at t = 0.6 s"),
}
"""What the second component does in its seventh step, and what is said."""


def rows_until(folder: Path, fault: str, record: tuple[str, ...]) -> tuple[Rows, dict[str, np.ndarray], str]:
    """Run a counter that feeds a component that fails; return rows, columns and what was said."""
    body, _ = FAULTS[fault]
    inner = variable("x", 2, "local") + variable("j", 0, "local", "Integer")
    count = "m->r[1]=m->n; m->r[2]=10*m->n; m->i[0]=100*m->n"
    a = foreign_fmu(folder / "a.fmu", Y + inner, step=count, depends="")
    b = foreign_fmu(folder / "b.fmu", U + Y, step=f"m->r[1]=m->r[0]; if(m->n==7){{{body};}}", depends="1", ends=True)
    rows, said = Rows(), ""
    system = read_system(write_ssd(folder / "s.ssd", {"a": a, "b": b}, [("a.y", "b.u")]))
    with Master(assemble(system), Settings(0.1, 1.0, record_every=4, record=record)) as master:
        try:
            said = master.run(rows).ended or ""
        except SimulationError as error:
            said = str(error)
        return rows, rows.columns(master.signals()), said


@pytest.mark.parametrize("fault", FAULTS)
def test_the_last_step_before_a_fault_is_kept(tmp_path: Path, fault: str) -> None:
    """Step 6 of a run that records every fourth; a local double of that moment is not known any more."""
    rows, found, said = rows_until(tmp_path, fault, ("a.x",))
    assert said.startswith(FAULTS[fault][1])
    np.testing.assert_allclose(rows.times, [0.0, 0.4, 0.6], rtol=1e-15)
    assert found["a.y"].tolist() == found["b.y"].tolist() == [0.0, 4.0, 6.0]
    assert found["a.x"].tolist()[:2] == [0.0, 40.0]
    assert np.isnan(found["a.x"][2])


def test_whole_numbers_of_that_step_are_kept_too(tmp_path: Path) -> None:
    """They cannot be marked as unknown, so they are fetched at every step, and the doubles with them."""
    rows, found, _ = rows_until(tmp_path, "error", ("a.*",))
    np.testing.assert_allclose(rows.times, [0.0, 0.4, 0.6], rtol=1e-15)
    assert (found["a.x"].tolist(), found["a.j"].tolist()) == ([0.0, 40.0, 60.0], [0, 400, 600])


def test_without_local_variables_nothing_is_missing(tmp_path: Path) -> None:
    rows, found, _ = rows_until(tmp_path, "error", ())
    assert found["b.y"].tolist() == [0.0, 4.0, 6.0]
    assert len(rows.times) == 3
