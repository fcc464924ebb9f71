"""Operators with an int literal on the right: ``x * 2`` becomes ``@rosslt.mul(x, 2)``.

A plain float on the left never asks a subclass of int on the right for its opinion, and the
literal's provenance would be lost: ``time.time() * 2``. So rewritten code asks first. The value
is what the plain operator gives for plain operands; whatever the left operand is besides a number
meets the plain operator itself, in its in-place form where the program wrote that.
"""

from __future__ import annotations

import builtins
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..provenance.frames import unseen
from ..provenance.operators import OPERATORS
from ..provenance.values import (
    DEPTH_LIMIT,
    TrackedFloat,
    TrackedInt,
    _fold,
    new_float,
    new_int,
    node,
)

if TYPE_CHECKING:  # takes long to import, and is not needed with a warm cache
    import ast

_PREFIX = "@rosslt."

_OPERATORS: dict[str, tuple[str, str]] = {
    "Add": ("add", "+"),
    "Sub": ("sub", "-"),
    "Mult": ("mul", "*"),
    "Div": ("truediv", "/"),
    "FloorDiv": ("floordiv", "//"),
    "Mod": ("mod", "%"),
    "Pow": ("pow", "**"),
}
"""Kind of node: name in the table of operators, sign. Those that a float has."""

# The numbers that are made most are made here, as the methods of the tracked classes make them.
_TEMPLATE = """
def operate(x, n, /):
    kind = type(x)
    if kind is float or kind is int:
        if type(n) is not TrackedInt:
            {otherwise}
        theirs = n._n
        value = x {sign} theirs[0]
        depth = theirs[4]
    elif kind is TrackedFloat and type(n) is TrackedInt:
        theirs = n._n
        value = x._v {sign} theirs[0]
        depth = theirs[4]
        if x._depth > depth:
            depth = x._depth
    else:
        {otherwise}
    depth += 1
    kind = type(value)
    if kind is float:
        made = new_float(TrackedFloat, value)
        made._v = value
        made._op = OPERATOR
        made._a = x
        made._b = n
        made._depth = depth
    elif kind is int:
        made = new_int(TrackedInt, value)
        made._n = (value, OPERATOR, x, n, depth)
    else:
        return node(value, OPERATOR, x, n, depth)
    if depth > DEPTH_LIMIT:
        fold(made)
    return made
"""


def _make(name: str, sign: str, in_place: bool) -> Callable[[Any, Any], Any]:
    otherwise = f"x {sign}= n; return x" if in_place else f"return x {sign} n"
    namespace = {
        "TrackedFloat": TrackedFloat, "TrackedInt": TrackedInt, "DEPTH_LIMIT": DEPTH_LIMIT,
        "new_float": new_float, "new_int": new_int, "node": node, "fold": _fold,
        "OPERATOR": OPERATORS[name],
    }  # fmt: skip
    source = _TEMPLATE.format(sign=sign, otherwise=otherwise)
    exec(compile(source, "<tracked operator>", "exec"), namespace)
    made: Any = namespace["operate"]
    made.__name__ = made.__qualname__ = f"i{name}" if in_place else name
    return unseen(made)


FUNCTIONS: dict[str, Callable[[Any, Any], Any]] = {
    _PREFIX + "i" * in_place + name: _make(name, sign, in_place)
    for name, sign in _OPERATORS.values()
    for in_place in (False, True)
}
"""The functions by the names under which rewritten code finds them, in `builtins`."""


def publish() -> None:
    """Lets rewritten code find the functions of this module."""
    vars(builtins).update(FUNCTIONS)


def helper(op: ast.operator, in_place: bool = False) -> str | None:
    """The name of the function for an operator, None if there is none."""
    row = _OPERATORS.get(op.__class__.__name__)
    return None if row is None else _PREFIX + "i" * in_place + row[0]
