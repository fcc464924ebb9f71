"""Rows of the operator table: Python's own operators on numbers, rounding, sums and choices."""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable
from typing import Any

from .operator_table import AnyOperands, Inverse, Partial, add, define

# ---------------------------------------------------------------- helpers of the rows


def quotient(target: Any, factor: Any) -> Any:
    """target / factor, an int where that is exact (large integers keep every digit)."""
    if type(target) is int and type(factor) is int:
        whole, rest = divmod(target, factor)
        if not rest:
            return whole
    return target / factor


def root(target: Any, base: Any, exponent: Any) -> Any:
    """The base whose power is `target`, on the side of zero on which the base is now."""
    if target < 0:
        if exponent == int(exponent) and int(exponent) % 2:
            return -((-target) ** (1 / exponent))
        raise ValueError("an even power is never negative")
    root = target ** (1 / exponent)
    if base < 0 and exponent == int(exponent) and int(exponent) % 2 == 0:
        return -root
    return root


def power_by_base(base: Any, exponent: Any) -> float:
    return 0.0 if exponent == 0 else exponent * base ** (exponent - 1)


def power_by_exponent(base: Any, exponent: Any) -> float:
    return math.log(base) * base**exponent


def shifted(forward: Callable[..., Any]) -> Inverse:
    """Inverse of a rounding: move the operand by as much as the result has to move."""

    def inverse(target: Any, value: Any, *rest: Any) -> Any:
        if not rest and target != math.floor(target):
            raise ValueError("only whole numbers are possible")
        moved = value + (target - forward(value, *rest))
        return moved if forward(moved, *rest) == target else target

    return inverse


def unabs(target: Any, x: Any) -> Any:
    if target < 0:
        raise ValueError("an absolute value is never negative")
    return -target if x < 0 else target


def _unmod(target: Any, a: Any, b: Any) -> Any:
    if not (0 <= target < b or b < target <= 0):
        raise ValueError(f"a remainder by {b!r} lies between 0 and {b!r}")
    moved = a + (target - a % b)
    # Where that rounds over the edge, the target is a solution itself.
    return moved if math.isclose(moved % b, target, abs_tol=1e-12) else target


