"""Table 4 of the paper against the inferred cases: goals, poles, modes behind instabilities."""

from __future__ import annotations

import numpy as np
import pytest
from coupled import scheme_error

from fmus.cases import read_cases
from orchestrator.errors import InputError
from orchestrator.paper.table4 import Cell, Table4, compare, find_table4
from orchestrator.published.table4 import CASES
from orchestrator.stability.analysis import Stability
from orchestrator.stability.cases import find_rail, find_stability, find_wheel
from orchestrator.stability.loop import linear_contact

COUNTS = {1: 8, 2: 7, 3: 6, 4: 2}
"""Unstable frequencies in Table 4."""


@pytest.fixture(scope="module")
def cases() -> dict[int, Stability]:
    return {case: find_stability(f"inferred{case}") for case in CASES}


@pytest.fixture(scope="module")
def table(cases: dict[int, Stability]) -> Table4:
    return compare(cases)


def cell(table: Table4, case: int, mode: str) -> Cell:
    return next(c for c in table.cells if (c.case, c.mode) == (case, mode))


def test_every_cell_is_stable_or_unstable_as_published(table: Table4) -> None:
    assert [(c.case, c.mode) for c in table.cells if not c.agrees] == []
    assert table.extra == ()


def test_every_gain_is_within_10_per_cent(table: Table4) -> None:
    """Goals: rms of ln(gain/paper gain) at most 0.035, each within 10 %."""
    assert table.log_error <= 0.035
    for c in table.cells:
        if c.paper_gain is not None:
            assert c.gain == pytest.approx(c.paper_gain, rel=0.10), c


def test_frequencies_are_as_printed_though_not_fitted(table: Table4) -> None:
    """The fit asks for 2 % below 300 Hz and 0.5 % above, and for 263.1 Hz; what comes is far nearer."""
    pairs = [(c.frequency_hz, c.paper_frequency_hz) for c in table.cells if c.frequency_hz and c.paper_frequency_hz]
    assert len(pairs) == 23
    off = np.array([ours - theirs for ours, theirs in pairs])
    assert np.sqrt(np.mean(off**2)) < 0.7
    assert np.abs(off).max() < 2.5


@pytest.mark.parametrize("case", CASES)
def test_unstable_poles_are_as_many_as_published(cases: dict[int, Stability], case: int) -> None:
    """With the modal rail in the analytical one's place, below 4.5 kHz."""
    poles = cases[case].poles
    assert poles is not None
    assert poles.unstable().below(4500).frequency_hz.size == COUNTS[case] == len(cases[case].instabilities)


@pytest.mark.parametrize("case", CASES)
def test_the_tone_of_the_paper_grows_fastest(cases: dict[int, Stability], case: int) -> None:
    """1100 Hz with the rail, which nothing in the fit asks for; 1978 Hz without, which its limits do."""
    poles = cases[case].poles
    assert poles is not None
    fastest = poles.frequency_hz[poles.growth_rate.argmax()]
    assert fastest == pytest.approx(1100.0 if case in (1, 3) else 1978.0, rel=0.005)


@pytest.mark.parametrize(
    ("case", "mode", "behind"), [(3, "(6,0)", ("(4,1)", "(6,0)")), (4, "(4,0)", ("(2,r)", "(4,0)"))]
)
def test_two_modes_are_behind_what_the_paper_says(table: Table4, case: int, mode: str, behind: tuple[str, ...]) -> None:
    assert cell(table, case, mode).modes == behind


@pytest.mark.parametrize("mode", ["(1,0)", "(0,0)", "(2,0)", "(3,0)", "(4,0)"])
def test_one_mode_alone_is_behind_each_other_instability_of_case_3(table: Table4, mode: str) -> None:
    assert cell(table, 3, mode).modes == (mode,)


@pytest.mark.parametrize("case", CASES)
def test_the_master_steps_the_inferred_cases_exactly_enough(case: int) -> None:
    """At 5 us every growth rate below 5 kHz within 1 % or 0.05 1/s."""
    law = next(c.contact for c in read_cases() if c.name == f"inferred{case}")
    wheel, rail = find_wheel("inferred"), find_rail("modal" if case in (1, 3) else "rigid")
    assert wheel.modes is not None
    assert rail.modes is not None
    e = scheme_error(wheel.modes, rail.modes, linear_contact(law), 5e-6)
    assert (np.abs(e.error) <= np.maximum(0.05, 0.01 * np.abs(e.exact))).all()


def test_an_unknown_family_is_refused() -> None:
    with pytest.raises(InputError, match="cases guessed: must be printed or inferred"):
        find_table4(cases_of="guessed")


@pytest.mark.slow
def test_the_command_takes_the_family() -> None:
    table = find_table4(cases_of="inferred")
    assert table.right == 32
    assert table.log_error <= 0.035
