"""The cases: `ssp/cases.toml` in, one `Case` for each out.

Two families of four: `case1` to `case4` with everything as the paper prints it, `inferred1` to `inferred4` with the
wheel and the friction law that the paper's Table 4 leads to.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SSP_FOLDER = Path(__file__).parents[1] / "ssp"


@dataclass(frozen=True)
class Case:
    """One of the paper's cases, as printed or as inferred.

    Attributes
    ----------
    name : such as "case1"
    title : what it is, in words
    wheel, rail : FMU files in the places of wheel and rail, without suffix
    contact : parameters of the contact that the case sets
    step_size, stop_time : default experiment [s]
    """

    name: str
    title: str
    wheel: str
    rail: str
    contact: Mapping[str, float]
    step_size: float
    stop_time: float

    @property
    def family(self) -> str:
        """Name without the number: which four cases belong together."""
        return self.name.rstrip("0123456789")


def read_cases(folder: Path = SSP_FOLDER) -> tuple[Case, ...]:
    """Return the cases that `cases.toml` lists."""
    data: dict[str, Any] = tomllib.loads((folder / "cases.toml").read_text(encoding="utf-8"))
    return tuple(
        Case(
            name=c["name"],
            title=c["title"],
            wheel=c["wheel"],
            rail=c["rail"],
            contact={"falling_ratio": c["falling_ratio"], **data["contact"][c["contact"]], **data["disturbance"]},
            step_size=data["step"]["size_s"],
            stop_time=data["step"]["stop_time_s"],
        )
        for c in data["case"]
    )
