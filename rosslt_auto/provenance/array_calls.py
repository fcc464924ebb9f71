"""Calls of numpy with tracked arguments: the plain call, and the rule of its result.

The tables are filled by `array_functions`. Values come from the plain function on plain arguments.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import array_rules
from .array_rules import Elementwise, Rule, Shadow
from .array_type import (
    MAX_SIZE,
    TrackedArray,
    has_provenance,
    holds_tracked,
    is_known,
    note_cells,
    operand_of,
    plain,
    plain_deeply,
    wrap,
)
from .operators import Operator
from .values import is_tracked

_log = logging.getLogger(__name__)
_ended: set[str] = set()
_ndarray = np.ndarray
_view = np.ndarray.view

ADVICE: dict[int, Callable[..., Any]] = {}
"""By the id of a function of numpy: its tracked version, for calls in instrumented code."""

UFUNCS: dict[Any, Callable[[Any, Sequence[Any]], Rule | None]] = {}
"""For a universal function what makes the rule of its result: (plain result, operands)."""

REDUCTIONS: dict[tuple[Any, str], Callable[..., Any]] = {}
"""By universal function and method: called as the method, with tracked arguments."""

FUNCTIONS: dict[Any, Callable[..., Any]] = {}
"""By function of numpy what is called in its place when an argument is tracked."""


def call_ufunc(ufunc: Any, method: str, inputs: Sequence[Any], keywords: dict[str, Any]) -> Any:
    """A universal function with tracked operands among `inputs`."""
    if method != "__call__":
        return _call_method(ufunc, method, inputs, keywords)
    if keywords:
        return _call_with_keywords(ufunc, inputs, keywords)
    known = False
    bare = []
    for x in inputs:
        if type(x) is TrackedArray:
            known = known or has_provenance(x)
            bare.append(_view(x, _ndarray))
        elif type(x) is _ndarray:
            bare.append(x)
        else:
            known = known or holds_tracked(x)
            bare.append(plain_deeply(x))
    found = ufunc(*bare)
    if not known:
        return found
    make = UFUNCS.get(ufunc)
    if make is None:
        return ended(ufunc, found)
    operands = [operand_of(x) for x in inputs]
    return wrap(found, make(found, operands) if any(map(is_known, operands)) else None)


def _call_with_keywords(ufunc: Any, inputs: Sequence[Any], keywords: dict[str, Any]) -> Any:
    out = keywords.get("out")
    out = () if out is None else out if type(out) is tuple else (out,)
    operands = [operand_of(x) for x in inputs]  # before `out` is written to
    found = ufunc(*map(plain_deeply, inputs), **plain_deeply(keywords))
    make = UFUNCS.get(ufunc)
    known = make is not None and "where" not in keywords and any(map(is_known, operands))
    rule = make(found, operands) if make is not None and known else None
    if not out:
        return wrap(found, rule)
    return written_to(out, found, rule)


def written_to(out: Sequence[Any], found: Any, rule: Rule | None) -> Any:
    """The arrays that a result was written to."""
    results = found if type(found) is tuple else (found,)
    written = []
    for given, result in zip(out, results, strict=True):
        if type(given) is not TrackedArray:
            written.append(result)
            continue
        given._cells = None
        given._shadow = None
        if rule is not None and given.dtype.kind in "iuf" and given.size <= MAX_SIZE:
            shadow = Shadow(plain(given), rule)
            if given._whole is None:
                given._shadow = shadow
            else:  # so that the array that it is a view of hears of it
                cells = {p: shadow.core(p) for p in range(given.size)}
                note_cells(given, {p: c if is_tracked(c) else None for p, c in cells.items()})
        written.append(given)
    return written[0] if type(found) is not tuple else tuple(written)


def _call_method(ufunc: Any, method: str, inputs: Sequence[Any], keywords: Any) -> Any:
    special = REDUCTIONS.get((ufunc, method))
    if special is not None:
        return special(*inputs, **keywords)
    out = keywords.get("out")
    found = getattr(ufunc, method)(*map(plain_deeply, inputs), **plain_deeply(keywords))
    if out is not None:
        return written_to(out if type(out) is tuple else (out,), found, None)
    return ended(ufunc, found)


def call_function(function: Any, args: Sequence[Any], keywords: dict[str, Any]) -> Any:
    """A function of numpy with tracked arguments."""
    special = FUNCTIONS.get(function)
    if special is not None:
        return special(*args, **keywords)
    return call_plain(function, args, keywords)


def call_plain(function: Any, args: Sequence[Any], keywords: dict[str, Any]) -> Any:
    """The plain function on plain arguments: provenance ends here."""
    found = function(*map(plain_deeply, args), **plain_deeply(keywords))
    out = keywords.get("out")
    if type(out) is TrackedArray:
        return written_to((out,), found, None)
    return ended(function, found)


def ended(function: Any, found: Any) -> Any:
    """Notes, once for a function, that provenance ends here."""
    name = getattr(function, "__name__", repr(function))
    if name not in _ended:
        _ended.add(name)
        if not isinstance(found, (bool, np.bool_, str, type(None))):
            _log.debug("provenance ends at numpy's %s", name)
    return found


def operate(op: Operator, a: Any, b: Any) -> Any:
    """Python's operator between a tracked number and something of numpy's, in either order."""
    found = op.forward(plain(a), plain(b))
    if type(found) is not _ndarray and not isinstance(found, np.generic):
        return found
    operands = [operand_of(a), operand_of(b)]
    if not any(map(is_known, operands)) or not all(map(_is_real, operands)):
        return found
    return wrap(found, Elementwise(array_rules.operation(op.name), operands, found.shape))


def _is_real(operand: Any) -> bool:
    if type(operand) is _ndarray:
        return operand.dtype.kind in "iuf"
    return type(operand) is Shadow or isinstance(operand, (float, int))


def _array_ufunc(self: Any, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
    return call_ufunc(ufunc, method, inputs, keywords)


def _array_function(self: Any, function: Any, types: Any, args: Any, keywords: Any) -> Any:
    return call_function(function, args, keywords)


for _name, _hook in {
    "__array_ufunc__": _array_ufunc,
    "__array_function__": _array_function,
}.items():
    setattr(TrackedArray, _name, _hook)
