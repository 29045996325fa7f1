"""The numbers of a run that its table, its JSON and the report show: one list, which all three read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .summary import Summary

Number = float | Mapping[str, float] | None


@dataclass(frozen=True)
class OutputFigure:
    """A number of a run, or one for each direction.

    Attributes
    ----------
    name : in JSON
    label, unit : for people; figures of one label share a row of a table by direction
    value : from the summary of a run; None where it is not known
    form : how the number is written, as `format` takes it
    unknown : what is said where it is not known
    """

    name: str
    label: str
    unit: str
    value: Callable[[Summary], Number]
    form: str = ".3g"
    unknown: str = "-"

    def words(self, summary: Summary) -> str:
        """Return the number as people read it.

        >>> figure = OutputFigure("a", "a", "m", lambda _: {"lat": 0.5, "ver": 2.0})
        >>> figure.words(None)
        'lat 0.5, ver 2 m'
        """
        value = self.value(summary)
        if isinstance(value, Mapping):
            said = ", ".join(f"{direction} {number:{self.form}}" for direction, number in value.items())
            return f"{said} {self.unit}" if said else self.unknown
        return self.unknown if value is None else f"{value:{self.form}} {self.unit}"


FIGURES = (
    OutputFigure("dominant_frequency_hz", "dominant frequency", "Hz", lambda s: s.dominant_frequency_hz, ".1f", "none"),
    OutputFigure("growth_rate", "growth rate", "1/s", lambda s: s.growth_rate, ".2f", "none seen"),
    OutputFigure("wheel_velocity_rms", "wheel velocity, rms", "m/s, rad/s", lambda s: s.wheel_velocity_rms),
    OutputFigure("wheel_velocity_rms_contact", "wheel velocity, rms", "m/s, rad/s", lambda s: s.wheel_contact_rms),
    OutputFigure("rail_velocity_rms", "rail velocity, rms", "m/s, rad/s", lambda s: s.rail_velocity_rms),
    OutputFigure("rail_velocity_rms_contact", "rail velocity, rms", "m/s, rad/s", lambda s: s.rail_contact_rms),
    OutputFigure("contact_lost", "contact lost", "of the time", lambda s: s.contact_lost, ".1%"),
    OutputFigure("energy_dissipated", "energy dissipated", "J", lambda s: s.energy_dissipated),
)
"""What is said of the second half of a run; the energy is that of the whole."""


def rows_by_direction(summary: Summary) -> dict[str, tuple[str, dict[str, float]]]:
    """Return unit and numbers of the figures that have one for each direction, by label."""
    rows: dict[str, tuple[str, dict[str, float]]] = {}
    for figure in FIGURES:
        value = figure.value(summary)
        if isinstance(value, Mapping):
            rows.setdefault(figure.label, (figure.unit, {}))[1].update(value)
    return rows
