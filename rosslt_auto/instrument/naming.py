"""Parameter names of literals (contract: Locations and parameters).

``rosslt.<module>.<qualified name>.<hint>``, made of tokens that ROS accepts everywhere. Names are
given when a whole module is known, because no name may be the dotted prefix of another: a hint
must not be called like a function or class beside it.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator

from ..provenance.tokens import module_tokens, token


def submodules(path: str) -> frozenset[str]:
    """If `path` is a package's ``__init__``: the tokens of what lies beside it, else nothing."""
    folder, name = os.path.split(path)
    if os.path.splitext(name)[0] != "__init__":
        return frozenset()
    try:
        entries = os.listdir(folder)
    except OSError:
        return frozenset()
    return frozenset(token(entry.partition(".")[0]) for entry in entries) - {"init", "pycache"}


class Scope:
    """A module, class, function or lambda; comprehensions are no scopes of their own here.

    Scopes of the same name in the same place (a property's getter and setter) are different
    objects but share their names.
    """

    __slots__ = ("children", "is_class", "name", "parent", "path")

    def __init__(self, name: str, parent: Scope | None, is_class: bool = False) -> None:
        self.name = token(name) if parent else name
        self.parent = parent
        self.is_class = is_class
        self.path: str = f"{parent.path}.{self.name}" if parent else name
        self.children: list[Scope] = []
        if parent:
            parent.children.append(self)

    def walk(self) -> Iterator[Scope]:
        """This scope and all that it contains, outer ones first."""
        yield self
        for child in self.children:
            yield from child.walk()


def module_scope(module: str, path: str) -> Scope:
    """The outermost scope of the module `module`, loaded from `path`."""
    return Scope(f"rosslt.{module_tokens(module, path)}", None)


def parameter_names(
    module: Scope,
    literals: Iterable[tuple[Scope, str]],
    reserved: Collection[str] = (),
) -> list[str]:
    """Names for `literals`, each the scope and the hint of a literal, in source order.

    `reserved` are names that the module itself must not use (its submodules, if it is a package).
    """
    for child in module.children:
        if child.name in reserved:
            child.name = _free(child.name, reserved)
    taken: dict[str, set[str]] = {module.path: set(reserved)}
    for scope in module.walk():
        if scope.parent:
            scope.path = f"{scope.parent.path}.{scope.name}"
            taken.setdefault(scope.parent.path, set()).add(scope.name)
    counts: dict[tuple[str, str], int] = {}
    names = []
    for scope, hint in literals:
        used = taken.setdefault(scope.path, set())
        hint = token(hint)
        number = counts.get((scope.path, hint), 0) + 1
        name = hint if number == 1 else f"{hint}_{number}"
        while name in used:
            number += 1
            name = f"{hint}_{number}"
        counts[scope.path, hint] = number
        used.add(name)
        names.append(f"{scope.path}.{name}")
    return names


def _free(name: str, reserved: Collection[str]) -> str:
    number = 2
    while f"{name}_{number}" in reserved:
        number += 1
    return f"{name}_{number}"
