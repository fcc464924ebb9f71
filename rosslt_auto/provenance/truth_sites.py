"""Which truth values may reach fields of messages, and from where, judged by the source.

A truth value cannot carry its provenance, so where one is put into a field its origin is told by
the place in the program where that happens: a `Site`. Sites are assignments to attributes
(``msg.data = True``) and keyword arguments of calls of what looks like a class
(``Bool(data=True)``). Whether it is a message at all shows at run time.

Origins that can be told: a literal there; a name or an attribute of ``self`` that the module binds
to literals and nothing else; a field of a message (``out.data = msg.data``).
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

Position = tuple[int, int, int, int]
"""First line, column, last line, column: of an assignment's target, or of a call."""


class Site(NamedTuple):
    """A place that puts a truth value into an attribute.

    position  see above
    keyword   of the call, None for an assignment
    literals  those that the value may come from, as the (line, column) of each
    path      names to follow to another field: ("msg", "data")
    """

    position: Position
    keyword: str | None
    literals: tuple[tuple[int, int], ...]
    path: tuple[str, ...]


class Bound(NamedTuple):
    """What a literal is bound to: attribute of the objects of a class (None: of the module)."""

    owner: str | None
    name: str


class TruthSites:
    """What there is in a tree.

    sites     all sites
    literals  the nodes of the literals that they refer to
    bound     by (line, column): what such a literal is bound to
    """

    def __init__(self, tree: ast.Module) -> None:
        walk = _Walk()
        walk.visit(tree)
        self.sites: list[Site] = []
        self.literals: list[ast.Constant] = []
        self.bound: dict[tuple[int, int], Bound] = {}
        for position, keyword, value, scopes in walk.sites:
            found, path = walk.origins(value, scopes)
            if found or path:
                places = tuple((node.lineno, node.col_offset) for node in found)
                self.sites.append(Site(position, keyword, places, path))
                self.literals += found
        for node in self.literals:
            bound = walk.bound.get(id(node))
            if bound is not None:
                self.bound[node.lineno, node.col_offset] = bound


_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
_SCOPES = frozenset((*_FUNCTIONS, ast.ClassDef))
_SELF = "self"
_UNKNOWN = None


class _Fields(dict[type, tuple[str, ...]]):
    """By kind of node: the fields that may hold others."""

    _OTHERS = frozenset({"ctx", "op", "ops", "id", "attr", "kind", "type_comment"})

    def __missing__(self, kind: type) -> tuple[str, ...]:
        fields: tuple[str, ...] = getattr(kind, "_fields", ())
        self[kind] = found = tuple(name for name in fields if name not in self._OTHERS)
        return found


_FIELDS = _Fields()
_LEAVES = frozenset({type(None), str, int, bool, ast.Constant, ast.Pass, ast.Break, ast.Continue})


