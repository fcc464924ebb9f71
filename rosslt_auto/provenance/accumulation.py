"""Which parts of an expression are history: what repeated executions have added (design 3.2).

``self.angle += STEP`` executed a thousand times leaves a chain of a thousand equal additions.
Nothing in the graph says that one statement made them, but its shape does: going down from the
value, the same operators with the same other operands come again and again.
"""

from __future__ import annotations

from typing import Any

from .expressions import is_leaf, operands
from .locations import source_of
from .values import is_tracked

MAX_PERIOD = 8
MAX_PREFIX = 64
MAX_SIGNATURE = 32
_ADDITIVE = frozenset({"add", "sub"})

Occurrence = tuple[int, int]
"""id of a node, index of one of its operands."""


def held_operands(value: Any) -> set[Occurrence]:
    """The operands below `value` that were accumulated: a change of their sources is not theirs."""
    held = _repeated_terms(value)
    spine = _spine(value)
    signatures = [_signature(node, index) for node, index in spine]
    for start in range(min(len(spine), MAX_PREFIX)):
        length = _periodic_length(spine, signatures, start)
        if length:
            for node, index in spine[start : start + length]:
                held |= {(id(node), i) for i in range(len(operands(node))) if i != index}
            break
    return held


def _repeated_terms(value: Any) -> set[Occurrence]:
    """Terms of folded expressions whose source occurred more than once."""
    held = set()
    stack, seen = [value], set()
    while stack:
        node = stack.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        below = operands(node)
        if node._op.name in ("affine", "linear"):
            held |= {(id(node), i) for i in range(1, len(below), 4) if below[i + 3] > 1}
        stack += [operand for operand in below if is_tracked(operand)]
    return held


def _spine(value: Any) -> list[tuple[Any, int]]:
    """From `value` down along the deepest operand: nodes, and the index at which it goes on."""
    spine: list[tuple[Any, int]] = []
    while not is_leaf(value):
        below = operands(value)
        tracked = [i for i, operand in enumerate(below) if is_tracked(operand)]
        index = max(tracked, key=lambda i: (below[i]._depth, -i))
        # Near its first value a history is no deeper than what is added to it: keep the side.
        if spine and spine[-1][0]._op is value._op and spine[-1][1] in tracked:
            before = spine[-1][1]
            if below[index]._depth - below[before]._depth <= MAX_PERIOD:
                index = before
        spine.append((value, index))
        value = below[index]
    return spine


def _signature(node: Any, index: int) -> Any:
    """Operator and shape of the other operands; plain numbers count as equal (measurements)."""
    others = tuple(
        _shape(operand, [MAX_SIGNATURE]) for i, operand in enumerate(operands(node)) if i != index
    )
    return (node._op.name, index, others)


def _shape(value: Any, budget: list[int]) -> Any:
    if not is_tracked(value):
        return "·"
    if is_leaf(value):
        return source_of(value)
    budget[0] -= 1
    if budget[0] < 0:
        return "…"
    return (value._op.name, *(_shape(operand, budget) for operand in operands(value)))


def _periodic_length(spine: list[Any], signatures: list[Any], start: int) -> int:
    """How many entries from `start` on repeat with some period often enough to be history."""
    for period in range(1, MAX_PERIOD + 1):
        end = start + period
        while end < len(signatures) and signatures[end] == signatures[end - period]:
            end += 1
        rounds = (end - start) // period
        names = {node._op.name for node, _ in spine[start : start + period]}
        if rounds >= (2 if names & _ADDITIVE else 4):
            return rounds * period
    return 0
