"""Any FMU against the contract of a rail: a file in, a row of pass / fail / not offered for each demand out.

What the file declares is compared first; then the FMU runs. Everything that is said about its dynamics comes from its
own answers to held forces.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fmus.interface import DEFAULT_STEP

from ..errors import InputError, SimulationError
from ..fmi.instance import open_fmu
from .rail import impulse_responses, in_si, read_mapping
from .rail_declaration import FAIL, NOT_RUN, Check, check_declaration
from .rail_passivity import Mobility, estimate_mobility
from .structure_trial import ROWS, Trial


@dataclass(frozen=True)
class RailReport:
    """What was found.

    Attributes
    ----------
    file : the FMU
    step : communication step [s]
    checks : rows in order
    mobility : point mobility from the impulse responses; None if the FMU did not run
    """

    file: Path
    step: float
    checks: tuple[Check, ...]
    mobility: Mobility | None

    @property
    def failed(self) -> tuple[Check, ...]:
        """The rows that failed."""
        return tuple(check for check in self.checks if check.status == FAIL)


def check_rail(path: Path, mapping_texts: Sequence[str] = (), step: float = DEFAULT_STEP) -> RailReport:
    """Test an FMU against the contract of a rail.

    Parameters
    ----------
    mapping_texts : see `rail_probe.read_mapping`
    step : communication step [s] of the tests

    Raises
    ------
    InputError
        If the file is no FMU that runs here, or the mapping or the step make no sense.
    """
    if not 1e-9 <= step <= 1e-2:
        raise InputError(f"step {step:g}: must be from 1e-9 to 1e-2 s")
    fmu = open_fmu(path)
    mapping = read_mapping(mapping_texts, fmu)
    declared, factors = check_declaration(fmu, mapping)
    if any(check.status == FAIL for check in declared):
        return RailReport(path, step, (*declared, Check("running", NOT_RUN, "what the FMU declares fails")), None)
    mapping = in_si(mapping, factors)
    try:
        rail = Trial(fmu, mapping, step, impulse_responses(fmu, mapping, step))
    except SimulationError as error:
        return RailReport(path, step, (*declared, Check("running", FAIL, str(error))), None)
    checks = [_attempt(name, check, rail) for name, check in ROWS.items()]
    return RailReport(path, step, (*declared, *checks), estimate_mobility(rail.responses))


def _attempt(name: str, check: Callable[[Trial], tuple[str, str]], rail: Trial) -> Check:
    """Return the row of a check; a failed call is a failure."""
    try:
        return Check(name, *check(rail))
    except SimulationError as error:
        return Check(name, FAIL, str(error))
