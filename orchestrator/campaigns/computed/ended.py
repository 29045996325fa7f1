"""Where a simulated run ended: a prepared system with tone and level in, the cycle or two tones that it is in out."""

from __future__ import annotations

from ...errors import InputError
from ...limit_cycles.catalogue import find_cycles
from ...limit_cycles.model import SquealModel
from ...limit_cycles.search import model_of
from ..ends import AT_REST, IRREGULAR, NOT_LISTED, NOT_SETTLED, Ends
from ..prepared import Prepared, structure_key


def ended_in(prepared: Prepared, tone_hz: float | None, lateral_rms: float, irregular: bool | None) -> str:
    """Return the end of a run in a word or two; nothing where the cycles of the system cannot be known.

    Parameters
    ----------
    tone_hz, lateral_rms : dominant frequency and lateral velocity of the wheel [Hz, m/s]; None: at rest
    irregular : whether there is no line spectrum; None where nothing can be said, as in runs that still grow
    """
    if tone_hz is None:
        return AT_REST
    if irregular is None:
        return NOT_SETTLED
    if irregular:
        return IRREGULAR
    try:
        model = model_of(prepared.assembly, prepared.settings.step)
    except InputError:
        return ""
    ends = _ends(prepared, model, tone_hz)
    return NOT_LISTED if ends is None else ends.label(tone_hz, lateral_rms)


def _ends(prepared: Prepared, model: SquealModel, tone_hz: float) -> Ends | None:
    """Return the cycles near a tone, found once per system however it starts; None if no pole is near."""
    assembly, kept = prepared.assembly, prepared.workshop.ends
    parts = (structure_key(fmu, assembly.parameters[name]) for name, fmu in sorted(assembly.fmus.items()))
    key = f"{'-'.join(parts)} at {tone_hz:.0f} Hz"
    if key not in kept:
        try:
            kept[key] = Ends(find_cycles(model, tone_hz=tone_hz))
        except InputError:
            kept[key] = None
    return kept[key]
