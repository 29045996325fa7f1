"""Equations that are not solved: how far they were and what was tried, and no number of a tone."""

from __future__ import annotations

import pytest
from squeal_models import class158_case, only, tone_of

from orchestrator.errors import InputError
from orchestrator.limit_cycles.balance import Truncation
from orchestrator.limit_cycles.catalogue import find_cycles
from orchestrator.limit_cycles.described import as_json
from orchestrator.limit_cycles.refinement import Lost, refine
from orchestrator.limit_cycles.tracing import Effort


@pytest.mark.parametrize(
    ("effort", "tried"),
    [
        (Effort(newton_steps=1, smallest=0.05), "with 6 harmonics and 1 Newton steps for a point none beyond is found"),
        (Effort(points=5), "followed over 5 points to 0.085 m/s, where the growth rate is 28 1/s; that are as many as"),
    ],
)
def test_a_curve_that_is_given_up_gives_no_tone(effort: Effort, tried: str) -> None:
    """Case 1's 1100 Hz with too few steps: the pole is unstable, so it must not be called quiet."""
    found = find_cycles(class158_case(1), tone_hz=1100.0, effort=effort)
    assert not found.cycles
    assert as_json("case1", found)["cycles"] == []
    words = found.quiet_words()
    assert words.startswith("no tone was found, which does not mean that there is none: pole at 1101.2 Hz (26.3 1/s)")
    assert tried in words
    with pytest.raises(InputError, match=r"within 2 % of 1100 Hz; no tone was found, .* its curve was followed"):
        found.near(1100.0)


def test_a_start_that_is_not_solved_is_told() -> None:
    """Without a Newton step there is no point at all."""
    found = find_cycles(class158_case(1), tone_hz=1100.0, effort=Effort(newton_steps=0))
    assert not found.cycles
    assert "not followed, its curve does not start: residual" in found.notes[0]
    assert "after 0 Newton steps at 0.004 m/s" in found.notes[0]


def test_a_cycle_that_other_harmonics_do_not_have_is_lost() -> None:
    """Two samples of a period cannot hold a tone: the truncations that were tried are named."""
    cycle = only(tone_of(1, 1100.0))
    lost = refine(cycle.balance, cycle.state, (Truncation(1, 2),))
    assert isinstance(lost, Lost)
    harmonics = cycle.balance.truncation.harmonics
    assert lost.words.startswith(
        f"the cycle at 1100.3 Hz, 0.215 m/s, was solved with {harmonics} harmonics; with 1 it "
    )
