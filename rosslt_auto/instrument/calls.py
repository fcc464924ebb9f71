"""Calls that would lose provenance, made by rewritten code: ``@rosslt.call1(math.sin, x)``.

The value always comes from the plain function on plain operands; provenance is recorded beside
it. Which function it is, is decided by the function object itself: whatever else a name like
``float`` means in a program is called as it is. With untracked arguments the plain function is
called at once.
"""

from __future__ import annotations

import builtins
import itertools
import math
from collections.abc import Callable, Iterable
from typing import Any

from ..provenance.operators import OPERATORS, Operator
from ..provenance.values import TrackedFloat, TrackedInt, is_tracked, node, record, untracked
from .frames import unseen, unseen_methods

CALL_1 = "@rosslt.call1"
CALL_2 = "@rosslt.call2"
CALL = "@rosslt.call"
UNTRACKED = "@rosslt.untracked"
"""The names under which rewritten code finds the functions, in `builtins`."""

Function = Callable[..., Any]

_one: dict[int, Function] = {}
_two: dict[int, Function] = {}
_any: dict[int, Function] = {}
"""Tracked versions by the id of the plain function: for one, two, and any other arguments.

An id, because a user's callable may have no hash; the plain functions live as long as we do.
"""


@unseen
def call_1(function: Function, x: Any, /) -> Any:
    """``function(x)``, tracked."""
    kind = type(x)
    if kind is TrackedFloat or kind is TrackedInt:
        tracked = _one.get(id(function))
        if tracked is not None:
            return tracked(x)
    return function(x)


@unseen
def call_2(function: Function, x: Any, y: Any, /) -> Any:
    """``function(x, y)``, tracked."""
    tracked = _two.get(id(function))
    if tracked is not None:
        return tracked(x, y)
    return function(x, y)


@unseen
def call_any(function: Function, /, *args: Any, **keywords: Any) -> Any:
    """``function(*args, **keywords)``, tracked."""
    tracked = _any.get(id(function))
    if tracked is not None:
        return tracked(*args, **keywords)
    return function(*args, **keywords)


def publish() -> None:
    """Lets rewritten code find the functions of this module."""
    vars(builtins).update({CALL_1: call_1, CALL_2: call_2, CALL: call_any, UNTRACKED: untracked})


# ---------------------------------------------------------------- tracked versions


def _unary(plain: Function, op: Operator) -> Function:
    @unseen
    def call(x: Any, /) -> Any:
        return node(plain(x._v), op, x, None, x._depth + 1)

    return call


def _binary(plain: Function, op: Operator) -> Function:
    @unseen
    def call(x: Any, y: Any, /) -> Any:
        kind, other = type(x), type(y)
        if (
            kind is TrackedFloat or kind is TrackedInt or other is TrackedFloat
            or other is TrackedInt
        ):  # fmt: skip
            return record(op, plain(untracked(x), untracked(y)), x, y)
        return plain(x, y)

    return call


def _variadic(plain: Function, op: Operator, arities: Iterable[int] | None = None) -> Function:
    """For any form of call; provenance where `op` takes as many operands (None: any number)."""

    @unseen
    def call(*args: Any, **keywords: Any) -> Any:
        if keywords or not any(map(is_tracked, args)):
            return plain(*args, **keywords)
        value = plain(*map(untracked, args))
        if arities is not None and len(args) not in arities:
            return value
        return record(op, value, *args)

    return call


def _plain_type(x: Any, /) -> type:
    return float if type(x) is TrackedFloat else int


@unseen
def _float(x: Any, /) -> Any:
    if type(x) is TrackedFloat:
        return x
    return node(float(x._v), OPERATORS["float"], x, None, x._depth + 1)


@unseen
def _int(x: Any, /) -> Any:
    if type(x) is TrackedInt:
        return x
    return node(int(x._v), OPERATORS["int"], x, None, x._depth + 1)


def _exactly(count: int, tracked: Function, plain: Function) -> Function:
    """`tracked` for calls with so many positional arguments, else the plain function."""

    @unseen
    def call(*args: Any, **keywords: Any) -> Any:
        if len(args) == count and not keywords:
            return tracked(*args)
        return plain(*args, **keywords)

    return call


def _converted(tracked: Function, plain: type) -> Function:
    @unseen
    def call(x: Any, /) -> Any:
        return tracked(x) if is_tracked(x) else plain(x)

    return call


