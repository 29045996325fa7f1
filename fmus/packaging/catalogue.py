"""Every component that is shipped."""

from __future__ import annotations

from ..cases import read_cases
from ..component import Component
from ..contact.component import contact
from ..curving.component import vehicle
from ..interface import DEFAULT_STEP
from ..rail.component import SHIPPED, rail, rigid_rail, shipped_rail
from ..system.component import system
from ..wheel.component import wheel
from ..wheel.inferred import inferred
from ..wheel.wheelset import DATA, read_wheelset
from .ssp.structure import contacts, system_mobility


def components() -> dict[str, Component]:
    """Return every component that is shipped, by the name of its FMU file without suffix."""
    the_wheel, the_rail, rigid = wheel(), rail(), rigid_rail()
    the_contact = contact(system_mobility([the_wheel, the_rail], DEFAULT_STEP))
    cases = read_cases()
    first = cases[0]
    wheels = {
        "wheel": the_wheel,
        "wheel-inferred": wheel(inferred().modes),
        "wheel-generic840": wheel(read_wheelset(DATA / "generic840.toml").modes),
    }
    parts = {**wheels, "rail": the_rail, "rail-rigid": rigid, "contact": the_contact}
    return {
        **wheels,
        **{name: shipped_rail(name) for name in SHIPPED},
        "rail-rigid": rigid,
        **contacts(parts, cases),
        "vehicle": vehicle(),
        "curvesqueal": system("curvesqueal", the_wheel, the_rail, the_contact, first.contact),
        "curvesqueal-rigid": system("curvesqueal_rigid", the_wheel, rigid, the_contact, first.contact),
    }
