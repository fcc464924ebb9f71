"""Which operands the operators of a header can have: how many, and of which kinds.

What arrives is evaluated and shown by code that relies on it, and comes from the network.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence

from ..provenance.operators import Operator

FOLDED = ("affine", "linear")
"""Operators for whole histories: only every fourth operand from the second on is no coefficient."""

_COUNTS: dict[str, Callable[[int], bool]] = {
    "sum": lambda count: count >= 1,
    "hypot": lambda count: count >= 1,
    "fsum": lambda count: count >= 1,
    "gcd": lambda count: count >= 1,
    "lcm": lambda count: count >= 1,
    **dict.fromkeys(
        ("fmean", "mean", "pstdev", "pvariance", "stdev", "variance"), lambda count: count >= 1
    ),
    "sumprod": lambda count: count >= 2 and count % 2 == 0,
    "read_int": lambda count: count in (1, 2),
    "affine": lambda count: count >= 5 and count % 4 == 1,
    "linear": lambda count: count >= 5 and count % 4 == 1,
    "min": lambda count: count >= 2,
    "max": lambda count: count >= 2,
    "str": lambda count: count == 1,
    "pieces": lambda count: count >= 3 and count % 3 == 0,
    "int": lambda count: count == 1,
    "float": lambda count: count == 1,
    "log": lambda count: count in (1, 2),
    "round": lambda count: count in (1, 2),
    "powmod": lambda count: count == 3,
}
_accepted: dict[tuple[str, int], bool] = {}


def accepts(op: Operator, count: int) -> bool:
    """Whether an operator can have so many operands."""
    key = op.name, count
    found = _accepted.get(key)
    if found is None:
        found = _count_fits(op, count)
        if len(_accepted) < 4096:  # the counts come from the network
            _accepted[key] = found
    return found


def _count_fits(op: Operator, count: int) -> bool:
    if op.name in _COUNTS:
        return _COUNTS[op.name](count)
    try:
        inspect.signature(op.forward).bind(*range(count))
    except (TypeError, ValueError):
        return False
    return True


# ---------------------------------------------------------------- kinds

Kinds = Sequence[type]

_NUMBERS = frozenset({float, int, bool, type(None)})
_TEXT = frozenset({str})
_PIECES = (None, frozenset({str, type(None)}), _TEXT)


def _numbers(result: type, operands: Kinds) -> bool:
    return result is not str and _NUMBERS.issuperset(operands)


def _texts(result: type, operands: Kinds) -> bool:
    return result is str and _TEXT.issuperset(operands)


def _alike(result: type, operands: Kinds) -> bool:
    return _numbers(result, operands) or _texts(result, operands)


def _from_text(result: type, operands: Kinds) -> bool:
    return result is not str and operands[0] is str and _NUMBERS.issuperset(operands[1:])


def _of_text(result: type, operands: Kinds) -> bool:
    return result is str and operands[0] is str


def _part_of_text(result: type, operands: Kinds) -> bool:
    return _of_text(result, operands) and not {str, float} & set(operands[1:])


def _pieces(result: type, operands: Kinds) -> bool:
    return result is str and all(
        allowed is None or kind in allowed
        for kind, allowed in zip(operands, _PIECES * (len(operands) // 3), strict=True)
    )


def _any(result: type, operands: Kinds) -> bool:
    return True


_RULES: dict[str, Callable[[type, Kinds], bool]] = {
    **dict.fromkeys(("same", "int", "float", "str", "repr", "remembered"), _any),
    **dict.fromkeys(("concat", "excerpts", "join", "upper", "lower", "strip"), _texts),
    **dict.fromkeys(("percent", "format"), _of_text),
    **dict.fromkeys(("read_int", "read_float"), _from_text),
    "repeat": _part_of_text,
    "slice": _part_of_text,
    "pieces": _pieces,
    "min": _alike,
    "max": _alike,
}


def fits(op: Operator, result: type, operands: Kinds) -> bool:
    """Whether an operator can give a result of this type from operands of these."""
    return _RULES.get(op.name, _numbers)(result, operands)


__all__ = ["FOLDED", "accepts", "fits"]
