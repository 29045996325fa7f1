"""The master: reads a system, loads its FMUs, couples them at a fixed step, and says what came out.

As a library it is `load`, `simulate`, `resume` and `cycles`; see `orchestrator.library`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .errors import InputError, SimulationError

if TYPE_CHECKING:
    from .coupling.master import Progress
    from .library import break_ups, cycles, load, plot_cycles, resume, simulate
    from .limit_cycles.catalogue import Catalogue
    from .runs.outcome import Outcome
    from .runs.scenario import Scenario

__all__ = [
    "Catalogue", "InputError", "Outcome", "Progress", "Scenario", "SimulationError", "break_ups", "cycles", "load",
    "plot_cycles", "resume", "simulate",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Load the library on first use: what needs only a part of the package starts fast."""
    if name == "__version__":
        return import_module("importlib.metadata").version("curvesqueal")
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(".library", __name__), name)
