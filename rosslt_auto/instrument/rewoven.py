"""A source file compiled twice, plain and rewritten: which code stands for which.

For code that has been loaded plain already. One rewriting of a file serves all its functions, and
gives them the locations that the import hook would give them. Code is compared by value: what has
no equal in the file as it is now was not made from it.
"""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable, Iterator
from types import CodeType
from typing import Any

from . import hook, tables
from .errors import NotInstrumented
from .evaluated import Evaluated
from .weaving import entry_of, rewritten_tree

_KEPT = 8

_files: dict[tuple[str, str], tuple[Any, Rewoven]] = {}
"""The last ones, by name and file of their modules, and what `_version` said of the file."""


class Rewoven:
    """A module's rewritten code.

    tree       the rewritten tree
    table      the name of its table of literals
    rewritten  rewritten code by plain code
    plain      plain code by rewritten code
    """

    def __init__(self, module: str, path: str, source: bytes) -> None:
        self.tree, self.table, found = rewritten_tree(module, path, source)
        compiler = _compiler(_loader(module))
        plain, code = compiler(source, path), compiler(self.tree, path)
        self.rewritten: dict[CodeType, CodeType] = {}
        for old, new in _pairs(plain, code):
            self.rewritten.setdefault(old, new)
        self.plain = {new: old for old, new in self.rewritten.items()}
        self.entry = entry_of(module, path, self.table, code, found)

    @functools.cached_property
    def evaluated(self) -> Evaluated:
        """What has been bound already where the plain code has run. Needs registered literals."""
        return Evaluated(self.tree, self.table)


def rewoven(module: str, path: str) -> Rewoven:
    """The rewritten code of the file `path`, loaded as `module`. Its literals are registered.

    Raises NotParsed or NotInstrumented.
    """
    version = _version(path)
    known = _files.get((module, path))
    if known is not None and known[0] == version:
        return known[1]
    source = _content(_loader(module), path)
    made = Rewoven(module, path, source)
    tables.publish(made.entry, source)
    for warning in made.entry.warnings:
        hook.warn_once(warning, warning)
    _files[module, path] = version, made
    while len(_files) > _KEPT:
        del _files[next(iter(_files))]
    return made


def forget() -> None:
    """Frees what is kept of files."""
    _files.clear()


def _version(path: str) -> object:
    try:
        status = os.stat(path)
    except OSError:  # in an archive
        return None
    return status.st_mtime_ns, status.st_size


def _content(loader: Any, path: str) -> bytes:
    try:
        if hasattr(loader, "get_data"):
            return loader.get_data(path)
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise NotInstrumented(error.strerror or error) from None


def _loader(module: str) -> Any:
    return getattr(sys.modules.get(module), "__loader__", None)


def _compiler(loader: Any) -> Callable[[Any, str], CodeType]:
    own = getattr(loader, "source_to_code", None)
    return _compile if own is None or hook.compiles_plainly(type(loader)) else own


def _compile(source: Any, path: str) -> CodeType:
    return compile(source, path, "exec", dont_inherit=True)


def _pairs(plain: CodeType, rewritten: CodeType) -> Iterator[tuple[CodeType, CodeType]]:
    """Code of the same function, class or lambda in both."""
    pairs = [(plain, rewritten)]
    for old, new in pairs:  # grows
        yield old, new
        theirs, ours = _nested(old), _nested(new)
        for key, codes in theirs.items():
            pairs += zip(codes, ours.get(key, ()), strict=False)  # equal lambdas are one constant


def _nested(code: CodeType) -> dict[tuple[str, int], list[CodeType]]:
    found: dict[tuple[str, int], list[CodeType]] = {}
    for const in code.co_consts:
        if isinstance(const, CodeType):
            found.setdefault((const.co_name, const.co_firstlineno), []).append(const)
    return found
