"""Which calls the rewriter turns into calls of ours, judged by what can be seen in the source.

Seeing is not knowing: ``float`` may be anything at run time. `calls` decides by the function object
that the name evaluates to; here, guessing too much costs time but never changes what happens.
"""

from __future__ import annotations

import ast

from .calls import CALL, CALL_1, CALL_2

BUILTIN_CALLS = frozenset({"float", "int", "sum", "type"})
"""Builtins that would drop provenance. (abs, round, divmod, pow, min and max do not.)"""

MATH_CALLS = frozenset(
    {
        "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "copysign", "cos",
        "cosh", "degrees", "dist", "erf", "erfc", "exp", "exp2", "expm1", "fabs", "fma", "fmod",
        "fsum", "gamma", "hypot", "ldexp", "lgamma", "log", "log10", "log1p", "log2", "modf",
        "nextafter", "pow", "radians", "remainder", "sin", "sinh", "sqrt", "sumprod", "tan",
        "tanh",
    }
)  # fmt: skip
"""Functions of `math` that would drop provenance, or that compute otherwise with subclasses.

Not floor, ceil, trunc and prod, which ask the operand's own methods; nor those between integers or
with truth values as results, which take a tracked number like a plain one.
"""

_OVER_ITERABLES = frozenset({"sum", "fsum"})
_NAMES_OF_INSTANCES = frozenset({"self", "cls"})


def call_helper(node: ast.Call, name: str) -> str | None:
    """The name of our function for a call of the function above called `name`; None: leave it."""
    func, args = node.func, node.args
    if func.lineno != func.end_lineno:
        return None  # rare, and where the compiler says that such a call stands is too intricate
    plain_shape = not node.keywords and not any(isinstance(arg, ast.Starred) for arg in args)
    if name == "type":
        if not plain_shape or len(args) != 1 or _cannot_be_number(args[0]):
            return None
    elif (
        name in ("float", "int") and plain_shape and (len(args) != 1 or _cannot_be_number(args[0]))
    ):
        return None
    if not plain_shape or name in _OVER_ITERABLES or not 1 <= len(args) <= 2:
        return CALL
    return CALL_1 if len(args) == 1 else CALL_2


def _cannot_be_number(node: ast.expr) -> bool:
    if isinstance(node, ast.Constant):
        return not isinstance(node.value, (int, float))
    if isinstance(node, ast.Name):
        return node.id in _NAMES_OF_INSTANCES
    return isinstance(node, (ast.JoinedStr, ast.List, ast.Tuple, ast.Dict, ast.Set, ast.Lambda))
