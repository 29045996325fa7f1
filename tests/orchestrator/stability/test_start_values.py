"""The FMUs as they are shipped: wired by hand with nothing set, they are Case 1."""

from __future__ import annotations

import numpy as np

from fmus.component import Component
from fmus.contact.linearised import linearise
from fmus.modal.modes import Modes
from fmus.modal.parameters import modes_of
from fmus.packaging.catalogue import components
from orchestrator.stability.cases import find_stability
from orchestrator.stability.poles import exact_poles


def starts(component: Component) -> dict[str, float]:
    return {v.name: v.start for v in component.variables if v.causality == "parameter" and v.start is not None}


def structure(component: Component) -> Modes:
    modes = modes_of(starts(component))
    assert modes is not None
    return modes


def test_nothing_set_gives_the_growth_rates_of_case_1() -> None:
    """Start values of wheel, rail and contact belong together: the contact's spring is that of the shipped wheel.

    All poles below 5 kHz, to the rounding of the eigenvalues of a matrix of some hundred rows.
    """
    shipped = components()
    found = exact_poles(structure(shipped["wheel"]), structure(shipped["rail"]), linearise(starts(shipped["contact"])))
    expected = find_stability("case1", rail="modal").poles
    assert expected is not None
    seen, wanted = found.below(5e3), expected.below(5e3)
    np.testing.assert_allclose(seen.frequency_hz, wanted.frequency_hz, rtol=1e-9)
    np.testing.assert_allclose(seen.growth_rate, wanted.growth_rate, atol=1e-6)
    assert (seen.growth_rate > 0).sum() == 8  # the unstable modes of Case 1 in Table 4
