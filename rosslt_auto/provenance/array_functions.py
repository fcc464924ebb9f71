"""What functions of numpy do to the provenance of arrays: tables of `array_calls`, filled here.

Three kinds: those that move elements (how, is found out by moving their numbers the same way),
those with a rule of their own (products, sums, norms), and those that numpy can do on arrays of
objects. Any other function gives plain results.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import array_algebra
from .array_calls import ADVICE, FUNCTIONS, UFUNCS, call_ufunc
from .array_methods import fill_methods
from .array_moving import fill_moving
from .array_names import SCALARS
from .array_reductions import fill_rules
from .array_type import (
    TrackedArray,
    holds_tracked,
    make_array,
    note_assignment,
    operand_of,
    plain_deeply,
    trackable,
)
from .array_ufuncs import fill_ufuncs

# ---------------------------------------------------------------- calls in instrumented code


def _advised_ufunc(ufunc: Any) -> Callable[..., Any]:
    def call(*args: Any, **keywords: Any) -> Any:
        if any(map(holds_tracked, args)):
            return call_ufunc(ufunc, "__call__", args, keywords)
        return ufunc(*args, **keywords)

    return call


def _advised(function: Any) -> Callable[..., Any]:
    tracked = FUNCTIONS[function]

    def call(*args: Any, **keywords: Any) -> Any:
        if any(map(holds_tracked, args)) or any(map(holds_tracked, keywords.values())):
            return tracked(*args, **keywords)
        return function(*args, **keywords)

    return call


def _making(function: Any) -> Callable[..., Any]:
    def call(*args: Any, **keywords: Any) -> Any:
        return make_array(function, args, keywords)

    return call


def _blank_making(function: Any) -> Callable[..., Any]:
    """zeros, eye, ...: an array into which tracked numbers may be put later."""

    def call(*args: Any, **keywords: Any) -> Any:
        if keywords:
            keywords = plain_deeply(keywords)
        return trackable(function(*map(plain_deeply, args), **keywords))

    return call


def _full(*args: Any, **keywords: Any) -> Any:
    found = trackable(np.full(*map(plain_deeply, args), **plain_deeply(keywords)))
    value = args[1] if len(args) > 1 else keywords.get("fill_value")
    if type(found) is TrackedArray and holds_tracked(value):
        note_assignment(found, ..., operand_of(value))
    return found


def _fill_advice() -> None:
    for ufunc in UFUNCS:
        ADVICE[id(ufunc)] = _advised_ufunc(ufunc)
    for function in FUNCTIONS:
        ADVICE[id(function)] = _advised(function)
    for name in ("array", "asarray", "asanyarray", "ascontiguousarray", "asfortranarray"):
        ADVICE[id(getattr(np, name))] = _making(getattr(np, name))
    for name in (
        "zeros", "ones", "empty", "eye", "identity", "zeros_like", "ones_like", "empty_like",
        "full_like",
    ):  # fmt: skip
        ADVICE[id(getattr(np, name))] = _blank_making(getattr(np, name))
    ADVICE[id(np.full)] = _full
    ADVICE[id(np.arange)] = array_algebra.arange
    for name in SCALARS:
        kind = getattr(np, name, None)  # not all in all versions
        if kind is not None:
            ADVICE[id(kind)] = array_algebra.scalar(kind)


def install() -> None:
    """Fills the tables of `array_calls`. Idempotent."""
    if not UFUNCS:
        fill_ufuncs()
        fill_moving()
        fill_rules()
        array_algebra.install()
        fill_methods()
    if not ADVICE:
        _fill_advice()
