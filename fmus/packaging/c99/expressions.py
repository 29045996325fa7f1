"""Expressions of a kernel in C; what is not in the subset is refused. No statements, no files."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from types import FunctionType
from typing import Any, ClassVar, Protocol

import numpy as np

from .values import (
    ARRAY,
    NUMBERS,
    REAL,
    TRUTH,
    WHOLE,
    Function,
    Type,
    Value,
    join,
    literal,
    member,
    name_of,
    pack,
    type_of,
)

MATHEMATICS = {
    *("acos", "asin", "atan", "atan2", "ceil", "cos", "cosh", "exp", "expm1", "fabs", "floor", "fmod", "hypot", "log"),
    *("log1p", "log10", "pow", "sin", "sinh", "sqrt", "tan", "tanh"),
}
"""Functions of Python's `math` that C's has under the same name."""

RESERVED = MATHEMATICS | {
    *("auto", "case", "char", "const", "default", "do", "double", "enum", "extern", "float", "goto", "inline", "int"),
    *("long", "register", "restrict", "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union"),
    *("unsigned", "void", "volatile"),
}
"""Names that no variable may have."""

ARITHMETIC = {ast.Add: ("+", 6), ast.Sub: ("-", 6), ast.Mult: ("*", 7), ast.Div: ("/", 7)}
ORDER = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
PREFIX, COMPARISON, BOTH, EITHER, CHOICE = 8, 5, 4, 3, 2
"""How tightly the other operators bind."""


class TranslationError(ValueError):
    """A kernel holds something that has no translation."""


class Program(Protocol):
    """What an expression needs of the file that it goes into; see `translator.Program`."""

    def function(self, function: FunctionType, arguments: tuple[Type, ...], error: TranslationError) -> Function:
        """Return a kernel for the types of its arguments."""

    def tuple_type(self, kind: tuple[Type, ...]) -> None:
        """Define a tuple's type."""

    def constant(self, name: str, value: Any) -> Value:
        """Return a constant of a module by its name in C."""


def label(node: ast.expr) -> str:
    """Return the name in C of a name of a module."""
    return ast.unparse(node).replace(".", "_").lstrip("_")


def variable(name: str) -> str:
    """Return the name in C of a variable."""
    return name + "_" * (name in RESERVED)


