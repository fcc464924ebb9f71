"""Every operator of Python on tracked values does what it does on the plain ones."""

from __future__ import annotations

import copy
import enum
import math
import operator
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rosslt_auto.provenance import is_tracked
from rosslt_auto.provenance.expressions import evaluate
from support.tracked import bits, outcome, tracked


class Colour(enum.IntEnum):
    RED = 1
    GREEN = 3


ARITHMETIC = [
    operator.add, operator.sub, operator.mul, operator.truediv, operator.floordiv, operator.mod,
    operator.pow, divmod, operator.matmul,
    operator.iadd, operator.isub, operator.imul, operator.itruediv, operator.ifloordiv,
    operator.imod, operator.ipow, operator.imatmul,
]  # fmt: skip
BITWISE = [
    operator.and_, operator.or_, operator.xor, operator.lshift, operator.rshift,
    operator.iand, operator.ior, operator.ixor, operator.ilshift, operator.irshift,
]  # fmt: skip
COMPARISONS = [operator.lt, operator.le, operator.eq, operator.ne, operator.gt, operator.ge]
BINARY = ARITHMETIC + BITWISE + COMPARISONS
EXPLODING = {operator.pow, operator.ipow, operator.lshift, operator.ilshift, operator.mul}
EXPLODING |= {operator.imul}
UNARY = [
    operator.neg, operator.pos, operator.abs, operator.invert, operator.not_, operator.index,
    operator.truth, round, math.trunc, math.floor, math.ceil, float, int, complex, bool, str,
    repr, hash, len, iter, ascii, bin, oct, hex, chr, sum, sorted,
]  # fmt: skip

floats = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, 2.5, 3.5, math.inf, -math.inf, math.nan, 5e-324,
                     1.7976931348623157e308, 0.1, 1e16]),
    st.floats(),
)  # fmt: skip
small_ints = st.integers(-9, 9)
ints = st.one_of(small_ints, st.integers(-(2**70), 2**70))
numbers = st.one_of(floats, ints)
small_numbers = st.one_of(floats, small_ints)
others = st.one_of(
    st.booleans(),
    st.sampled_from(list(Colour)),
    st.complex_numbers(),
    st.fractions(max_denominator=99),
    st.sampled_from([Decimal("1.5"), Decimal("NaN"), Decimal(0)]),
    st.sampled_from([np.float64(1.5), np.float32(2.5), np.int64(3), np.int8(-2), np.bool_(True)]),
    st.sampled_from([np.array([1.0, 2.0]), np.array([1, 0]), np.array([1.5], dtype=np.float32)]),
    st.sampled_from(["ab", "", "%d", "%s and", b"x", [1, 2], (1, 2), None, {1: 2}, range(3)]),
    st.sampled_from([object, print, NotImplemented, ...]),
)


def check(op: Any, left: Any, right: Any) -> None:
    def result(wrap_left: Any, wrap_right: Any) -> Any:
        # Copies: an in-place operator changes an array.
        return outcome(op, wrap_left(copy.copy(left)), wrap_right(copy.copy(right)))

    def same(value: Any) -> Any:
        return value

    with np.errstate(all="ignore"):
        expected = result(same, same)
        assert result(tracked, same) == expected
        assert result(same, tracked) == expected
        assert result(tracked, tracked) == expected


@pytest.mark.parametrize("op", BINARY, ids=lambda op: op.__name__)
@given(data=st.data())
def test_numbers_with_numbers(op: Any, data: Any) -> None:
    pool = small_numbers if op in EXPLODING else numbers
    check(op, data.draw(pool), data.draw(pool))


@pytest.mark.parametrize("op", BINARY, ids=lambda op: op.__name__)
@given(data=st.data())
def test_numbers_with_anything_else(op: Any, data: Any) -> None:
    number, other = data.draw(small_numbers), data.draw(others)
    check(op, number, other)
    check(op, other, number)


@pytest.mark.parametrize("op", UNARY, ids=lambda op: op.__name__)
@given(value=numbers)
def test_unary(op: Any, value: Any) -> None:
    assume(not (op is hash and math.isnan(value)))  # that one depends on the object
    assert outcome(op, tracked(value)) == outcome(op, value)


@given(value=numbers, digits=st.one_of(st.integers(-20, 20), st.sampled_from([None, 1.5, "2"])))
def test_round_with_digits(value: Any, digits: Any) -> None:
    expected = outcome(round, value, digits)
    assert outcome(round, tracked(value), digits) == expected
    assert outcome(round, value, tracked(digits)) == expected
    assert outcome(round, tracked(value), tracked(digits)) == expected


@given(
    st.one_of(ints, floats), st.one_of(small_ints, floats),
    st.one_of(ints, floats, st.sampled_from([None, "x", Fraction(1, 2), True])),
)  # fmt: skip
def test_power_with_modulus(base: Any, exponent: Any, modulus: Any) -> None:
    if modulus is None and isinstance(base, int):
        assume(abs(base) < 100)
    expected = outcome(pow, base, exponent, modulus)
    for a in (base, tracked(base)):
        for b in (exponent, tracked(exponent)):
            for c in (modulus, tracked(modulus)):
                found = outcome(pow, a, b, c)
                # What Python says of a wrong modulus depends on whose slot it asks last.
                assert found == expected or found[:2] == expected[:2] == ("raises", TypeError)


