"""Inverses for operators that have no formula for them: Newton's method on one operand."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from .operator_table import Inverse

_STEPS = 80
_SHORTER = 40


def numerically(
    forward: Callable[..., Any], slope: Callable[..., float], index: int = 0
) -> Inverse:
    """An inverse that starts from the operand as it is and follows the slope to the target.

    forward  the operator
    slope    its partial derivative by the operand at `index`
    """

    def inverse(target: Any, *operands: Any) -> float:
        def value_at(x: float) -> float:
            try:
                return float(forward(*operands[:index], x, *operands[index + 1 :]))
            except (ArithmeticError, ValueError):
                return math.nan

        def slope_at(x: float) -> float:
            return slope(*operands[:index], x, *operands[index + 1 :])

        return _solved(value_at, slope_at, float(target), float(operands[index]))

    return inverse


def _solved(
    value_at: Callable[[float], float],
    slope_at: Callable[[float], float],
    target: float,
    x: float,
) -> float:
    error = value_at(x) - target
    for _ in range(_STEPS):
        rate = slope_at(x) if error else 0.0
        if not error or not rate or not math.isfinite(rate):
            break
        step = error / rate
        for _ in range(_SHORTER):  # a step that leads away is too long
            following = value_at(x - step) - target
            if abs(following) < abs(error):
                break
            step /= 2
        else:
            break
        x, error = x - step, following
    if not math.isclose(value_at(x), target, rel_tol=1e-9, abs_tol=1e-12):
        raise ValueError(f"nothing near gives {target!r}")
    return x


def digamma(x: float) -> float:
    """The derivative of ``lgamma``: reflected, raised, then the asymptotic series (DLMF 5.11.2)."""
    if x < 0.5:
        return digamma(1 - x) - math.pi / math.tan(math.pi * x)
    shift = 0.0
    while x < 10:
        shift += 1 / x
        x += 1
    square = 1 / (x * x)
    series = square * (1 / 12 - square * (1 / 120 - square * (1 / 252 - square * (1 / 240))))
    return math.log(x) - 0.5 / x - series - shift


def without(operands: Sequence[Any], index: int) -> list[Any]:
    """All operands but one."""
    return [*operands[:index], *operands[index + 1 :]]
