"""The creep law with the blended bound: limits, invariants, grid."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.creep.blended import blended, spin_flexibility, volumes
from fmus.creep.fastsim import flexibilities
from fmus.creep.kalker import creepage_coefficients
from fmus.creep.strips import SCRATCH_SIZE, cell

A, B, G, FRICTION = 0.010, 0.005, 80e9, 18e3


def force(
    xi: float, eta: float, phi: float, cells: int = 10, strips: int = 10, friction: float = FRICTION
) -> np.ndarray:
    c11, c22, c23, c33 = creepage_coefficients(A, B, 0.3)
    L = (*flexibilities(A, B, G, c11, c22, c23), spin_flexibility(B, G, c33))
    scratch = np.zeros(SCRATCH_SIZE + 1)
    found = blended(xi, eta, phi, friction, *volumes(A, B, cells, strips), A, B, *L, cells, strips, scratch, 1)
    assert not scratch.any()
    return np.array(found)


@given(st.integers(1, 12), st.integers(1, 12))
def test_volumes_are_the_sums_over_the_grid(cells: int, strips: int) -> None:
    y = (2 * np.arange(strips) + 1) / strips - 1
    root = np.sqrt(1 - y * y)
    q, length = np.array([cell(k, cells, True)[1:] for k in range(cells)]).T
    area = A * root[:, None] * length * 2 * B / strips
    bound = root[:, None] * q
    assert volumes(A, B, cells, strips) == pytest.approx([(bound * area).sum(), (bound**2 * area).sum()], rel=1e-12)


def test_volumes_of_a_fine_grid() -> None:
    assert volumes(A, B, 400, 400) == pytest.approx([2 / 3 * math.pi * A * B, math.pi * A * B / 2], rel=1e-4)


@pytest.mark.parametrize("grid", [1, 7, 10])
def test_full_sliding_gives_the_friction_force_on_any_grid(grid: int) -> None:
    assert force(0, 0.05, 0, grid, grid) == pytest.approx([0, -FRICTION, 0], rel=1e-12, abs=1e-9)


def test_small_creepages_give_kalkers_linear_theory() -> None:
    """Forces by C11, C22, C23, moment by C33: on 40 x 40 cells within 0.2 %, the grid's error."""
    c11, c22, c23, c33 = creepage_coefficients(A, B, 0.3)
    arm = math.sqrt(A * B)
    small = 1e-8
    assert force(small, 0, 0, 40, 40)[0] == pytest.approx(-G * A * B * c11 * small, rel=2e-3)
    assert force(0, small, 0, 40, 40)[1] == pytest.approx(-G * A * B * c22 * small, rel=2e-3)
    lon, lat, moment = force(0, 0, small, 40, 40)
    assert lon == pytest.approx(0.0, abs=1e-12 * FRICTION)
    assert lat == pytest.approx(-G * A * B * arm * c23 * small, rel=2e-3)
    assert moment == pytest.approx(-G * (A * B) ** 2 * c33 * small, rel=2e-3)


creepages = st.floats(-0.05, 0.05).map(lambda x: round(x, 9))


@given(creepages, creepages, st.floats(-5, 5).map(lambda x: round(x, 6)), st.integers(1, 20), st.floats(1e-3, 1e5))
def test_force_is_bounded_odd_and_dissipative(xi: float, eta: float, phi: float, grid: int, friction: float) -> None:
    found = force(xi, eta, phi, grid, grid, friction)
    assert math.hypot(found[0], found[1]) <= friction * (1 + 1e-12)
    np.testing.assert_allclose(force(-xi, -eta, -phi, grid, grid, friction), -found, atol=1e-12 * (1 + friction))
    if phi == 0.0:
        assert found[0] * xi + found[1] * eta <= 1e-12 * (1 + friction)


@pytest.mark.parametrize("creepage", [(0, 1e-3, 0), (1e-3, 0, 0), (0, 0, 0.3), (0, 0, 1), (5e-4, -1e-3, 0.5)])
def test_order_in_the_cells(creepage: tuple[float, float, float]) -> None:
    """Sixteen times the cells give at least 1/60 of the error, first order: 1/16. Means over a few grids."""
    exact = force(*creepage, 20000, 8) / [1, 1, A]
    coarse, fine = (
        np.mean([abs(force(*creepage, n, 8) / [1, 1, A] - exact).max() for n in range(m, 3 * m // 2, m // 10)])
        for m in (10, 160)
    )
    assert coarse < 0.02 * FRICTION
    assert fine < coarse / 60


def test_nothing_gives_nothing() -> None:
    assert force(0.01, 0.02, 0.1, friction=0.0).tolist() == [0, 0, 0]
    assert force(0.0, 0.0, 0.0).tolist() == [0, 0, 0]
