"""Truth values with provenance.

``bool`` cannot be subclassed, and ``flag is True`` must hold: a program never gets anything but
True and False. What remembers where one came from is a leaf beside it, which is kept by whatever
keeps the value - a message, see `ros.flags` - and which is never handed to the program.
"""

from __future__ import annotations

from typing import Any

from .operators import SOURCE
from .values import MORE_KINDS, PlainType


class TrackedBool(metaclass=PlainType):
    """A leaf that stands for a truth value; for its attributes see `values.TrackedFloat`."""

    __slots__ = ("_a", "_b", "_depth", "_op", "_v")
    _plain = bool
    _v: bool
    _op: Any
    _a: Any
    _b: Any
    _depth: int

    def __bool__(self) -> bool:
        return self._v

    def __repr__(self) -> str:
        return repr(self._v)


def truth_leaf(value: bool, op: Any, a: Any, b: Any) -> TrackedBool:
    """A leaf for a truth value: operator and operands as for any leaf."""
    made = object.__new__(TrackedBool)
    made._v = value
    made._op = op
    made._a = a
    made._b = b
    made._depth = 0
    return made


def _node(value: bool, op: Any, a: Any, b: Any, depth: int) -> Any:
    """For `values.node`: a source's leaf; results of operations stay plain."""
    return truth_leaf(value, op, a, b) if op is SOURCE else value


MORE_KINDS[id(bool)] = _node
