"""Which operators the rewriter turns into calls of the functions of `arithmetic`.

Those whose right operand is an int literal, or a name that the program binds to one: ``x * 2``,
``x / self.count`` after ``self.count = 4``. Not where the left operand keeps provenance by itself,
being a literal or computed with one.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Sequence
from typing import Any, NamedTuple

from .arithmetic import FUNCTIONS, helper
from .naming import Scope

_LOAD = ast.Load()
_SIMPLE = (ast.Name, ast.Constant)
_NO_FLOATS = (
    ast.Constant, ast.JoinedStr, ast.Compare, ast.Lambda,
    ast.List, ast.Tuple, ast.Dict, ast.Set, ast.ListComp, ast.SetComp, ast.DictComp,
)  # fmt: skip
_GIVE_INTS = frozenset({"hash", "id", "int", "len", "ord"})
"""Functions whose result asks an int on its right by itself."""


class _Noted(NamedTuple):
    node: Any
    scope: Scope
    block: Any


class Operations:
    """Collects operators during the walk, and rewrites them when all literals are known."""

    def __init__(self) -> None:
        self._noted: dict[Any, _Noted] = {}  # once each: compilers copy operators, not operands
        self._integers: set[tuple[Scope | None, str]] = set()

    @property
    def nodes(self) -> list[Any]:
        """The operators that have been noted."""
        return list(self._noted)

    def bound(self, target: ast.expr, value: ast.expr, scope: Scope) -> None:
        """Notes that a program binds a name or an attribute of its object to an int literal."""
        if type(_constant(value)) is not int:
            return
        if isinstance(target, ast.Name):
            self._integers.add((scope, target.id))
            if scope.is_class:
                self._integers.add((None, target.id))
        elif isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name):
            self._integers.add((None, target.attr))

    def binary(self, node: ast.BinOp, scope: Scope, block: Any) -> None:
        """Notes an operator that may have to be rewritten."""
        if (
            _may_be_int(node.right)
            and not isinstance(node.left, _NO_FLOATS)
            and not _gives_int(node.left)
        ):
            self._noted[node] = _Noted(node, scope, block)

    def augmented(
        self, node: ast.AugAssign, scope: Scope, block: Any, local: Collection[str]
    ) -> None:
        """Notes an operator in place whose target can be written twice and evaluated once.

        local  names that nobody else can bind to something else in between
        """
        target = node.target
        if isinstance(target, ast.Attribute):
            fits = isinstance(target.value, ast.Name) and target.value.id in local
        elif isinstance(target, ast.Subscript):
            parts = (target.value, target.slice)
            fits = all(
                isinstance(part, _SIMPLE) and getattr(part, "id", "") in (*local, "")
                for part in parts
            )
        else:
            fits = True
        if fits and _may_be_int(node.value):
            self._noted[node] = _Noted(node, scope, block)

    def rewrite(
        self,
        table: str,
        values: Sequence[Any],
        module: Scope,
        is_off: Callable[[Any], bool],
    ) -> None:
        """Rewrites in place what was noted; literals are look-ups in `table` by now.

        values  of the literals, by index
        is_off  whether a node is to be left alone
        """
        for node, scope, block in self._noted.values():
            in_place = isinstance(node, ast.AugAssign)
            left, right = (node.target, node.value) if in_place else (node.left, node.right)
            name = helper(node.op, in_place)
            if (
                name is None
                or is_off(node)
                or left.lineno != left.end_lineno  # what is executed first may stand elsewhere
                or not self._is_int(right, table, values, scope, module)
                or (not in_place and _is_tracked(left, table))
            ):
                continue
            if in_place:
                _become(node, _assignment(node, name))
            else:
                _become(node, _call(node, name, left, right))
            if block is not None:
                block.names.add(name)

    def _is_int(
        self, node: ast.expr, table: str, values: Sequence[Any], scope: Scope, module: Scope
    ) -> bool:
        if isinstance(node, ast.Name):
            return not self._integers.isdisjoint({(scope, node.id), (module, node.id)})
        if isinstance(node, ast.Attribute):
            return (None, node.attr) in self._integers
        index = _index(node, table)
        return index is not None and type(values[index]) is int


def _constant(node: ast.expr) -> Any:
    if isinstance(node, ast.UnaryOp):
        node = node.operand
    return node.value if isinstance(node, ast.Constant) else None


def _may_be_int(node: ast.expr) -> bool:
    if isinstance(node, ast.Attribute):
        return isinstance(node.value, ast.Name)
    return isinstance(node, ast.Name) or type(_constant(node)) is int


def _gives_int(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in _GIVE_INTS
    )


def _index(node: ast.expr, table: str) -> int | None:
    """The index of a literal, None for anything else."""
    if not isinstance(node, ast.Subscript) or not isinstance(node.value, ast.Name):
        return None
    at = node.slice
    return int(at.value) if node.value.id == table and isinstance(at, ast.Constant) else None  # type: ignore[arg-type]


def _is_tracked(node: ast.expr, table: str) -> bool:
    """Whether a number that this expression gives has a literal's provenance."""
    while isinstance(node, (ast.BinOp, ast.UnaryOp)):
        if isinstance(node, ast.BinOp):
            if _is_tracked(node.right, table):
                return True
            node = node.left
        else:
            node = node.operand
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS
    return _index(node, table) is not None


def _call(at: Any, name: str, left: ast.expr, right: ast.expr) -> ast.Call:
    func = ast.copy_location(ast.Name(name, _LOAD), left)
    return ast.copy_location(ast.Call(func, [left, right], []), at)


def _assignment(node: ast.AugAssign, name: str) -> ast.Assign:
    value = _call(node, name, _loaded(node.target), node.value)
    return ast.copy_location(ast.Assign([node.target], value, None), node)


def _become(node: Any, other: ast.AST) -> None:
    """Puts another node in the place of `node`: nobody needs to know its parent."""
    node.__dict__.clear()
    node.__class__ = other.__class__
    node.__dict__.update(vars(other))


def _loaded(target: Any) -> Any:
    """A target as an expression that gives its present value."""
    if isinstance(target, ast.Name):
        copy: ast.expr = ast.Name(target.id, _LOAD)
    elif isinstance(target, ast.Attribute):
        copy = ast.Attribute(_loaded(target.value), target.attr, _LOAD)
    elif isinstance(target, ast.Subscript):
        copy = ast.Subscript(_loaded(target.value), _loaded(target.slice), _LOAD)
    else:
        copy = ast.Constant(target.value)
    return ast.copy_location(copy, target)
