"""Calls of functions of module statistics, made by rewritten code: ``@rosslt.statistics(mean, x)``.

The module is not imported here for a program that does without.
"""

from __future__ import annotations

import builtins
import sys
from typing import Any

from ..provenance.elements import any_tracked
from ..provenance.frames import unseen
from ..provenance.operators import OPERATORS, Operator
from ..provenance.values import record
from .wrappers import Function, is_number, number, watched

CALL_STATISTICS = "@rosslt.statistics"
"""The name under which rewritten code finds `call_statistics`, in `builtins`."""

STATISTICS_CALLS = frozenset({"fmean", "mean", "pstdev", "pvariance", "stdev", "variance"})
"""Functions that compute. Those that choose, like median, ask the numbers themselves."""

_tracked: dict[int, Function] = {}
"""Tracked versions for one argument, by the id of the plain function."""


@unseen
def call_statistics(function: Function, /, *args: Any, **keywords: Any) -> Any:
    """``function(*args, **keywords)``, tracked."""
    if len(args) == 1 and not keywords:
        tracked = _versions().get(id(function))
        if tracked is not None:
            return tracked(*args)
    return function(*args, **keywords)


def publish() -> None:
    """Lets rewritten code find the function of this module."""
    setattr(builtins, CALL_STATISTICS, call_statistics)


def _versions() -> dict[int, Function]:
    module = sys.modules.get("statistics")
    if not _tracked and hasattr(module, "pstdev"):  # the last one: it is there as a whole
        for name in STATISTICS_CALLS:
            plain = getattr(module, name)
            _tracked[id(plain)] = _over_items(plain, OPERATORS[name])
    return _tracked


def _over_items(plain: Function, op: Operator) -> Function:
    """For a list or tuple: a function of statistics is not C, and sees what it gets."""

    @unseen
    def call(items: Any, /) -> Any:
        if type(items) not in (list, tuple) or not any_tracked(items):
            return plain(items)
        seen: list[Any] = []
        value = plain(list(watched(items, seen)))
        if not all(map(is_number, seen)):
            return value
        return record(op, value, *map(number, seen))

    return call
