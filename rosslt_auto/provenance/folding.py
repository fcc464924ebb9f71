"""Histories stay bounded: a long expression is replaced by what it comes to (design 3.4).

An expression that is affine in its terms (`forms`) is folded exactly; any other by its first-order
form around the values that the sources have, and marked as such (operator "linear"). A text becomes
the texts that it is made of (`excerpts`). Either way the value is the same bit for bit as long as
no source changes.
"""

from __future__ import annotations

import collections
import itertools
from typing import Any

from .expressions import operands, topological
from .forms import KEEPS_AFFINE, LINEAR, TERM_DEPTH, Forms, one_tracked
from .operators import OPERATORS
from .values import DEPTH_LIMIT, is_tracked

MAX_TERMS = 64
"""Terms that a folded expression keeps, those with the greatest influence."""

SHALLOW = DEPTH_LIMIT // 16
"""What is no deeper than this is not history: it needs no folding."""

NODE_LIMIT = 16 * DEPTH_LIMIT
"""An expression of more nodes than this is wide: many values that depend on each other."""

WIDE_TERMS = 8
"""`MAX_TERMS` of each of the many values of a wide expression."""

APPROXIMATE = frozenset({LINEAR, OPERATORS["excerpts"]})
"""Operators of what is known only around the values that sources have."""

KEPT_AROUND = 32
"""Operations around exact parts that `fold` keeps."""


def fold(value: Any) -> None:
    """Folds the expression of `value`, in place, to what is short enough to travel.

    That is one operator over its terms, or some others over parts that are exact: ``cos(angle)``.
    """
    order = topological([value])
    parts = _exact_parts(value, order)
    if parts is None:
        Forms(order, MAX_TERMS).fold({id(value)})
    else:
        chosen, around = parts
        Forms(order, MAX_TERMS).fold(chosen)
        _count_depths(around, 0)


def _exact_parts(value: Any, order: list[Any]) -> tuple[set[int], list[Any]] | None:
    """The ids of the largest deep parts that are affine, and the nodes around them, operands
    first; None if there are too many around, or nothing to be left."""
    exact: set[int] = set()
    for node in order:
        if node._depth <= TERM_DEPTH:
            if node._op is not LINEAR and type(node._v) is not str:
                exact.add(id(node))
        elif node._op in KEEPS_AFFINE:
            below = operands(node)
            if one_tracked(node._op, below) and all(
                id(operand) in exact for operand in below if is_tracked(operand)
            ):
                exact.add(id(node))
    chosen: set[int] = set()
    around: set[int] = set()
    stack = [value]
    while stack:
        node = stack.pop()
        if id(node) in exact:
            if node._depth > TERM_DEPTH:
                chosen.add(id(node))
        elif id(node) not in around:
            around.add(id(node))
            if len(around) > KEPT_AROUND:
                return None
            stack += [operand for operand in operands(node) if is_tracked(operand)]
    return (chosen, [node for node in order if id(node) in around]) if chosen else None


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
    Forms(order, MAX_TERMS).fold(chosen)
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
    Forms(order, WIDE_TERMS).fold(chosen)
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
