"""What can be computed at a point: one table of stages, and the run of a point through those that a plan asks for."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import InputError, SimulationError
from ..runs.identity import identity
from .computed import balanced, linear, simulated
from .factors import Value
from .plan import Plan
from .prepared import Campaign, Prepared, Workshop, prepare
from .rows import DONE, FAILED, Number, Quantity, Row


@dataclass(frozen=True)
class Stage:
    """A way to compute something at a point.

    Attributes
    ----------
    quantities : what it gives
    compute : a prepared system in, the quantities out
    unstable : whether its quantities say that the next stage is worth while
    """

    quantities: tuple[Quantity, ...]
    compute: Callable[[Prepared], dict[str, Number]]
    unstable: Callable[[dict[str, Number]], bool]


STAGES: dict[str, Stage] = {
    "linear": Stage(linear.QUANTITIES, linear.linear, linear.is_unstable),
    "cycles": Stage(balanced.QUANTITIES, balanced.balanced, balanced.may_squeal),
    "time": Stage(simulated.QUANTITIES, simulated.simulated, simulated.squeals),
}
"""Stages by the name that plans give them."""


def quantities(plan: Plan) -> tuple[Quantity, ...]:
    """Return what the rows of a plan hold.

    Raises
    ------
    InputError
        For a stage that is not there.
    """
    for name in plan.compute.stages:
        if name not in STAGES:
            raise InputError(f"[compute] stage = {name}: must be one of {', '.join(STAGES)}")
    return tuple(q for name in plan.compute.stages for q in STAGES[name].quantities)


def run_point(campaign: Campaign, workshop: Workshop, index: int, point: Mapping[str, Value]) -> Row:
    """Return the row of a point; whatever goes wrong is its sentence."""
    begin = time.perf_counter()
    name = ""
    try:
        assembly = prepare(campaign, workshop, point)
        name = identity(assembly, campaign.settings)
        values = _through(campaign.plan, Prepared(assembly, campaign.settings, workshop, campaign.plan.compute.compare))
    except (InputError, SimulationError) as error:
        return Row(index, FAILED, name, str(error), seconds=time.perf_counter() - begin)
    except Exception as error:  # one bad point must not end a campaign
        sentence = f"{type(error).__name__}: {error}"
        return Row(index, FAILED, name, sentence, seconds=time.perf_counter() - begin)
    wrong = [
        q.name
        for q in quantities(campaign.plan)
        if q.name in values and not q.lacks and not q.text and not np.all(np.isfinite(values[q.name]))
    ]
    seconds = time.perf_counter() - begin
    if wrong:
        return Row(index, FAILED, name, f"gives no finite number: {', '.join(wrong)}", values, seconds)
    return Row(index, DONE, name, "", values, seconds)


def _through(plan: Plan, prepared: Prepared) -> dict[str, Number]:
    """Return the quantities of all stages up to the first that finds nothing unstable."""
    values: dict[str, Number] = {}
    for name in plan.compute.stages:
        found = STAGES[name].compute(prepared)
        values.update(found)
        if not STAGES[name].unstable(found):
            break
    return values
