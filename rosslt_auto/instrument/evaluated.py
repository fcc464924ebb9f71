"""Literals that plain code has evaluated already: default arguments, class attributes, globals.

What such a name holds is replaced where it still is what its literals make: the same type and
value as the expression gives that stands there - a literal, arithmetic of literals, or a tuple,
list or dict of them - and no other statement of that body binds the name. Whatever else has been
computed from them meanwhile stays plain.
"""

from __future__ import annotations

import ast
import operator
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from types import FunctionType
from typing import Any

from ..provenance.registry import registered
from ..provenance.values import is_tracked, untracked

_OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Pow: operator.pow,
    ast.Div: operator.truediv, ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod,
    ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
_BODIES = (*_FUNCTIONS, ast.ClassDef)


class _Unknown(Exception):
    """An expression that is not made of literals alone."""


class Evaluated:
    """What the rewritten tree of a module says of names that have been bound already."""

    def __init__(self, tree: ast.Module, table: str) -> None:
        self.tree = tree
        self.table = table
        self.literals = next((one for one in registered() if one.name == table), None)
        self.functions: dict[tuple[str, int], list[Any]] = {}
        self.classes: dict[str, list[ast.ClassDef]] = {}
        self._index(tree, "")

    def _index(self, node: ast.AST, prefix: str) -> None:
        for child in ast.iter_child_nodes(node):
            below = prefix
            if isinstance(child, _FUNCTIONS):
                name = getattr(child, "name", "<lambda>")
                decorators = getattr(child, "decorator_list", ())
                line = decorators[0].lineno if decorators else child.lineno
                self.functions.setdefault((name, line), []).append(child)
                below = f"{prefix}{name}.<locals>."
            elif isinstance(child, ast.ClassDef):
                self.classes.setdefault(prefix + child.name, []).append(child)
                below = f"{prefix}{child.name}."
            self._index(child, below)

    # ------------------------------------------------------------ places

    def track_defaults(self, function: FunctionType) -> None:
        """Replaces default arguments of a function that stands in the module."""
        code = function.__code__
        nodes = self.functions.get((code.co_name, code.co_firstlineno), ())
        if len(nodes) != 1:  # lambdas on one line
            return
        args = nodes[0].args
        defaults = function.__defaults__ or ()
        if len(defaults) == len(args.defaults):
            _set_defaults(function, map(self.tracked, defaults, args.defaults))
        keywords = function.__kwdefaults__ or {}
        for arg, node in zip(args.kwonlyargs, args.kw_defaults, strict=True):
            if node is not None and arg.arg in keywords:
                keywords[arg.arg] = self.tracked(keywords[arg.arg], node)

    def track_attributes(self, cls: type) -> None:
        """Replaces attributes of a class that stands in the module, and what was made of them."""
        nodes = self.classes.get(cls.__qualname__, ())
        if len(nodes) != 1:
            return
        for name, node in _bound_once(nodes[0].body):
            if name.startswith("__") and not name.endswith("__"):
                name = f"_{cls.__name__.lstrip('_')}{name}"
            if name in vars(cls):
                old = vars(cls)[name]
                new = self.tracked(old, node)
                if new is not old:
                    type.__setattr__(cls, name, new)
            self._track_generated(cls, name, node)

    def _track_generated(self, cls: type, name: str, node: ast.expr) -> None:
        """What dataclasses, named tuples and the like have made of an attribute."""
        field = getattr(cls, "__dataclass_fields__", {}).get(name)
        if field is not None:
            field.default = self.tracked(field.default, node)
        named = vars(cls).get("_field_defaults", {})
        if name in named:
            named[name] = self.tracked(named[name], node)
        for method in ("__init__", "__new__"):
            function = vars(cls).get(method)
            function = getattr(function, "__func__", function)
            if type(function) is FunctionType and not self._stands_here(function):
                self._track_parameter(function, name, node)

    def _stands_here(self, function: FunctionType) -> bool:
        code = function.__code__
        return (code.co_name, code.co_firstlineno) in self.functions

    def _track_parameter(self, function: FunctionType, name: str, node: ast.expr) -> None:
        code = function.__code__
        defaults, keywords = function.__defaults__ or (), function.__kwdefaults__ or {}
        names = code.co_varnames[: code.co_argcount][code.co_argcount - len(defaults) :]
        if name in names:
            _set_defaults(
                function,
                (
                    self.tracked(value, node) if name == own else value
                    for own, value in zip(names, defaults, strict=True)
                ),
            )
        elif name in keywords:
            keywords[name] = self.tracked(keywords[name], node)

    def track_globals(self, names: dict[str, Any]) -> None:
        """Replaces what is bound in the module's namespace."""
        elsewhere = {
            name
            for statement in ast.walk(self.tree)
            if isinstance(statement, ast.Global)
            for name in statement.names
        }
        for name, node in _bound_once(self.tree.body):
            if name in names and name not in elsewhere:
                names[name] = self.tracked(names[name], node)

    # ------------------------------------------------------------ values

    def tracked(self, value: Any, node: ast.expr) -> Any:
        """`value` with provenance, if it is what `node` makes; else as it is."""
        kind = type(value)
        if kind is tuple and isinstance(node, ast.Tuple) and len(value) == len(node.elts):
            items = tuple(map(self.tracked, value, node.elts))
            return value if all(map(operator.is_, items, value)) else items
        if kind is list and isinstance(node, ast.List) and len(value) == len(node.elts):
            value[:] = map(self.tracked, value, node.elts)
        elif kind is dict and isinstance(node, ast.Dict):
            for key, item in zip(node.keys, node.values, strict=True):
                if isinstance(key, ast.Constant) and key.value in value:
                    value[key.value] = self.tracked(value[key.value], item)
        elif kind in (float, int, str) and not is_tracked(value):
            try:
                first, now = self._made_by(node)
            except (_Unknown, ArithmeticError, TypeError, ValueError):
                return value
            if type(first) is kind and repr(first) == repr(value) and is_tracked(now):
                return now if type(untracked(now)) is kind else value
        return value

    def _made_by(self, node: ast.expr) -> tuple[Any, Any]:
        """What an expression of literals gave when they were as in the file, and gives now."""
        if isinstance(node, ast.Constant):
            return node.value, node.value
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
            index = getattr(node.slice, "value", None)
            if node.value.id == self.table and isinstance(index, int):
                return self._literal(index)
        elif isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
            operate = _OPERATORS[type(node.op)]
            (left, left_now), (right, right_now) = (
                self._made_by(node.left),
                self._made_by(node.right),
            )
            return operate(left, right), operate(left_now, right_now)
        elif isinstance(node, ast.UnaryOp) and type(node.op) in _OPERATORS:
            value, now = self._made_by(node.operand)
            return _OPERATORS[type(node.op)](value), _OPERATORS[type(node.op)](now)
        elif isinstance(node, ast.Call):
            for keyword in node.keywords:
                if keyword.arg == "default":  # a dataclass's field(default=0.5)
                    return self._made_by(keyword.value)
        raise _Unknown

    def _literal(self, index: int) -> tuple[Any, Any]:
        assert self.literals is not None
        location = self.literals.location(index)
        return location.first, location.leaf


