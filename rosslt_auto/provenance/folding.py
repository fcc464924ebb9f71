"""Histories stay bounded: a long expression is replaced by what it comes to (design 3.4).

An expression that is affine in its sources is folded exactly; any other by its first-order form
around the values that the sources have, and marked as such (operator "linear"). Either way the
value is the same bit for bit as long as no source changes.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

from .expressions import is_leaf, operands, slope_by, topological
from .locations import source_of
from .operators import OPERATORS
from .values import DEPTH_LIMIT, PlainType, is_tracked, untracked

MAX_TERMS = 64
"""Sources that a folded expression keeps, those with the greatest influence."""

SHALLOW = DEPTH_LIMIT // 16
"""What is no deeper than this is not history: it needs no folding."""

AFFINE = OPERATORS["affine"]
LINEAR = OPERATORS["linear"]
MUL = OPERATORS["mul"]
TRUEDIV = OPERATORS["truediv"]

_KEEPS_AFFINE = frozenset(
    OPERATORS[name]
    for name in ("add", "sub", "neg", "pos", "same", "float", "sum", "affine", "mul", "truediv")
)

_CONSTANT_SLOPES = {OPERATORS["add"]: (1.0, 1.0), OPERATORS["sub"]: (1.0, -1.0)}
"""The commonest operators of a history, whose slopes need no look at the operands."""


def fold(value: Any) -> None:
    """Replaces the expression of `value`, in place, by one operator over its sources."""
    _fold_last(topological([value]))


def shorten(value: Any) -> None:
    """Folds the oldest part of a long history, in place, and notes the depths that remain.

    What is folded is shared by all values that are built on it: none of them is long any more,
    and the next fold is some hundred steps away. The latest steps stay as they are.
    """
    order = topological([value])
    level, positions = _narrowest_cut(order)
    for position in positions:
        _fold_last(order[: position + 1])
    for node in order:
        if node._depth > level:
            depth = 1 + max((o._depth for o in operands(node) if is_tracked(o)), default=0)
            node._set(node._op, node._a, node._b, depth)


def _narrowest_cut(order: list[Any]) -> tuple[int, list[int]]:
    """A level of depth, and the positions of the nodes to fold: those that lie just below it.

    The level is the one that the fewest nodes reach up through. Shallow nodes need no folding,
    wherever they are used.
    """
    reach: dict[int, int] = {}
    positions: dict[int, int] = {}
    for position, node in enumerate(order):
        depth = node._depth
        if depth > SHALLOW:
            positions[id(node)] = position
            if depth > DEPTH_LIMIT // 2:
                for operand in operands(node):
                    key = id(operand)
                    if key in positions and reach.get(key, 0) < depth:
                        reach[key] = depth
    width = [0] * (DEPTH_LIMIT + 2)
    for key, end in reach.items():
        width[min(order[positions[key]]._depth, DEPTH_LIMIT)] += 1
        width[min(end, DEPTH_LIMIT + 1)] -= 1
    width = list(itertools.accumulate(width))
    level = min(range(DEPTH_LIMIT - SHALLOW, DEPTH_LIMIT // 2, -1), key=width.__getitem__)
    return level, [
        positions[key] for key, end in reach.items() if order[positions[key]]._depth <= level < end
    ]


def _fold_last(order: list[Any]) -> None:
    """Folds the last node of a topological order, which may have more in it than is needed."""
    value = order[-1]
    if type(value._v) is str:
        _fold_text(value, topological([value]))
        return
    found, affine = _slopes(order)
    terms: dict[tuple[Any, Any], list[Any]] = {}
    for leaf, slope, times in found:
        if slope and math.isfinite(slope):
            term = terms.setdefault((source_of(leaf), leaf._v), [leaf, leaf._v, 0.0, 0])
            term[2] += slope
            term[3] = min(term[3] + times, 2)
    kept = sorted(terms.values(), key=lambda term: -abs(term[2]))[:MAX_TERMS]
    chosen = {id(term) for term in kept}
    flat: list[Any] = [value._v]
    for term in terms.values():
        if id(term) in chosen:
            term[2] = _whole(term[2]) if type(value._v) is int else term[2]
            flat += term
    value._set(AFFINE if affine else LINEAR, tuple(flat), None, 1)


def _fold_text(value: Any, order: list[Any]) -> None:
    """A text keeps the knowledge of its sources, but no way back."""
    leaves = {source_of(node): node for node in order if is_leaf(node)}
    kept = list(leaves.values())[:MAX_TERMS]
    value._set(OPERATORS["remembered"], (value._v, *kept), None, 1)


def _whole(slope: float) -> float | int:
    return int(slope) if slope.is_integer() and abs(slope) < 2**53 else slope


def _slopes(order: list[Any]) -> tuple[list[tuple[Any, float, int]], bool]:
    """The leaves below the last node: each with the slope of its value by it, and on how many
    ways it is reached (two stands for more); and whether that is the whole truth."""
    affine = True
    found: list[tuple[Any, float, int]] = []
    weights: dict[int, tuple[float, int]] = {id(order[-1]): (1.0, 1)}
    for node in reversed(order):
        weight = weights.pop(id(node), None)
        if weight is None:
            continue
        slope, times = weight
        below = operands(node)
        if not below:
            found.append((node, slope, times))
            continue
        op = node._op
        affine = affine and op in _KEEPS_AFFINE and _one_tracked(op, below)
        constant = _CONSTANT_SLOPES.get(op)
        plain = [] if constant else [untracked(operand) for operand in below]
        folded = op is AFFINE or op is LINEAR
        for index, operand in enumerate(below):
            if type(type(operand)) is not PlainType:
                continue
            part = slope * (constant[index] if constant else slope_by(op, index, plain))
            ways = 2 if folded and plain[index + 3] > 1 else times
            key = id(operand)
            if key in weights:
                weights[key] = (weights[key][0] + part, 2)
            else:
                weights[key] = (part, ways)
    found.reverse()
    return found, affine


def _one_tracked(op: Any, below: tuple[Any, ...]) -> bool:
    """Whether a multiplication or division is one by a constant; true of other operators."""
    if op is MUL:
        return not (is_tracked(below[0]) and is_tracked(below[1]))
    return op is not TRUEDIV or not is_tracked(below[1])
