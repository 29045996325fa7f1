"""Kernels in, one C99 file out: each kernel becomes a function for the types that it is called with.

The subset is what kernels are made of: whole and real numbers, truth values, tuples of these, flat arrays and pieces of
them, loops over ranges, `math`, and calls of other kernels; names of the module are constants. Types follow from those
of the arguments. Everything else is refused with its place. An index is taken as it is: one that is not a literal must
not be negative.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Mapping
from types import FunctionType
from typing import Any

import numpy as np

from .expressions import TranslationError, variable
from .statements import Statements, declarations
from .values import ARRAY, NOTHING, PRELUDE, REAL, Function, Type, Value, definition, literal, name_of, table, type_of


class Program:
    """The functions, constants and tuple types of one C file."""

    def __init__(self) -> None:
        self._functions: dict[tuple[FunctionType, tuple[Type, ...]], Function | None] = {}
        self._names: dict[str, int] = {}
        self._constants: dict[str, tuple[Any, str]] = {}
        self._tuples: dict[tuple[Type, ...], None] = {}

    def function(self, function: FunctionType, arguments: tuple[Type, ...], error: TranslationError) -> Function:
        """Return a kernel for the types of its arguments; `error` is raised if it cannot be called so."""
        key = (function, arguments)
        if key not in self._functions:
            if len(inspect.signature(function).parameters) != len(arguments):
                raise error
            self._functions[key] = None  # under way
            self._functions[key] = self._translate(function, arguments)
        found = self._functions[key]
        if found is None:  # it calls itself
            raise error
        return found

    def _translate(self, function: FunctionType, arguments: tuple[Type, ...]) -> Function:
        tree: Any = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        names = [a.arg for a in tree.args.args]
        before: tuple[dict[str, Type], Type] = {}, NOTHING
        body = Statements(self, function, dict(zip(names, arguments, strict=True)))
        while before != (body.types, body.result):
            before = dict(body.types), body.result
            body = Statements(self, function, dict(body.types))
            body.result = before[1]
            body.block(tree.body)
        for kind in (*body.types.values(), body.result):
            if isinstance(kind, tuple):
                self.tuple_type(kind)
        name = f"{function.__module__.partition('.')[2]}_{function.__name__}".replace(".", "_")
        self._names[name] = self._names.get(name, 0) + 1
        name += f"_{self._names[name]}" * (self._names[name] > 1)
        used = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}
        head = ", ".join(f"{name_of(body.types[n])} {variable(n)}" for n in names)
        lines = [
            f"/* {(ast.get_docstring(tree) or name).splitlines()[0]} */",
            f"static {name_of(body.result)} {name}({head}) {{",
            *(f"    (void){n};" for n in names if n not in used),
            *declarations({n: kind for n, kind in body.types.items() if n not in names}),
            *body.lines,
            "}",
        ]
        parameters = tuple(body.types[n] for n in names)
        return Function(name, parameters, body.result, "\n".join(lines), tuple(body.calls))

    def tuple_type(self, kind: tuple[Type, ...]) -> None:
        """Define a tuple's type, after those of its items."""
        for item in kind:
            if isinstance(item, tuple):
                self.tuple_type(item)
        self._tuples.setdefault(kind)

    def constant(self, name: str, value: Any) -> Value:
        """Return a constant of a module by its name in C."""
        while name in self._constants and not np.array_equal(self._constants[name][0], value):
            name += "_"
        kind, text = type_of(value) or ARRAY, name
        if isinstance(value, np.ndarray):
            shape = "".join(f"[{n}]" for n in value.shape)
            line = f"static const double {name}{shape} = {table(value.tolist())};"
            text = name if value.ndim > 1 else f"((Array){{(double *){name}, {value.size}}})"
        elif isinstance(kind, tuple):
            self.tuple_type(kind)
            line = f"static const {name_of(kind)} {name} = {{{table(value)}}};"
        else:
            line = f"#define {name} {literal(value).text}"
        self._constants[name] = (value, line)
        return Value(kind, text, known=value)

    def text(self, entries: list[Function]) -> str:
        """Return the C file: types, constants, and the functions that `entries` need, each after those it calls."""
        order: dict[Function, None] = {}

        def add(function: Function) -> None:
            for each in function.calls:
                add(each)
            order.setdefault(function)

        for entry in entries:
            add(entry)
        constants = sorted(line for _, line in self._constants.values())
        return "\n".join([PRELUDE, *map(definition, self._tuples), "", *constants, *(f"\n{f.text}" for f in order), ""])


ENTRIES = {
    "initialise": ((), "", ""),
    "do_step": ((REAL,), ", double step", ", step"),
    "differentiate": (
        (REAL, ARRAY, ARRAY),
        ", double step, double *seed, double *sensitivity",
        ", step, (Array){seed, a[3].size}, (Array){sensitivity, a[4].size}",
    ),
}
"""Types of further arguments of each kernel, parameters of its entry point and what that hands on."""


def translate(kernels: Mapping[str, Any], sizes: list[int]) -> str:
    """Return the C file of a component's kernels, with the entry points `curvesqueal_NAME` that instance.h declares.

    Parameters
    ----------
    kernels : 'initialise', 'do_step' and, where there is one, 'differentiate'
    sizes : lengths of parameters, derived, state, inputs and outputs, one after the other in the memory

    Raises
    ------
    TranslationError
        For a kernel outside the subset.
    """
    program = Program()
    arrays = ", ".join(f"{{memory + {sum(sizes[:k])}, {n}}}" for k, n in enumerate(sizes))
    functions, entries = [], []
    for name, kernel in kernels.items():
        more, parameters, values = ENTRIES[name]
        arguments: tuple[Type, ...] = (*(ARRAY,) * len(sizes), *more)
        error = TranslationError(f"{name}: unexpected parameters")
        functions.append(program.function(getattr(kernel, "py_func", kernel), arguments, error))
        head = f"KERNEL int32_t curvesqueal_{name}(void **result, void **error, double *memory{parameters})"
        entries.append(
            f"\n{head};\n\n{head} {{\n    const Array a[5] = {{{arrays}}};\n    (void)result;\n    (void)error;\n"
            f"    {functions[-1].name}(a[0], a[1], a[2], a[3], a[4]{values});\n    return 0;\n}}\n"
        )
    head = "/* Translated from the Python source of the kernels. */\n#ifndef KERNEL\n#define KERNEL\n#endif\n"
    return head + program.text(functions) + "".join(entries)