def _set_defaults(function: FunctionType, values: Iterable[Any]) -> None:
    new = tuple(values)
    if function.__defaults__ is not None and not all(map(operator.is_, new, function.__defaults__)):
        function.__defaults__ = new


def _bound_once(body: list[ast.stmt]) -> Iterator[tuple[str, ast.expr]]:
    """Names that one statement of a body alone binds, and what expressions they are bound to."""
    bound: list[tuple[str, ast.expr]] = []
    for statement in body:
        if isinstance(statement, ast.Assign):
            for target in statement.targets:
                bound += _targets(target, statement.value)
        elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
            bound += _targets(statement.target, statement.value)
    counts = Counter(_names_bound_in(body))
    for name, value in bound:
        if counts[name] == 1:
            yield name, value


def _targets(target: ast.expr, value: ast.expr) -> list[tuple[str, ast.expr]]:
    if isinstance(target, ast.Name):
        return [(target.id, value)]
    if isinstance(target, ast.Tuple) and isinstance(value, (ast.Tuple, ast.List)):
        parts = [*target.elts, *value.elts]
        if len(target.elts) == len(value.elts) and not any(
            isinstance(part, ast.Starred) for part in parts
        ):
            pairs = zip(target.elts, value.elts, strict=True)
            return [found for pair in pairs for found in _targets(*pair)]
    return []


def _names_bound_in(body: list[ast.stmt]) -> Iterator[str]:
    stack: list[ast.AST] = list(body)
    while stack:
        node = stack.pop()
        if isinstance(node, ast.Name):
            if not isinstance(node.ctx, ast.Load):
                yield node.id
        elif isinstance(node, _BODIES):
            yield getattr(node, "name", "")
        else:
            stack += ast.iter_child_nodes(node)


__all__ = ["Evaluated"]
