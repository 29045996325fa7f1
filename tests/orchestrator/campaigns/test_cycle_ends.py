"""Ends of runs among the cycles: what lasts, what breaks up, what is on no list."""

from __future__ import annotations

from squeal_models import tone_of

from orchestrator.campaigns.ends import end_words, missing_words


def test_an_end_is_the_cycle_only_at_its_level() -> None:
    """Case 1's 1100 Hz lasts; the step of a run makes it lower by 0.15 %."""
    found = tone_of(1, 1100.0)
    cycle = found.near(1100.0)
    rms = cycle.wheel_velocity_rms["lat"]
    assert end_words(found, 1100.37, 0.9985 * rms) == f"the cycle at {cycle.frequency_hz:.2f} Hz, which lasts"
    assert "its level is +30% off" in end_words(found, 1100.37, 1.3 * rms)
    assert end_words(found, 700.0, rms).startswith("no cycle of the list; the nearest are at 1100.")


def test_a_strongest_line_of_several_tones_is_no_tone() -> None:
    """Case 1's 272 Hz: the run at 0.212 m/s there is two tones at once, of which the cycle at 271.7 Hz tells."""
    words = end_words(tone_of(1, 272.0), 271.8, 0.212)
    assert words.startswith("no tone by itself: the cycle at 271.7")
    assert "breaks up through sidebands at " in words


def test_cycles_that_no_run_ended_in_are_named_with_their_growth() -> None:
    """Growth from rest is what there is to say of a basin."""
    found = tone_of(1, 1100.0)
    assert missing_words(found, [1100.4]) is None
    assert missing_words(found, [272.0]) == "last, too, but no run ended there: 1100.3 Hz (grows from rest by 26.3 1/s)"
