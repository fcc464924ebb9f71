"""Calls that would lose provenance, made by rewritten code: ``@rosslt.call1(math.sin, x)``.

The value always comes from the plain function on plain operands; provenance is recorded beside
it. Which function it is, is decided by the function object itself: whatever else a name like
``float`` means in a program is called as it is. With untracked arguments the plain function is
called at once.
"""

from __future__ import annotations

import builtins
from collections.abc import Mapping
from typing import Any

from ..provenance.elements import any_tracked
from ..provenance.frames import unseen, unseen_methods
from ..provenance.values import TrackedFloat, TrackedInt, TrackedStr, untracked
from . import builtin_calls, math_calls
from .builtin_calls import DISGUISED
from .wrappers import Function

CALL_1 = "@rosslt.call1"
CALL_2 = "@rosslt.call2"
CALL_ITEMS = "@rosslt.items"
CALL = "@rosslt.call"
UNTRACKED = "@rosslt.untracked"
"""The names under which rewritten code finds the functions, in `builtins`."""


def _by_id(*tables: Mapping[Function, Function]) -> dict[int, Function]:
    return {id(plain): tracked for table in tables for plain, tracked in table.items()}


_one = _by_id(builtin_calls.ONE, math_calls.ONE)
_two = _by_id(builtin_calls.TWO, math_calls.TWO)
_items = _by_id(builtin_calls.ITEMS, math_calls.ITEMS)
_any = _by_id(builtin_calls.ANY, math_calls.ANY)
"""Tracked versions by the id of the plain function: for one number, two, the items of one
argument, and any other arguments.

An id, because a user's callable may have no hash; the plain functions live as long as we do.
"""


@unseen
def call_1(function: Function, x: Any, /) -> Any:
    """``function(x)``, tracked."""
    kind = type(x)
    if kind is float or type(kind) is type:
        return function(x)
    tracked = _one.get(id(function))
    return function(x) if tracked is None else tracked(x)


@unseen
def call_items(function: Function, items: Any, /) -> Any:
    """``function(items)`` of a function over items, tracked."""
    tracked = _items.get(id(function))
    return function(items) if tracked is None else tracked(items)


@unseen
def call_2(function: Function, x: Any, y: Any, /) -> Any:
    """``function(x, y)``, tracked."""
    kind = type(x)
    if kind is float or type(kind) is type:
        kind = type(y)
        if kind is float or type(kind) is type:
            return function(x, y)
    tracked = _two.get(id(function))
    return function(x, y) if tracked is None else tracked(x, y)


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
    vars(builtins).update(
        {CALL_1: call_1, CALL_2: call_2, CALL_ITEMS: call_items, CALL: call_any,
         UNTRACKED: untracked}
    )  # fmt: skip


@unseen
def _map(*args: Any, **keywords: Any) -> Any:
    """`map` with the tracked version of its function, where there may be something to track."""
    if len(args) < 2 or keywords:
        return map(*args, **keywords)
    function, *items = args
    tracked = (_one if len(items) == 1 else _any).get(id(function))
    if tracked is None or all(map(_is_plain, items)):
        return map(function, *items)
    return map(tracked, *items)


def _is_plain(items: Any) -> bool:
    kind = type(items)
    return kind is range or ((kind is list or kind is tuple) and not any_tracked(items))


_any[id(map)] = _map

# An error inside of an overloaded operator must look like one of the plain operator.
for _cls in (TrackedFloat, TrackedInt, TrackedStr):
    unseen_methods(_cls)

__all__ = [
    "CALL",
    "CALL_1",
    "CALL_2",
    "CALL_ITEMS",
    "DISGUISED",
    "UNTRACKED",
    "call_1",
    "call_2",
    "call_any",
    "call_items",
    "forget",
    "learn",
    "publish",
]