class _Walk:
    """Collects bindings of names and attributes, and candidates of sites."""

    def __init__(self) -> None:
        self.sites: list[tuple[Position, str | None, ast.expr, list[ast.AST]]] = []
        self.names: dict[tuple[int, str], list[Any]] = defaultdict(list)
        self.attributes: dict[str, list[Any]] = defaultdict(list)
        self.bound: dict[int, Bound] = {}
        self._simple: set[int] = set()  # targets whose value is known

    def visit(self, tree: ast.Module) -> None:
        """Goes through a tree, one scope after another: the order does not matter.

        But targets come after their statement. (This takes the most time of all passes over a
        tree, so the loop is written out.)
        """
        scopes_left: list[tuple[ast.AST, list[ast.AST]]] = [(tree, [tree])]
        while scopes_left:
            scope, scopes = scopes_left.pop()
            nodes: list[Any] = [scope]
            while nodes:
                node = nodes.pop()
                kind = node.__class__
                if node is not scope:
                    if kind in self._VISITS:
                        self._VISITS[kind](self, node, scopes)
                    if kind in _SCOPES:
                        scopes_left.append((node, [*scopes, node]))
                        continue
                for name in _FIELDS[kind]:
                    child = getattr(node, name, None)
                    if child.__class__ is list:
                        nodes += child
                    elif child.__class__ not in _LEAVES:
                        nodes.append(child)

    def _assignment(self, node: Any, scopes: list[ast.AST]) -> None:
        if node.value is not None:
            for target in node.targets if isinstance(node, ast.Assign) else (node.target,):
                self._bind(target, node.value, scopes)
                self._simple.add(id(target))

    def _call(self, node: ast.Call, scopes: list[ast.AST]) -> None:
        if node.keywords and _looks_like_class(node.func):
            for keyword in node.keywords:
                if keyword.arg is not None:
                    self.sites.append((_position(node), keyword.arg, keyword.value, scopes))

    def _target(self, node: Any, scopes: list[ast.AST]) -> None:
        if node.ctx.__class__ is not ast.Load and id(node) not in self._simple:
            self._bind(node, _UNKNOWN, scopes)

    def _bind(self, target: ast.expr, value: ast.expr | None, scopes: list[ast.AST]) -> None:
        scope = scopes[-1]
        if isinstance(target, ast.Name):
            if isinstance(scope, ast.ClassDef):
                self._note(self.attributes[target.id], value, Bound(scope.name, target.id))
            else:
                bound = Bound(None, target.id) if isinstance(scope, ast.Module) else None
                self._note(self.names[id(scope), target.id], value, bound)
        elif isinstance(target, ast.Attribute):
            of_self = isinstance(target.value, ast.Name) and target.value.id == _SELF
            owner = next((s.name for s in reversed(scopes) if isinstance(s, ast.ClassDef)), None)
            bound = Bound(owner, target.attr) if owner is not None else None
            if of_self:
                self._note(self.attributes[target.attr], value, bound)
                return
            if value is None or _path(value) != (_SELF, target.attr):
                self.attributes[target.attr].append(_UNKNOWN)  # perhaps of such an object
            if value is not None:
                self.sites.append((_position(target), None, value, scopes))

    def _note(self, bindings: list[Any], value: ast.expr | None, bound: Bound | None) -> None:
        bindings.append(value)
        if bound is not None and value is not None:
            self.bound[id(value)] = bound

    # Bindings whose values cannot be told:

    def _argument(self, node: ast.arg, scopes: list[ast.AST]) -> None:
        self.names[id(scopes[-1]), node.arg].append(_UNKNOWN)

    def _declaration(self, node: ast.Global | ast.Nonlocal, scopes: list[ast.AST]) -> None:
        for name in node.names:
            for scope in scopes:
                self.names[id(scope), name].append(_UNKNOWN)

    def _definition(self, node: Any, scopes: list[ast.AST]) -> None:
        self.names[id(scopes[-1]), node.name].append(_UNKNOWN)
        self.attributes[node.name].append(_UNKNOWN)

    def _import(self, node: ast.alias, scopes: list[ast.AST]) -> None:
        name = (node.asname or node.name).partition(".")[0]
        self.names[id(scopes[-1]), name].append(_UNKNOWN)

    def _capture(self, node: Any, scopes: list[ast.AST]) -> None:
        if node.name:
            self.names[id(scopes[-1]), node.name].append(_UNKNOWN)

    _VISITS: ClassVar[dict[type, Callable[[_Walk, Any, list[ast.AST]], None]]] = {
        ast.Assign: _assignment,
        ast.AnnAssign: _assignment,
        ast.Call: _call,
        ast.Name: _target,
        ast.Attribute: _target,
        ast.arg: _argument,
        ast.Global: _declaration,
        ast.Nonlocal: _declaration,
        ast.FunctionDef: _definition,
        ast.AsyncFunctionDef: _definition,
        ast.ClassDef: _definition,
        ast.alias: _import,
        ast.ExceptHandler: _capture,
        ast.MatchAs: _capture,
        ast.MatchStar: _capture,
    }

    def origins(
        self, value: ast.expr, scopes: list[ast.AST]
    ) -> tuple[list[ast.Constant], tuple[str, ...]]:
        """The literals that a value may come from, or the path of another field."""
        if _is_truth(value):
            return [value], ()  # type: ignore[list-item]
        if isinstance(value, ast.IfExp):
            found = [node for part in (value.body, value.orelse)
                     for node in self.origins(part, scopes)[0]]  # fmt: skip
            return found, ()
        if isinstance(value, ast.Name):
            for scope in reversed(scopes):
                if isinstance(scope, ast.ClassDef) and scope is not scopes[-1]:
                    continue  # not visible from its methods
                if (id(scope), value.id) in self.names:
                    return _all_truths(self.names[id(scope), value.id]), ()
            return [], ()
        path = _path(value)
        if len(path) == 2 and path[0] == _SELF:
            return _all_truths(self.attributes.get(path[1], [])), ()
        return [], path


def _all_truths(values: list[Any]) -> list[ast.Constant]:
    return values if values and all(map(_is_truth, values)) else []


def _is_truth(node: Any) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) is bool


def _path(node: ast.expr) -> tuple[str, ...]:
    names: list[str] = []
    while isinstance(node, ast.Attribute):
        names.append(node.attr)
        node = node.value
    if not names or not isinstance(node, ast.Name):
        return ()
    return (node.id, *reversed(names))


def _looks_like_class(func: ast.expr) -> bool:
    name = func.attr if isinstance(func, ast.Attribute) else getattr(func, "id", "")
    return name.lstrip("_")[:1].isupper()


def _position(node: ast.expr) -> Position:
    assert node.end_lineno is not None and node.end_col_offset is not None
    return node.lineno, node.col_offset, node.end_lineno, node.end_col_offset


__all__ = ["Bound", "Position", "Site", "TruthSites"]
