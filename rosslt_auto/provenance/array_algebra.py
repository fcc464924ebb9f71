"""Linear algebra, interpolation and statistics of arrays: tracked versions for `array_calls`.

Small matrices only: the expression of an inverse grows with the third power of its size.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .array_calls import FUNCTIONS, call_plain, ended
from .array_rules import (
    Elementwise,
    Lanes,
    Shadow,
    Whole,
    lanes_along,
    mean,
    node_of,
    product,
    scalar_shadow,
)
from .array_type import is_known, is_real, operand_of, plain_deeply, trackable, wrap
from .elements import adapted
from .operators import OPERATORS
from .values import is_tracked, record, untracked

_LARGEST = 8
"""Rows of a matrix whose inverse gets expressions."""

_LARGEST_DETERMINANT = 4

Rows = list[list[Any]]


def _rows(matrix: Any) -> Rows:
    return [[node_of(item) for item in row] for row in matrix]


def _is_zero(node: Any) -> bool:
    return not is_tracked(node) and node == 0


def _less(a: Any, b: Any) -> Any:
    return a if _is_zero(b) else -b if _is_zero(a) else a - b


def _solution(a: Rows, b: Rows) -> Rows:
    """``a^-1 b`` by elimination (Gauss and Jordan), with the largest pivots."""
    count = len(a)
    rows = [[*left, *right] for left, right in zip(a, b, strict=True)]
    for column in range(count):
        sizes = [abs(untracked(row[column])) for row in rows[column:]]
        pivot = column + sizes.index(max(sizes))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        divisor = rows[column][column]
        rows[column] = [x if _is_zero(x) else x / divisor for x in rows[column]]
        for other, row in enumerate(rows):
            factor = row[column]
            if other != column and not _is_zero(factor):
                rows[other] = [
                    _less(x, product(factor, y)) for x, y in zip(row, rows[column], strict=True)
                ]
    return [row[count:] for row in rows]


def _determinant(a: Rows) -> Any:
    """Along the first row (Laplace)."""
    if len(a) == 1:
        return a[0][0]
    found: Any = 0.0
    for column, factor in enumerate(a[0]):
        minor = _determinant([[*row[:column], *row[column + 1 :]] for row in a[1:]])
        term = product(factor, minor)
        if not _is_zero(term):
            found = _less(found, term) if column % 2 else term if _is_zero(found) else found + term
    return found


def _inverse(a: Any) -> Any:
    identity = [[float(i == j) for j in range(len(a))] for i in range(len(a))]
    return _solution(_rows(a), identity)


def _solve(a: Any, b: Any) -> Any:
    if np.ndim(b) == 2:
        return _solution(_rows(a), _rows(b))
    return [row[0] for row in _solution(_rows(a), [[node_of(item)] for item in b])]


def _interpolate(x: Any, xp: Any, fp: Any) -> Any:
    """Between the neighbours of each x, and their values; at the ends the last value."""
    points, values = [node_of(p) for p in xp], [node_of(v) for v in fp]
    found = []
    for item in np.ravel(x):
        at = node_of(item)
        right = int(np.searchsorted([untracked(p) for p in points], untracked(at), "right"))
        if right == 0 or right == len(points):
            found.append(values[max(0, right - 1)])
            continue
        left = right - 1
        slope = (values[right] - values[left]) / (points[right] - points[left])
        found.append(values[left] + slope * (at - points[left]))
    return found


def _matrices(
    function: Any, make: Callable[..., Any], largest: int, count: int
) -> Callable[..., Any]:
    """The tracked version of a function of `count` small matrices."""

    def call(*args: Any, **keywords: Any) -> Any:
        found = function(*map(plain_deeply, args), **plain_deeply(keywords))
        operands = [operand_of(arg) for arg in args]
        if keywords or len(args) != count or not any(map(is_known, operands)):
            return found
        if np.ndim(operands[0]) != 2 and getattr(operands[0], "shape", ()) != (len(args[0]),) * 2:
            return ended(function, found)
        if len(args[0]) > largest or (count == 2 and np.ndim(plain_deeply(args[1])) > 2):
            return ended(function, found)
        return wrap(found, Whole(make, operands))

    return call


def _interp(x: Any, xp: Any, fp: Any, **keywords: Any) -> Any:
    found = np.interp(*map(plain_deeply, (x, xp, fp)), **plain_deeply(keywords))
    operands = [_with_elements(arg) for arg in (x, xp, fp)]
    if keywords or not any(map(is_known, operands)):
        return found
    return wrap(found, Whole(_interpolate, operands))


def _with_elements(arg: Any) -> Any:
    operand = operand_of(arg)
    return scalar_shadow(operand) if is_tracked(operand) else operand


# ---------------------------------------------------------------- statistics


def _middle(value: Any, *terms: Any) -> Any:
    ordered = sorted(terms, key=untracked)
    half = len(ordered) // 2
    if len(ordered) % 2:
        return adapted(ordered[half], value)
    return mean(value, *ordered[half - 1 : half + 1])


def _recorded(name: str) -> Callable[..., Any]:
    def build(value: Any, *terms: Any) -> Any:
        return record(OPERATORS[name], value, *terms)

    return build


def _spread(function: Any, builds: Sequence[Callable[..., Any]]) -> Callable[..., Any]:
    """The tracked version of a function over an axis.

    builds  what makes an element, by the number of degrees of freedom that are taken away
    """

    def call(a: Any, axis: Any = None, *rest: Any, **keywords: Any) -> Any:
        freedom = untracked(keywords.get("ddof", 0))
        known = keywords.keys() <= {"ddof", "keepdims"} and freedom in range(len(builds))
        if rest or not known:
            return call_plain(function, (a, axis, *rest), keywords)
        found = function(plain_deeply(a), axis, **plain_deeply(keywords))
        operand = operand_of(a)
        if type(operand) is not Shadow or not operand.values.size or np.isnan(found).any():
            return found
        return wrap(found, Lanes(builds[freedom], operand, functools.partial(lanes_along, axis)))

    return call


# ---------------------------------------------------------------- making


def _step(value: Any, start: Any, step: Any, index: Any) -> Any:
    return start if not index and not is_tracked(step) else start + step * index


def arange(*args: Any, **keywords: Any) -> Any:
    """`numpy.arange`: elements follow the start and the step; how many there are, does not."""
    found = np.arange(*map(plain_deeply, args), **plain_deeply(keywords))
    start, step = (args[0] if len(args) > 1 else 0), (args[2] if len(args) > 2 else 1)
    if keywords or not (is_tracked(start) or is_tracked(step)) or not is_real(found):
        return trackable(found)
    operands = [operand_of(start), operand_of(step), np.arange(found.size)]
    return wrap(found, Elementwise(_step, operands, found.shape))


def scalar(kind: Any) -> Callable[..., Any]:
    """The tracked version of a class of numpy's scalars: ``np.float64(x)``."""

    def call(*args: Any, **keywords: Any) -> Any:
        if len(args) != 1 or keywords or not is_tracked(args[0]):
            return kind(*map(plain_deeply, args), **keywords)
        found = kind(untracked(args[0]))
        operand = operand_of(args[0])
        if not is_known(operand):
            return found
        return wrap(found, Elementwise(lambda value, x: adapted(x, value), [operand], ()))

    return call


def install() -> None:
    """Fills the table of `array_calls`."""
    FUNCTIONS.update({
        np.linalg.inv: _matrices(np.linalg.inv, _inverse, _LARGEST, 1),
        np.linalg.det: _matrices(
            np.linalg.det, lambda a: _determinant(_rows(a)), _LARGEST_DETERMINANT, 1
        ),
        np.linalg.solve: _matrices(np.linalg.solve, _solve, _LARGEST, 2),
        np.interp: _interp,
        np.var: _spread(np.var, (_recorded("pvariance"), _recorded("variance"))),
        np.std: _spread(np.std, (_recorded("pstdev"), _recorded("stdev"))),
        np.median: _spread(np.median, (_middle,)),
    })  # fmt: skip