class Expressions:
    """Expressions of one kernel, given the types of its variables; statements before them go into `lines`."""

    def __init__(self, program: Program, function: FunctionType, types: dict[str, Type]) -> None:
        self.program = program
        self.function = function
        self.types = types
        self.lines: list[str] = []
        self.calls: list[Any] = []
        self.depth = 1
        self.kept = 0

    def error(self, node: ast.AST, what: str) -> TranslationError:
        """Return the error about a place in the source."""
        line = self.function.__code__.co_firstlineno + getattr(node, "lineno", 1) - 1
        place = f"{self.function.__module__}.{self.function.__qualname__}, line {line}"
        return TranslationError(f"{place}: {what} cannot be translated to C; kernels are loops, math and flat arrays")

    def want(self, holds: object, node: ast.AST, what: str = "") -> None:
        """Raise an error about a place unless a condition holds."""
        if not holds:
            raise self.error(node, what or ast.unparse(node))

    def emit(self, text: str) -> None:
        """Add a line."""
        self.lines.append("    " * self.depth + text)

    def fresh(self, letter: str) -> str:
        """Return the name of a new variable."""
        self.kept += 1
        return f"{letter}_{self.kept}_"

    def keep(self, value: Value) -> Value:
        """Return a value under a name of its own."""
        name = self.fresh("kept")
        self.emit(f"const {name_of(value.type)} {name} = {value.text};")
        return Value(value.type, name)

    def named(self, value: Value) -> Value:
        """Return a value that can be read more than once."""
        return value if value.text.replace(".", "_").isidentifier() else self.keep(value)

    def at_once(self, node: ast.expr) -> Value:
        """Return an expression that needs no statement before it: it may not be evaluated, or more than once."""
        before = len(self.lines)
        value = self.value(node)
        self.want(len(self.lines) == before, node, "a tuple that is taken apart in a condition")
        return value

    def convert(self, value: Value, wanted: Type, node: ast.AST) -> str:
        """Return a value as another type that holds it."""
        self.want(join(value.type, wanted) == wanted, node, f"{name_of(value.type)} as {name_of(wanted)}")
        if isinstance(wanted, str) or value.type == wanted:
            return value.text
        kept = self.named(value)
        return pack([self.convert(member(kept, k), part, node) for k, part in enumerate(wanted)], wanted)

    def condition(self, node: ast.expr) -> Value:
        """Return an expression as a truth value."""
        value = self.at_once(node)
        self.want(value.type in NUMBERS, node)
        return value if value.type == TRUTH else Value(TRUTH, f"{value.within(COMPARISON + 1)} != 0", COMPARISON)

    def number(self, node: ast.expr, whole: bool = False) -> Value:
        """Return an expression that is a number."""
        value = self.value(node)
        wanted = (WHOLE,) if whole else NUMBERS
        self.want(value.type in wanted, node, f"{ast.unparse(node)}, which is {name_of(value.type)} here,")
        return value

    def value(self, node: ast.expr) -> Value:
        """Return an expression in C."""
        self.want(type(node) in self._HANDLERS, node)
        return self._HANDLERS[type(node)](self, node)

    def _constant(self, node: ast.Constant) -> Value:
        self.want(isinstance(node.value, bool | int | float), node)
        return literal(node.value)

    def known(self, node: ast.expr) -> Any:
        """Return the Python value of a name of the module or of an attribute of one; None if it is not known."""
        if isinstance(node, ast.Attribute):
            return getattr(self.known(node.value), node.attr, None)
        return self.function.__globals__.get(node.id) if isinstance(node, ast.Name) else None

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.types:
            return Value(self.types[node.id], variable(node.id))
        return self._module_name(node)

    def _attribute(self, node: ast.Attribute) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id not in self.types:
            return self._module_name(node)
        base = self.value(node.value)
        self.want(node.attr == "size" and base.type == ARRAY, node)
        return Value(WHOLE, f"{base.text}.size")

    def _module_name(self, node: ast.expr) -> Value:
        known = self.known(node)
        self.want(isinstance(known, np.ndarray) or type_of(known) is not None, node, f"the name {ast.unparse(node)}")
        return self.program.constant(label(node), known)

    def _tuple(self, node: ast.Tuple) -> Value:
        self.want(node.elts, node)
        items = [self.value(item) for item in node.elts]
        kind = tuple(item.type for item in items)
        self.program.tuple_type(kind)
        return Value(kind, pack([item.text for item in items], kind))

    def _subscript(self, node: ast.Subscript) -> Value:
        base = self.value(node.value)
        if isinstance(base.known, np.ndarray) and base.known.ndim > 1:
            places = node.slice.elts if isinstance(node.slice, ast.Tuple) else []
            self.want(len(places) == base.known.ndim, node)
            return Value(REAL, base.text + "".join(f"[{self.number(p, whole=True).text}]" for p in places))
        if isinstance(node.slice, ast.Slice):
            return self._slice(node, base, node.slice)
        index = self.number(node.slice, whole=True)
        if base.type == ARRAY:
            end = f"{base.text}.size - " if (index.known or 0) < 0 else ""
            return Value(REAL, f"{base.text}.at[{end}{abs(index.known) if end else index.text}]")
        self.want(isinstance(base.type, tuple), node)
        if index.known is not None:
            return member(self.named(base), range(len(base.type))[index.known])
        self.want(len(set(base.type)) == 1, node, "a variable index into a tuple of several types")
        return Value(base.type[0], f"{self.named(base).text}.at[{index.text}]")

    def _slice(self, node: ast.Subscript, base: Value, part: ast.Slice) -> Value:
        self.want(base.type == ARRAY and part.step is None, node)
        begin = self.number(part.lower, whole=True).text if part.lower else "0"
        end = self.number(part.upper, whole=True).text if part.upper else f"{base.text}.size"
        return Value(ARRAY, f"piece({base.text}, {begin}, {end})")

    def _binary(self, node: ast.BinOp) -> Value:
        left, right = self.number(node.left), self.number(node.right)
        whole = REAL not in (left.type, right.type)
        if type(node.op) in ARITHMETIC:
            sign, level = ARITHMETIC[type(node.op)]
            first = f"(double){left.within(PREFIX)}" if sign == "/" and whole else left.within(level)
            return Value(WHOLE if whole and sign != "/" else REAL, f"{first} {sign} {right.within(level + 1)}", level)
        if isinstance(node.op, ast.Pow) and not whole:
            return Value(REAL, f"pow({left.text}, {right.text})")
        helper = {ast.FloorDiv: "floor_div", ast.Mod: "modulo"}.get(type(node.op))
        self.want(helper and whole, node, f"{ast.unparse(node)} of {name_of(left.type)} and {name_of(right.type)}")
        return Value(WHOLE, f"{helper}({left.text}, {right.text})")

    def _unary(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value(TRUTH, f"!{self.condition(node.operand).within(PREFIX)}", PREFIX)
        self.want(isinstance(node.op, ast.USub), node)
        operand = self.number(node.operand)
        known = None if operand.known is None else -operand.known
        return Value(join(operand.type, WHOLE) or REAL, f"-{operand.within(PREFIX + 1)}", PREFIX, known)

    def _compare(self, node: ast.Compare) -> Value:
        terms = [self.at_once(term) for term in (node.left, *node.comparators)]
        self.want(all(t.type in NUMBERS for t in terms) and all(type(op) in ORDER for op in node.ops), node)
        sides = [term.within(COMPARISON + 1) for term in terms]
        parts = [f"{a} {ORDER[type(op)]} {b}" for a, op, b in zip(sides, node.ops, sides[1:], strict=False)]
        return Value(TRUTH, " && ".join(parts), BOTH if len(parts) > 1 else COMPARISON)

    def _boolean(self, node: ast.BoolOp) -> Value:
        level, sign = (BOTH, " && ") if isinstance(node.op, ast.And) else (EITHER, " || ")
        return Value(TRUTH, sign.join(self.condition(term).within(COMPARISON) for term in node.values), level)

    def _choice(self, node: ast.IfExp) -> Value:
        test, yes, no = self.condition(node.test), self.at_once(node.body), self.at_once(node.orelse)
        kind = join(yes.type, no.type)
        self.want(kind and (kind in NUMBERS or yes.type == no.type), node)
        return Value(kind or REAL, f"{test.within(CHOICE + 1)} ? {yes.text} : {no.within(CHOICE)}", CHOICE)

    def _call(self, node: ast.Call) -> Value:
        self.want(not node.keywords, node, "a call with keywords")
        arguments = [self.value(a) for a in node.args]
        name = ast.unparse(node.func)
        function = self.known(node.func)
        if function is None and name in self._BUILTINS:
            return self._BUILTINS[name](self, node, arguments)
        word = getattr(function, "__name__", "")
        if word in MATHEMATICS and function is getattr(math, word):
            return Value(REAL, f"{word}({', '.join(self.number(a).text for a in node.args)})")
        function = getattr(function, "py_func", function)
        self.want(isinstance(function, FunctionType), node, f"a call of {name}")
        called = self.program.function(
            function, tuple(a.type for a in arguments), self.error(node, f"this call: {name}")
        )
        self.calls.append(called)
        texts = [self.convert(a, t, node) for a, t in zip(arguments, called.parameters, strict=True)]
        return Value(called.result, f"{called.name}({', '.join(texts)})")

    def _extreme(self, node: ast.Call, values: list[Value]) -> Value:
        self.want(len(values) > 1 and all(v.type in NUMBERS for v in values), node)
        kind = REAL if any(v.type == REAL for v in values) else WHOLE
        text = values[0].text
        for v in values[1:]:
            text = f"{ast.unparse(node.func)}_{'real' if kind == REAL else 'whole'}({text}, {v.text})"
        return Value(kind, text)

    def _absolute(self, node: ast.Call, values: list[Value]) -> Value:
        self.want(len(values) == 1 and values[0].type in NUMBERS, node)
        kind, function = (REAL, "fabs") if values[0].type == REAL else (WHOLE, "abs_whole")
        return Value(kind, f"{function}({values[0].text})")

    def _cast(self, node: ast.Call, values: list[Value]) -> Value:
        self.want(len(values) == 1 and values[0].type in NUMBERS, node)
        kind = {"int": WHOLE, "float": REAL, "bool": TRUTH}[ast.unparse(node.func)]
        return Value(kind, f"({kind}){values[0].within(PREFIX)}", PREFIX)

    def _length(self, node: ast.Call, values: list[Value]) -> Value:
        self.want(values[0].type == ARRAY or isinstance(values[0].type, tuple), node)
        return Value(WHOLE, f"{values[0].text}.size") if values[0].type == ARRAY else literal(len(values[0].type))

    _BUILTINS: ClassVar[dict[str, Callable[..., Value]]] = {
        **{"min": _extreme, "max": _extreme, "abs": _absolute, "len": _length},
        **{"int": _cast, "float": _cast, "bool": _cast},
    }
    _HANDLERS: ClassVar[dict[type[ast.expr], Callable[..., Value]]] = {
        **{ast.Constant: _constant, ast.Name: _name, ast.Attribute: _attribute, ast.Tuple: _tuple},
        **{ast.Subscript: _subscript, ast.BinOp: _binary, ast.UnaryOp: _unary, ast.Compare: _compare},
        **{ast.BoolOp: _boolean, ast.IfExp: _choice, ast.Call: _call},
    }
