"""How commands change a system, the same for all: `--set`, `--replace`, `--rail`, `--wheel`, `--damp`, `--friction`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any

import typer

from fmus.contact.friction.named import NAMED

from ..errors import InputError
from ..fmi.instance import Value
from ..runs.changes import Changes
from ..system.friction import FRICTION

System = Annotated[
    str,
    typer.Argument(metavar="CASE|FILE", help="case1 to case4, inferred1 to inferred4, an .ssp, .ssd or .fmu file."),
]
Texts = list[str] | None

WheelOption = Annotated[
    str | None,
    typer.Option(
        help="Wheel, with its contact stiffness: class158, inferred, generic840, straight840, a .toml file or an FMU."
    ),
]

OPTIONS: dict[str, Any] = {
    "values": Annotated[Texts, typer.Option("--set", help="Parameter, such as contact.mu0=0.35. Repeatable.")],
    "replace": Annotated[Texts, typer.Option(help="Other FMU in a place: rail=FILE.fmu. Repeatable.")],
    "rail": Annotated[
        str | None, typer.Option(help="Rail: a track such as soft-pads, fitted once and kept, a track file or an FMU.")
    ],
    "wheel": WheelOption,
    "damp": Annotated[
        Texts,
        typer.Option(help="Damping by label: '(3,0)=1e-3', '(*,0)=+1e-4', 'wheel=x2', 'rail:lat 1=0.2'. Repeatable."),
    ],
    "friction": Annotated[
        str | None,
        typer.Option(help=f"Friction law of the contact: {', '.join(NAMED)}, or a CSV file of creepage and friction."),
    ],
}
"""Name of an argument: its option. None is the default of each."""


def changes_system(command: Callable[..., None], **others: Any) -> Callable[..., None]:
    """Return a command that takes `OPTIONS` where its argument `changes` stands, and is given `Changes`.

    Parameters
    ----------
    command : a command with an argument `changes`
    others : options that take the place of those of `OPTIONS`, by name
    """
    return with_options(command, "changes", {**OPTIONS, **others}, changes_of)


def with_options(
    command: Callable[..., None], argument: str, options: dict[str, Any], made: Callable[..., Any]
) -> Callable[..., None]:
    """Return a command that takes options where one of its arguments stands, and is given what they mean.

    Parameters
    ----------
    command : a command
    argument : of `command`, that the options take the place of
    options : by name; the default of each is None
    made : called with all options by name, returns the argument
    """
    own = signature(command, eval_str=True).parameters

    @wraps(command)
    def called(**given: Any) -> None:
        value = made(**{name: given.pop(name, None) for name in options})
        command(**given, **{argument: value})

    shown: list[Parameter] = []
    for parameter in own.values():
        if parameter.name != argument:
            shown.append(parameter)
            continue
        shown += [Parameter(n, Parameter.KEYWORD_ONLY, default=None, annotation=a) for n, a in options.items()]
    keyword = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in shown]
    called.__signature__ = signature(command).replace(parameters=keyword, return_annotation=None)  # type: ignore[attr-defined]
    called.__annotations__ = {p.name: p.annotation for p in keyword}
    return called


def changes_of(
    values: Texts, replace: Texts, rail: str | None, wheel: str | None, damp: Texts, friction: str | None = None
) -> Changes:
    """Return the changes that the options name."""
    given = parse_values(values or [])
    if friction is not None:
        given.setdefault("contact", {})[FRICTION] = friction
    return Changes(given, parse_sources(replace or []), rail, wheel, tuple(damp or []))


def parse_values(texts: Iterable[str]) -> dict[str, dict[str, Value]]:
    """Return parameter values of texts such as 'contact.mu0=0.35'."""
    values: dict[str, dict[str, Value]] = {}
    for text in texts:
        match = re.fullmatch(r"([^.=\s]+)\.([^=\s]+)=(.+)", text)
        if match is None:
            raise InputError(f"--set {text}: must be COMPONENT.PARAMETER=VALUE, such as contact.mu0=0.35")
        component, name, value = match.groups()
        values.setdefault(component, {})[name] = value
    return values


def parse_sources(texts: Iterable[str]) -> dict[str, Path]:
    """Return replacements of texts such as 'rail=my-rail.fmu'."""
    sources = {}
    for text in texts:
        name, separator, file = text.partition("=")
        if not (name and separator and file):
            raise InputError(f"--replace {text}: must be COMPONENT=FILE.fmu, such as rail=my-rail.fmu")
        sources[name] = Path(file)
    return sources