def _unfloordiv(target: Any, a: Any, b: Any) -> Any:
    """The dividend moved by whole divisors, or, where that rounds badly, halfway between two."""
    if target != math.floor(target):
        raise ValueError("only whole numbers are possible")
    moved = a + (target - a // b) * b
    return moved if moved // b == target else (target + 0.5) * b


# ---------------------------------------------------------------- Python's own operators

define(
    "add", "+", 12, operator.add,
    (lambda t, a, b: t - b, lambda t, a, b: t - a),
    (lambda a, b: 1.0,),
)  # fmt: skip
define(
    "sub", "-", 12, operator.sub,
    (lambda t, a, b: t + b, lambda t, a, b: a - t),
    (lambda a, b: 1.0, lambda a, b: -1.0),
)  # fmt: skip
define(
    "mul", "*", 13, operator.mul,
    (
        lambda t, a, b: t / b if type(t) is float else quotient(t, b),
        lambda t, a, b: t / a if type(t) is float else quotient(t, a),
    ),
    (lambda a, b: b, lambda a, b: a),
    "a multiplication by zero is always zero",
)  # fmt: skip
define(
    "truediv", "/", 13, operator.truediv,
    (lambda t, a, b: t * b, lambda t, a, b: a / t),
    (lambda a, b: 1 / b, lambda a, b: -a / (b * b)),
    "zero divided by anything is always zero",
)  # fmt: skip
define(
    "floordiv", "//", 13, operator.floordiv,
    (_unfloordiv, None),
    (lambda a, b: 1 / b, lambda a, b: -a / (b * b)),
    "only whole numbers are possible",
)  # fmt: skip
define(
    "mod", "%", 13, operator.mod,
    (_unmod, None),
    (lambda a, b: 1.0, lambda a, b: -float(a // b)),
    "a remainder lies between zero and the divisor",
)  # fmt: skip
define(
    "pow", "**", 15, operator.pow,
    (root, lambda t, a, b: math.log(t) / math.log(a)),
    (power_by_base, power_by_exponent),
    "not every number is a power",
)  # fmt: skip
define("powmod", "pow", None, pow)
define(
    "lshift", "<<", 11, operator.lshift,
    (lambda t, a, b: t >> b, None),
    (lambda a, b: float(1 << b), lambda a, b: (a << b) * math.log(2)),
    "only multiples of a power of two are possible",
)  # fmt: skip
define(
    "rshift", ">>", 11, operator.rshift,
    (lambda t, a, b: (t << b) | (a & ((1 << b) - 1)), None),
    (lambda a, b: 1.0 / (1 << b), None),
)  # fmt: skip
define("and", "&", 10, operator.and_)
define("xor", "^", 9, operator.xor, (lambda t, a, b: t ^ b, lambda t, a, b: t ^ a))
define("or", "|", 8, operator.or_)
define("neg", "-", 14, operator.neg, (lambda t, a: -t,), (lambda a: -1.0,))
define("pos", "+", 14, operator.pos, (lambda t, a: t,), (lambda a: 1.0,))
# An element of an array: what was put there, as the array holds it. Nobody sees it in a text.
define("same", "", 98, lambda a: a, (lambda t, a: t,), (lambda a: 1.0,))
define("invert", "~", 14, operator.invert, (lambda t, a: ~t,), (lambda a: -1.0,))
define(
    "abs", "abs", None, abs, (unabs,), (lambda a: math.copysign(1.0, a),),
    "an absolute value is never negative",
)  # fmt: skip

# ---------------------------------------------------------------- conversions and rounding

define("float", "float", None, float, (lambda t, a: t,), (lambda a: 1.0,))
_ROUNDINGS: dict[str, Callable[..., Any]] = {
    "int": int,
    "round": round,
    "trunc": math.trunc,
    "floor": math.floor,
    "ceil": math.ceil,
}
for _name, _forward in _ROUNDINGS.items():
    define(
        _name, _name, None, _forward, (shifted(_forward), None), (lambda *a: 1.0, None),
        "only rounded numbers are possible",
    )  # fmt: skip


def _sum_inverse(index: int) -> Inverse:
    def inverse(target: Any, *operands: Any) -> Any:
        return target - sum(operands[:index]) - sum(operands[index + 1 :])

    return inverse


def _affine(offset: Any, *terms: Any) -> Any:
    """offset + sum of slope * (source - base), what a long history is folded to (`folding`).

    `terms` are (source, base, slope, times) one after another; `times` says how often the source
    occurred, which evaluation does not need.
    """
    total = offset
    for i in range(0, len(terms), 4):
        total = total + terms[i + 2] * (terms[i] - terms[i + 1])
    return round(total) if type(offset) is int and type(total) is float else total


def _affine_inverse(index: int) -> Inverse | None:
    if index % 4 != 1:
        return None

    def inverse(target: Any, *operands: Any) -> Any:
        source, base, slope = operands[index : index + 3]
        others = _affine(*operands) - slope * (source - base)
        return base + quotient(target - others, slope)

    return inverse


def _affine_partial(index: int) -> Partial | None:
    return (lambda *operands: operands[index + 2]) if index % 4 == 1 else None


def _choice_inverse(choose: Callable[..., Any]) -> Callable[[int], Inverse]:
    """Of min and max: an operand gives the result as long as the others leave it the choice."""

    def make_inverse(index: int) -> Inverse:
        def inverse(target: Any, *operands: Any) -> Any:
            limit = choose((*operands[:index], *operands[index + 1 :]))
            if choose(target, limit) != target:
                raise ValueError(f"limited to {limit!r}")
            return target

        return inverse

    return make_inverse


def _choice_partial(choose: Callable[..., Any]) -> Callable[[int], Partial]:
    return lambda index: lambda *operands: float(operands[index] == choose(*operands))


for _row in (
    AnyOperands("min", "min", min, _choice_inverse(min), _choice_partial(min)),
    AnyOperands("max", "max", max, _choice_inverse(max), _choice_partial(max)),
    AnyOperands("sum", "sum", lambda *operands: sum(operands[1:], operands[0]),
                _sum_inverse, lambda index: lambda *operands: 1.0),
    AnyOperands("affine", "affine", _affine, _affine_inverse, _affine_partial),
    AnyOperands("linear", "about", _affine, _affine_inverse, _affine_partial),
):  # fmt: skip
    add(_row)


def float32(x: Any) -> float:
    try:
        return float(struct.unpack("f", struct.pack("f", x))[0])
    except OverflowError:
        return math.copysign(math.inf, x)


# What a float32 field of a message does to a value on its way.
define(
    "float32", "float32", None, float32, (lambda t, a: t,), (lambda a: 1.0,),
    "a float32 has 24 significant bits",
)  # fmt: skip
