"""The wheel/rail system in this process, without FMI: the reference that other routes are compared with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmus.component import Component, Instance
from fmus.contact.component import contact
from fmus.contact.linearised import LinearContact, linearise
from fmus.interface import INITIAL_VELOCITY, STEP_SIZE, connections
from fmus.modal import parameters as modal
from fmus.modal.modes import Modes
from fmus.packaging.ssp.structure import system_mobility
from fmus.rail.component import rail, rigid_rail
from fmus.wheel.component import wheel as wheel_of
from fmus.wheel.wheelset import DATA, read_wheelset
from orchestrator.stability.linear_model import LinearModel
from orchestrator.stability.scheme import growth_of_scheme
from orchestrator.stability.step_map import BELOW_HZ, SchemeError

Real = NDArray[np.float64]

FALLING = {1: 0.1, 2: 0.1, 3: 0.0, 4: 0.0}
HAS_RAIL = {1: True, 2: False, 3: True, 4: False}


def modes_of(component: Component) -> Modes:
    """Return the modes that a structure has as start values."""
    modes = modal.modes_of({v.name: v.start for v in component.of("parameter")})
    assert modes is not None
    return modes


def wheel() -> Component:
    """Return the finite-element wheel, which goes with the contact's own stiffness."""
    return wheel_of(read_wheelset(DATA / "generic840.toml").modes)


def rail_of(case: int) -> Component:
    """Return the rail of a case of the paper."""
    return rail() if HAS_RAIL[case] else rigid_rail()


def linear_contact(case: int, **parameters: float) -> LinearContact:
    """Return the linearised contact of a case of the paper."""
    return linearise({"falling_ratio": FALLING[case], **parameters})


def scheme_error(
    wheel: Modes,
    rail: Modes,
    contact: LinearContact,
    h: float,
    algorithm: str = "staggered",
    below_hz: float = BELOW_HZ,
) -> SchemeError:
    """Compare the growth rates of a scheme with those of the coupled system, for all modes below a frequency."""
    return growth_of_scheme(LinearModel(wheel, rail, contact), h, algorithm, below_hz).modes


@dataclass
class Coupled:
    """The three components of a case, stepped by hand."""

    wheel: Instance
    rail: Instance
    contact: Instance
    step_size: float
    jacobi: bool

    @classmethod
    def of(
        cls,
        case: int,
        step_size: float,
        velocities: Real | None = None,
        jacobi: bool = False,
        implicit: bool = True,
        own_wheel: Component | None = None,
        **parameters: float,
    ) -> Coupled:
        """Return the initialised system; `velocities` are the initial modal velocities of wheel, then rail."""
        parts = [own_wheel or wheel(), rail_of(case)]
        instances = [Instance(part, {STEP_SIZE: step_size}) for part in parts]
        if velocities is not None:
            begin = 0
            for instance in instances:
                n = instance.component.state_size // 2
                for i in range(n):
                    instance.set_parameter(f"{INITIAL_VELOCITY}_{i + 1:03d}", float(velocities[begin + i]))
                begin += n
        mobility = system_mobility(parts, step_size) if implicit else None
        third = Instance(contact(mobility), {"falling_ratio": FALLING[case], **parameters})
        system = cls(instances[0], instances[1], third, step_size, jacobi)
        for instance in instances:
            instance.initialise()
        system._bring("contact")
        third.initialise()
        for name in ("wheel", "rail"):
            system._bring(name)
        return system

    def _bring(self, name: str) -> None:
        """Copy the outputs of the others to the inputs of one component."""
        target: Instance = getattr(self, name)
        places = {v.name: i for i, v in enumerate(target.component.of("input"))}
        for c in connections():
            if c.end_element == name:
                source: Instance = getattr(self, c.start_element)
                outputs = [v.name for v in source.component.of("output")]
                target.inputs[places[c.end_connector]] = source.outputs[outputs.index(c.start_connector)]

    def step(self) -> None:
        """Make one communication step."""
        h = self.step_size
        self.wheel.do_step(h)
        self.rail.do_step(h)
        if self.jacobi:
            self.contact.do_step(h)
            self._exchange()
        else:
            self._exchange()
            self.contact.do_step(h)
        self.wheel.inputs[:] = self.contact.outputs[0:4]
        self.rail.inputs[:] = self.contact.outputs[4:8]

    def _exchange(self) -> None:
        """Bring the contact's inputs up to date; the same as `_bring("contact")`, by position, for speed."""
        u, w, r = self.contact.inputs, self.wheel.outputs, self.rail.outputs
        u[0:4], u[4:8], u[8:10], u[10:12] = w[0:4], r[0:4], w[5:7], r[5:7]

    def run(self, steps: int) -> dict[str, Real]:
        """Make steps; return all outputs by component, one row per step."""
        parts = {"wheel": self.wheel, "rail": self.rail, "contact": self.contact}
        record = {name: np.empty((steps, part.outputs.size)) for name, part in parts.items()}
        for k in range(steps):
            self.step()
            for name, part in parts.items():
                record[name][k] = part.outputs
        return record

    @property
    def state(self) -> Real:
        """Modal velocities of wheel and rail, then their modal displacements."""
        halves = [np.split(part.state, 2) for part in (self.wheel, self.rail)]
        return np.concatenate([half[i] for i in (0, 1) for half in halves])


def output(component: Component, name: str) -> int:
    """Return the position of an output."""
    return [v.name for v in component.of("output")].index(name)
