"""What of a file is used, and as what: contents and a user's choice in, receptances in SI and the contract's axes out.

Nothing is assumed: what the file does not say (quantity, units, node) must be chosen, what it says may not be
contradicted, and what was used comes with the result.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import DataError
from ..interface import DIRECTIONS
from .choice import Choice
from .function import Complex, Contents, Function, Place, Real
from .units import QUANTITIES, Ratio, read_ratio, read_system, rotations

_FORMAT_SI = "SI, as the format has it"


@dataclass(frozen=True)
class Measured:
    """One measured function: a receptance in SI between two directions of the contract.

    Attributes
    ----------
    response, reference : directions of motion and force
    frequency_hz : (m,) increasing frequencies > 0 [Hz]
    receptance : (m,) complex [m/N; rotations rad, moments N m]
    coherence : (m,) from 0 to 1; None where it was not measured
    used : what was taken for it: 'set', 'point', 'quantity', 'units', 'factor', 'sign', 'from_hz', 'to_hz',
        and 'origin' if the file says it
    si_assumed : whether the unit is SI because the format says so, not the file
    lines : (m,) line of the file that each value stands on; None where there is none
    """

    response: str
    reference: str
    frequency_hz: Real
    receptance: Complex
    coherence: Real | None
    used: Mapping[str, str | float]
    si_assumed: bool = False
    lines: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        """Check directions, frequencies and values."""
        where, f = self._where(), self.frequency_hz
        for direction in (self.response, self.reference):
            if direction not in DIRECTIONS:
                raise DataError(f"{where}: direction {direction!r}; must be one of {', '.join(DIRECTIONS)}")
        bad = np.flatnonzero(~np.isfinite(f) | (f <= 0))
        if bad.size or not f.size:
            got = f"frequency {bad[0] + 1} is {f[bad[0]]:g} Hz" if bad.size else "no frequency above 0 Hz"
            raise DataError(f"{self._where(*bad[:1])}: {got}; must be finite and > 0")
        bad = np.flatnonzero(np.diff(f) <= 0)
        if bad.size:
            got = f"{f[bad[0] + 1]:g} Hz comes after {f[bad[0]]:g} Hz"
            raise DataError(f"{self._where(bad[0] + 1)}: {got}; frequencies must increase")
        if self.receptance.shape != f.shape:
            raise DataError(f"{where}: {self.receptance.size} values in {self.words} for {f.size} frequencies")
        bad = np.flatnonzero(~np.isfinite(self.receptance) | (self.receptance == 0))
        if bad.size:
            got = self.receptance[bad[0]]
            raise DataError(
                f"{self._where(bad[0])}: {self.words} at {f[bad[0]]:g} Hz is {got}; must be finite and not 0"
            )
        if self.coherence is not None:
            bad = np.flatnonzero(~((self.coherence >= 0) & (self.coherence <= 1)))
            if bad.size:
                got = self.coherence[bad[0]]
                raise DataError(f"{self._where(bad[0])}: the coherence at {f[bad[0]]:g} Hz is {got:g}; must be 0 to 1")

    def _where(self, place: int | None = None) -> str:
        """Return where the function, or one of its values, stands."""
        where = str(self.used.get("set", "measurement"))
        return where if place is None or self.lines is None else f"{where}, line {self.lines[place]}"

    @property
    def words(self) -> str:
        """Return the directions as words."""
        return _words((self.response, self.reference))

    def on_lines(self, inside: NDArray[np.bool_]) -> Measured:
        """Return the function on the lines that are kept."""
        f = self.frequency_hz[inside]
        return replace(
            self,
            frequency_hz=f,
            receptance=self.receptance[inside],
            coherence=None if self.coherence is None else self.coherence[inside],
            lines=None if self.lines is None else self.lines[inside],
            used={**self.used, "from_hz": float(f[0]), "to_hz": float(f[-1])},
        )


def select(contents: Contents, choice: Choice) -> list[Measured]:
    """Return the functions at the driving point, those of one pair of directions each.

    Raises
    ------
    DataError
        Where the file holds nothing that fits, several that do, or says something else than the user; says what it
        holds.
    """
    name = contents.path.name
    if not contents.functions:
        raise DataError(f"{name}: holds no frequency response; holds {contents.listed()}")
    at_one_point = [f for f in contents.functions if f.response.node == f.reference.node]
    fitting = [f for f in at_one_point if choice.direction(f.response.code) and choice.direction(f.reference.code)]
    if not fitting:
        raise DataError(
            f"{name}: no function has motion and force at one node in the axes asked for; holds {contents.listed()}"
        )
    nodes = sorted({f.response.node for f in fitting if f.response.node is not None})
    if choice.node is not None and nodes and choice.node not in nodes:
        raise DataError(f"{name}: no driving point at node {choice.node}; has {_nodes(fitting)}")
    if choice.node is None and len(nodes) > 1:
        raise DataError(f"{name}: driving points at nodes {_nodes(fitting)}; choose one (option node)")
    found: dict[tuple[str, str], Measured] = {}
    for function in fitting:
        if nodes and function.response.node != (nodes[0] if choice.node is None else choice.node):
            continue
        measured = _in_si(function, contents, choice)
        pair = (measured.response, measured.reference)
        if pair in found:
            raise DataError(f"{function.where}: a second function of {_words(pair)}; must be one")
        found[pair] = measured
    return list(found.values())


def files_and_origins(files: Iterable[Path], used: Iterable[Mapping[str, str | float]]) -> str:
    """Return the names of files, and what they say about themselves."""
    origins = dict.fromkeys(str(row["origin"]) for row in used if "origin" in row)
    return "; ".join([", ".join(file.name for file in files), *origins])


def _nodes(functions: Sequence[Function]) -> str:
    """Return the nodes of functions, each with where its first stands."""
    places: dict[int, str] = {}
    for function in functions:
        if function.response.node is not None:
            places.setdefault(function.response.node, function.where.partition(", ")[2])
    return ", ".join(f"{node} ({place})" if place else str(node) for node, place in sorted(places.items()))


def _in_si(function: Function, contents: Contents, choice: Choice) -> Measured:
    """Return a function as a receptance in SI on the lines of the band, with what was used for it."""
    (response, s), (reference, t) = (_direction(p, choice) for p in (function.response, function.reference))
    if function.force is False:
        raise DataError(f"{function.where}: the denominator is no force but {function.units[1] or 'something else'}")
    quantity, factor, units = _meaning(function, contents, choice, (response, reference))
    start = 1 if function.frequency_hz.size and function.frequency_hz[0] == 0 else 0  # mobility says nothing at 0 Hz
    f, values = function.frequency_hz[start:], function.values[start:]
    with np.errstate(divide="ignore", invalid="ignore"):
        receptance = values * (2j * np.pi * f) ** -float(QUANTITIES[quantity]) * (factor * s * t)
    measured = Measured(
        response=response,
        reference=reference,
        frequency_hz=f,
        receptance=np.asarray(receptance, dtype=complex),
        coherence=_coherence(function, contents, f),
        used={
            "set": function.where, "point": f"{function.response} due to {function.reference}",
            "direction": _words((response, reference)), "quantity": quantity, "units": units, "factor": factor,
            "sign": s * t, "from_hz": float(f[0]) if f.size else 0.0, "to_hz": float(f[-1]) if f.size else 0.0,
            **({"origin": contents.origin} if contents.origin else {}),
        },
        si_assumed=units == _FORMAT_SI,
        lines=None if function.lines is None else function.lines[start:],
    )  # fmt: skip
    inside = (f >= (choice.start_hz or 0.0)) & (f <= (choice.stop_hz or np.inf))
    if not inside.any():
        raise DataError(f"{function.where}: has {f[0]:g} to {f[-1]:g} Hz; no line lies in the band asked for")
    return measured.on_lines(inside)


def _direction(place: Place, choice: Choice) -> tuple[str, float]:
    found = choice.direction(place.code)
    assert found is not None  # `select` keeps only these
    return found


def _meaning(function: Function, contents: Contents, choice: Choice, pair: tuple[str, str]) -> tuple[str, float, str]:
    """Return quantity, factor to SI and the words for the unit of a function."""
    label = _label_ratio(function)
    said = function.quantity or (label.quantity if label else None)
    given = _given_ratio(choice)
    sources = (
        ("its axis label says", label.quantity if label else None),
        ("the option units says", given.quantity if given else None),
        ("the option quantity says", choice.quantity),
    )
    for source, quantity in sources:
        if said is not None and quantity is not None and quantity != said:
            raise DataError(f"{function.where}: holds {said}; {source} {quantity}")
        said = said or quantity
    if said is None:
        raise DataError(
            f"{function.where}: does not say whether it is a receptance, mobility or accelerance; "
            "say it with the option quantity"
        )
    if function.force is None and label is None and given is None:
        raise DataError(
            f"{function.where}: does not say that its denominator is a force; if it is, say so with the "
            "option units, such as m/s/N"
        )
    for ratio in (label, given):
        if ratio is not None and ratio.rotations != rotations(*pair):
            raise DataError(f"{function.where}: unit {ratio.text!r} is not that of {_words(pair)}")
    return said, *_factor(function, contents, choice, pair)


def _factor(function: Function, contents: Contents, choice: Choice, pair: tuple[str, str]) -> tuple[float, str]:
    """Return factor to SI and the words for the unit: data set 164, else labels, else the user, else the format."""
    label, given = _label_ratio(function), _given_ratio(choice)
    gravity = label is not None and "g" in function.units[0].split("/")[0].strip("() ").split()
    if contents.system is not None and not gravity:
        factor = contents.system.factor(*pair)
        _require_same(function, choice, pair, factor, contents.system.source)
        differs = label is not None and not np.isclose(label.factor, factor, rtol=1e-4)
        note = f"; the axis label {label.text!r} says otherwise" if differs and label is not None else ""
        return factor, f"{contents.system.text(*pair)}, {contents.system.source}{note}"
    if label is not None:
        _require_same(function, choice, pair, label.factor, f"axis label {label.text!r}")
        return label.factor, f"{label.text}, axis label"
    if given is not None:
        return given.factor, f"{given.text}, option units"
    if choice.units is not None:
        system = read_system(choice.units)
        return system.factor(*pair), f"{system.text(*pair)}, option units"
    if contents.si:
        return 1.0, _FORMAT_SI
    raise DataError(f"{function.where}: does not say its units; give them with the option units, such as m/s/N or mm,N")


def _require_same(function: Function, choice: Choice, pair: tuple[str, str], factor: float, source: str) -> None:
    """Raise ValueError if the user's units are not those of the file."""
    given = _given_ratio(choice)
    if choice.units is None:
        return
    asked = given.factor if given is not None else read_system(choice.units).factor(*pair)
    if not np.isclose(asked, factor, rtol=1e-4):
        raise DataError(
            f"{function.where}: the option units, {choice.units}, is {asked:g} in SI; {source} says {factor:g}"
        )


def _given_ratio(choice: Choice) -> Ratio | None:
    return read_ratio(choice.units) if choice.units is not None and "," not in choice.units else None


def _label_ratio(function: Function) -> Ratio | None:
    """Return what the axis labels say, None where there are none; labels that mean nothing are refused."""
    numerator, denominator = function.units
    if not numerator:
        return None
    for text in (numerator, f"({numerator})/({denominator})"):
        try:
            return read_ratio(text)
        except ValueError:
            continue
    shown = numerator if not denominator else f"{numerator} per {denominator}"
    raise DataError(f"{function.where}: unit {shown!r} is no displacement, velocity or acceleration per force")


def _coherence(function: Function, contents: Contents, frequency_hz: Real) -> Real | None:
    """Return the coherence at some frequencies, None where there is none."""
    found = contents.coherence.get((function.response, function.reference))
    return None if found is None else np.asarray(np.interp(frequency_hz, *found))


def _words(pair: tuple[str, str]) -> str:
    return pair[0] if pair[0] == pair[1] else f"{pair[0]} due to {pair[1]}"
