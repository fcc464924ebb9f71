"""Tracked versions of plain functions, made from the function and its row of the operator table.

The value always comes from the plain function on plain operands; provenance is recorded beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ..provenance.frames import unseen
from ..provenance.operators import Operator
from ..provenance.values import PlainType, TrackedStr, is_tracked, node, record, untracked

Function = Callable[..., Any]


def unary(plain: Function, op: Operator) -> Function:
    """For one operand."""

    @unseen
    def call(x: Any, /) -> Any:
        if type(type(x)) is not PlainType:
            return plain(x)
        value = plain(x._v)
        x = getattr(x, "_core", x)
        return node(value, op, x, None, x._depth + 1)

    return call


def binary(plain: Function, op: Operator) -> Function:
    """For two operands."""

    @unseen
    def call(x: Any, y: Any, /) -> Any:
        if type(type(x)) is PlainType or type(type(y)) is PlainType:
            return record(op, plain(untracked(x), untracked(y)), number(x), number(y))
        return plain(x, y)

    return call


def variadic(plain: Function, op: Operator, arities: Iterable[int] | None = None) -> Function:
    """For any form of call; provenance where `op` takes as many operands (None: any number)."""

    @unseen
    def call(*args: Any, **keywords: Any) -> Any:
        if keywords or not any(map(is_tracked, args)):
            return plain(*args, **keywords)
        value = plain(*map(untracked, args))
        if arities is not None and len(args) not in arities:
            return value
        return record(op, value, *map(number, args))

    return call


def exactly(count: int, tracked: Function, plain: Function) -> Function:
    """`tracked` for calls with so many positional arguments, else the plain function."""

    @unseen
    def call(*args: Any, **keywords: Any) -> Any:
        if len(args) == count and not keywords:
            return tracked(*args)
        return plain(*args, **keywords)

    return call


def watched(items: Any, seen: list[Any]) -> Any:
    """Iterates over `items` once, as the plain function would, but hands out plain values."""
    add = seen.append

    @unseen
    def note(item: Any, /) -> Any:
        add(item)
        return untracked(item)

    return map(note, items)


def number(x: Any) -> Any:
    """An operand as expressions have it: of numpy's scalars the Python number."""
    if type(type(x)) is PlainType:
        return getattr(x, "_core", x)
    kind = type(x)
    if kind is float or kind is int or not hasattr(kind, "dtype"):
        return x
    return x.item()


def is_number(item: Any) -> bool:
    """Whether an expression can have it as a number."""
    kind = type(item)
    if type(kind) is PlainType:
        return kind is not TrackedStr
    return kind is float or kind is int or kind is bool
