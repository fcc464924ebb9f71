"""Which calls the rewriter turns into calls of ours, judged by what can be seen in the source.

Seeing is not knowing: ``float`` may be anything at run time. `calls` decides by the function object
that the name evaluates to; here, guessing too much costs time but never changes what happens.
"""

from __future__ import annotations

import ast

from ..provenance.array_names import CALLS as ARRAY_CALLS
from . import math_calls
from .calls import CALL, CALL_1, CALL_2, CALL_ITEMS
from .executed import CALL_EXECUTE
from .file_calls import CALL_FILE, FILE_CALLS
from .statistics_calls import CALL_STATISTICS, STATISTICS_CALLS

BUILTIN_CALLS = frozenset({"float", "format", "int", "map", "max", "min", "str", "sum", "type"})
"""Builtins that would drop provenance, or some of it. (abs, round, divmod and pow do not.)"""

ARRAY_MODULES = frozenset({"array", "numpy"})
FILE_MODULES = frozenset({"json", "yaml"})
"""Modules whose functions the names of a program are followed to."""

MATH_MODULES = frozenset({"math", "statistics"})
"""Modules whose functions are tracked by these names."""

MATH_CALLS = math_calls.NAMES | STATISTICS_CALLS

_OVER_ITEMS = frozenset({"fsum", "sum"})
_OVER_ITERABLES = frozenset({"sum", *math_calls.OVER_ITERABLES})

EXECUTION_CALLS = frozenset({"exec", "eval"})
"""Builtins that execute what may be a text."""

METHOD_CALLS = MATH_CALLS | ARRAY_CALLS | FILE_CALLS
"""Last names of functions that are called as attributes, and may be rewritten."""

_CONVERSIONS = frozenset({"float", "int", "str"})
_NAMES_OF_INSTANCES = frozenset({"self", "cls"})


def call_helper(node: ast.Call, name: str) -> str | None:
    """The name of our function for a call of the function above called `name`; None: leave it."""
    args = node.args
    if is_spread(node):
        return None
    plain_shape = not node.keywords and not any(isinstance(arg, ast.Starred) for arg in args)
    if name == "type":
        if not plain_shape or len(args) != 1 or _cannot_be_number(args[0]):
            return None
    elif name in ("min", "max"):
        if len(args) == 1 and [keyword.arg for keyword in node.keywords] == ["default"]:
            return CALL
        if not plain_shape or not args:
            return None  # with a key, or several numbers that cannot be seen
        return {1: CALL_ITEMS, 2: CALL_2}.get(len(args), CALL)
    elif name == "map":
        return CALL if plain_shape and len(args) > 1 and _may_be_known(args[0]) else None
    elif name in _CONVERSIONS and plain_shape and not _may_convert(args, name):
        return None
    if name in STATISTICS_CALLS:
        return CALL_STATISTICS
    if plain_shape and len(args) == 1 and name in _OVER_ITEMS:
        return CALL_ITEMS
    if not plain_shape or name in _OVER_ITERABLES or not 1 <= len(args) <= 2:
        return CALL
    return CALL_1 if len(args) == 1 else CALL_2


def array_helper(node: ast.Call, name: str) -> str | None:
    """The same for a function of one of `ARRAY_MODULES`."""
    return CALL if name in ARRAY_CALLS and not is_spread(node) else None


def file_helper(node: ast.Call, name: str) -> str | None:
    """The same for a function or method that may read a file."""
    return CALL_FILE if name in FILE_CALLS and not is_spread(node) else None


def execution_helper(node: ast.Call) -> str | None:
    """The same for what may be `exec` or `eval`."""
    plain_shape = not node.keywords and not any(isinstance(arg, ast.Starred) for arg in node.args)
    if not plain_shape or not 1 <= len(node.args) <= 3 or is_spread(node):
        return None
    return CALL_EXECUTE


def is_spread(node: ast.Call) -> bool:
    """Whether the function's expression goes over several lines."""
    # Rare, and where the compiler says that such a call stands is too intricate.
    return node.func.lineno != node.func.end_lineno


def root_name(node: ast.expr) -> str | None:
    """The first name of ``a.b.c``, None for anything else."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return node.id if isinstance(node, ast.Name) else None


def _cannot_be_number(node: ast.expr) -> bool:
    if isinstance(node, ast.Constant):
        return not isinstance(node.value, (int, float))
    if isinstance(node, ast.Name):
        return node.id in _NAMES_OF_INSTANCES
    return isinstance(node, (ast.JoinedStr, ast.List, ast.Tuple, ast.Dict, ast.Set, ast.Lambda))


def _may_convert(args: list[ast.expr], name: str) -> bool:
    return len(args) in ((1, 2) if name == "int" else (1,)) and not _cannot_be_number(args[0])


def _may_be_known(function: ast.expr) -> bool:
    """Whether a function that is handed on may be one of those above."""
    if isinstance(function, ast.Attribute):
        return function.attr in MATH_CALLS
    return isinstance(function, ast.Name) and function.id in BUILTIN_CALLS | MATH_CALLS
