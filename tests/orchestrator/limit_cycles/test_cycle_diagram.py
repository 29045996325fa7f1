"""Cycles against a parameter: births against the linear onset, folds, hysteresis, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from squeal_models import class158_case, fused_run, start_of, tone_of

from orchestrator.errors import InputError
from orchestrator.limit_cycles.bifurcations.diagram import Branch, follow
from orchestrator.limit_cycles.bifurcations.parameter import Parameter, find_parameter
from orchestrator.limit_cycles.catalogue import find_cycles
from orchestrator.limit_cycles.tracing import find_poles


def followed(case: int, tone: float, name: str, span: tuple[float, float], stability: bool = False) -> Branch:
    """Return the branch of a tone."""
    cycle = tone_of(case, tone).near(tone)
    return follow(cycle, find_parameter(cycle.balance.model, name), span, stability)


def onset(parameter: Parameter, pole_hz: float, low: float, high: float) -> float:
    """Return where the growth rate of a pole passes zero."""

    def growth(value: float) -> float:
        near = [p for p in find_poles(parameter.at(value)) if abs(p.frequency_hz / pole_hz - 1) < 5e-3]
        return max(near, key=lambda p: abs(p.motion[1]) / max(abs(p.motion))).growth_rate

    return float(brentq(growth, low, high, rtol=1e-8))


def test_a_branch_is_born_at_the_linear_onset_and_turns_back() -> None:
    """Case 1's 1100 Hz against friction: Hopf point to 1e-3, fold as with another number of harmonics, hysteresis."""
    branch = followed(1, 1100.0, "contact.mu0", (0.01, 0.6))
    (birth,), (fold,) = branch.of("Hopf"), branch.of("fold")
    assert birth == pytest.approx(onset(find_parameter(class158_case(1), "contact.mu0"), 1101.2, 0.02, 0.1), rel=1e-3)
    assert birth == pytest.approx(0.03353, rel=1e-3)  # small motion does not know of the cells of FASTSIM
    assert fold == pytest.approx(0.02275, rel=2e-3)  # H = 12 gives 0.02276
    assert branch.words == f"hysteresis: squeal starts above {birth:.4g} and stops below {fold:.4g}"
    assert branch.ends == ("is born there", "leaves the range")


@pytest.mark.slow
def test_constant_friction_makes_the_branch_vertical() -> None:
    """Case 3's 1100 Hz jumps to nearly its full amplitude where it is born, without hysteresis."""
    branch = followed(3, 1101.0, "contact.mu0", (0.01, 0.6))
    (birth,) = branch.of("Hopf")
    assert birth == pytest.approx(0.05589, rel=1e-3)
    steep = branch.amplitude < 0.15
    assert np.ptp(branch.value[steep]) < 1e-3 * birth
    assert branch.words.startswith("squeal starts at")


@pytest.mark.slow
def test_hysteresis_is_seen_in_the_time_domain_from_both_sides() -> None:
    """Case 1's 416 Hz at 80 times the damping: quiet is stable, and so is the tone; a threshold lies between."""
    branch = followed(1, 415.6, "wheel.damping_factor", (0.5, 120.0))
    (birth,), (fold,) = branch.of("Hopf"), branch.of("fold")
    linear = onset(find_parameter(class158_case(1), "wheel.damping_factor"), 416.0, 20, 90)
    assert birth == pytest.approx(linear, rel=1e-3)
    assert birth < 80 < fold
    amplitudes = [
        float(np.interp(80.0, *_rising(branch.value[part], branch.amplitude[part]))) for part in _sides(branch)
    ]
    threshold = min(amplitudes) / max(amplitudes)
    assert 0.6 < threshold < 0.85
    cycle = tone_of(1, 415.6).near(415.6)
    model = find_parameter(cycle.balance.model, "wheel.damping_factor").at(80.0)
    start = max(amplitudes) / cycle.amplitude
    ends = [
        float(np.std(fused_run(model, start_of(cycle.motion, start * part), 5e-6, 1.0)[-40000:, 0]))
        for part in (threshold + 0.1, threshold - 0.3)
    ]
    assert ends[0] == pytest.approx(max(amplitudes) / np.sqrt(2), rel=0.1)
    assert ends[1] < 0.3 * ends[0]


def _sides(branch: Branch) -> tuple[slice, slice]:
    turn = int(branch.value.argmax())
    return slice(0, turn + 1), slice(turn, None)


def _rising(value: np.ndarray, amplitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    order = np.argsort(value)
    return value[order], amplitude[order]


@pytest.mark.slow
def test_a_branch_stops_at_what_the_parameter_can_be() -> None:
    """Friction ends at 2, whatever is asked for; the last point is there."""
    branch = followed(1, 1100.0, "contact.mu0", (0.2, 5.0))
    assert branch.ends == ("leaves the range", "stops: the parameter cannot go beyond 2")
    assert branch.value[[0, -1]] == pytest.approx([0.2, 2.0])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "tone", "high", "kind", "between"),
    [(1, 415.6, 12.0, "Neimark-Sacker", (7.2, 8.0)), (2, 253.7, 8.0, "period doubling", (5.5, 6.5))],
)
def test_losses_of_stability_are_marked(
    case: int, tone: float, high: float, kind: str, between: tuple[float, float]
) -> None:
    """Against a factor on all damping; cycles found anew on both sides, 5 % off, last or not as the mark says."""
    name = "wheel.damping_factor"
    branch = followed(case, tone, name, (0.5, high), stability=True)
    (at,) = branch.of(kind)
    assert between[0] < at < between[1]
    assert {m.kind for m in branch.marks} == {kind}
    model = find_parameter(tone_of(case, tone).near(tone).balance.model, name)
    below, above = (find_cycles(model.at(f * at), tone_hz=tone).near(tone).stability for f in (0.95, 1.05))
    assert below is not None
    assert above is not None
    assert (below.kind, above.kind) == ("sidebands" if kind == "Neimark-Sacker" else kind, "stable")


def test_ranges_that_mean_nothing_are_refused() -> None:
    """No range, not about the system's own value, or of no parameter."""
    cycle = tone_of(1, 1100.0).near(1100.0)
    model = cycle.balance.model
    with pytest.raises(InputError, match="must be a range from a smaller to a larger number"):
        follow(cycle, find_parameter(model, "contact.mu0"), (0.6, 0.01))
    with pytest.raises(InputError, match="must contain the value of the system"):
        follow(cycle, find_parameter(model, "contact.mu0"), (0.01, 0.1))
    with pytest.raises(InputError, match="has no such number"):
        find_parameter(model, "contact.nothing")
    with pytest.raises(InputError, match="damping_ratio_001"):
        find_parameter(model, "wheel.damping_ratio_999")