METHODS = {
    float: ["as_integer_ratio", "conjugate", "hex", "is_integer", "__int__", "__float__",
            "__trunc__", "__floor__", "__ceil__", "__round__", "__bool__", "__getnewargs__"],
    int: ["as_integer_ratio", "bit_count", "bit_length", "conjugate", "__int__", "__float__",
          "__index__", "__trunc__", "__floor__", "__ceil__", "__round__", "__bool__",
          "__getnewargs__"],
}  # fmt: skip


@given(numbers)
def test_methods_and_attributes(value: Any) -> None:
    for name in METHODS[type(value)]:
        assert outcome(getattr(tracked(value), name)) == outcome(getattr(value, name)), name
    for name in ("real", "imag", "numerator", "denominator", "__doc__", "nonsense"):
        got, expected = outcome(getattr, tracked(value), name), outcome(getattr, value, name)
        assert got == expected, name


@pytest.mark.parametrize(
    "function", [f for name, f in vars(math).items() if callable(f) and name[0] != "_"],
    ids=lambda f: f.__name__,
)  # fmt: skip
@given(data=st.data())
def test_module_math_takes_them(function: Any, data: Any) -> None:
    """Also where it is called by code that is not instrumented."""
    pool = small_ints if function.__name__ in ("factorial", "perm", "comb") else small_numbers
    a, b = data.draw(pool), data.draw(pool)
    for operands in ((a,), (a, b), ([a, b],), ((a, b), (b, a))):
        wrapped = [
            type(o)(tracked(i) for i in o) if isinstance(o, (list, tuple)) else tracked(o)
            for o in operands
        ]
        if function is math.fsum or function.__name__ == "sumprod":
            assume(all(map(math.isfinite, (a, b))))
        assert outcome(function, *wrapped) == outcome(function, *operands)


# ---------------------------------------------------------------- other people's numbers


def make_logging(base: type, names: tuple[str, ...], log: list[Any]) -> type:
    """A subclass of float or int that notes how it is asked, and declines every second time."""

    def method(name: str) -> Any:
        def asked(self: Any, other: Any) -> Any:
            log.append((name, type(other), bits(other)))
            return NotImplemented if len(log) % 2 else f"{name} of a {base.__name__}"

        return asked

    return type("Logging", (base,), {name: method(name) for name in names})


@pytest.mark.parametrize("base", [float, int])
@pytest.mark.parametrize("implemented", ["both", "left", "reflected", "none"])
@given(value=small_numbers, data=st.data())
def test_subclasses_keep_their_own_dispatch(
    base: type, implemented: str, value: Any, data: Any
) -> None:
    """The same methods are called in the same order with the same operands."""
    op = data.draw(st.sampled_from(ARITHMETIC[:8] + BITWISE[:5]))
    log: list[Any] = []
    name = op.__name__.strip("_")
    names = {
        "both": (f"__{name}__", f"__r{name}__"),
        "left": (f"__{name}__",),
        "reflected": (f"__r{name}__",),
        "none": (),
    }[implemented]
    foreign = make_logging(base, names, log)(3)
    for swap in (False, True):
        found = []
        for number in (value, tracked(value)):
            log.clear()
            pair = (foreign, number) if swap else (number, foreign)
            found.append((outcome(op, *pair), list(log)))
        assert found[0] == found[1]


@given(value=small_numbers, data=st.data())
def test_unrelated_classes_are_asked_last(value: Any, data: Any) -> None:
    op = data.draw(st.sampled_from(BINARY))

    class Vector:
        def __init__(self) -> None:
            self.log: list[Any] = []

        def __getattr__(self, name: str) -> Any:
            raise AttributeError(name)

    def asked(name: str) -> Any:
        return lambda self, other: self.log.append((name, type(other), bits(other)))

    for name in ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow", "divmod", "matmul"):
        setattr(Vector, f"__{name}__", asked(name))
        setattr(Vector, f"__r{name}__", asked(f"r{name}"))
    plain, other = Vector(), Vector()
    assert outcome(op, value, plain)[0] == outcome(op, tracked(value), other)[0]
    assert plain.log == other.log


# ---------------------------------------------------------------- provenance is there


@pytest.mark.parametrize("op", ARITHMETIC[:7] + BITWISE[:5], ids=lambda op: op.__name__)
@given(data=st.data())
def test_numeric_results_are_tracked(op: Any, data: Any) -> None:
    """With operands of either kind; and evaluation without changes gives the value."""
    pool = small_ints if op in BITWISE else st.one_of(small_ints, st.floats(-50, 50))
    a, b = data.draw(pool), data.draw(pool)
    try:
        expected = op(a, b)
    except (ArithmeticError, ValueError):
        return
    for left, right in ((tracked(a), b), (a, tracked(b)), (tracked(a), tracked(b, "y"))):
        if type(left) is float and type(right) is not float and type(b) is int:
            continue  # a plain float asks no int; in instrumented code it is tracked itself
        result = op(left, right)
        assert is_tracked(result) == (type(expected) in (float, int))
        assert outcome(evaluate, result, {}) == outcome(lambda: expected)


def test_pairs_and_roundings_are_tracked() -> None:
    x, n = tracked(7.5), tracked(7)
    for result in (*divmod(x, 2), *divmod(20, n), pow(n, 2, 5), round(x), round(x, 1), -x, +n, ~n,
                   abs(x), math.trunc(x), math.floor(x), math.ceil(x)):  # fmt: skip
        assert is_tracked(result)


def test_booleans_and_comparisons_are_plain() -> None:
    x = tracked(1.5)
    assert (x == 1.5) is True
    assert (x < 1) is False
    assert type(not x) is bool
