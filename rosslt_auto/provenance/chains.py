"""The common shape of an expression, made fast: one source, one tracked operand per operator.

``2 * count + 1`` is a chain, ``count * count`` is not. Evaluating a chain and walking it back
needs no search and no table of results; Table I of the paper measures just that.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .operators import LITERAL, SOURCE
from .values import TrackedFloat, TrackedInt, is_tracked

Step = tuple[Callable[..., Any], bool, Any]
"""Forward operation; whether the plain operand comes first; that operand, None if there is none."""


def chain(value: Any) -> tuple[Any, list[Step]] | None:
    """The leaf of `value` and the steps from `value` down to it; None if it is not a chain."""
    steps: list[Step] = []
    append = steps.append
    kind = type(value)
    while True:
        if kind is TrackedFloat:
            op, a, b = value._op, value._a, value._b
        elif kind is TrackedInt:
            _, op, a, b, _ = value._n
        else:  # a string, an element of an array
            return None
        kind = type(a)
        if kind is TrackedFloat or kind is TrackedInt:
            other = type(b)
            if other is not int and other is not float and is_tracked(b):
                return None
            append((op.forward, False, b))
            value = a
        elif is_tracked(b):
            append((op.forward, True, a))
            value = b
            kind = type(b)
        else:
            return (value, steps) if op is LITERAL or op is SOURCE else None


def evaluate_chain(steps: list[Step], result: Any) -> Any:
    """The value of the chain when its leaf is `result`."""
    for forward, first, other in reversed(steps):
        if first:
            result = forward(other, result)
        elif other is None:
            result = forward(result)
        else:
            result = forward(result, other)
    return result


def invert_chain(value: Any, target: Any) -> tuple[Any, list[Step], Any] | None:
    """`chain`, and what the leaf has to be for `target`; None if it is not a chain.

    Raises what the inverses raise.
    """
    steps: list[Step] = []
    append = steps.append
    kind = type(value)
    while True:
        if kind is TrackedFloat:
            op, a, b = value._op, value._a, value._b
        elif kind is TrackedInt:
            _, op, a, b, _ = value._n
        else:  # a string, an element of an array
            return None
        kind = type(a)
        if kind is TrackedFloat or kind is TrackedInt:
            other = type(b)
            now = a._v if kind is TrackedFloat else a._n[0]
            if b is None:
                target = op.inverses[0](target, now)
            elif other is not int and other is not float and is_tracked(b):
                return None
            else:
                target = op.inverses[0](target, now, b)
            append((op.forward, False, b))
            value = a
        elif is_tracked(b):
            target = op.inverses[1](target, a, b._v)
            append((op.forward, True, a))
            value = b
            kind = type(b)
        else:
            return (value, steps, target) if op is LITERAL or op is SOURCE else None
