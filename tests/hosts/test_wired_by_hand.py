"""The three FMUs of a build wired by hand, nothing set: what a user of any tool does first."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from slaves import H, Slave

from fmus.interface import connections
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.system.reader import read_system

STEPS = 2000
"""10 ms: the pulse of the case, 1 ms, and ten periods of its tone."""


def wired_by_hand(native: Path) -> np.ndarray:
    """Step wheel and rail with the held forces, then the contact; return the wheel's lateral velocity at each step."""
    slaves = {name: Slave(native / f"{name}.fmu") for name in ("wheel", "rail", "contact")}
    into: dict[str, list[tuple[str, int, int]]] = {name: [] for name in slaves}
    for c in connections():
        references = (
            slaves[c.start_element].reference[c.start_connector],
            slaves[c.end_element].reference[c.end_connector],
        )
        into[c.end_element].append((c.start_element, *references))

    def feed(name: str) -> None:
        values = [slaves[owner].slave.getReal([source])[0] for owner, source, _ in into[name]]
        slaves[name].slave.setReal([target for _, _, target in into[name]], values)

    found = np.zeros(STEPS)
    lateral = slaves["wheel"].reference["v_lat"]
    for n in range(STEPS):
        for stage in (("wheel", "rail"), ("contact",)):
            for name in stage:
                feed(name)
            for name in stage:
                slaves[name].slave.doStep(n * H, H)
        found[n] = slaves["wheel"].slave.getReal([lateral])[0]
    for slave in slaves.values():
        slave.close()
    return found


def test_the_fmus_wired_by_hand_with_nothing_set_are_case_1(native: Path) -> None:
    """Friction, creepage, stiffness, pulse and interface mobility are start values: the motion is that of the case.

    To 1e-9 of the largest value: the master makes one more exchange before the first step, from rest.
    """
    found = wired_by_hand(native)
    with Master(assemble(read_system(native / "curvesqueal.ssp")), Settings(H, STEPS * H)) as master:
        place = master.outputs.index(("wheel", "v_lat"))
        expected = np.zeros(STEPS)
        for n in range(STEPS):
            master.run(steps=1)
            expected[n] = master.plan.y[place]
    assert np.abs(expected).max() > 1e-4
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
