"""Normal modes as Nastran writes them, printed (.f06) and binary (.op2), after the layout of published files."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_HEAD = "1    A WHEEL                             NOVEMBER   1, 2025  MSC.NASTRAN  1/ 1/25   PAGE     1"


@dataclass(frozen=True)
class Model:
    """What a run of Nastran has found: frequencies, masses, points that move, shapes (n, k, 3 or 6), all points."""

    frequency_hz: NDArray[np.float64]
    mass: NDArray[np.float64]
    nodes: NDArray[np.int64]
    shape: NDArray[np.float64]
    position: Mapping[int, NDArray[np.float64]]
    output_system: int = 0

    def but(self, **change: Any) -> Model:
        """Return it with something else."""
        return replace(self, **change)

    @property
    def eigenvalue(self) -> NDArray[np.float64]:
        """Return (2 pi f)^2, below 0 for a frequency below 0."""
        return np.sign(self.frequency_hz) * (2 * np.pi * self.frequency_hz) ** 2

    @property
    def motion(self) -> NDArray[np.float64]:
        """Return the shapes with rotations, which solid elements do not have: printed as 0."""
        rotations = np.zeros((*self.shape.shape[:2], 6 - self.shape.shape[2]))
        return np.concatenate([self.shape, rotations], axis=2)


def write_f06(path: Path, model: Model, echo: bool = True, lines_on_a_page: int = 30) -> Path:
    """Write what the solver prints, with the sorted bulk data echo unless told otherwise."""
    lines = [_HEAD, "0        N A S T R A N    E X E C U T I V E    C O N T R O L    E C H O", _HEAD]
    if echo:
        lines.append("0                          S O R T E D   B U L K   D A T A   E C H O")
        for i, (node, (x, y, z)) in enumerate(model.position.items(), start=1):
            large = f"GRID*   {node:16d}{'':16}{x:16.8E}{y:16.8E}", f"*       {z:16.8E}{model.output_system:16d}"
            lines += [f"{2 * i + j:21d}-        {card}" for j, card in enumerate(large)]
        lines.append(_HEAD)
    lines.append("                                              R E A L   E I G E N V A L U E S")
    lines.append("   MODE    EXTRACTION      EIGENVALUE            RADIANS             CYCLES            GENERALIZED")
    for i, (square, mass) in enumerate(zip(model.eigenvalue, model.mass, strict=True), start=1):
        root = np.sqrt(abs(square))
        numbers = (square, root, root / (2 * np.pi), mass, mass * square)
        lines.append(f"{i:9d}{i:10d}" + "".join(f"{x:20.6E}" for x in numbers))
    for i, motion in enumerate(model.motion, start=1):
        for start in range(0, model.nodes.size, lines_on_a_page):
            lines += [_HEAD, f"      EIGENVALUE ={model.eigenvalue[i - 1]:14.6E}"]
            lines.append(f"          CYCLES =  0.0          R E A L   E I G E N V E C T O R   N O .{i:11d}")
            lines.append(
                "      POINT ID.   TYPE          T1             T2             T3             R1             R2"
            )
            rows = slice(start, start + lines_on_a_page)
            for node, values in zip(model.nodes[rows], motion[rows], strict=True):
                texts = [f"{x:15.6E}" if x else "      0.0      " for x in values]
                lines.append(f"{node:14d}      G" + "".join(texts))
    lines += [_HEAD, "                                        * * * END OF JOB * * *"]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_op2(path: Path, model: Model, order: str = "<", size: int = 4, tables: str = "GEOM1 LAMA OUGV1") -> Path:
    """Write the binary results in a byte order and with words of 4 or 8 bytes."""
    i, f = {4: ("i", "f"), 8: ("q", "d")}[size]

    def fortran(data: bytes) -> bytes:
        length = struct.pack(f"{order}i", len(data))
        return length + data + length

    def record(data: bytes) -> bytes:
        return fortran(struct.pack(f"{order}{i}", len(data) // size)) + fortran(data)

    def mark(value: int) -> bytes:
        return fortran(struct.pack(f"{order}{i}", value))

    def ints(*values: int) -> bytes:
        return struct.pack(f"{order}{len(values)}{i}", *values)

    def reals(*values: float) -> bytes:
        return struct.pack(f"{order}{len(values)}{f}", *values)

    def table(name: str, bodies: list[bytes]) -> bytes:
        text = name.ljust(2 * size).encode()
        out = record(text) + mark(-1) + record(ints(*[101] * 7)) + mark(-2) + record(ints(0)) + record(text)
        for number, body in enumerate(bodies, start=3):
            out += mark(-number) + record(ints(0)) + record(body)
        return out + mark(-len(bodies) - 3) + record(ints(0)) + mark(0)

    grids = b"".join(
        ints(n, 0) + reals(*xyz) + ints(model.output_system, 0, 0) for n, xyz in sorted(model.position.items())
    )
    squares, masses = model.eigenvalue.tolist(), model.mass.tolist()
    rows = [
        ints(k, k) + reals(s, abs(s) ** 0.5, 0.0, m, 0.0)
        for k, (s, m) in enumerate(zip(squares, masses, strict=True), start=1)
    ]
    vectors = []
    for mode, (square, motion) in enumerate(zip(squares, model.motion.tolist(), strict=True), start=1):
        vectors.append(ints(21, 7, 0, 1, mode) + reals(square) + ints(0, 0, 1, 8) + ints(*[0] * 136))
        vectors.append(
            b"".join(ints(10 * n + 1, 1) + reals(*v) for n, v in zip(model.nodes.tolist(), motion, strict=True))
        )
    bodies = {"GEOM1": [ints(4501, 45, 1) + grids, ints(65535, 65535, 65535)],
              "LAMA": [ints(*[0] * 146), b"".join(rows)], "OUGV1": vectors}  # fmt: skip
    head = record(ints(1, 11, 25)) + record(b"NASTRAN FORT TAPE ID CODE - ".ljust(7 * size)) + record(b"X" * 2 * size)
    data = head + mark(-1) + mark(0) + b"".join(table(name, bodies[name]) for name in tables.split()) + mark(0)
    path.write_bytes(data)
    return path
