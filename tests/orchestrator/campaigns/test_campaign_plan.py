"""Plans: what a plan file means, and one sentence for whatever means nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plans import plan_of
from scipy import stats

from orchestrator.campaigns.factors import read_factor
from orchestrator.campaigns.plan import read_plan
from orchestrator.campaigns.sampling import points
from orchestrator.errors import InputError

MU0 = "contact.mu0"
UNIT_SQUARE = f'"{MU0}" = {{ from = 0.0, to = 1.0 }}\n"contact.x" = {{ from = 0.0, to = 1.0 }}'


def test_a_grid_is_every_combination_last_factor_fastest() -> None:
    found = points(plan_of(f'"{MU0}" = {{ from = 0.1, to = 0.3, n = 3 }}\nseed = [5, 7]'))
    assert [tuple(found[i].values()) for i in range(len(found))] == [
        (0.1, 5), (0.1, 7), (0.2, 5), (0.2, 7), (0.3, 5), (0.3, 7),
    ]  # fmt: skip


def test_names_need_no_quotes() -> None:
    """TOML reads contact.mu0 without quotes as a table in a table; the plan means the same."""
    quoted, bare = (points(plan_of(f"{name} = [0.1, 0.2]")) for name in (f'"{MU0}"', MU0))
    assert quoted[1] == bare[1] == {MU0: 0.2}


def test_levels_in_equal_ratios() -> None:
    levels = read_factor("a.b", {"from": 1.0, "to": 100.0, "n": 3, "spacing": "log"}).levels()
    assert levels is not None
    np.testing.assert_allclose(levels, [1, 10, 100], rtol=1e-14)


@pytest.mark.parametrize(
    ("entry", "law"),
    [
        ({"distribution": "uniform", "from": 1.0, "to": 3.0}, stats.uniform(1, 2)),
        ({"distribution": "normal", "mean": 1.0, "std": 0.2}, stats.norm(1, 0.2)),
        ({"distribution": "lognormal", "median": 2.0, "sigma": 0.3}, stats.lognorm(0.3, scale=2)),
        ({"distribution": "triangular", "from": 0.0, "mode": 1.0, "to": 4.0}, stats.triang(0.25, 0, 4)),
        (
            {"distribution": "truncated_normal", "mean": 0.0, "std": 1.0, "from": -1.0, "to": 2.0},
            stats.truncnorm(-1, 2),
        ),
    ],
)
def test_quantiles_are_inverse_to_the_distribution(entry: dict[str, Any], law: Any) -> None:
    u = np.linspace(0.01, 0.99, 33)
    np.testing.assert_allclose(law.cdf(read_factor("a.b", entry).at(u)), u, rtol=1e-10)


@given(st.lists(st.integers(0, 99), min_size=1, max_size=9, unique=True))
def test_values_of_a_list_are_alike_probable(values: list[int]) -> None:
    u = (np.arange(100 * len(values)) + 0.5) / (100 * len(values))
    found, count = np.unique(read_factor("seed", values).at(u), return_counts=True)
    assert found.tolist() == sorted(values)
    assert (count == 100).all()


def test_a_latin_hypercube_has_one_point_in_each_stratum() -> None:
    found = points(
        plan_of(
            f'"{MU0}" = {{ from = 0.0, to = 1.0 }}\n"contact.x" = {{ from = 0.0, to = 1.0 }}',
            'method = "latin"\nn = 40',
        )
    )
    for column in found.columns.values():
        assert sorted((column * 40).astype(int)) == list(range(40))


def test_a_sobol_sequence_is_balanced() -> None:
    """Of 2^m points of a Sobol sequence, 2^(m-3) are in each eighth of every axis."""
    found = points(
        plan_of(
            UNIT_SQUARE,
            'method = "sobol"\nn = 64',
        )
    )
    for column in found.columns.values():
        assert np.bincount((8 * column).astype(int)).tolist() == [8] * 8


def test_saltelli_mixes_one_column_at_a_time() -> None:
    vary = "\n".join(f'"contact.{name}" = {{ from = 0.0, to = 1.0 }}' for name in "abc")
    blocks = np.array(list(points(plan_of(vary, 'method = "saltelli"\nn = 8')).columns.values())).T.reshape(5, 8, 3)
    A, B = blocks[:2]
    for k in range(3):
        np.testing.assert_array_equal(blocks[2 + k], np.where(np.arange(3) == k, B, A))


def test_points_are_the_same_every_time_and_depend_on_the_seed() -> None:
    first, again, other = (
        points(plan_of(f'"{MU0}" = {{ from = 0.0, to = 1.0 }}', f'method = "latin"\nn = 5\nseed = {seed}')).columns[MU0]
        for seed in (1, 1, 2)
    )
    assert (first == again).all()
    assert (first != other).any()


def test_a_table_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text("seed,contact.mu0\n3,0.25\n9,0.5\n")
    vary = f'"{MU0}" = {{ from = 0.0, to = 1.0 }}\nseed = {{ from = 0, to = 9 }}'
    found = points(plan_of(vary, 'method = "table"\nfile = "points.csv"', folder=tmp_path))
    assert [found[i] for i in range(2)] == [{MU0: 0.25, "seed": 3}, {MU0: 0.5, "seed": 9}]


def test_what_does_not_change_a_number_is_not_in_the_digest() -> None:
    vary = f'"{MU0}" = [0.1]'
    assert plan_of(vary).digest == plan_of(vary, compute="timeout_s = 5\nattempts = 2").digest
    assert plan_of(vary).digest != plan_of(vary, compute='stage = "time"').digest


GRID = f'"{MU0}" = {{ from = 0.1, to = 0.5, n = 2 }}'


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        ((f'"{MU0}" = []',), r"\[vary\] contact.mu0: is empty; give at least one value"),
        ((f'"{MU0}" = {{ from = 0.5, to = 0.1, n = 3 }}',), r"contact.mu0: is empty, from 0.5 to 0.1"),
        ((f'"{MU0}" = {{ from = 0.1, to = 0.5 }}',), "contact.mu0: a grid needs n or a list of values"),
        ((f'"{MU0}" = {{ from = 0.1, to = 0.5, n = 0 }}',), "n = 0: must be a whole number >= 1"),
        ((f'"{MU0}" = {{ from = 0.1, to = inf, n = 2 }}',), "to must be a finite number, got inf"),
        ((f'"{MU0}" = {{ from = 0.1, to = 0.5, n = 2, step = 1 }}',), "step means nothing here"),
        ((f'"{MU0}" = {{ from = -1, to = 1, n = 3, spacing = "log" }}',), "from = -1: must be > 0 for spacing log"),
        ((f'"{MU0}" = {{ distribution = "poisson" }}',), "distribution = poisson: must be one of uniform"),
        ((f'"{MU0}" = {{ distribution = "normal", mean = 0, std = 0 }}',), "std = 0: must be > 0"),
        ((f'"{MU0}" = [0.1, "a"]',), "numbers and texts in one list"),
        ((f'"{MU0}" = [0.1, 0.1]',), "has a value twice"),
        (("mu0 = [0.1]",), "must be COMPONENT.PARAMETER, a component with FMUs, seed, start_hz or a choice"),
        (("seed = { from = 0, to = 3, n = 2 }",), "a range of seeds is"),
        (("",), r"\[vary\] is empty"),
        ((GRID, 'method = "monte carlo"'), "method = monte carlo: must be one of grid"),
        ((GRID, 'method = "sobol"'), "n: sobol needs the number of points"),
        ((GRID, 'method = "grid"\nn = 4'), "a grid has its number of points itself"),
        ((GRID, 'method = "table"'), "method table needs a CSV file"),
        ((GRID, "", 'stage = "guess"'), "stage = guess: must be one of linear, cycles, time"),
        ((GRID, "", 'stage = ["time", "linear"]'), "in the order linear, cycles, time"),
        ((GRID, "", "timeout_s = 0"), "timeout_s = 0: must be > 0 s"),
        ((GRID, "", "speed = 1"), r"\[compute\] speed: means nothing here"),
        ((GRID, "", "", ""), r"\[system\] must name a case"),
        ((GRID, "", "", 'case = "case3"\nstep = -1'), "step = -1: must be > 0 s"),
        ((GRID, "", "", 'case = "case3"\nset = { mu0 = 1 }'), "set mu0: must be COMPONENT.PARAMETER"),
        ((GRID, 'method = "saltelli"\nn = 6'), "n = 6: Saltelli's scheme needs a power of 2"),
    ],
)  # fmt: skip
def test_bad_plans_are_one_sentence(plan: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        points(plan_of(*plan))


def test_more_than_ten_million_runs_are_refused() -> None:
    vary = "\n".join(f'"contact.{name}" = {{ from = 0, to = 1, n = 1000 }}' for name in "abc")
    with pytest.raises(InputError, match="the plan has 1,000,000,000 runs; at most 10,000,000 are allowed"):
        points(plan_of(vary))


def test_bad_files_are_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    with pytest.raises(InputError, match=r"plan.toml: No such file"):
        read_plan(path)
    path.write_text("[system\n")
    with pytest.raises(InputError, match=r"plan.toml: is no TOML"):
        read_plan(path)
    path.write_text('[system]\ncase = "case3"\n[vary]\n"contact.mu0" = []\n')
    with pytest.raises(InputError, match=r"plan.toml: \[vary\] contact.mu0: is empty"):
        read_plan(path)


@pytest.mark.parametrize(
    ("table", "message"),
    [("seed\n1\n", "has the columns seed; wanted are contact.mu0"), ("contact.mu0\n", "has no points"),
     ("contact.mu0\n0.1\nx\n", r"line 3: contact.mu0 = x: must be a finite number")],
)  # fmt: skip
def test_bad_tables_are_one_sentence(tmp_path: Path, table: str, message: str) -> None:
    (tmp_path / "points.csv").write_text(table)
    with pytest.raises(InputError, match=message):
        points(plan_of(GRID, 'method = "table"\nfile = "points.csv"', folder=tmp_path))
