"""FMUs with the traits that Modelica's Reference-FMUs have, written here: see `reference_slave.c`."""

from __future__ import annotations

from pathlib import Path

from table_fmus import Table, Var, library

SOURCE = Path(__file__).parent / "reference_slave.c"


def _real(name: str, reference: int, causality: str, start: float | None = None, alias: str = "") -> Var:
    return Var(name, reference, "Real", causality, reference, start, alias=alias)


def variables(kind: str, fmi: int) -> tuple[Var, ...]:
    """Return the variables of a slave, in the types of a version of FMI."""
    real, whole = ("Real", "Integer") if fmi == 2 else ("Float64", "Int32")
    counter = [_real("y", 1, "output"), Var("n", 2, whole, "output", 0)]
    found = {
        "Early": counter, "Stuck": counter, "Events": counter,
        "Dahlquist": [_real("x", 1, "output"), _real("der(x)", 2, "local"), _real("k", 3, "parameter", 1.0)],
        "VanDerPol": [_real("x0", 1, "output"), _real("x1", 3, "output"), _real("mu", 5, "parameter", 1.0)],
        "BouncingBall": [
            _real("h", 1, "output"), _real("h_ft", 1, "output", alias="h"), _real("v", 3, "output"),
            _real("g", 5, "parameter", -9.81), _real("e", 6, "parameter", 0.7),
        ],
        "Stair": [Var("counter", 1, whole, "output", 0)],
        "Resource": [Var("y", 1, whole, "output", 0)],
        "Feedthrough": [
            _real("real_in", 1, "input", 0.0), _real("real_out", 2, "output"),
            Var("int_in", 3, whole, "input", 0, 0), Var("int_out", 4, whole, "output", 0),
            Var("bool_in", 5, "Boolean", "input", 0, 0), Var("bool_out", 6, "Boolean", "output", 0),
            Var("text_in", 15, "String", "input", 0, 0), Var("text_out", 16, "String", "output", 0),
        ],
    }[kind]  # fmt: skip
    if fmi == 3 and kind == "Feedthrough":
        found += [
            Var("int64_in", 7, "Int64", "input", 0, 0), Var("int64_out", 8, "Int64", "output", 0),
            Var("uint64_in", 9, "UInt64", "input", 0, 0), Var("uint64_out", 10, "UInt64", "output", 0),
            Var("uint8_in", 11, "UInt8", "input", 0, 0), Var("uint8_out", 12, "UInt8", "output", 0),
        ]  # fmt: skip
    return tuple(Var(**{**vars(v), "type": real if v.type == "Real" else v.type}) for v in found)


def reference_fmu(folder: Path, kind: str, fmi: int) -> Path:
    """Write a slave."""
    more = {"y.txt": "a file"} if kind == "Resource" else {}
    flags = 'hasEventMode="true"' if kind == "Events" else 'canHandleVariableCommunicationStepSize="true"'
    return Table(
        kind, fmi, variables(kind, fmi), (), flags=flags, states=False, source=SOURCE, token=kind, more=more
    ).write(folder)


STATE_SPACE = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="StateSpace" instantiationToken="StateSpace">
<CoSimulation modelIdentifier="table" canHandleVariableCommunicationStepSize="true" fixedInternalStepSize="1"/>
<ModelVariables>
<UInt64 name="m" valueReference="1" causality="structuralParameter" variability="tunable" start="3" min="1"/>
<UInt64 name="n" valueReference="2" causality="structuralParameter" variability="tunable" start="3" min="1"/>
<UInt64 name="r" valueReference="3" causality="structuralParameter" variability="tunable" start="3" min="1"/>
{arrays}
<Float64 name="time" valueReference="99" causality="independent" variability="continuous"/>
</ModelVariables>
<ModelStructure><Output valueReference="9" dependencies="8"/><InitialUnknown valueReference="9"/></ModelStructure>
</fmiModelDescription>"""


def state_space(folder: Path) -> Path:
    """Write x' = A x + B u, y = C x + D u of FMI 3.0, whose sizes m, n and r are structural parameters."""
    sizes = {"A": "nn", "B": "nm", "C": "rn", "D": "rm", "u": "m", "y": "r", "x": "n", "x0": "n"}
    identity = "1 0 0 0 1 0 0 0 1"
    rows = ""
    for k, (name, shape) in enumerate(sizes.items()):
        causality = {"u": "input", "y": "output", "x": "local"}.get(name, "parameter")
        start = "" if name in "yx" else f' start="{identity if len(shape) == 2 else "0 0 0"}"'
        inside = "".join(f'<Dimension valueReference="{"mnr".index(s) + 1}"/>' for s in shape)
        variability = "tunable" if causality == "parameter" else "continuous"
        rows += (
            f'<Float64 name="{name}" valueReference="{4 + k}" causality="{causality}" '
            f'variability="{variability}"{start}>{inside}</Float64>'
        )
    table = Table("StateSpace", 3, (), (), source=SOURCE, token="StateSpace", xml=STATE_SPACE.format(arrays=rows))
    return table.write(folder)


def clocks(folder: Path) -> Path:
    """Write an FMU for scheduled execution only."""
    xml = (
        '<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="3.0" modelName="Clocks" '
        'instantiationToken="g"><ScheduledExecution modelIdentifier="table"/><ModelVariables>'
        '<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>'
        '<Clock name="tick" valueReference="1" causality="input" intervalVariability="triggered"/>'
        "</ModelVariables><ModelStructure/></fmiModelDescription>"
    )
    return Table("Clocks", 3, (), (), xml=xml).write(folder)


def ticking(folder: Path) -> Path:
    """Write a co-simulation FMU of FMI 3.0 with a clock and binary variables that others may be connected to."""
    ends = "".join(
        f'<Binary name="{name}" valueReference="{reference}" causality="{causality}" variability="discrete">{start}'
        "</Binary>"
        for name, reference, causality, start in (
            ("sent", 20, "output", ""), ("received", 21, "input", '<Start value="00"/>'),
        )
    )  # fmt: skip
    xml = (
        '<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="3.0" modelName="Ticking" '
        'instantiationToken="Early"><CoSimulation modelIdentifier="table" '
        'canHandleVariableCommunicationStepSize="true"/><ModelVariables>'
        '<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>'
        '<Float64 name="y" valueReference="1" causality="output" variability="continuous"/>'
        f'<Clock name="clock1" valueReference="2" causality="input" intervalVariability="triggered"/>{ends}'
        '</ModelVariables><ModelStructure><Output valueReference="1" dependencies=""/>'
        '<InitialUnknown valueReference="1"/></ModelStructure></fmiModelDescription>'
    )
    return Table("Ticking", 3, (), (), source=SOURCE, token="Early", xml=xml).write(folder)


__all__ = ["clocks", "library", "reference_fmu", "state_space", "ticking"]
