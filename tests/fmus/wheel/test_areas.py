"""Estimated radiating areas against those of the finite elements, and labels taken over from a known wheel."""

from __future__ import annotations

import re

import numpy as np
import pytest

from fmus.modal.modes import Modes
from fmus.wheel.areas import UNCERTAINTY_DB, estimated_wheelset, like
from fmus.wheel.class158 import class158
from fmus.wheel.wheelset import DATA, read_wheelset


@pytest.mark.parametrize("name", ["generic840", "straight840"])
def test_estimates_are_as_good_as_they_say(name: str) -> None:
    """Against the surface integrals of both webs below 5.2 kHz: all (n,0), and 85 of 100 others, as is said."""
    true = read_wheelset(DATA / f"{name}.toml")
    found = estimated_wheelset(true.modes, "estimate")
    other = []
    for i, label in enumerate(true.modes.labels):
        if label.startswith("rigid") or true.modes.omega[i] > 2 * np.pi * 5200 or not true.area_axial[i]:
            continue
        error = 10 * np.log10(found.area_axial[i] / true.area_axial[i])
        if re.match(r"\(\d,0\)", label):
            assert abs(error) < UNCERTAINTY_DB["(n,0)"], label
            assert found.nodal_diameters[i] == true.nodal_diameters[i]
        else:
            other.append(abs(error))
    assert np.percentile(other, 85) < UNCERTAINTY_DB["others"]


def test_the_area_of_a_doublet_is_that_of_both_members_and_grows_with_the_wheel() -> None:
    modes = Modes(
        np.array([2000.0, 2000.0]), np.full(2, 1e-4), np.array([[0, 0.1, 0, 0], [0, 0, 0, 0.5]]),
        ("(2,0) cosine", "(2,0) sine"),
    )  # fmt: skip
    small, large = estimated_wheelset(modes, "a"), estimated_wheelset(modes, "b", radius=0.84)
    assert small.area_axial[0] == small.area_axial[1] == pytest.approx(0.225 * 0.01, rel=1e-12)
    np.testing.assert_allclose(large.area_axial, 4 * small.area_axial, rtol=1e-12)


def test_labels_come_from_a_known_wheel() -> None:
    """Class158 with every frequency 1 % higher and no labels: those of the modes that squeal come back."""
    known = class158().modes
    bare = Modes(1.01 * known.omega, known.zeta, known.shape, ("?",) * len(known))
    found = like(bare, known)
    squeal = [i for i, label in enumerate(known.labels) if re.match(r"\([2-7],0\)", label)]
    assert [found.labels[i] for i in squeal] == [known.labels[i] for i in squeal]
    assert like(bare, known, within=1e-6).labels == bare.labels
