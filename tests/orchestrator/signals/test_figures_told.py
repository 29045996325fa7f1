"""The one list of the numbers of a run: all that the summary knows is told, under names of its own."""

from __future__ import annotations

from dataclasses import fields

from orchestrator.signals.figures_told import FIGURES, rows_by_direction
from orchestrator.signals.summary import Summary


def test_every_number_of_the_summary_is_told_once() -> None:
    numbers = {field.name: k + 0.5 for k, field in enumerate(fields(Summary))}
    summary = Summary(**numbers)  # type: ignore[arg-type]
    assert sorted(figure.value(summary) for figure in FIGURES) == sorted(numbers.values())  # type: ignore[type-var]
    assert len({figure.name for figure in FIGURES}) == len(FIGURES)


def test_track_and_contact_axes_share_a_row_and_what_is_not_known_is_said() -> None:
    summary = Summary(None, None, {"lat": 1.0}, {}, {"plane": 2.0}, {}, 0.25, None)
    assert rows_by_direction(summary)["wheel velocity, rms"] == ("m/s, rad/s", {"lat": 1.0, "plane": 2.0})
    words = {figure.name: figure.words(summary) for figure in FIGURES}
    assert (words["dominant_frequency_hz"], words["contact_lost"]) == ("none", "25.0% of the time")
    assert words["wheel_velocity_rms"] == "lat 1 m/s, rad/s"