def _watched(items: Any, seen: list[Any]) -> Any:
    """Iterates over `items` once, as the plain function would, but hands out plain values."""
    add = seen.append

    @unseen
    def note(item: Any, /) -> Any:
        add(item)
        return untracked(item)

    return map(note, items)


@unseen
def _sum(items: Any, /, start: Any = 0) -> Any:
    """`sum` of plain operands: of floats it is compensated since 3.12, of a subclass it is not."""
    again = items
    if type(items) not in (list, tuple):
        items, again = itertools.tee(items)  # looked at once, when the plain function looks
    value = sum(items, start)
    if not is_tracked(value):
        return value  # with an operand that is tracked, the result is
    operands = (start, *again)
    if len(operands) == 1 or not all(map(_is_number, operands)):
        return value
    value = sum(map(untracked, operands[1:]), untracked(start))
    return record(OPERATORS["sum"], value, *operands)


@unseen
def _any_sum(*args: Any, **keywords: Any) -> Any:
    if 1 <= len(args) + len(keywords) <= 2 and args and keywords.keys() <= {"start"}:
        return _sum(*args, **keywords)
    return sum(*args, **keywords)


def _is_number(item: Any) -> bool:
    return is_tracked(item) or type(item) in (float, int, bool)


@unseen
def _fsum(items: Any, /) -> Any:
    op = OPERATORS.get("fsum")
    if op is None:
        return math.fsum(items)
    seen: list[Any] = []
    return record(op, math.fsum(_watched(items, seen)), *seen)


@unseen
def _dist(p: Any, q: Any, /) -> Any:
    """The distance is the hypotenuse of the differences, computed in one go."""
    p, q = tuple(p), tuple(q)
    value = math.dist(tuple(map(untracked, p)), tuple(map(untracked, q)))
    if any(map(is_tracked, p + q)):
        return record(OPERATORS["hypot"], value, *(a - b for a, b in zip(p, q, strict=True)))
    return value


@unseen
def _sumprod(p: Any, q: Any, /) -> Any:
    """Of plain operands, for the value's sake; no provenance."""
    return math.sumprod(map(untracked, p), map(untracked, q))  # type: ignore[attr-defined]


_OPERATOR_NAMES = {"pow": "fpow"}
_ARITIES = {"log": (1, 2), "hypot": None}
_BINARY = ("atan2", "copysign", "fmod", "ldexp", "nextafter", "pow", "remainder")
_UNARY = (
    "acos", "acosh", "asin", "asinh", "atan", "atanh", "cbrt", "cos", "cosh", "degrees", "erf",
    "erfc", "exp", "exp2", "expm1", "fabs", "gamma", "lgamma", "log10", "log1p", "log2",
    "radians", "sin", "sinh", "sqrt", "tan", "tanh",
)  # fmt: skip


def _fill_tables() -> None:
    """Every function that has an operator, in all forms of call."""
    for name, arities in {
        **dict.fromkeys(_UNARY, (1,)), **dict.fromkeys(_BINARY, (2,)), **_ARITIES,
    }.items():  # fmt: skip
        plain = getattr(math, name, None)
        op = OPERATORS.get(_OPERATOR_NAMES.get(name, name))
        if plain is None or op is None:
            continue
        if arities is None or 1 in arities:
            _one[id(plain)] = _unary(plain, op)
        if arities is None or 2 in arities:
            _two[id(plain)] = _binary(plain, op)
        _any[id(plain)] = _variadic(plain, op, arities)
    _one.update({id(float): _float, id(int): _int, id(type): _plain_type})
    _two.update({id(sum): _sum, id(math.dist): _dist})
    _any[id(sum)] = _any_sum
    for plain, tracked in ((float, _float), (int, _int)):
        _any[id(plain)] = _exactly(1, _converted(tracked, plain), plain)
    _any[id(math.fsum)] = _exactly(1, _fsum, math.fsum)
    _any[id(math.dist)] = _exactly(2, _dist, math.dist)
    sumprod = getattr(math, "sumprod", None)  # new in 3.12
    if sumprod is not None:
        _two[id(sumprod)] = _sumprod
        _any[id(sumprod)] = _exactly(2, _sumprod, sumprod)


_fill_tables()
# An error inside of an overloaded operator must look like one of the plain operator.
for _cls in (TrackedFloat, TrackedInt):
    unseen_methods(_cls)
