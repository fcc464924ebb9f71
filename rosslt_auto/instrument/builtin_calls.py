"""Tracked versions of Python's own functions: conversions, choices, sums."""

from __future__ import annotations

import itertools
from typing import Any

from ..provenance.elements import any_tracked
from ..provenance.frames import unseen
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
from .wrappers import Function, exactly, is_number, number

# ---------------------------------------------------------------- conversions


def _plain_type(x: Any, /) -> type:
    cls = type(x)
    return cls._plain if type(cls) is PlainType else DISGUISED.get(type(cls), cls)


DISGUISED: dict[type, type] = {}
"""For metaclasses of array classes that pass for a plain one: the plain one."""


def _number_type(plain: type, tracked: type, convert: Operator, read: Operator) -> Function:
    """`float` or `int` of one operand, a number or a text."""

    @unseen
    def call(x: Any, /) -> Any:
        kind = type(x)
        if kind is tracked:
            return x
        if type(kind) is not PlainType:
            return plain(x)
        if kind is TrackedStr:
            return node(plain(x._v), read, x, None, x._depth + 1)
        core = getattr(x, "_core", x)
        if type(core) is tracked:
            return core
        return node(plain(x._v), convert, core, None, core._depth + 1)

    return call


_float = _number_type(float, TrackedFloat, OPERATORS["float"], OPERATORS["read_float"])
_int = _number_type(int, TrackedInt, OPERATORS["int"], OPERATORS["read_int"])


@unseen
def _int_in_base(x: Any, base: Any, /) -> Any:
    if type(x) is not TrackedStr or type(untracked(base)) is not int:
        return int(x, base)
    base = untracked(base)
    return record(OPERATORS["read_int"], int(untracked(x), base), x, base)


@unseen
def _any_int(*args: Any, **keywords: Any) -> Any:
    if len(args) == 1 and not keywords:
        return _int(*args)
    if len(args) == 2 and not keywords:
        return _int_in_base(*args)
    if len(args) == 1 and len(keywords) == 1 and "base" in keywords:
        return _int_in_base(args[0], keywords["base"])
    return int(*args, **keywords)


@unseen
def _str(x: Any, /) -> Any:
    if type(type(x)) is not PlainType:
        return str(x)
    core = getattr(x, "_core", x)
    if core is x:
        return tracked_str(x)
    text = str(x._v)
    return tracked_str(core) if str(core._v) == text else text


@unseen
def _format(x: Any, specification: Any = "", /) -> Any:
    text = format(untracked(x), untracked(specification))
    if type(x) is TrackedFloat or type(x) is TrackedInt:
        return record(OPERATORS["pieces"], text, x, None, untracked(specification))
    return text


# ---------------------------------------------------------------- choices

_MANY = 256


def _extreme(plain: Function, op: Operator) -> tuple[Function, Function, Function]:
    """`min` or `max` of two numbers, of the items of something, and in any other form.

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
        if (
            _is_several(items)
            and len(items) <= _MANY
            and any_tracked(items)
            and all(map(_is_pythons, items))
        ):
            return record(op, plain(map(untracked, items)), *items)
        return plain(items)

    @unseen
    def of_any(*items: Any, **keywords: Any) -> Any:
        if len(items) == 1 and keywords.keys() == {"default"} and _is_several(items[0]):
            return of_items(*items)
        if keywords:
            return plain(*items, **keywords)
        return of_items(items) if len(items) > 1 else of_items(*items)

    return of_two, of_items, of_any


def _is_several(items: Any) -> bool:
    return (type(items) is list or type(items) is tuple) and len(items) > 1


def _is_pythons(item: Any) -> bool:
    kind = type(item)
    return (
        kind is TrackedFloat or kind is TrackedInt or kind is float or kind is int or kind is bool
    )


# ---------------------------------------------------------------- sums


@unseen
def _sum(items: Any, /, start: Any = 0) -> Any:
    """`sum` of plain operands: of floats it is compensated since 3.12, of a subclass it is not.

    Adding tracked values would make a node for each, in vain: only where there may be others.
    """
    again = items
    kind = type(items)
    if kind is not list and kind is not tuple:
        items, again = itertools.tee(items)  # looked at once, when the plain function looks
    likely = again is items and len(again) > 0 and is_tracked(again[0])
    operands = (start, *again) if likely else ()
    if not (likely and all(map(is_number, operands))):
        value = sum(items, start)
        if not is_tracked(value):
            return value  # with an operand that is tracked, the result is
        operands = (start, *again)
        if len(operands) == 1 or not all(map(is_number, operands)):
            return value
    value = sum(map(untracked, operands[1:]), untracked(start))
    return record(OPERATORS["sum"], value, *map(number, operands))


@unseen
def _any_sum(*args: Any, **keywords: Any) -> Any:
    if 1 <= len(args) + len(keywords) <= 2 and args and keywords.keys() <= {"start"}:
        return _sum(*args, **keywords)
    return sum(*args, **keywords)


_min_of_two, _min_of_items, _any_min = _extreme(min, OPERATORS["min"])
_max_of_two, _max_of_items, _any_max = _extreme(max, OPERATORS["max"])

ONE: dict[Function, Function] = {
    float: _float, int: _int, str: _str, type: _plain_type, format: _format,
}  # fmt: skip
TWO: dict[Function, Function] = {
    int: _int_in_base, min: _min_of_two, max: _max_of_two, format: _format,
}  # fmt: skip
ITEMS: dict[Function, Function] = {min: _min_of_items, max: _max_of_items, sum: _sum}
ANY: dict[Function, Function] = {
    float: exactly(1, _float, float), int: _any_int, str: exactly(1, _str, str),
    min: _any_min, max: _any_max, sum: _any_sum,
}  # fmt: skip
"""Tracked versions by the plain function: for one number, two, items, and any other arguments."""
