"""Rows of the operator table: the functions of module statistics that compute.

(Those that choose - median, mode, quantiles - ask the operands themselves.)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .numerical import numerically, without
from .operator_table import AnyOperands, Inverse, add


def _forward(name: str) -> Callable[..., Any]:
    def forward(*operands: Any) -> Any:
        import statistics  # takes long to import, and few need it

        return getattr(statistics, name)(operands)

    return forward


def _mean_inverse(index: int) -> Inverse:
    return lambda target, *operands: target * len(operands) - math.fsum(without(operands, index))


def _mean_partial(index: int) -> Callable[..., float]:
    return lambda *operands: 1 / len(operands)


def _variance_partial(freedom: int) -> Callable[[int], Callable[..., float]]:
    def make(index: int) -> Callable[..., float]:
        def partial(*operands: Any) -> float:
            mean = math.fsum(operands) / len(operands)
            return float(2 * (operands[index] - mean) / (len(operands) - freedom))

        return partial

    return make


def _deviation_partial(name: str, freedom: int) -> Callable[[int], Callable[..., float]]:
    forward, slope = _forward(name), _variance_partial(freedom)

    def make(index: int) -> Callable[..., float]:
        return lambda *operands: slope(index)(*operands) / (2 * forward(*operands))

    return make


def _row(name: str, partial: Callable[[int], Callable[..., float]], domain: str) -> AnyOperands:
    forward = _forward(name)
    return AnyOperands(
        name, name, forward, lambda i: numerically(forward, partial(i), i), partial, domain
    )


_DOMAIN = "a spread is never negative"

for _name in ("mean", "fmean"):
    add(AnyOperands(_name, _name, _forward(_name), _mean_inverse, _mean_partial))
for _name, _freedom in (("variance", 1), ("pvariance", 0)):
    add(_row(_name, _variance_partial(_freedom), _DOMAIN))
for _name, _freedom in (("stdev", 1), ("pstdev", 0)):
    add(_row(_name, _deviation_partial(_name, _freedom), _DOMAIN))
