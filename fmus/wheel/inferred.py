"""The wheelset of the inferred cases, and the friction law and contact spring that were identified with it.

`data/inferred.toml` holds the modes, `data/inferred-identification.toml` the law and how both were found. Both are
written by `python -m orchestrator.identification inferred`; nodal diameters and radiating areas are those of the finite
elements, whose modes these are.
"""

from __future__ import annotations

import tomllib

from .class158 import PRIOR, on_finite_elements
from .wheelset import DATA, Wheelset

MODES = DATA / "inferred.toml"
IDENTIFICATION = DATA / "inferred-identification.toml"


def inferred() -> Wheelset:
    """Return the inferred wheelset.

    Raises
    ------
    DataError
        If the generic wheelset has other modes than when the wheelset was identified.
    """
    return on_finite_elements(MODES, PRIOR)


def inferred_law() -> dict[str, float]:
    """Return the parameters of the contact that go with it: spring, mu0, falling ratio, saturation coefficient."""
    settings = tomllib.loads(IDENTIFICATION.read_text(encoding="utf-8"))
    return {name: float(value) for name, value in settings["law"].items()}
