"""FMUs of other tools with one peculiarity each: what must come out, worked out by hand."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import curvesqueal
from fmi3_fmu import write_ssd
from foreign_fmus import ANY_STEP, Rows, U, Y, foreign_fmu, variable
from table_fmus import COMPILER

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError, SimulationError
from orchestrator.fmi.instance import FmuInstance, open_fmu
from orchestrator.results.file import open_results
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario
from orchestrator.system.reader import read_system

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMUs")


def simulate(ssd: Path, how: Settings) -> tuple[Rows, dict[str, np.ndarray], Master]:
    """Run a system; return its rows, its signals and the master."""
    rows = Rows()
    with Master(assemble(read_system(ssd)), how) as master:
        master.run(rows)
        return rows, rows.columns(master.signals()), master


def test_aliases_keep_their_values(tmp_path: Path) -> None:
    """`a` and `b` share a value reference; `c` and `d` behind them, one connected, get their own."""
    outputs = "".join(variable(n, r, "output") for n, r in (("a", 0), ("b", 0), ("c", 1), ("d", 2)))
    step = "m->r[0]=1+m->t; m->r[1]=100+m->t; m->r[2]=1000+m->t"
    alias = foreign_fmu(
        tmp_path / "alias.fmu", outputs, step=step, init="m->r[0]=1;m->r[1]=100;m->r[2]=1000", depends=""
    )
    sink = foreign_fmu(tmp_path / "sink.fmu", U + Y, step="m->r[1]=m->r[0]", init="m->r[1]=m->r[0]", depends="1")
    ssd = write_ssd(tmp_path / "s.ssd", {"c": alias, "k": sink}, [("c.d", "k.u")])
    _, found, _ = simulate(ssd, Settings(0.1, 1.0, record_every=1))
    last = {name: values[-1] for name, values in found.items()}
    assert last == {"c.a": 2.0, "c.b": 2.0, "c.c": 101.0, "c.d": 1001.0, "k.y": 1001.0}
    _, late, _ = simulate(ssd, Settings(0.1, 1.0, "jacobi", record_every=1))
    np.testing.assert_array_equal(late["k.y"][1:], late["c.d"][:-1])


def test_two_names_of_an_input_cannot_be_fed_twice(tmp_path: Path) -> None:
    two = foreign_fmu(tmp_path / "two.fmu", U + variable("w", 0, "input", start=0) + Y, step="m->r[1]=m->r[0]")
    one = foreign_fmu(tmp_path / "one.fmu", Y + variable("z", 2, "output"), step="m->r[1]=m->t")
    parts = {"a": one, "b": two}
    bad = write_ssd(tmp_path / "bad.ssd", parts, [("a.y", "b.u"), ("a.z", "b.w")])
    with pytest.raises(InputError, match=r"inputs b\.u and b\.w are one variable \(value reference 0\), and two"):
        assemble(read_system(bad))
    same = write_ssd(tmp_path / "same.ssd", parts, [("a.y", "b.u"), ("a.y", "b.w")])
    _, found, _ = simulate(same, Settings(0.1, 0.5))
    assert found["b.y"][-1] == 0.5


@pytest.mark.parametrize("step", [0.1, 0.2])
def test_a_constant_step_is_any_constant_step(tmp_path: Path, step: float) -> None:
    """Without canHandleVariableCommunicationStepSize; the step of DefaultExperiment is no more than advice."""
    experiment = '<DefaultExperiment startTime="0" stopTime="1" stepSize="0.5"/>'
    fmu = foreign_fmu(tmp_path / "x.fmu", U + Y, step="m->r[1]+=h*(1+m->r[0])", attributes="", before=experiment)
    _, found, _ = simulate(write_ssd(tmp_path / "s.ssd", {"c": fmu}, []), Settings(step, 0.4))
    assert found["c.y"][-1] == pytest.approx(0.4, rel=1e-15)


def test_instances_that_share_their_statics_are_kept_apart(tmp_path: Path) -> None:
    """canBeInstantiatedOnlyOncePerProcess; also a second run in the same process begins anew."""
    flags = f'{ANY_STEP} canBeInstantiatedOnlyOncePerProcess="true"'
    fmu = foreign_fmu(tmp_path / "x.fmu", Y, step="static double S; S+=h; m->r[1]=S", attributes=flags)
    ssd = write_ssd(tmp_path / "s.ssd", {"a": fmu, "b": fmu}, [])
    for _ in range(2):
        _, found, master = simulate(ssd, Settings(0.125, 1.0))
        assert (found["a.y"][-1], found["b.y"][-1]) == (1.0, 1.0)
        assert any("a process can have one instance of this FMU only" in notice for notice in master.notices)


def test_a_look_beforehand_is_taken_in_a_process_of_its_own(tmp_path: Path) -> None:
    """An instance that probes steps the statics of its process; the run that comes after begins anew, in this one."""
    flags = f'{ANY_STEP} canBeInstantiatedOnlyOncePerProcess="true"'
    fmu = foreign_fmu(tmp_path / "x.fmu", Y, step="static double T; T+=h; m->r[1]=T", attributes=flags)
    probe = FmuInstance(open_fmu(fmu), "probe", scratch=True)
    try:
        probe.enter_initialization_mode(0.0, 1.0)
        probe.exit_initialization_mode()
        probe.do_step(0.0, 0.5)
        assert (probe.apart, probe.get_real(["y"])) == (True, [0.5])
    finally:
        probe.close()
    _, found, master = simulate(write_ssd(tmp_path / "s.ssd", {"a": fmu}, []), Settings(0.125, 1.0))
    assert (found["a.y"][-1], master.instances["a"].apart) == (1.0, False)


def mass_and_spring(folder: Path) -> Path:
    """Return a mass on a spring, two FMUs that declare no dependencies."""
    mass = foreign_fmu(
        folder / "mass.fmu",
        variable("f", 0, "input", start=0) + variable("x", 1, "output") + variable("v", 2, "output"),
        init="m->r[1]=1;m->r[2]=0",
        step="m->r[2]+=h*(m->r[0]-m->r[1]);m->r[1]+=h*m->r[2]",
    )
    spring = foreign_fmu(
        folder / "spring.fmu",
        variable("x", 0, "input", start=0) + variable("f", 1, "output"),
        init="m->r[1]=-99*m->r[0]",
        step="m->r[1]=-99*m->r[0]",
    )
    return write_ssd(folder / "s.ssd", {"m": mass, "k": spring}, [("m.x", "k.x"), ("k.f", "m.f")])


def test_silent_fmus_in_a_ring_step_one_after_the_other(tmp_path: Path) -> None:
    """The mass swings between -1 and 1 (5 % for the step); jacobi makes it grow, and both say what they do."""
    ssd = mass_and_spring(tmp_path)
    _, found, master = simulate(ssd, Settings(0.01, 10.0, record_every=1))
    assert np.abs(found["m.x"]).max() <= 1.05
    assert [n for n in master.notices if "do not declare" in n and '<Component stage="..."/>' in n]
    _, grown, late = simulate(ssd, Settings(0.01, 10.0, "jacobi"))
    assert np.abs(grown["m.x"]).max() > 10
    assert late.notices == [
        "jacobi gives every component the outputs of the step before, which can make a stable system grow"
    ]
    system = read_system(ssd)
    told = replace(system, elements={n: replace(e, stage=k) for k, (n, e) in enumerate(system.elements.items())})
    with Master(assemble(told), Settings(0.01, 10.0)) as quiet:
        assert not quiet.notices
        assert quiet.stages == [["m"], ["k"]]


def test_large_numbers_stay_exact(tmp_path: Path) -> None:
    """Integers in their type, doubles as doubles; CSV with the shortest decimals that are exact."""
    outputs = variable("n", 0, "output", "Integer") + Y + variable("b", 2, "output", "Boolean")
    fmu = foreign_fmu(
        tmp_path / "x.fmu", outputs, init="m->i[0]=16777217; m->r[1]=1e8; m->i[2]=1",
        step="m->i[0]=16777217+m->n; m->r[1]=1e8+0.25*m->n; m->i[2]=m->n%2",
    )  # fmt: skip
    ssd = write_ssd(tmp_path / "s.ssd", {"c": fmu}, [], stop=1.0)
    outcome = run_scenario(Scenario(str(ssd), step=0.1), tmp_path / "r", Report(csv=True, picture=False))
    with open_results(outcome.results) as data:
        assert [data[f"c.{name}"].dtype.name for name in "nyb"] == ["int32", "float64", "bool"]
        assert (int(data["c.n"][-1]), float(data["c.y"][-1])) == (16777227, 100000002.5)
    lines = outcome.results.with_suffix(".csv").read_text().splitlines()
    assert lines[0] == "time [s],c.y [],c.n [],c.b []" or lines[0] == "time [s],c.n [],c.y [],c.b []"
    assert sorted(lines[-1].split(",")) == sorted(["1.0", "16777227", "100000002.5", "false"])


@pytest.mark.parametrize(("step", "every", "times"), [(0.1, 4, [0.0, 0.4, 0.8, 1.0]), (1.0, 4, [0.0, 1.0])])
def test_first_and_last_row_are_always_there(tmp_path: Path, step: float, every: int, times: list[float]) -> None:
    """Also of a run of one step."""
    fmu = foreign_fmu(tmp_path / "x.fmu", Y, step="m->r[1]=m->t")
    ssd = write_ssd(tmp_path / "s.ssd", {"c": fmu}, [], stop=1.0)
    outcome = run_scenario(Scenario(str(ssd), step=step, record_every=every), tmp_path / "r", Report())
    assert outcome.error is None
    with open_results(outcome.results) as data:
        assert data["time"].to_numpy() == pytest.approx(times, rel=1e-15)
        np.testing.assert_array_equal(data["c.y"], data["time"])


def test_no_step_passes_the_stop_time(tmp_path: Path) -> None:
    """An FMU that refuses t + h > stopTime runs to the end; a duration that is no multiple of the step is shortened."""
    check = (
        'if(m->stopdef && t+h>m->stop){m->cb->logger(0,m->name,fmi2Error,"e","past the stop time");return fmi2Error;}'
    )
    for flags in (ANY_STEP, ""):
        fmu = foreign_fmu(tmp_path / "x.fmu", Y, step=f"{check} m->r[1]=m->t", attributes=flags)
        ssd = write_ssd(tmp_path / "s.ssd", {"c": fmu}, [])
        rows, _, master = simulate(ssd, Settings(1e-3, 0.7))
        assert (rows.times[-1], master.notices) == (0.7, [])
        rows, _, master = simulate(ssd, Settings(0.15, 1.0))
        assert rows.times[-1] == pytest.approx(0.9, rel=1e-15)
        assert master.notices == ["a duration of 1 s is no whole number of steps of 0.15 s: the run ends at 0.9 s"]


def test_messages_come_with_their_arguments(tmp_path: Path) -> None:
    step = 'm->cb->logger(0,m->name,fmi2Error,"e","file %s misses line %d","road.csv",42); return fmi2Error'
    ssd = write_ssd(tmp_path / "s.ssd", {"c": foreign_fmu(tmp_path / "x.fmu", Y, step=step)}, [])
    with pytest.raises(SimulationError, match=r"c: doStep returned error at t = 0 s: file road\.csv misses line 42$"):
        simulate(ssd, Settings(0.1, 1.0))


def test_what_an_fmu_prints_is_not_in_the_json(tmp_path: Path) -> None:
    fmu = foreign_fmu(
        tmp_path / "x.fmu", Y, step='m->r[1]=m->t; printf("hello\\n"); fflush(stdout)', create='puts("made")'
    )
    ssd = write_ssd(tmp_path / "s.ssd", {"c": fmu}, [], stop=1.0)
    done = curvesqueal("run", str(ssd), "--step", "0.1", "--json", "--out", str(tmp_path / "r"))
    assert json.loads(done.stdout)["completed"] is True
    assert "hello" in done.stderr


def test_an_algebraic_loop_has_one_way_out(tmp_path: Path) -> None:
    """Two FMUs without their states: staggered and iterative send to jacobi, which runs."""
    parts = {}
    for name, gain in (("p", 0.5), ("q", -0.5)):
        rule = f"m->r[1]=1+{gain}*m->r[0]"
        parts[name] = foreign_fmu(tmp_path / f"{name}.fmu", U + Y, step=rule, init=rule, depends="1")
    ssd = write_ssd(tmp_path / "s.ssd", parts, [("p.y", "q.u"), ("q.y", "p.u")])
    for algorithm in ("staggered", "iterative"):
        with pytest.raises(
            InputError, match=r"cannot get and set its state, so a step cannot be repeated.*use the algorithm jacobi$"
        ):
            simulate(ssd, Settings(0.1, 1.0, algorithm))
    _, found, _ = simulate(ssd, Settings(0.1, 5.0, "jacobi"))
    assert (found["p.y"][-1], found["q.y"][-1]) == pytest.approx((1.2, 0.4), rel=1e-9)


def test_instances_do_not_see_what_others_write_into_their_resources(tmp_path: Path) -> None:
    """Each reads the number in its file and writes one more; the next instance reads the first again."""
    create = (
        'char p[4096]; snprintf(p,4096,"%s/n.txt",strncmp(res,"file://",7)?res:res+7);'
        'FILE*f=fopen(p,"r"); fscanf(f,"%lf",&m->r[1]); fclose(f);'
        'f=fopen(p,"w"); fprintf(f,"%g",m->r[1]+1); fclose(f)'
    )
    fmu = foreign_fmu(tmp_path / "x.fmu", Y, create=create, more={"resources/n.txt": "3"})
    ssd = write_ssd(tmp_path / "s.ssd", {"a": fmu, "b": fmu}, [])
    for _ in range(2):
        _, found, _ = simulate(ssd, Settings(0.1, 0.2))
        assert (found["a.y"][-1], found["b.y"][-1]) == (3.0, 3.0)


def test_an_execution_tool_is_told_once(tmp_path: Path) -> None:
    flags = f'{ANY_STEP} needsExecutionTool="true"'
    fmu = foreign_fmu(tmp_path / "x.fmu", Y, step="m->r[1]=m->t", attributes=flags)
    _, _, master = simulate(write_ssd(tmp_path / "s.ssd", {"a": fmu, "b": fmu}, []), Settings(0.1, 0.2))
    assert master.notices == ["a (x.fmu) needs an execution tool on this machine: a tool that it does not name"]
