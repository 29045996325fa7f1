"""Names of modal parameters: both spellings mean the same, and what is not shown is not taken for nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.modal.layout import BLOCKS
from fmus.modal.parameters import block_of, modal_velocities, modes_of, name_of, numbered


def spelled(fmi: int, table: np.ndarray) -> dict[str, float]:
    """Return a table, one row per mode, as parameters in the spelling of a version of FMI."""
    return {
        name_of(block, i + 1) if fmi == 2 else f"{block}[{i + 1}]": float(value)
        for i, row in enumerate(table)
        for block, value in zip(BLOCKS, row, strict=True)
    }


@given(st.integers(1, 1500), st.sampled_from(BLOCKS))
def test_a_name_says_its_block_and_mode_in_both_spellings(mode: int, block: str) -> None:
    assert numbered(name_of(block, mode)) == (block, mode)
    assert numbered(f"{block}[{mode}]") == (block, mode)


def test_modes_are_in_the_order_of_their_numbers_above_999_too() -> None:
    """As text, frequency_1000 sorts before frequency_101, and frequency[10] before frequency[2]."""
    table = np.random.default_rng(1).uniform(0.1, 1.0, (1100, len(BLOCKS)))
    for fmi in (2, 3):
        modes = modes_of(spelled(fmi, table))
        assert modes is not None
        np.testing.assert_array_equal(modes.omega, 2 * np.pi * table[:, 0])
        np.testing.assert_array_equal(modes.shape, table[:, 2:6])
        np.testing.assert_array_equal(block_of("damping_ratio", spelled(fmi, table)), table[:, 1])


def test_no_modes_are_told_apart_from_modes_that_are_not_shown() -> None:
    still = np.zeros((1, len(BLOCKS)))
    for fmi in (2, 3):
        modes = modes_of(spelled(fmi, still))
        assert modes is not None
        assert len(modes) == 0
    for values in ({}, {"step_size": 5e-6}, {"mass": 60.0}):
        assert modes_of(values) is None


def test_an_incomplete_mode_is_refused() -> None:
    with pytest.raises(ValueError, match="mode 1 has no damping_ratio"):
        modes_of({"frequency_001": 100.0})


def test_modal_velocities_are_in_order() -> None:
    columns = ["wheel.v_lat", *(f"wheel.modal_velocity[{i}]" for i in range(12, 0, -1)), "rail.modal_velocity[1]"]
    assert modal_velocities("wheel", columns) == [f"wheel.modal_velocity[{i}]" for i in range(1, 13)]
