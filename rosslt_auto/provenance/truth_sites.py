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
from typing import Any, NamedTuple

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

    def __init__(self, tree: ast.AST) -> None:
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
_SCOPES = (*_FUNCTIONS, ast.ClassDef, ast.Module)
_SELF = "self"
_UNKNOWN = None


class _Walk:
    """Collects bindings of names and attributes, and candidates of sites."""

    def __init__(self) -> None:
        self.sites: list[tuple[Position, str | None, ast.expr, list[ast.AST]]] = []
        self.names: dict[tuple[int, str], list[Any]] = defaultdict(list)
        self.attributes: dict[str, list[Any]] = defaultdict(list)
        self.bound: dict[int, Bound] = {}

    def visit(self, tree: ast.AST) -> None:
        stack: list[tuple[ast.AST, list[ast.AST]]] = [(tree, [tree])]
        simple: set[int] = set()  # targets whose value is known
        while stack:
            node, scopes = stack.pop()
            if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                for target in targets:
                    self._bind(target, node.value, scopes)
                    simple.add(id(target))
            elif isinstance(node, ast.Call) and _looks_like_class(node.func):
                for keyword in node.keywords:
                    if keyword.arg is not None:
                        self.sites.append((_position(node), keyword.arg, keyword.value, scopes))
            elif isinstance(node, (ast.Name, ast.Attribute)) and id(node) not in simple:
                if not isinstance(node.ctx, ast.Load):
                    self._bind(node, _UNKNOWN, scopes)
            else:
                self._bind_others(node, scopes)
            inner = [*scopes, node] if isinstance(node, _SCOPES) and node is not tree else scopes
            # Not reversed: the order does not matter, but targets come after their statement.
            stack.extend((child, inner) for child in ast.iter_child_nodes(node))

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

    def _bind_others(self, node: ast.AST, scopes: list[ast.AST]) -> None:
        """Bindings whose values cannot be told."""
        scope = scopes[-1]
        if isinstance(node, ast.arg):
            self.names[id(scope), node.arg].append(_UNKNOWN)
        elif isinstance(node, (ast.Global, ast.Nonlocal)):
            for name in node.names:
                for other in scopes:
                    self.names[id(other), name].append(_UNKNOWN)
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            self.names[id(scope), node.name].append(_UNKNOWN)
            self.attributes[node.name].append(_UNKNOWN)
        elif isinstance(node, ast.alias):
            name = (node.asname or node.name).partition(".")[0]
            self.names[id(scope), name].append(_UNKNOWN)
        elif isinstance(node, (ast.ExceptHandler, ast.MatchAs, ast.MatchStar)) and node.name:
            self.names[id(scope), node.name].append(_UNKNOWN)

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
