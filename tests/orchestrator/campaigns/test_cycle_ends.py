"""Ends of runs among the cycles: what lasts, what breaks up, what is on no list."""

from __future__ import annotations

import pytest
from plans import plan_of
from squeal_models import tone_of

from orchestrator.campaigns.computed.ended import ended_in
from orchestrator.campaigns.ends import NOT_LISTED, Ends, missing_words
from orchestrator.campaigns.prepared import Prepared, Workshop, prepare
from orchestrator.campaigns.rows import DONE
from orchestrator.campaigns.stages import run_point
from orchestrator.campaigns.sweep import checked


def test_an_end_is_the_cycle_only_at_its_level() -> None:
    """Case 1's 1100 Hz lasts; the step of a run makes it lower by 0.15 %."""
    found = tone_of(1, 1100.0)
    cycle = found.near(1100.0)
    rms = cycle.wheel_velocity_rms["lat"]
    ends = Ends(found)
    assert ends.words(1100.37, 0.9985 * rms) == f"the cycle at {cycle.frequency_hz:.2f} Hz, which lasts"
    assert "its level is +30% off" in ends.words(1100.37, 1.3 * rms)
    assert ends.words(700.0, rms).startswith("no cycle of the list; the nearest are at 1100.")
    assert ends.label(1100.37, 0.9985 * rms) == f"cycle {cycle.frequency_hz:.2f} Hz"
    assert ends.label(1100.37, 1.3 * rms) == ends.label(700.0, rms) == NOT_LISTED


@pytest.mark.slow
def test_a_strongest_line_of_several_tones_is_no_tone() -> None:
    """Case 1's 272 Hz: the run at 0.212 m/s there is two tones at once, into which the cycle at 271.7 Hz breaks up."""
    ends = Ends(tone_of(1, 272.0))
    words = ends.words(271.8, 0.2121)
    assert words.startswith("no tone by itself: two tones at once, 271.80 + 146.80 Hz: the cycle at 271.7")
    assert words.endswith(" into 272 + 147 + 419 Hz")
    assert ends.label(271.8, 0.2121) == "tones 271.80 + 146.80 Hz"
    assert ends.label(271.8, 0.19) == NOT_LISTED
    assert ends.words(271.8, 0.19).startswith("no tone by itself: the cycle at 271.7")


def test_the_end_of_a_simulated_point_is_in_its_row() -> None:
    """Case 1 from its mode at 1100 Hz: 0.6 s end in that cycle; another seed would know the list already."""
    plan = plan_of(
        "start_hz = [1100.0]", compute='stage = "time"\nsound = false', system='case = "case1"\nduration = 0.8'
    )
    campaign, _, where = checked(plan)
    workshop = Workshop()
    row = run_point(campaign, workshop, 0, where[0])
    assert row.status == DONE, row.message
    assert row.values["ended_in"] == f"cycle {tone_of(1, 1100.0).near(1100.0).frequency_hz:.2f} Hz"
    (ends,) = workshop.ends.values()
    assert ends is not None
    prepared = Prepared(prepare(campaign, workshop, where[0]), campaign.settings, workshop)
    assert ended_in(prepared, 1100.3, 0.5, None) == "not settled"
    assert ended_in(prepared, 274.0, 0.35, irregular=True) == "irregular"
    assert ended_in(prepared, None, 0.0, None) == "at rest"
    assert ended_in(prepared, 700.0, 0.1, irregular=False) == NOT_LISTED


def test_cycles_that_no_run_ended_in_are_named_with_their_growth() -> None:
    """Growth from rest is what there is to say of a basin."""
    found = tone_of(1, 1100.0)
    assert missing_words(found, [1100.4]) is None
    assert missing_words(found, [272.0]) == "last, too, but no run ended there: 1100.3 Hz (grows from rest by 26.3 1/s)"
