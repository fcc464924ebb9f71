"""Rows of the operator table: the functions of module math."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .number_operators import power_by_base, power_by_exponent, quotient, root, shifted, unabs
from .numerical import digamma, numerically, without
from .operator_table import AnyOperands, Inverse, Partial, add, define


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


def _unless_zero(slope: Callable[..., float]) -> Partial:
    """A slope with a pole: infinite rather than an error."""

    def partial(*operands: Any) -> float:
        try:
            return slope(*operands)
        except ZeroDivisionError:
            return math.inf

    return partial


def _within(target: float, limit: float, inverse: Callable[[float], float]) -> float:
    if abs(target) > limit:
        raise ValueError("out of range")
    return inverse(target)


def _unarccosine(target: Any, x: Any) -> float:
    return _within(target - math.pi / 2, math.pi / 2, lambda u: math.cos(u + math.pi / 2))


def _unsqrt(target: Any, x: Any) -> float:
    if target < 0:
        raise ValueError("a root is never negative")
    return target * target


def _unhypot(index: int) -> Inverse:
    def inverse(target: Any, *sides: Any) -> float:
        rest = target * target - sum(s * s for i, s in enumerate(sides) if i != index)
        if target < 0 or rest < 0:
            raise ValueError("the other sides are longer already")
        return math.copysign(math.sqrt(rest), sides[index])

    return inverse


def _hypot_partial(index: int) -> Partial:
    return _unless_zero(lambda *sides: sides[index] / math.hypot(*sides))


def _erf_slope(x: float) -> float:
    return 2 / math.sqrt(math.pi) * math.exp(-x * x)


def _erfc_slope(x: float) -> float:
    return -_erf_slope(x)


def _gamma_slope(x: float) -> float:
    return math.gamma(x) * digamma(x)


_UNIT = "values lie between -1 and 1"
_QUARTER = "values lie between -pi/2 and pi/2"
_POSITIVE = "values are positive"

# name: inverse, derivative, domain
_UNARY: dict[str, tuple[Inverse | None, Partial | None, str]] = {
    "sin": (_unsine, math.cos, _UNIT),
    "cos": (_uncosine, lambda x: -math.sin(x), _UNIT),
    "tan": (
        lambda t, x: _nearest(math.atan(t), x, math.pi),
        lambda x: 1 / math.cos(x) ** 2,
        "",
    ),
    "asin": (
        lambda t, x: _within(t, math.pi / 2, math.sin),
        _unless_zero(lambda x: 1 / math.sqrt(1 - x * x)),
        _QUARTER,
    ),
    "acos": (
        _unarccosine,
        _unless_zero(lambda x: -1 / math.sqrt(1 - x * x)),
        "values lie between 0 and pi",
    ),
    "atan": (
        lambda t, x: _within(t, math.pi / 2, math.tan),
        lambda x: 1 / (1 + x * x),
        _QUARTER,
    ),
    "sinh": (lambda t, x: math.asinh(t), math.cosh, ""),
    "cosh": (
        lambda t, x: math.copysign(math.acosh(t), x),
        math.sinh,
        "values are at least 1",
    ),
    "tanh": (lambda t, x: math.atanh(t), lambda x: 1 - math.tanh(x) ** 2, _UNIT),
    "asinh": (lambda t, x: math.sinh(t), lambda x: 1 / math.sqrt(x * x + 1), ""),
    "acosh": (
        lambda t, x: math.cosh(t),
        _unless_zero(lambda x: 1 / math.sqrt(x * x - 1)),
        "values are not negative",
    ),
    "atanh": (lambda t, x: math.tanh(t), _unless_zero(lambda x: 1 / (1 - x * x)), ""),
    "exp": (lambda t, x: math.log(t), math.exp, _POSITIVE),
    "exp2": (lambda t, x: math.log2(t), lambda x: math.log(2) * math.exp2(x), _POSITIVE),
    "expm1": (lambda t, x: math.log1p(t), math.exp, "values are greater than -1"),
    "log2": (lambda t, x: math.exp2(t), lambda x: 1 / (x * math.log(2)), ""),
    "log10": (lambda t, x: 10.0**t, lambda x: 1 / (x * math.log(10)), ""),
    "log1p": (lambda t, x: math.expm1(t), lambda x: 1 / (1 + x), ""),
    "sqrt": (_unsqrt, _unless_zero(lambda x: 0.5 / math.sqrt(x)), "a root is never negative"),
    "cbrt": (lambda t, x: t**3, _unless_zero(lambda x: 1 / (3 * math.cbrt(x) ** 2)), ""),
    "degrees": (lambda t, x: math.radians(t), lambda x: 180 / math.pi, ""),
    "radians": (lambda t, x: math.degrees(t), lambda x: math.pi / 180, ""),
    "fabs": (
        unabs,
        lambda x: math.copysign(1.0, x),
        "an absolute value is never negative",
    ),
    "gamma": (numerically(math.gamma, _gamma_slope), _gamma_slope, ""),
    "lgamma": (numerically(math.lgamma, digamma), digamma, ""),
    "erf": (numerically(math.erf, _erf_slope), _erf_slope, _UNIT),
    "erfc": (numerically(math.erfc, _erfc_slope), _erfc_slope, "values lie between 0 and 2"),
}
for _name, (_inverse, _partial, _domain) in _UNARY.items():
    define(_name, _name, None, getattr(math, _name), (_inverse,), (_partial,), _domain)


def _unatan2_y(target: Any, y: Any, x: Any) -> float:
    return x * math.tan(target)


def _unatan2_x(target: Any, y: Any, x: Any) -> float:
    return y / math.tan(target)


def _log(x: Any, *base: Any) -> float:
    return math.log(x, *base)


define(
    "atan2", "atan2", None, math.atan2,
    (_unatan2_y, _unatan2_x),
    (lambda y, x: x / (x * x + y * y), lambda y, x: -y / (x * x + y * y)),
    "values lie between -pi and pi",
)  # fmt: skip
define(
    "log", "log", None, _log,
    (lambda t, x, *base: base[0] ** t if base else math.exp(t), lambda t, x, base: x ** (1 / t)),
    (
        lambda x, *base: 1 / (x * math.log(base[0])) if base else 1 / x,
        lambda x, base: -math.log(x) / (base * math.log(base) ** 2),
    ),
)  # fmt: skip
define(
    "fpow", "pow", None, math.pow,
    (root, lambda t, a, b: math.log(t) / math.log(a)),
    (power_by_base, power_by_exponent),
    "not every number is a power",
)  # fmt: skip
define(
    "fmod", "fmod", None, math.fmod,
    (lambda t, a, b: a + (t - math.fmod(a, b)), None),
    (lambda a, b: 1.0, lambda a, b: -float(math.trunc(a / b))),
    "a remainder is smaller than the divisor",
)  # fmt: skip
define(
    "remainder", "remainder", None, math.remainder,
    (lambda t, a, b: a + (t - math.remainder(a, b)), None),
    (lambda a, b: 1.0, lambda a, b: -float(round(a / b))),
    "a remainder is at most half the divisor",
)  # fmt: skip
define(
    "copysign", "copysign", None, math.copysign,
    (lambda t, a, b: math.copysign(t, a), lambda t, a, b: math.copysign(b or 1.0, t)),
    (lambda a, b: math.copysign(1.0, a) * math.copysign(1.0, b), lambda a, b: 0.0),
)  # fmt: skip
define(
    "ldexp", "ldexp", None, math.ldexp,
    (lambda t, a, b: math.ldexp(t, -b), None),
    (lambda a, b: math.ldexp(1.0, b), None),
)  # fmt: skip
add(
    AnyOperands(
        "hypot", "hypot", math.hypot, _unhypot, _hypot_partial, "a length is never negative"
    )
)

# ---------------------------------------------------------------- parts of a float


def _unfraction(target: Any, x: Any) -> float:
    whole = math.modf(x)[1]
    if not abs(target) < 1 or (whole and target * whole < 0):
        raise ValueError("a fraction is less than 1, and on the same side of zero")
    return float(whole + target)


def _unmantissa(target: Any, x: Any) -> float:
    if target and not 0.5 <= abs(target) < 1:
        raise ValueError("a mantissa lies between 0.5 and 1")
    return math.ldexp(target, math.frexp(x)[1])


def _unnext(target: Any, x: Any, towards: Any) -> float:
    before = math.nextafter(target, math.copysign(math.inf, target - towards))
    return before if math.nextafter(before, towards) == target else target


def modf_fraction(x: Any) -> float:
    """The first part of ``modf(x)``."""
    return math.modf(x)[0]


def modf_whole(x: Any) -> float:
    """The second part of ``modf(x)``."""
    return math.modf(x)[1]


def frexp_mantissa(x: Any) -> float:
    """The first part of ``frexp(x)``."""
    return math.frexp(x)[0]


def frexp_exponent(x: Any) -> int:
    """The second part of ``frexp(x)``."""
    return math.frexp(x)[1]


define("modf_fraction", "fraction", None, modf_fraction, (_unfraction,), (lambda x: 1.0,))
define("modf_whole", "trunc", None, modf_whole, (shifted(modf_whole),), (lambda x: 1.0,))
define("frexp_mantissa", "mantissa", None, frexp_mantissa, (_unmantissa,),
       (lambda x: math.ldexp(1.0, -math.frexp(x)[1]),))  # fmt: skip
define("frexp_exponent", "exponent", None, frexp_exponent,
       (lambda t, x: math.ldexp(math.frexp(x)[0], t),), (None,))  # fmt: skip
define("nextafter", "nextafter", None, math.nextafter, (_unnext, None), (lambda x, y: 1.0, None))
define("ulp", "ulp", None, math.ulp, (None,), (lambda x: 0.0,))

# ---------------------------------------------------------------- sums


def _fsum(*operands: Any) -> float:
    return math.fsum(operands)


def _unfsum(index: int) -> Inverse:
    return lambda target, *operands: target - math.fsum(without(operands, index))


def sumprod(*operands: Any) -> Any:
    """``math.sumprod`` of the first half of the operands and the second one."""
    half = len(operands) // 2
    p, q = operands[:half], operands[half:]
    plain = getattr(math, "sumprod", None)  # new in 3.12
    if plain is not None:
        return plain(p, q)
    from fractions import Fraction  # takes long to import, and few need it

    products = [Fraction(a) * Fraction(b) for a, b in zip(p, q, strict=True)]
    kind = float if any(type(operand) is float for operand in operands) else int
    return kind(sum(products))


def _partner(operands: tuple[Any, ...], index: int) -> Any:
    return operands[(index + len(operands) // 2) % len(operands)]


def _unsumprod(index: int) -> Inverse:
    def inverse(target: Any, *operands: Any) -> Any:
        factor = _partner(operands, index)
        rest = sumprod(*(0 if i == index else operand for i, operand in enumerate(operands)))
        return quotient(target - rest, factor)

    return inverse


add(AnyOperands("fsum", "fsum", _fsum, _unfsum, lambda index: lambda *operands: 1.0))
add(
    AnyOperands(
        "sumprod", "sumprod", sumprod, _unsumprod,
        lambda index: lambda *operands: _partner(operands, index),
    )
)  # fmt: skip
