"""The four cases as the paper prints them: Tables 1 to 3, peaks of the rail, dominant tones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmus.contact.parameters import P


class Printed(NamedTuple):
    """A number of the paper and the parameter of the contact that has it here."""

    quantity: str
    unit: str
    value: float
    parameter: int
    scale: float = 1.0


TABLE1 = (
    Printed("Coulomb friction coefficient mu0", "-", 0.3, P.mu0),
    Printed("falling ratio lambda", "-", 0.1, P.falling_ratio),
    Printed("saturation coefficient kappa", "-", 0.005, P.saturation_coefficient),
    Printed("longitudinal creepage", "-", 0.0, P.steady_creepage_lon),
    Printed("spin creepage", "1/m", 0.0, P.steady_creepage_spin),
    Printed("longitudinal semi-axis a", "mm", 10.0, P.semi_axis_lon, 1e3),
    Printed("lateral semi-axis b", "mm", 5.0, P.semi_axis_lat, 1e3),
)

TABLE3 = (
    Printed("normal force N", "kN", 60.0, P.normal_load, 1e-3),
    Printed("rolling velocity V0", "m/s", 10.0, P.rolling_velocity),
    Printed("lateral steady creepage gamma2", "-", 0.02, P.steady_creepage_lat),
    Printed("longitudinal steady creepage gamma1", "-", 0.0, P.steady_creepage_lon),
    Printed("spin steady creepage gamma6", "1/m", 0.0, P.steady_creepage_spin),
    Printed("contact angle (section 5.1)", "degrees", 2.0, P.contact_angle, 180 / np.pi),
)

TABLE2 = {1: (True, True), 2: (True, False), 3: (False, True), 4: (False, False)}
"""Case: falling friction, rail."""

PEAKS_HZ = (80.0, 700.0)
"""Peaks of the vertical receptance in Fig. 3."""

CASES = ("case1", "case2", "case3", "case4")
INFERRED = ("inferred1", "inferred2", "inferred3", "inferred4")
"""The same with what Table 4 alone tells."""

PAPER_HZ = {"case1": 1100.0, "case2": 1978.0, "case3": 1100.0, "case4": 1978.0}
"""Dominant frequencies of Figs 8 to 11."""

SAME_TONE = 0.01
