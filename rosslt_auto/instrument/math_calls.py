"""Tracked versions of the functions of module math."""

from __future__ import annotations

import math
from typing import Any

from ..provenance.frames import unseen
from ..provenance.operators import OPERATORS, Operator
from ..provenance.values import is_tracked, record, untracked
from .wrappers import (
    Function,
    binary,
    exactly,
    is_number,
    number,
    unary,
    variadic,
    watched,
)


@unseen
def _fsum(items: Any, /) -> Any:
    seen: list[Any] = []
    value = math.fsum(watched(items, seen))
    if not all(map(is_number, seen)):
        return value
    return record(OPERATORS["fsum"], value, *map(number, seen))


@unseen
def _dist(p: Any, q: Any, /) -> Any:
    """The distance is the hypotenuse of the differences, computed in one go."""
    p, q = tuple(p), tuple(q)
    value = math.dist(tuple(map(untracked, p)), tuple(map(untracked, q)))
    if any(map(is_tracked, p + q)) and all(map(is_number, p + q)):
        return record(OPERATORS["hypot"], value, *(a - b for a, b in zip(p, q, strict=True)))
    return value


@unseen
def _sumprod(p: Any, q: Any, /) -> Any:
    seen: tuple[list[Any], list[Any]] = ([], [])
    value = math.sumprod(watched(p, seen[0]), watched(q, seen[1]))  # type: ignore[attr-defined]
    operands = [*seen[0], *seen[1]]
    if not all(map(is_number, operands)):
        return value
    return record(OPERATORS["sumprod"], value, *map(number, operands))


def _pair(plain: Function, first: Operator, second: Operator) -> Function:
    """A function that gives a pair of numbers: the parts of its operand."""

    @unseen
    def call(x: Any, /) -> Any:
        if not is_tracked(x):
            return plain(x)
        a, b = plain(x._v)
        return record(first, a, number(x)), record(second, b, number(x))

    return call


_OPERATOR_NAMES = {"pow": "fpow"}
_ARITIES: dict[str, tuple[int, ...] | None] = {
    **dict.fromkeys(
        ("acos", "acosh", "asin", "asinh", "atan", "atanh", "cbrt", "cos", "cosh", "degrees",
         "erf", "erfc", "exp", "exp2", "expm1", "fabs", "factorial", "gamma", "isqrt", "lgamma",
         "log10", "log1p", "log2", "radians", "sin", "sinh", "sqrt", "tan", "tanh", "ulp"),
        (1,),
    ),
    **dict.fromkeys(
        ("atan2", "comb", "copysign", "fmod", "ldexp", "nextafter", "perm", "pow", "remainder"),
        (2,),
    ),
    "log": (1, 2),
    **dict.fromkeys(("gcd", "hypot", "lcm"), None),
}  # fmt: skip
"""For how many operands a function has an operator; None: for any number."""

_PAIRS = {"modf": ("modf_fraction", "modf_whole"), "frexp": ("frexp_mantissa", "frexp_exponent")}

OVER_ITERABLES: dict[str, tuple[int, Function]] = {
    "fsum": (1, _fsum), "dist": (2, _dist), "sumprod": (2, _sumprod)
}  # fmt: skip
"""Functions over the items of their arguments: how many these are, and the tracked version."""

NAMES = frozenset({*_ARITIES, *_PAIRS, *OVER_ITERABLES})
"""Functions that would drop provenance, or that compute otherwise with subclasses.

Not floor, ceil, trunc and prod, which ask the operand's own methods; nor those with truth values
as results, which take a tracked number like a plain one.
"""

ONE: dict[Function, Function] = {}
TWO: dict[Function, Function] = {}
ITEMS: dict[Function, Function] = {math.fsum: _fsum}
ANY: dict[Function, Function] = {}
"""Tracked versions by the plain function: for one number, two, items, and any other arguments."""


def _fill_tables() -> None:
    for name, arities in _ARITIES.items():
        plain = getattr(math, name)
        op = OPERATORS[_OPERATOR_NAMES.get(name, name)]
        if arities is None or 1 in arities:
            ONE[plain] = unary(plain, op)
        if arities is None or 2 in arities:
            TWO[plain] = binary(plain, op)
        ANY[plain] = variadic(plain, op, arities)
    for name, (first, second) in _PAIRS.items():
        plain = getattr(math, name)
        ONE[plain] = _pair(plain, OPERATORS[first], OPERATORS[second])
        ANY[plain] = exactly(1, ONE[plain], plain)
    for name, (count, tracked) in OVER_ITERABLES.items():
        plain = getattr(math, name, None)
        if plain is not None:  # sumprod is new in 3.12
            ANY[plain] = exactly(count, tracked, plain)


_fill_tables()
