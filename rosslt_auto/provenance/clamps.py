"""Bounds of clamps, ``max(-0.5, min(0.5, v))``: a bound that does not hold anything now is not to
become the value.

Raising the -0.5 would give any value above, and lowering the 0.5 any below; nobody who wants the
value changed means that. What tells a bound from what it bounds: it is a number as it stands in
the program, and the other is computed. Where both are, the one that counts now goes first.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .expressions import is_leaf, operands, topological
from .locations import source_of
from .sources import Source
from .values import is_tracked, untracked

_CHOICES = frozenset({"min", "max"})
_CONVERSIONS = frozenset({"neg", "pos", "float", "int", "same", "radians", "degrees"})


def in_order(value: Any, candidates: Sequence[Source]) -> list[Source]:
    """Those of the sources of a value that may be changed for it, without idle bounds; numbers
    that are passed over now, beside others of which the same could be said, come last."""
    bounds: set[Source] = set()
    passed_over: set[Source] = set()
    effective: set[Source] = set()
    reached = {id(value)}
    for node in reversed(topological([value])):  # each after all that are computed from it
        if is_leaf(node):
            if id(node) in reached:
                effective.add(source_of(node))
            continue
        held = [operand for operand in operands(node) if is_tracked(operand)]
        below = held
        if node._op.name in _CHOICES:
            idle = [operand for operand in held if untracked(operand) != node._v]
            below = [operand for operand in held if untracked(operand) == node._v]
            as_they_stand = [source for o in idle if (source := _as_it_stands(o)) is not None]
            computed = any(_as_it_stands(operand) is None for operand in operands(node))
            (bounds if computed else passed_over).update(as_they_stand)
            below += [operand for operand in idle if _as_it_stands(operand) is None]
        if id(node) in reached:
            reached.update(map(id, below))
    kept = [source for source in candidates if source in effective or source not in bounds]
    return sorted(kept, key=lambda source: source in passed_over and source not in effective)


def _as_it_stands(operand: Any) -> Source | None:
    """The source of a number that nothing is computed from but its sign or its unit."""
    if not is_tracked(operand):
        return None
    while not is_leaf(operand):
        held = operands(operand)
        if len(held) != 1 or operand._op.name not in _CONVERSIONS or not is_tracked(held[0]):
            return None
        operand = held[0]
    return source_of(operand)
