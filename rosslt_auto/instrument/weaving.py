"""From source to instrumented code, where the cache has none."""

from __future__ import annotations

import ast
import contextlib
import marshal
from collections.abc import Callable, Iterator
from types import CodeType
from typing import Any

from .cache import Entry, table_name
from .errors import NotInstrumented, NotParsed
from .naming import module_scope, submodules
from .remarks import read
from .rewriter import Rewritten, rewrite
from .selection import is_stdlib


def rewritten_tree(
    module: str, path: str, source: bytes, leave: tuple[type[ast.stmt], ...] = ()
) -> tuple[ast.Module, str, Rewritten]:
    """The rewritten tree of a module, the name of its table, and what is in the table.

    leave  kinds of statements that stay as they are

    Raises NotParsed or NotInstrumented.
    """
    try:
        tree: Any = compile(source, path, "exec", ast.PyCF_ONLY_AST, dont_inherit=True)
    except Exception as error:
        raise NotParsed(str(error)) from error
    table = table_name(module, path, source)
    try:
        remarks = read(source, tree, path)
        scope = module_scope(module, path)
        with _hidden(tree, leave):
            # What the library executes is its users' own: a debugger's program, a profiler's.
            executing = not is_stdlib(path)
            return tree, table, rewrite(tree, scope, table, submodules(path), remarks, executing)
    except Exception as error:
        raise NotInstrumented(f"{type(error).__name__}: {error}") from error


class _Hidden(ast.stmt):
    """A kind of statement that the rewriter does not know."""


@contextlib.contextmanager
def _hidden(tree: ast.Module, kinds: tuple[type[ast.stmt], ...]) -> Iterator[None]:
    hidden: list[Any] = (
        [node for node in ast.walk(tree) if isinstance(node, kinds)] if kinds else []
    )
    originals = [node.__class__ for node in hidden]
    for node in hidden:
        node.__class__ = _Hidden
    yield
    for node, kind in zip(hidden, originals, strict=True):
        node.__class__ = kind


def weave(
    module: str,
    path: str,
    source: bytes,
    compiler: Callable[[Any, str], CodeType] | None = None,
) -> Entry:
    """The instrumented code of a module and what it needs to run.

    Raises NotParsed or NotInstrumented.
    """
    tree, table, rewritten = rewritten_tree(module, path, source)
    try:
        if compiler is None:
            code = compile(tree, path, "exec", dont_inherit=True)
        else:
            code = compiler(tree, path)
    except Exception as error:
        _compile_plainly(source, path)  # an error of the program, or ours?
        raise NotInstrumented(f"{type(error).__name__}: {error}") from error
    return entry_of(module, path, table, code, rewritten)


def entry_of(module: str, path: str, table: str, code: CodeType, rewritten: Rewritten) -> Entry:
    """What `tables.publish` needs to know of the code that a rewritten tree was compiled to."""
    infos = marshal.dumps([tuple(info) for info in rewritten.infos])
    return Entry(
        module, path, table, code, rewritten.values, infos,
        rewritten.interpolations, rewritten.warnings,
    )  # fmt: skip


def _compile_plainly(source: bytes, path: str) -> None:
    try:
        compile(source, path, "exec", dont_inherit=True)
    except Exception as error:
        raise NotParsed(str(error)) from error
