"""The table of operators: inverses undo, partials are slopes, impossible targets are refused."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rosslt_auto.provenance import NotInvertible, provenance
from rosslt_auto.provenance.expressions import gradient
from rosslt_auto.provenance.inversion import reached
from rosslt_auto.provenance.operators import OPERATORS
from support.tracked import apply, sources_by_name, tracked


class Case(NamedTuple):
    """An operator, where its operands are drawn from, and which of them can be solved for."""

    name: str
    operands: tuple[st.SearchStrategy[Any], ...]
    solvable: tuple[int, ...] = (0,)
    differentiable: tuple[int, ...] | None = None
    on_grid: bool = False  # results are discrete


def reals(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


wide, positive, unit = reals(-50, 50), reals(0.01, 50), reals(-0.99, 0.99)
away = st.one_of(reals(-50, -0.1), reals(0.1, 50))
whole = st.integers(-50, 50)
small = st.integers(0, 8)

CASES = [
    Case("add", (wide, wide), (0, 1)),
    Case("sub", (wide, wide), (0, 1)),
    Case("mul", (away, away), (0, 1)),
    Case("truediv", (away, away), (0, 1)),
    Case("pow", (positive, reals(0.5, 3)), (0,)),
    Case("pow", (reals(1.1, 5), reals(-3, 3)), (1,)),
    Case("neg", (wide,)),
    Case("pos", (wide,)),
    Case("abs", (away,)),
    Case("float", (wide,)),
    Case("floordiv", (wide, away), (0,), (), on_grid=True),
    Case("mod", (wide, reals(0.5, 9)), (0,), ()),
    Case("invert", (whole,), (0,), (), on_grid=True),
    Case("lshift", (whole, small), (0,), (), on_grid=True),
    Case("rshift", (whole, small), (0,), (), on_grid=True),
    Case("xor", (whole, whole), (0, 1), (), on_grid=True),
    *[Case(name, (wide,), (0,), (), True) for name in ("int", "round", "trunc", "floor", "ceil")],
    *[Case(name, (wide,)) for name in ("sin", "cos", "atan", "asinh", "degrees", "radians")],
    *[Case(name, (reals(-3, 3),)) for name in ("sinh", "tanh", "exp", "exp2", "expm1")],
    *[Case(name, (unit,)) for name in ("tan", "asin", "acos", "atanh")],
    *[Case(name, (positive,)) for name in ("log", "log2", "log10", "log1p", "sqrt", "cbrt")],
    Case("cosh", (st.one_of(reals(-3, -0.1), reals(0.1, 3)),)),
    Case("acosh", (reals(1.05, 50),)),
    Case("fabs", (away,)),
    Case("erf", (unit,)),
    Case("erfc", (unit,)),
    Case("gamma", (reals(2, 9),)),
    Case("lgamma", (reals(2, 50),)),
    Case("fsum", (wide, wide, wide), (0, 1, 2)),
    Case("sumprod", (wide, wide, away, away), (0, 1)),
    Case("mean", (wide, wide, wide), (0, 2)),
    Case("fmean", (wide, wide), (0, 1)),
    Case("pvariance", (reals(1, 50), reals(-50, 0), reals(-50, 0)), (0,)),
    Case("pstdev", (reals(1, 50), reals(-50, 0), reals(-50, 0)), (0,)),
    Case("modf_fraction", (reals(3.1, 3.9),)),
    Case("modf_whole", (wide,), (0,), (), on_grid=True),
    Case("frexp_mantissa", (reals(4.1, 7.9),)),
    Case("frexp_exponent", (positive,), (0,), (), on_grid=True),
    Case("nextafter", (wide, st.just(math.inf)), (0,), ()),
    Case("factorial", (st.integers(2, 20),), (0,), (), on_grid=True),
    Case("isqrt", (st.integers(0, 50),), (0,), (), on_grid=True),
    Case("comb", (st.integers(3, 40), st.just(3)), (0,), (), on_grid=True),
    Case("perm", (st.integers(3, 40), st.just(3)), (0,), (), on_grid=True),
    Case("gcd", (st.integers(1, 50), st.just(60)), (0,), (), on_grid=True),
    Case("lcm", (st.integers(1, 50), st.just(6)), (0,), (), on_grid=True),
    Case("atan2", (away, positive), (0, 1)),
    Case("log", (reals(1.5, 50), reals(1.5, 9)), (0, 1)),
    Case("fpow", (positive, reals(0.5, 3)), (0,)),
    Case("fmod", (positive, reals(0.5, 9)), (0,), ()),
    Case("remainder", (positive, reals(0.5, 9)), (0,), ()),
    Case("ldexp", (away, small), (0,), (0,)),
    Case("hypot", (away, away), (0, 1)),
    Case("sum", (wide, wide, wide), (0, 1, 2)),
]
REPEATING = ("mod", "fmod", "remainder", "sin", "cos", "tan")
"""Their results may be much smaller than their operands, and are as inexact as those."""

IDS = [f"{case.name}{case.solvable}" for case in CASES]


@pytest.mark.parametrize("case", CASES, ids=IDS)
@given(data=st.data())
def test_what_the_operator_gives_can_be_asked_for(case: Case, data: Any) -> None:
    """From one value of an operand to the result that another value gives."""
    present = [data.draw(operand) for operand in case.operands]
    for index in case.solvable:
        other = list(present)
        # The other value lies on the same side of zero: where two values give the same result,
        # the nearer is the right one.
        other[index] = data.draw(
            case.operands[index].filter(lambda v, n=present[index]: v * n > 0 or (not v and not n))
        )
        target = OPERATORS[case.name].forward(*other)
        assume(type(target) is int or math.isfinite(target))
        if case.name == "mod":  # which rounding may make as large as the divisor
            assume(target < present[1])
        if case.name == "remainder":  # which jumps at halves of it
            assume(abs(target) < 0.499 * present[1])
        if case.name in REPEATING:  # and which is lost beside a large operand
            assume(not 0 < abs(target) < 1e-6 * abs(present[0]))
        operands = [tracked(v, f"s{i}") if i == index else v for i, v in enumerate(present)]
        value = apply(case.name, *operands)
        try:
            solution = provenance(value).invert(target)
        except NotInvertible:
            slope = abs(gradient(value).get(sources_by_name(value)[f"s{index}"], 0.0))
            assert slope < 1e-6 or case.on_grid, f"{other} gives it"
            raise
        assert solution.exact
        rounding = 1e-14 * abs(present[0]) if case.name in REPEATING else 0.0
        assert reached(solution.value, target) or abs(solution.value - target) < rounding


@pytest.mark.parametrize("case", CASES, ids=IDS)
@given(data=st.data())
def test_partials_are_slopes(case: Case, data: Any) -> None:
    present = [data.draw(operand) for operand in case.operands]
    op = OPERATORS[case.name]
    which = range(len(present)) if case.differentiable is None else case.differentiable
    for index in which:
        if type(present[index]) is int:
            continue
        expected = difference(op.forward, present, index)
        partial = op.partial(index)
        if expected is None:
            continue
        assert partial is not None
        assert math.isclose(partial(*present), expected, rel_tol=1e-4, abs_tol=1e-4)


def difference(function: Callable[..., Any], present: list[Any], index: int) -> float | None:
    """The slope by differences, None where they do not settle."""

    def shifted(by: float) -> float:
        return function(*[v + by if i == index else v for i, v in enumerate(present)])

    try:
        one, two = [(shifted(s) - shifted(-s)) / (2 * s) for s in (1e-5, 5e-6)]
    except (ArithmeticError, ValueError):
        return None
    return two if abs(one - two) <= 1e-5 * max(1.0, abs(two)) else None


IMPOSSIBLE = [
    ("sin", (0.5,), 1.5), ("cos", (0.5,), -2.0), ("tanh", (0.5,), 1.0), ("exp", (0.5,), 0.0),
    ("exp", (0.5,), -1.0), ("sqrt", (4.0,), -2.0), ("abs", (-3.0,), -1.0), ("cosh", (1.0,), 0.5),
    ("asin", (0.5,), 2.0), ("acos", (0.5,), -1.0), ("atan", (0.5,), 2.0),
    ("hypot", (3.0, 4.0), -5.0),
    ("hypot", (3.0, 4.0), 2.0), ("mod", (7.5, 2.0), 3.0), ("mod", (7.5, 2.0), -1.0),
    ("fmod", (7.5, 2.0), 2.5), ("round", (2.4,), 2.5), ("floor", (2.4,), 2.5),
    ("pow", (3.0, 2.0), -1.0),
    ("atan2", (1.0, 2.0), 4.0), ("truediv", (0.0, 2.0), None), ("expm1", (0.5,), -1.5),
    ("fabs", (0.5,), -1.0), ("erf", (0.5,), 1.5), ("floordiv", (7.0, 2.0), 2.5),
]  # fmt: skip


@pytest.mark.parametrize(("name", "present", "target"), IMPOSSIBLE)
def test_the_impossible_is_refused_with_a_reason(
    name: str, present: tuple[float, ...], target: float | None
) -> None:
    """Only the first operand may change."""
    if target is None:
        present, target = (2.0, 0.0), 1.0
        name = "mul"
    value = apply(name, tracked(present[0]), *present[1:])
    if type(value) == int:  # noqa: E721 - that is what it calls itself
        with pytest.raises(NotInvertible, match="is not"):
            provenance(value).invert(target)
        return
    with pytest.raises(NotInvertible) as refusal:
        provenance(value).invert(target)
    assert str(refusal.value)


def test_every_row_is_complete() -> None:
    for name, op in OPERATORS.items():
        assert op.name == name
        assert callable(op.forward)
        assert pickle.loads(pickle.dumps(op)) is op
        assert repr(op) == f"<operator {name}>"
