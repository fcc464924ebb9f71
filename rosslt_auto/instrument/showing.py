"""Rewritten source for people: what the rewriter makes of a file, and the files of a program."""

from __future__ import annotations

import ast
import os
import pkgutil
import re
from collections.abc import Iterator
from fnmatch import fnmatchcase
from importlib.machinery import ModuleSpec, PathFinder
from typing import NamedTuple

from ..provenance.limits import Limits
from .naming import module_scope
from .weaving import rewritten_tree


class File(NamedTuple):
    """A module and the file that it is loaded from."""

    module: str
    path: str


def rewritten_source(module: str, path: str, source: bytes) -> str:
    """The rewritten tree of a module as text, the literals of each line behind it.

    ``@name[3]`` is the fourth entry of the module's table of literals, ``@name+[0]`` its first
    f-string; other names with an ``@`` are calls of ours. Raises NotParsed or NotInstrumented.
    """
    tree, table, found = rewritten_tree(module, path, source)
    scope = module_scope(module, path).path
    short = "@" + scope.rpartition(".")[2]
    text = ast.unparse(tree).replace(table, short)
    look_up = re.compile(re.escape(short) + r"\[(\d+)\]")

    def about(index: int) -> str:
        info = found.infos[index]
        said = f"{info.parameter.removeprefix(scope + '.')} = {found.values[index]!r}"
        if info.limits is not None:
            said += f" ({Limits(*info.limits)})"
        return f"{said} (frozen)" if info.frozen else said

    lines = []
    for line in text.split("\n"):
        literals = [about(int(number)) for number in dict.fromkeys(look_up.findall(line))]
        lines.append(f"{line}  # {', '.join(literals)}" if literals else line)
    return "\n".join([*(f"# {warning}" for warning in found.warnings), *lines]) + "\n"


def program_file(target: str, as_module: bool) -> File | None:
    """The file that is run as ``__main__``; None if there is none with source."""
    if not as_module:
        inside = os.path.join(target, "__main__.py")
        return File("__main__", inside if os.path.isdir(target) else target)
    for name in (f"{target}.__main__", target):
        spec = _found(name)
        if spec is not None and spec.submodule_search_locations is None and _has_source(spec):
            return File(name, str(spec.origin))
    return None


def matching_files(pattern: str) -> Iterator[File]:
    """The modules on the path whose dotted name matches; imports nothing."""
    top = pattern.partition(".")[0]
    if top.isidentifier():
        names = [top]
    else:
        names = [found.name for found in pkgutil.iter_modules() if fnmatchcase(found.name, top)]
    for name in names:
        yield from _below(name, None, pattern)


def _below(name: str, path: list[str] | None, pattern: str) -> Iterator[File]:
    spec = PathFinder.find_spec(name, path)
    if spec is None:
        return
    if fnmatchcase(name, pattern) and _has_source(spec):
        yield File(name, str(spec.origin))
    inside = spec.submodule_search_locations
    if inside is not None:
        for found in pkgutil.iter_modules(list(inside)):
            yield from _below(f"{name}.{found.name}", list(inside), pattern)


def _found(name: str) -> ModuleSpec | None:
    path: list[str] | None = None
    parts = name.split(".")
    for count in range(1, len(parts)):
        package = PathFinder.find_spec(".".join(parts[:count]), path)
        if package is None or package.submodule_search_locations is None:
            return None
        path = list(package.submodule_search_locations)
    return PathFinder.find_spec(name, path)


def _has_source(spec: ModuleSpec) -> bool:
    return spec.has_location and str(spec.origin).endswith(".py")
