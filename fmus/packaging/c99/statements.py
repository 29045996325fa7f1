"""Statements of a kernel in C, and the types of its variables. No files."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from typing import Any, ClassVar

from .expressions import Expressions, variable
from .values import ARRAY, NOTHING, NUMBERS, REAL, WHOLE, Type, Value, join, member, name_of


class Statements(Expressions):
    """The body of one kernel: walked again and again until the types of its variables no longer change."""

    result: Type = NOTHING

    def block(self, statements: Iterable[ast.stmt]) -> None:
        """Translate statements."""
        for node in statements:
            self.want(type(node) in self._STATEMENTS, node)
            self._STATEMENTS[type(node)](self, node)

    def _indented(self, statements: Iterable[ast.stmt]) -> None:
        self.depth += 1
        self.block(statements)
        self.depth -= 1

    def store(self, target: ast.expr, value: Value) -> None:
        """Assign a value to a name, an element of an array, or the names of a tuple."""
        if isinstance(target, ast.Tuple) and isinstance(value.type, tuple) and len(target.elts) == len(value.type):
            kept = self.named(value)
            for k, item in enumerate(target.elts):
                self.store(item, member(kept, k))
        elif isinstance(target, ast.Subscript):
            place = self.value(target)
            self.want(self.value(target.value).type == ARRAY and value.type in NUMBERS, target)
            self.emit(f"{place.text} = {value.text};")
        else:
            self.want(isinstance(target, ast.Name) and value.type != NOTHING, target, "this assignment")
            self._store_name(target, value)

    def _store_name(self, target: Any, value: Value) -> None:
        if target.id == "_":
            return
        known = self.types.get(target.id, value.type)
        kind = join(known, value.type)
        self.want(kind, target, f"{target.id}, which is {name_of(known)} and {name_of(value.type)},")
        self.types[target.id] = kind or known
        self.emit(f"{variable(target.id)} = {self.convert(value, self.types[target.id], target)};")

    def _assign(self, node: ast.Assign) -> None:
        target = node.targets[0]
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple) and len(node.targets) == 1:
            self.want(len(target.elts) == len(node.value.elts), node)
            values = [self.value(item) for item in node.value.elts]
            kept = [v if v.known is not None else self.keep(v) for v in values]  # all are read before one is written
            for item, value in zip(target.elts, kept, strict=True):
                self.store(item, value)
            return
        value = self.value(node.value)
        if len(node.targets) > 1 and value.known is None:
            value = self.keep(value)
        for target in node.targets:
            self.store(target, value)

    def _assign_more(self, node: ast.AugAssign) -> None:
        before = ast.parse(ast.unparse(node.target), mode="eval").body
        self.store(node.target, self.value(ast.copy_location(ast.BinOp(before, node.op, node.value), node)))

    def _for(self, node: ast.For) -> None:
        call = node.iter
        self.want(isinstance(call, ast.Call) and ast.unparse(call.func) == "range" and not node.orelse, call)
        bounds = [self.number(a, whole=True) for a in getattr(call, "args", [])]
        begin, end = bounds[:2] if len(bounds) > 1 else (Value(WHOLE, "0"), bounds[0])
        step = bounds[2] if len(bounds) > 2 else Value(WHOLE, "1", known=1)
        self.want(step.known, node, "a range with an unknown step")
        i, n = self.fresh("i"), self.fresh("n")
        sign = "<" if step.known > 0 else ">"
        self.emit(f"for (int64_t {i} = {begin.text}, {n} = {end.text}; {i} {sign} {n}; {i} += {step.text}) {{")
        self.depth += 1
        self.store(node.target, Value(WHOLE, i))
        self.block(node.body)
        self.depth -= 1
        self.emit("}")

    def _while(self, node: ast.While) -> None:
        self.want(not node.orelse, node)
        self.emit(f"while ({self.condition(node.test).text}) {{")
        self._indented(node.body)
        self.emit("}")

    def _if(self, node: ast.If, word: str = "if") -> None:
        self.emit(f"{word} ({self.condition(node.test).text}) {{")
        self._indented(node.body)
        if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
            self._if(node.orelse[0], "} else if")
            return
        if node.orelse:
            self.emit("} else {")
            self._indented(node.orelse)
        self.emit("}")

    def _return(self, node: ast.Return) -> None:
        if node.value is None:
            self.emit("return;")
            return
        value = self.value(node.value)
        kind = value.type if self.result == NOTHING else join(self.result, value.type)
        self.want(kind, node, f"a result that is {name_of(self.result)} and {name_of(value.type)}")
        self.result = kind or NOTHING
        self.emit(f"return {self.convert(value, self.result, node)};")

    def _expression(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            self.emit(f"{self.value(node.value).text};")
        else:
            self.want(isinstance(node.value, ast.Constant) and isinstance(node.value.value, str), node)

    def _word(self, node: ast.Break | ast.Continue | ast.Pass) -> None:
        self.emit({ast.Break: "break;", ast.Continue: "continue;", ast.Pass: ";"}[type(node)])

    _STATEMENTS: ClassVar[dict[type[ast.stmt], Callable[..., Any]]] = {
        **{ast.Assign: _assign, ast.AugAssign: _assign_more, ast.For: _for, ast.While: _while, ast.If: _if},
        **{ast.Return: _return, ast.Expr: _expression, ast.Break: _word, ast.Continue: _word, ast.Pass: _word},
    }


def declarations(types: dict[str, Type]) -> list[str]:
    """Return the declarations of variables."""
    zero = {REAL: "0.0", ARRAY: "{0}"} | {kind: "0" for kind in NUMBERS if kind != REAL}
    return [
        f"    {name_of(kind)} {variable(n)} = {zero.get(kind, '{0}') if isinstance(kind, str) else '{0}'};"
        for n, kind in types.items()
    ]
