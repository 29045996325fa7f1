"""The friction curve as a contact FMU shows it: creepage in, friction force over normal force out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DEFAULT_STEP

from ..fmi.instance import FmuInstance, Value, open_fmu


def friction_curve(
    contact: Path, creepage: NDArray[np.float64], parameters: dict[str, Value] | None = None
) -> NDArray[np.float64]:
    """Return the lateral creep force over the normal force at steady lateral creepages.

    Parameters
    ----------
    contact : contact FMU
    creepage : (n,) lateral creepages [-]
    parameters : other parameters of the contact

    Returns
    -------
    (n,) ratios [-], positive
    """
    fmu = open_fmu(contact)
    mobility = {name: 0.0 for name in fmu.names("parameter") if name.startswith("mobility_")}
    ratios = np.empty(creepage.size)
    instance = FmuInstance(fmu, "contact")
    instance.set({**mobility, "steady_creepage_lat": 0.0, "contact_angle": 0.0, **(parameters or {})})
    instance.enter_initialization_mode(0.0, 1.0)
    instance.exit_initialization_mode()
    for i, gamma in enumerate(creepage):
        instance.set({"steady_creepage_lat": float(gamma)})
        instance.do_step(i * DEFAULT_STEP, DEFAULT_STEP)
        force, load = instance.get_real(["tangential_force_lat", "normal_force"])
        ratios[i] = -force / load
    instance.close()
    return ratios
