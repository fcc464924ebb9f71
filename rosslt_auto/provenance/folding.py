"""Histories stay bounded: a long expression is replaced by what it comes to (design 3.4).

An expression that is affine in its sources is folded exactly; any other by its first-order form
around the values that the sources have, and marked as such (operator "linear"). Either way the
value is the same bit for bit as long as no source changes.
"""

from __future__ import annotations

import collections
import itertools
import math
from collections.abc import Set
from typing import Any

from .expressions import is_leaf, operands, slope_by, topological
from .locations import source_of
from .operators import OPERATORS
from .values import DEPTH_LIMIT, PlainType, is_tracked, untracked

MAX_TERMS = 64
"""Sources that a folded expression keeps, those with the greatest influence."""

SHALLOW = DEPTH_LIMIT // 16
"""What is no deeper than this is not history: it needs no folding."""

NODE_LIMIT = 16 * DEPTH_LIMIT
"""An expression of more nodes than this is wide: many values that depend on each other."""

WIDE_TERMS = 8
"""`MAX_TERMS` of each of the many values of a wide expression."""

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
    _fold(topological([value]), {id(value)}, MAX_TERMS)


def shorten(value: Any) -> None:
    """Folds the oldest part of a long history, in place, and notes the depths that remain.

    What is folded is shared by all values that are built on it: none of them is long any more,
    and the next fold is some hundred steps away. The latest steps stay as they are.
    """
    recent = DEPTH_LIMIT - SHALLOW
    _count_depths(topological([value], deeper_than=recent), recent)
    if value._depth <= recent:  # folded below already, for another value
        return
    order = topological([value])
    if len(order) > NODE_LIMIT:
        _narrow(order)
        return
    level, chosen = _narrowest_cut(order)
    _fold(order, chosen, MAX_TERMS)
    _count_depths(order, level)


def _narrow(order: list[Any]) -> None:
    """Folds all that lies below the latest `NODE_LIMIT` / 2 nodes."""
    counts = collections.Counter(node._depth for node in order)
    level, above = order[-1]._depth, 0
    while level and above + counts[level] <= NODE_LIMIT // 2:
        above += counts[level]
        level -= 1
    chosen = {
        id(operand)
        for node in order
        if node._depth > level
        for operand in operands(node)
        if is_tracked(operand) and operand._depth <= level
    }
    if order[-1]._depth <= level:  # a single node with that many operands
        chosen.add(id(order[-1]))
    _fold(order, chosen, WIDE_TERMS)
    _count_depths(order, level)


def _count_depths(order: list[Any], level: int) -> None:
    """Notes the depths of the nodes above a level below which everything was folded."""
    for node in order:
        if node._depth > level:
            depth = 1 + max((o._depth for o in operands(node) if is_tracked(o)), default=0)
            node._set(node._op, node._a, node._b, depth)


