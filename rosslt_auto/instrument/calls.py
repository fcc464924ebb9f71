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
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ..provenance.elements import any_tracked
from ..provenance.frames import unseen, unseen_methods
from ..provenance.operators import OPERATORS, Operator
from ..provenance.strings import tracked_str
from ..provenance.values import (
    PlainType,
    TrackedFloat,
    TrackedInt,
    TrackedStr,
    is_tracked,
    node,
    record,
    untracked,
)

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
    if type(type(x)) is not type:
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


def learn(tracked: Mapping[int, Function]) -> None:
    """Adds tracked versions for any arguments, by the id of a plain function that stays."""
    _any.update(tracked)


def forget(tracked: Mapping[int, Function]) -> None:
    """Takes away what `learn` has added."""
    for key in tracked:
        _any.pop(key, None)


def publish() -> None:
    """Lets rewritten code find the functions of this module."""
    vars(builtins).update({CALL_1: call_1, CALL_2: call_2, CALL: call_any, UNTRACKED: untracked})


# ---------------------------------------------------------------- tracked versions


def _unary(plain: Function, op: Operator) -> Function:
    @unseen
    def call(x: Any, /) -> Any:
        if type(type(x)) is not PlainType:
            return plain(x)
        value = plain(x._v)
        x = getattr(x, "_core", x)
        return node(value, op, x, None, x._depth + 1)

    return call


def _binary(plain: Function, op: Operator) -> Function:
    @unseen
    def call(x: Any, y: Any, /) -> Any:
        if type(type(x)) is PlainType or type(type(y)) is PlainType:
            return record(op, plain(untracked(x), untracked(y)), _number(x), _number(y))
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
        return record(op, value, *map(_number, args))

    return call


def _number(x: Any) -> Any:
    """An operand as expressions have it: of numpy's scalars the Python number."""
    if type(type(x)) is PlainType:
        return getattr(x, "_core", x)
    kind = type(x)
    if kind is float or kind is int or not hasattr(kind, "dtype"):
        return x
    return x.item()


def _plain_type(x: Any, /) -> type:
    cls = type(x)
    return cls._plain if type(cls) is PlainType else DISGUISED.get(type(cls), cls)


DISGUISED: dict[type, type] = {}
"""For metaclasses of array classes that pass for a plain one: the plain one."""


@unseen
def _float(x: Any, /) -> Any:
    kind = type(x)
    if kind is TrackedFloat:
        return x
    if type(kind) is not PlainType or kind is TrackedStr:
        return float(x)
    core = getattr(x, "_core", x)
    if type(core) is TrackedFloat:
        return core
    return node(float(x._v), OPERATORS["float"], core, None, core._depth + 1)


@unseen
def _int(x: Any, /) -> Any:
    kind = type(x)
    if kind is TrackedInt:
        return x
    if type(kind) is not PlainType or kind is TrackedStr:
        return int(x)
    core = getattr(x, "_core", x)
    if type(core) is TrackedInt:
        return core
    return node(int(x._v), OPERATORS["int"], core, None, core._depth + 1)


@unseen
def _str(x: Any, /) -> Any:
    if type(type(x)) is not PlainType:
        return str(x)
    core = getattr(x, "_core", x)
    if core is x:
        return tracked_str(x)
    text = str(x._v)
    return tracked_str(core) if str(core._v) == text else text


_MANY = 256


def _extreme(plain: Function, op: Operator) -> tuple[Function, Function]:
    """`min` or `max` of two numbers, and in any other form.

    The result is one of the operands, with the provenance of all. (Of other things than Python's
    numbers it is that operand itself, as it is.)
    """

    @unseen
    def of_two(x: Any, y: Any, /) -> Any:
        if type(type(x)) is PlainType or type(type(y)) is PlainType:
            return of_items((x, y))
        return plain(x, y)

    @unseen
    def of_items(items: Any, /) -> Any:
        kind = type(items)
        if (
            (kind is list or kind is tuple)
            and 1 < len(items) <= _MANY
            and any_tracked(items)
            and all(map(_is_pythons, items))
        ):
            return record(op, plain(map(untracked, items)), *items)
        return plain(items)

    @unseen
    def of_any(*items: Any, **keywords: Any) -> Any:
        if keywords:
            return plain(*items, **keywords)
        return of_items(items) if len(items) > 1 else of_items(*items)

    return of_two, of_any


def _is_pythons(item: Any) -> bool:
    kind = type(item)
    return (
        kind is TrackedFloat or kind is TrackedInt or kind is float or kind is int or kind is bool
    )


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
    return record(OPERATORS["sum"], value, *map(_number, operands))


@unseen
def _any_sum(*args: Any, **keywords: Any) -> Any:
    if 1 <= len(args) + len(keywords) <= 2 and args and keywords.keys() <= {"start"}:
        return _sum(*args, **keywords)
    return sum(*args, **keywords)


def _is_number(item: Any) -> bool:
    kind = type(item)
    if type(kind) is PlainType:
        return kind is not TrackedStr
    return kind is float or kind is int or kind is bool


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
    if any(map(is_tracked, p + q)) and all(map(_is_number, p + q)):
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
    _one.update({id(float): _float, id(int): _int, id(type): _plain_type, id(str): _str})
    for plain in (min, max):
        _two[id(plain)], _any[id(plain)] = _extreme(plain, OPERATORS[plain.__name__])
    _two.update({id(sum): _sum, id(math.dist): _dist})
    _any[id(sum)] = _any_sum
    for plain, tracked in ((float, _float), (int, _int), (str, _str)):
        _any[id(plain)] = _exactly(1, _converted(tracked, plain), plain)
    _any[id(math.fsum)] = _exactly(1, _fsum, math.fsum)
    _any[id(math.dist)] = _exactly(2, _dist, math.dist)
    sumprod = getattr(math, "sumprod", None)  # new in 3.12
    if sumprod is not None:
        _two[id(sumprod)] = _sumprod
        _any[id(sumprod)] = _exactly(2, _sumprod, sumprod)


_fill_tables()
# An error inside of an overloaded operator must look like one of the plain operator.
for _cls in (TrackedFloat, TrackedInt, TrackedStr):
    unseen_methods(_cls)
