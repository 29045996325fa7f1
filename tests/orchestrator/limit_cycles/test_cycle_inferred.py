"""The inferred cases: the tones that last are the paper's."""

from __future__ import annotations

import pytest

from orchestrator import cycles
from orchestrator.published.cases import PAPER_HZ, SAME_TONE


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_the_papers_tone_lasts(number: int) -> None:
    """Within what counts as the same tone; on the rigid rail of Case 4, one of two that last."""
    wanted = PAPER_HZ[f"case{number}"]
    cycle = cycles(f"inferred{number}", tone_hz=wanted).near(wanted)
    assert cycle.stable
    assert abs(cycle.frequency_hz / wanted - 1) < SAME_TONE
