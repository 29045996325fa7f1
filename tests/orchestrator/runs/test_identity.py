"""Identity of a run: the same for the same, different for whatever changes a number."""

from __future__ import annotations

from dataclasses import replace

import pytest

from orchestrator.runs.identity import identity
from orchestrator.runs.scenario import Scenario


@pytest.fixture(scope="module")
def base() -> str:
    return identity(*Scenario("case1").prepare())


def test_identity_is_a_digest_and_repeats(base: str) -> None:
    assert len(base) == 64
    assert identity(*Scenario("case1").prepare()) == base


def test_how_a_value_came_to_be_does_not_matter(base: str) -> None:
    """A value that is set to its start value, and what is recorded, change nothing."""
    assembly, _ = Scenario("case1").prepare()
    start = assembly.fmus["contact"].variables["mu0"].start
    assert identity(*Scenario("case1", values={"contact": {"mu0": start}}, record_every=16).prepare()) == base


@pytest.mark.parametrize(
    "other",
    [
        Scenario("case2"), Scenario("case1", step=4e-6), Scenario("case1", duration=1.0), Scenario("case1", seed=1),
        Scenario("case1", algorithm="jacobi"), Scenario("case1", values={"contact": {"mu0": 0.31}}),
    ],
)  # fmt: skip
def test_what_changes_a_number_changes_the_identity(base: str, other: Scenario) -> None:
    assert identity(*other.prepare()) != base


def test_a_factor_on_a_wire_changes_the_identity(base: str) -> None:
    assembly, settings = Scenario("case1").prepare()
    links = (replace(assembly.links[0], gain=0.5), *assembly.links[1:])
    assert identity(replace(assembly, links=links), settings) != base