def _narrowest_cut(order: list[Any]) -> tuple[int, set[int]]:
    """A level of depth, and the ids of the nodes to fold: those that lie just below it.

    The level is the one that the fewest nodes reach up through. Shallow nodes need no folding,
    wherever they are used.
    """
    reach: dict[int, int] = {}
    depths: dict[int, int] = {}
    for node in order:
        depth = node._depth
        if depth > SHALLOW:
            depths[id(node)] = depth
            if depth > DEPTH_LIMIT // 2:
                for operand in operands(node):
                    key = id(operand)
                    if key in depths and reach.get(key, 0) < depth:
                        reach[key] = depth
    width = [0] * (DEPTH_LIMIT + 2)
    for key, end in reach.items():
        width[min(depths[key], DEPTH_LIMIT)] += 1
        width[min(end, DEPTH_LIMIT + 1)] -= 1
    width = list(itertools.accumulate(width))
    level = min(range(DEPTH_LIMIT - SHALLOW, DEPTH_LIMIT // 2, -1), key=width.__getitem__)
    return level, {key for key, end in reach.items() if depths[key] <= level < end}


Form = tuple[dict[int, float], Set[int], bool]
"""What a value comes to, to first order: how it moves with its leaves, by their ids; which of
them it reaches on several ways; whether that is the whole truth. Forms are shared."""

_NONE: frozenset[int] = frozenset()

_LARGE = 10**300


def _fold(order: list[Any], chosen: set[int], most: int) -> None:
    """Folds the nodes with the ids `chosen` to `most` terms, all in one walk upwards.

    order  all nodes below and including them, operands first
    """
    # The forms of a wide expression would be too many: they go when their last user is done.
    last = _last_users(order) if len(order) > NODE_LIMIT else None
    known: dict[tuple[Any, Any], Any] = {}
    leaves: dict[int, Any] = {}
    forms: dict[int, Form] = {}
    left = len(chosen)
    for node in order:
        key = id(node)
        below = operands(node)
        if not below:
            leaf = known.setdefault((source_of(node), node._v), node)
            leaves[id(leaf)] = leaf
            forms[key] = ({id(leaf): 1.0}, _NONE, True)
        else:
            form = _combined(node._op, below, forms)
            forms[key] = form if len(form[0]) <= 2 * most else _greatest(form, most)
            if last is not None:
                for operand in below:
                    if last.get(id(operand)) is node:
                        forms.pop(id(operand), None)
        if key in chosen:
            if below:
                _replace(node, forms[key], leaves, most)
            left -= 1
            if not left:
                return


def _last_users(order: list[Any]) -> dict[int, Any]:
    return {id(o): node for node in order for o in operands(node) if type(type(o)) is PlainType}


def _combined(op: Any, below: tuple[Any, ...], forms: dict[int, Form]) -> Form:
    """The form of an operation, from those of its operands."""
    if op is AFFINE or op is LINEAR:
        return _unfolded(op, below, forms)
    constant = _CONSTANT_SLOPES.get(op)
    plain = [] if constant else [untracked(operand) for operand in below]
    if op is MUL:
        constant = (_finite(plain[1]), _finite(plain[0]))
    keeps = op in _KEEPS_AFFINE and _one_tracked(op, below)
    found: Form | None = None
    for index, operand in enumerate(below):
        if type(type(operand)) is PlainType:
            slope = constant[index] if constant else slope_by(op, index, plain)
            form = forms[id(operand)]
            if slope != 1.0 or not keeps:
                form = ({key: slope * s for key, s in form[0].items()}, form[1], keeps and form[2])
            found = form if found is None else _added(found, form)
    assert found is not None
    return found


def _finite(factor: Any) -> Any:
    """A slope by which others can be multiplied: an int may be too large for a float."""
    return factor if type(factor) is not int or -_LARGE < factor < _LARGE else math.nan


def _added(a: Form, b: Form) -> Form:
    slopes = a[0] | b[0]
    repeated = a[1] | b[1] if a[1] or b[1] else _NONE
    both = a[0].keys() & b[0].keys()
    if both:
        repeated = repeated | both
        for key in both:
            slopes[key] = a[0][key] + b[0][key]
    return (slopes, repeated, a[2] and b[2])


def _unfolded(op: Any, below: tuple[Any, ...], forms: dict[int, Form]) -> Form:
    """The form of what has been folded before: its operands are leaves."""
    slopes: dict[int, float] = {}
    repeated: set[int] = set()
    for index in range(1, len(below), 4):
        if type(type(below[index])) is not PlainType:
            continue
        [key] = forms[id(below[index])][0]
        if below[index + 3] > 1 or key in slopes:
            repeated.add(key)
        slopes[key] = slopes.get(key, 0.0) + below[index + 2]
    return (slopes, repeated, op is AFFINE)


def _greatest(form: Form, most: int) -> Form:
    """The form without the terms of least influence, if there are more than `most`."""
    if len(form[0]) <= most:
        return form
    kept = sorted(form[0], key=lambda key: -abs(form[0][key]))[:most]
    return ({key: form[0][key] for key in kept}, form[1], False)


def _replace(node: Any, form: Form, leaves: dict[int, Any], most: int) -> None:
    """Makes `node` one operator over its terms."""
    if type(node._v) is str:
        _fold_text(node, topological([node]))
        return
    slopes = {key: slope for key, slope in form[0].items() if slope and math.isfinite(slope)}
    slopes, repeated, exact = _greatest((slopes, form[1], form[2]), most)
    flat: list[Any] = [node._v]
    for key, slope in slopes.items():
        leaf = leaves[key]
        times = 2 if key in repeated else 1
        flat += (leaf, leaf._v, _whole(slope) if type(node._v) is int else slope, times)
    node._set(AFFINE if exact else LINEAR, tuple(flat), None, 1)


def _fold_text(value: Any, order: list[Any]) -> None:
    """A text keeps the knowledge of its sources, but no way back."""
    leaves = {source_of(node): node for node in order if is_leaf(node)}
    kept = list(leaves.values())[:MAX_TERMS]
    value._set(OPERATORS["remembered"], (value._v, *kept), None, 1)


def _whole(slope: float) -> float | int:
    return int(slope) if slope.is_integer() and abs(slope) < 2**53 else slope


def _one_tracked(op: Any, below: tuple[Any, ...]) -> bool:
    """Whether a multiplication or division is one by a constant; true of other operators."""
    if op is MUL:
        return not (is_tracked(below[0]) and is_tracked(below[1]))
    return op is not TRUEDIV or not is_tracked(below[1])
