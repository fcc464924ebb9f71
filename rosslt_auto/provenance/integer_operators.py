"""Rows of the operator table: the functions of module math between integers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .numerical import without
from .operator_table import AnyOperands, Inverse, add, define

_LARGEST = 10_000
"""Operands come in headers: what would take long to compute is not computed again."""


def _small(function: Callable[..., int]) -> Callable[..., int]:
    def forward(n: int, k: int) -> int:
        if min(k, abs(n - k)) > _LARGEST:
            raise ValueError(f"{function.__name__} of such numbers takes too long")
        return function(n, k)

    return forward


def _factorial(n: int) -> int:
    if n > _LARGEST:
        raise ValueError("factorial of such a number takes too long")
    return math.factorial(n)


def _search(forward: Callable[..., int]) -> Inverse:
    """The first operand of a function that grows with it."""

    def inverse(target: Any, *operands: Any) -> int:
        rest = operands[1:]
        low, high = 0, 1
        while high <= _LARGEST and forward(high, *rest) < target:
            low, high = high, 2 * high
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if forward(middle, *rest) >= target else (middle + 1, high)
        if forward(low, *rest) != target:
            raise ValueError(f"no integer gives {target}")
        return low

    return inverse


def _unisqrt(target: Any, n: int) -> int:
    """Of all squares with this root the nearest: what is left over stays as it can."""
    if target < 0 or target != int(target):
        raise ValueError("a root is a whole number, and not negative")
    return int(target) ** 2 + min(n - math.isqrt(n) ** 2, 2 * int(target))


def _common(forward: Callable[..., int]) -> Callable[[int], Inverse]:
    """Of gcd and lcm: the multiple of the target, or its divisor, that is next to the operand."""

    def make_inverse(index: int) -> Inverse:
        def inverse(target: Any, *operands: int) -> int:
            others = without(operands, index)
            now = operands[index]
            if target < 0 or target != int(target):
                raise ValueError("only whole numbers are possible")
            around = round(now / target) if target else 0
            multiples = [int(target) * (around + d) for d in (0, 1, -1, 2, -2, 3, -3)]
            for candidate in sorted({*multiples, int(target)}, key=lambda c: abs(c - now)):
                if forward(candidate, *others) == target:
                    return candidate
            raise ValueError(f"the others do not go with {target}")

        return inverse

    return make_inverse


_WHOLE = "only whole numbers are possible"

define("factorial", "factorial", None, _factorial, (_search(_factorial),), domain=_WHOLE)
define("isqrt", "isqrt", None, math.isqrt, (_unisqrt,),
       (lambda n: 0.5 / math.sqrt(n),), _WHOLE)  # fmt: skip
for _name in ("comb", "perm"):
    _forward = _small(getattr(math, _name))
    define(_name, _name, None, _forward, (_search(_forward), None), domain=_WHOLE)
for _name in ("gcd", "lcm"):
    add(AnyOperands(_name, _name, getattr(math, _name), _common(getattr(math, _name)),
                    domain=_WHOLE))  # fmt: skip
