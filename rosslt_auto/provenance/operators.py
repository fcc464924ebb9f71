"""The operators that tracked values can pass through: one table, one row each.

A row says how an operator computes (``forward``), how a wanted result is turned into a wanted
operand (``inverses``, Section IV-A of the paper), how the result moves with each operand
(``partials``) and what results are possible at all (``domain``).  Everything else - evaluation,
inversion, derivatives, texts, the wire format - is read from this table and knows no arithmetic.

Inverses and partial derivatives are called with the operands as they are: ``inverse(target, *operands)``
gives the new value of its operand, all others unchanged; ``partial(*operands)`` gives the slope.
An inverse raises ArithmeticError or ValueError where no operand gives the target.
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable
from typing import Any

Inverse = Callable[..., Any]
Partial = Callable[..., float]


class Operator:
    """One row of the table.

    name        how it is called on the wire, stable for ever
    symbol      how people write it: ``+`` between operands, or a function's name before them
    precedence  binding strength of an infix or prefix symbol, None for a function
    forward     the plain operation on plain operands
    inverses    per operand; the last one also serves all further operands
    partials    per operand; the last one also serves all further operands
    domain      which results are possible, in words, for refusals
    """

    __slots__ = ("domain", "forward", "inverses", "name", "partials", "precedence", "symbol")

    def __init__(
        self,
        name: str,
        symbol: str,
        precedence: int | None,
        forward: Callable[..., Any],
        inverses: tuple[Inverse | None, ...] = (None, None),
        partials: tuple[Partial | None, ...] = (None, None),
        domain: str = "",
    ) -> None:
        self.name = name
        self.symbol = symbol
        self.precedence = precedence
        self.forward = forward
        self.inverses = inverses
        self.partials = partials
        self.domain = domain

    def inverse(self, index: int) -> Inverse | None:
        """The inverse for the operand at `index`, None if there is none."""
        return self.inverses[index] if index < len(self.inverses) else self.inverses[-1]

    def partial(self, index: int) -> Partial | None:
        """The partial derivative by the operand at `index`, None if there is none."""
        return self.partials[index] if index < len(self.partials) else self.partials[-1]

    def __repr__(self) -> str:
        return f"<operator {self.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return (_by_name, (self.name,))


def _by_name(name: str) -> Operator:
    return OPERATORS[name] if name in OPERATORS else LEAVES[name]


OPERATORS: dict[str, Operator] = {}
"""Every operator by its wire name."""


def _define(*row: Any, **more: Any) -> None:
    op = Operator(*row, **more)
    OPERATORS[op.name] = op


# Leaves: where an expression begins. They compute nothing, so they are not in the table.
LITERAL = Operator("literal", "", None, lambda: None)
SOURCE = Operator("source", "", None, lambda: None)
LEAVES = {"literal": LITERAL, "source": SOURCE}

# A node whose operator and operands are worked out when somebody asks for them.
DEFERRED = Operator("deferred", "", None, lambda: None)


# ---------------------------------------------------------------- helpers of the rows


def _quotient(target: Any, factor: Any) -> Any:
    """target / factor, an int where that is exact (large integers keep every digit)."""
    if type(target) is int and type(factor) is int:
        whole, rest = divmod(target, factor)
        if not rest:
            return whole
    return target / factor


def _root(target: Any, base: Any, exponent: Any) -> Any:
    """The base whose power is `target`, on the side of zero on which the base is now."""
    if target < 0:
        if exponent == int(exponent) and int(exponent) % 2:
            return -((-target) ** (1 / exponent))
        raise ValueError("an even power is never negative")
    root = target ** (1 / exponent)
    if base < 0 and exponent == int(exponent) and int(exponent) % 2 == 0:
        return -root
    return root


def _power_by_base(base: Any, exponent: Any) -> float:
    return 0.0 if exponent == 0 else exponent * base ** (exponent - 1)


def _power_by_exponent(base: Any, exponent: Any) -> float:
    return math.log(base) * base**exponent


def _shifted(forward: Callable[..., Any]) -> Inverse:
    """Inverse of a rounding: move the operand by as much as the result has to move."""

    def inverse(target: Any, value: Any, *rest: Any) -> Any:
        if not rest and target != math.floor(target):
            raise ValueError("only whole numbers are possible")
        moved = value + (target - forward(value, *rest))
        return moved if forward(moved, *rest) == target else target

    return inverse


def _nearest(angle: float, now: float, period: float) -> float:
    """`angle` plus the multiple of `period` that brings it next to `now`."""
    return angle + period * round((now - angle) / period)


def _closer(now: float, *candidates: float) -> float:
    return min(candidates, key=lambda candidate: abs(candidate - now))


def _unsine(target: Any, x: Any) -> float:
    angle, turn = math.asin(target), 2 * math.pi
    return _closer(x, _nearest(angle, x, turn), _nearest(math.pi - angle, x, turn))


def _uncosine(target: Any, x: Any) -> float:
    angle, turn = math.acos(target), 2 * math.pi
    return _closer(x, _nearest(angle, x, turn), _nearest(-angle, x, turn))


def _unabs(target: Any, x: Any) -> Any:
    if target < 0:
        raise ValueError("an absolute value is never negative")
    return -target if x < 0 else target


def _unmod(target: Any, a: Any, b: Any) -> Any:
    if not (0 <= target < b or b < target <= 0):
        raise ValueError(f"a remainder by {b!r} lies between 0 and {b!r}")
    return a + (target - a % b)


def _unhypot(target: Any, *sides: Any, index: int = 0) -> Any:
    rest = target * target - sum(s * s for i, s in enumerate(sides) if i != index)
    if target < 0 or rest < 0:
        raise ValueError("the other sides are longer already")
    return math.copysign(math.sqrt(rest), sides[index])


def _unless_zero(slope: Callable[..., float]) -> Partial:
    """A slope with a pole: infinite rather than an error."""

    def partial(*operands: Any) -> float:
        try:
            return slope(*operands)
        except ZeroDivisionError:
            return math.inf

    return partial


# ---------------------------------------------------------------- Python's own operators

_define(
    "add", "+", 12, operator.add,
    (lambda t, a, b: t - b, lambda t, a, b: t - a),
    (lambda a, b: 1.0,),
)  # fmt: skip
_define(
    "sub", "-", 12, operator.sub,
    (lambda t, a, b: t + b, lambda t, a, b: a - t),
    (lambda a, b: 1.0, lambda a, b: -1.0),
)  # fmt: skip
_define(
    "mul", "*", 13, operator.mul,
    (
        lambda t, a, b: t / b if type(t) is float else _quotient(t, b),
        lambda t, a, b: t / a if type(t) is float else _quotient(t, a),
    ),
    (lambda a, b: b, lambda a, b: a),
    "a multiplication by zero is always zero",
)  # fmt: skip
_define(
    "truediv", "/", 13, operator.truediv,
    (lambda t, a, b: t * b, lambda t, a, b: a / t),
    (lambda a, b: 1 / b, lambda a, b: -a / (b * b)),
    "zero divided by anything is always zero",
)  # fmt: skip
_define(
    "floordiv", "//", 13, operator.floordiv,
    (lambda t, a, b: a + (t - a // b) * b, None),
    (lambda a, b: 1 / b, lambda a, b: -a / (b * b)),
    "only whole numbers are possible",
)  # fmt: skip
_define(
    "mod", "%", 13, operator.mod,
    (_unmod, None),
    (lambda a, b: 1.0, lambda a, b: -float(a // b)),
    "a remainder lies between zero and the divisor",
)  # fmt: skip
_define(
    "pow", "**", 15, operator.pow,
    (_root, lambda t, a, b: math.log(t) / math.log(a)),
    (_power_by_base, _power_by_exponent),
    "not every number is a power",
)  # fmt: skip
_define("powmod", "pow", None, pow)
_define(
    "lshift", "<<", 11, operator.lshift,
    (lambda t, a, b: t >> b, None),
    (lambda a, b: float(1 << b), lambda a, b: (a << b) * math.log(2)),
    "only multiples of a power of two are possible",
)  # fmt: skip
_define(
    "rshift", ">>", 11, operator.rshift,
    (lambda t, a, b: (t << b) | (a & ((1 << b) - 1)), None),
    (lambda a, b: 1.0 / (1 << b), None),
)  # fmt: skip
_define("and", "&", 10, operator.and_)
_define("xor", "^", 9, operator.xor, (lambda t, a, b: t ^ b, lambda t, a, b: t ^ a))
_define("or", "|", 8, operator.or_)
_define("neg", "-", 14, operator.neg, (lambda t, a: -t,), (lambda a: -1.0,))
_define("pos", "+", 14, operator.pos, (lambda t, a: t,), (lambda a: 1.0,))
# An element of an array: what was put there, as the array holds it. Nobody sees it in a text.
_define("same", "", 98, lambda a: a, (lambda t, a: t,), (lambda a: 1.0,))
_define("invert", "~", 14, operator.invert, (lambda t, a: ~t,), (lambda a: -1.0,))
_define(
    "abs", "abs", None, abs, (_unabs,), (lambda a: math.copysign(1.0, a),),
    "an absolute value is never negative",
)  # fmt: skip

# ---------------------------------------------------------------- conversions and rounding

_define("float", "float", None, float, (lambda t, a: t,), (lambda a: 1.0,))
for _name, _forward in {
    "int": int,
    "round": round,
    "trunc": math.trunc,
    "floor": math.floor,
    "ceil": math.ceil,
}.items():
    _define(
        _name, _name, None, _forward, (_shifted(_forward), None), (lambda *a: 1.0, None),
        "only rounded numbers are possible",
    )  # fmt: skip
def _sum_inverse(index: int) -> Inverse:
    def inverse(target: Any, *operands: Any) -> Any:
        return target - sum(operands[:index]) - sum(operands[index + 1 :])

    return inverse


# Operators with any number of operands make the inverse for an index when it is asked for.
class _AnyOperand(Operator):
    __slots__ = ("make_inverse", "make_partial")

    def __init__(self, name, symbol, forward, make_inverse, make_partial, domain=""):
        inverses = (make_inverse(0), make_inverse(1))
        super().__init__(name, symbol, None, forward, inverses, domain=domain)
        self.make_inverse = make_inverse
        self.make_partial = make_partial

    def inverse(self, index):
        return self.make_inverse(index)

    def partial(self, index):
        return self.make_partial(index)


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
        return base + _quotient(target - others, slope)

    return inverse


def _affine_partial(index: int) -> Partial | None:
    return (lambda *operands: operands[index + 2]) if index % 4 == 1 else None


def _choice_inverse(choose: Callable[..., Any]) -> Callable[[int], Inverse]:
    """Of min and max: an operand gives the result as long as the others leave it the choice."""

    def make_inverse(index: int) -> Inverse:
        def inverse(target: Any, *operands: Any) -> Any:
            limit = choose(*operands[:index], *operands[index + 1 :])
            if choose(target, limit) != target:
                raise ValueError(f"limited to {limit!r}")
            return target

        return inverse

    return make_inverse


def _choice_partial(choose: Callable[..., Any]) -> Callable[[int], Partial]:
    return lambda index: lambda *operands: float(operands[index] == choose(*operands))


for _row in (
    _AnyOperand("min", "min", min, _choice_inverse(min), _choice_partial(min)),
    _AnyOperand("max", "max", max, _choice_inverse(max), _choice_partial(max)),
    _AnyOperand("sum", "sum", lambda *operands: sum(operands[1:], operands[0]),
                _sum_inverse, lambda index: lambda *operands: 1.0),
    _AnyOperand("affine", "affine", _affine, _affine_inverse, _affine_partial),
    _AnyOperand("linear", "about", _affine, _affine_inverse, _affine_partial),
    _AnyOperand("hypot", "hypot", math.hypot,
                lambda index: lambda t, *sides: _unhypot(t, *sides, index=index),
                lambda index: _unless_zero(lambda *sides: sides[index] / math.hypot(*sides)),
                "a length is never negative"),
):  # fmt: skip
    OPERATORS[_row.name] = _row

# ---------------------------------------------------------------- module math

_unit = "values lie between -1 and 1"
for _row in (
    ("sin", _unsine, math.cos, _unit),
    ("cos", _uncosine, lambda x: -math.sin(x), _unit),
    ("tan", lambda t, x: _nearest(math.atan(t), x, math.pi), lambda x: 1 / math.cos(x) ** 2, ""),
    ("asin", lambda t, x: _within(t, math.pi / 2, math.sin), _unless_zero(lambda x: 1 / math.sqrt(1 - x * x)), "values lie between -pi/2 and pi/2"),
    ("acos", lambda t, x: _within(t - math.pi / 2, math.pi / 2, lambda u: math.cos(u + math.pi / 2)), _unless_zero(lambda x: -1 / math.sqrt(1 - x * x)), "values lie between 0 and pi"),
    ("atan", lambda t, x: _within(t, math.pi / 2, math.tan), lambda x: 1 / (1 + x * x), "values lie between -pi/2 and pi/2"),
    ("sinh", lambda t, x: math.asinh(t), math.cosh, ""),
    ("cosh", lambda t, x: math.copysign(math.acosh(t), x), math.sinh, "values are at least 1"),
    ("tanh", lambda t, x: math.atanh(t), lambda x: 1 - math.tanh(x) ** 2, _unit),
    ("asinh", lambda t, x: math.sinh(t), lambda x: 1 / math.sqrt(x * x + 1), ""),
    ("acosh", lambda t, x: math.cosh(t), _unless_zero(lambda x: 1 / math.sqrt(x * x - 1)), "values are not negative"),
    ("atanh", lambda t, x: math.tanh(t), _unless_zero(lambda x: 1 / (1 - x * x)), ""),
    ("exp", lambda t, x: math.log(t), math.exp, "values are positive"),
    ("exp2", lambda t, x: math.log2(t), lambda x: math.log(2) * math.exp2(x), "values are positive"),
    ("expm1", lambda t, x: math.log1p(t), math.exp, "values are greater than -1"),
    ("log2", lambda t, x: math.exp2(t), lambda x: 1 / (x * math.log(2)), ""),
    ("log10", lambda t, x: 10.0**t, lambda x: 1 / (x * math.log(10)), ""),
    ("log1p", lambda t, x: math.expm1(t), lambda x: 1 / (1 + x), ""),
    ("sqrt", lambda t, x: t * t if t >= 0 else math.sqrt(t), _unless_zero(lambda x: 0.5 / math.sqrt(x)), "a root is never negative"),
    ("cbrt", lambda t, x: t**3, _unless_zero(lambda x: 1 / (3 * math.cbrt(x) ** 2)), ""),
    ("degrees", lambda t, x: math.radians(t), lambda x: 180 / math.pi, ""),
    ("radians", lambda t, x: math.degrees(t), lambda x: math.pi / 180, ""),
    ("fabs", _unabs, lambda x: math.copysign(1.0, x), "an absolute value is never negative"),
    ("gamma", None, None, ""),
    ("lgamma", None, None, ""),
    ("erf", None, lambda x: 2 / math.sqrt(math.pi) * math.exp(-x * x), _unit),
    ("erfc", None, lambda x: -2 / math.sqrt(math.pi) * math.exp(-x * x), "values lie between 0 and 2"),
):  # fmt: skip
    _define(_row[0], _row[0], None, getattr(math, _row[0]), (_row[1],), (_row[2],), _row[3])


def _within(target: float, limit: float, inverse: Callable[[float], float]) -> float:
    if abs(target) > limit:
        raise ValueError("out of range")
    return inverse(target)


def _unatan2_y(target: Any, y: Any, x: Any) -> float:
    return x * math.tan(target)


def _unatan2_x(target: Any, y: Any, x: Any) -> float:
    return y / math.tan(target)


def _log(x: Any, *base: Any) -> float:
    return math.log(x, *base)


_define(
    "atan2", "atan2", None, math.atan2,
    (_unatan2_y, _unatan2_x),
    (lambda y, x: x / (x * x + y * y), lambda y, x: -y / (x * x + y * y)),
    "values lie between -pi and pi",
)  # fmt: skip
_define(
    "log", "log", None, _log,
    (lambda t, x, *base: base[0] ** t if base else math.exp(t), lambda t, x, base: x ** (1 / t)),
    (
        lambda x, *base: 1 / (x * math.log(base[0])) if base else 1 / x,
        lambda x, base: -math.log(x) / (base * math.log(base) ** 2),
    ),
)  # fmt: skip
_define(
    "fpow", "pow", None, math.pow,
    (_root, lambda t, a, b: math.log(t) / math.log(a)),
    (_power_by_base, _power_by_exponent),
    "not every number is a power",
)  # fmt: skip
_define(
    "fmod", "fmod", None, math.fmod,
    (lambda t, a, b: a + (t - math.fmod(a, b)), None),
    (lambda a, b: 1.0, lambda a, b: -float(math.trunc(a / b))),
    "a remainder is smaller than the divisor",
)  # fmt: skip
_define(
    "remainder", "remainder", None, math.remainder,
    (lambda t, a, b: a + (t - math.remainder(a, b)), None),
    (lambda a, b: 1.0, lambda a, b: -float(round(a / b))),
    "a remainder is at most half the divisor",
)  # fmt: skip
_define(
    "copysign", "copysign", None, math.copysign,
    (lambda t, a, b: math.copysign(t, a), lambda t, a, b: math.copysign(b or 1.0, t)),
    (lambda a, b: math.copysign(1.0, a) * math.copysign(1.0, b), lambda a, b: 0.0),
)  # fmt: skip
_define(
    "ldexp", "ldexp", None, math.ldexp,
    (lambda t, a, b: math.ldexp(t, -b), None),
    (lambda a, b: math.ldexp(1.0, b), None),
)  # fmt: skip


def _float32(x: Any) -> float:
    try:
        return float(struct.unpack("f", struct.pack("f", x))[0])
    except OverflowError:
        return math.copysign(math.inf, x)


# What a float32 field of a message does to a value on its way.
_define(
    "float32", "float32", None, _float32, (lambda t, a: t,), (lambda a: 1.0,),
    "a float32 has 24 significant bits",
)  # fmt: skip
