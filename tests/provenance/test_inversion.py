"""Forcing values: which source is changed, to what, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rosslt_auto.provenance import NotInvertible, inversion, provenance, untracked
from rosslt_auto.provenance.inversion import (
    alternatives,
    check_target,
    invert,
    invert_many,
    reached,
    rounding,
)
from support.tracked import apply, tracked


def changes(value: Any, target: Any, *policy: str, **options: Any) -> dict[str, Any]:
    found = invert(value, target, *policy, **options)
    assert found.exact
    assert reached(found.value, target)
    return {source.parameter: new for source, new in found.changes.items()}


A, B, C = tracked(2.0, "a"), tracked(3.0, "b"), tracked(5.0, "c")
N, M = tracked(4, "n"), tracked(6, "m")


@pytest.mark.parametrize(
    ("value", "target", "expected"),
    [
        (A + 1, 5.0, {"a": 4.0}), (1 + A, 5.0, {"a": 4.0}), (A - 1, 5.0, {"a": 6.0}),
        (1 - A, 5.0, {"a": -4.0}), (A * 4, 2.0, {"a": 0.5}), (A / 4, 2.0, {"a": 8.0}),
        (4 / A, 8.0, {"a": 0.5}), (-A, 5.0, {"a": -5.0}), (A**2, 9.0, {"a": 3.0}),
        (2**A, 8.0, {"a": 3.0}), (abs(-A), 7.0, {"a": 7.0}), (N + 1, 9, {"n": 8}),
        (N * 3, 21, {"n": 7}), (N // 2, 5, {"n": 10}), (N % 5, 2, {"n": 2}), (~N, 5, {"n": -6}),
        (N << 2, 32, {"n": 8}), (N >> 1, 5, {"n": 10}), (N ^ 1, 8, {"n": 9}),
        (N / 8, 2.0, {"n": 16}),
        (A + B, 7.0, {"a": 4.0}), (B + A, 7.0, {"b": 5.0}), (A * 1.5 + B * C, 3.0, {"a": -8.0}),
        (A, 7.5, {"a": 7.5}), (N, 7, {"n": 7}), (A, 7, {"a": 7.0}),
    ],
)  # fmt: skip
def test_left_bias(value: Any, target: Any, expected: dict[str, Any]) -> None:
    assert changes(value, target) == pytest.approx(expected)


def test_limits() -> None:
    """A clamp gives way on its own side, and the limit is a source like any other."""
    clamped = apply("max", apply("min", A * 2.0, B), 1.0)
    assert untracked(clamped) == 3.0
    assert changes(clamped, 2.0, source="a") == {"a": 1.0}
    assert changes(clamped, 3.5) == {"b": 3.5}
    with pytest.raises(NotInvertible, match="limited to 3"):
        invert(clamped, 3.5, source="a")
    with pytest.raises(NotInvertible, match=r"limited to 1\.0"):
        invert(clamped, 0.5)


def test_coefficients_come_after_names() -> None:
    """The 2 of ``2 * count`` is a source too, but not the one that is meant."""
    two = tracked(2, "two", named=False)
    assert changes(two * N, 14) == {"n": 7}
    assert changes(two * N, 12, source="two") == {"two": 3}


def test_what_cannot_is_passed_over() -> None:
    """An int that would have to be a fraction leaves it to the next source."""
    assert changes(N * A, 9.0) == {"a": 2.25}
    assert changes(N + A, 6.5) == {"a": 2.5}


@pytest.mark.parametrize(
    ("value", "target"),
    [
        (A * 0.0, 1.0), (0.0 * A, -1.0), (A * A, -1.0), (A * A + A, -1.0), (abs(A), -1.0),
        (A % 3, 4.0),
        (0.0 / A, 1.0), (apply("sin", A) + apply("sin", A), 3.0), (A - A, 1.0), (A / A, 2.0),
        (A**2, -4.0),
    ],
)  # fmt: skip
def test_unreachable(value: Any, target: float) -> None:
    for policy in ("left", "least-change"):
        with pytest.raises(NotInvertible) as refusal:
            invert(value, target, policy)
        assert str(refusal.value)


@pytest.mark.parametrize(
    ("value", "target"),
    [
        (A, math.nan),
        (A, math.inf),
        (A, "1"),
        (A, True),
        (A, None),
        (N, 1.0),
        (N, math.nan),
        (A, 1j),
    ],
)
def test_wrong_targets(value: Any, target: Any) -> None:
    with pytest.raises(NotInvertible):
        check_target(value, target)
    with pytest.raises(NotInvertible):
        invert(value * 2, target)


def test_wrong_questions() -> None:
    with pytest.raises(NotInvertible, match="no provenance"):
        invert(1.5, 2.0)
    with pytest.raises(NotInvertible, match="policy"):
        invert(A, 2.0, "nonsense")
    with pytest.raises(NotInvertible, match="not a source"):
        invert(A, 2.0, source="b")
    assert provenance(1.5) is None
    with pytest.raises(KeyError, match="not a source"):
        provenance(A).evaluate({"b": 1.0})


@pytest.mark.parametrize(
    ("value", "target"),
    [
        (A * A, 9.0), (A * A * A, -27.0), (A * A + 3 * A, 2.0), (A + A, 5.0), (A * B + A, 5.0),
        (apply("sin", A) + A, 4.0), (apply("exp", A) * A, 1.0), (A / (A + 1), 0.25),
        (apply("cos", A) * A, 10.0),
    ],
)  # fmt: skip
def test_aliasing(value: Any, target: float) -> None:
    """A source that occurs several times (Section V-A)."""
    assert list(changes(value, target)) == ["a"]


@pytest.mark.parametrize(
    ("value", "target", "expected"),
    [
        (N * 7 // 3, 11, {"n": 5}),
        (N * 2 // 3, 3, {"n": 5}),
        (N * tracked(7, "m") // 3, 12, {"m": 9}),
        (tracked(14, "n") % M, 6, {"m": 8}),
        (apply("round", N * 0.3), 3, {"n": 11}),
    ],
)
def test_whole_numbers_reach_what_rounding_gives(
    value: Any, target: int, expected: dict[str, int]
) -> None:
    """The exact inverse lies between two whole numbers, one of them is a solution as well."""
    assert changes(value, target) == expected


def test_nearest_of_whole_numbers() -> None:
    for value, target, expected in ((N * 2, 15, {"n": 7}), (N * N, 26, {"n": 5})):
        found = invert(value, target)
        assert not found.exact
        assert {s.parameter: new for s, new in found.changes.items()} == expected
        assert untracked(found.value) != target
    with pytest.raises(NotInvertible):
        invert(tracked(7, "n") * 2, 15)  # it is as near as it can be


def test_least_change() -> None:
    """Every source moves a little for its size, instead of one by all."""
    found = changes(A + B + C, 20.0, "least-change")
    assert list(sorted(found)) == ["a", "b", "c"]
    assert found["a"] < found["b"] < found["c"]
    assert changes(A + B, 5.0, "least-change") == {}


@pytest.mark.parametrize(
    "values",
    [
        [A + B, A * C],
        [A * A * C, B * B * A + C],
        [apply("sin", A) * B, apply("cos", A) * B + C],
        [A * 2.0, A + B],
        [N * 0.5, A + N],
    ],
)
def test_targets_together_and_one_after_another_change_the_same(values: list[Any]) -> None:
    targets = [
        (value, untracked(value) + by) for value, by in zip(values, (0.5, 0.01), strict=True)
    ]
    together = inversion._at_once(targets, [inversion._candidates(v, None) for v in values])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(inversion, "_at_once", lambda *_: None)
        one_by_one = invert_many(targets).changes
    assert together is not None
    assert together.changes.keys() == one_by_one.keys()
    for source, new in together.changes.items():
        assert new == pytest.approx(one_by_one[source], rel=1e-9)


def test_several_targets() -> None:
    x, y, angle = tracked(1.0, "x"), tracked(2.0, "y"), tracked(0.5, "angle")
    cosine, sine = apply("cos", angle), apply("sin", angle)
    targets = [(x * cosine - y * sine, 1.5), (x * sine + y * cosine, 1.8)]
    for policy in ("left", "least-change"):
        found = invert_many(targets, policy)
        assert found.exact
        assert all(reached(v, t) for v, (_, t) in zip(found.values, targets, strict=True))
    with pytest.raises(NotInvertible, match="same source"):
        invert_many([(A + 1, 2.0), (A + 2, 2.0)])
    assert invert_many([(A + 1, 2.0), (A + 2, 3.0)]).exact
    found = invert_many([(A + B, 2.0), (A, 3.0)])  # the first target must not use up a
    assert {s.parameter: new for s, new in found.changes.items()} == pytest.approx(
        {"a": 3.0, "b": -1.0}
    )


def test_alternatives() -> None:
    found = {s.parameter: answer for s, answer in alternatives(A * N + C, 12.0)}
    assert [*found] == ["a", "n", "c"]
    assert found["a"].value == found["c"].value == 12.0
    assert isinstance(found["n"], NotInvertible)


def test_changes_are_what_sources_can_hold() -> None:
    found = invert(A + 0.1, 0.3)
    assert all(type(value) is float for value in found.changes.values())
    found = invert(N + 1.0, 7.0)
    assert [type(value) for value in found.changes.values()] == [int]
    with pytest.raises(NotInvertible, match="64 bits"):
        invert(N * 1, 2**63)


@pytest.mark.parametrize("policy", ["left", "least-change"])
@pytest.mark.parametrize("target", [1e-12, -3e-15])
def test_tiny_targets_are_reached(policy: str, target: float) -> None:
    """The tolerance is relative: nothing is zero because it is small (a covariance, say)."""
    a, b = tracked(2e-11, "a"), tracked(3e-11, "b")
    for value in (a * 3.0, a + b, a * 4.0 - b):
        found = invert(value, target, policy)
        assert found.exact
        assert math.isclose(found.value, target, rel_tol=1e-6)


def test_zero_is_reached_but_for_rounding() -> None:
    """No float has a cosine of zero, and what 1000 was added to has lost digits."""
    assert abs(invert(apply("cos", A) * 5.0, 0.0).value) < 1e-14
    assert abs(invert((A + 1000.0) - 1000.0, 1e-13).value - 1e-13) < 1e-11
    assert abs(invert(apply("sin", A) * A, 0.0).value) < 1e-14


def test_what_is_no_rounding_is_a_difference() -> None:
    assert not reached(0.0, 1e-12)
    assert not reached(1e-12, 1.5e-12)
    assert reached(1e-12, 1e-12 * (1 + 1e-10))
    assert not reached("1", 1) and not reached(2, 3)
    assert rounding(A * 1e-12) == 16 * math.ulp(2.0)


def test_large_integers_keep_every_digit() -> None:
    big = 3**39
    assert changes(tracked(1, "n") * 3, big * 3) == {"n": big}
    assert changes(tracked(1, "n") - big, 1) == {"n": big + 1}


def test_provenance_of_a_value() -> None:
    value = 2 * N + 1
    found = provenance(value)
    assert found.expression == "2 * n + 1"
    assert [source.parameter for source in found.sources] == ["n"]
    assert found.evaluate({}) == 9
    assert found.evaluate({"n": 5}) == found.evaluate({found.sources[0]: 5}) == 11
    assert found.invert(11).value == 11
    assert "9" in repr(found)


def test_least_change_leaves_alone_what_hardly_matters() -> None:
    """A source without influence keeps every digit: its literal is not rewritten."""
    x, y = tracked(1.0, "x"), tracked(0.0, "angle")
    tiny = tracked(2.0, "tiny")
    value = x * apply("cos", y) + tiny * 1e-9
    assert changes(value, 3.0, "least-change").keys() == {"x"}
    value = x * apply("cos", y + 1e-12) + A * 0.0
    assert changes(value, 3.0, "least-change").keys() == {"x"}


@pytest.mark.parametrize(
    ("value", "target", "source", "expected"),
    [
        (A % tracked(1.5, "d"), 0.7, "d", 1.3),
        (apply("fmod", A, tracked(1.5, "d")), 0.8, "d", 1.2),
        (tracked(3, "i") << tracked(2, "s"), 48, "s", 4), (N & 3, 3, "n", 3),
        (apply("float", ~N), -9.0, "n", 8),
    ],
)  # fmt: skip
def test_where_an_operator_has_no_inverse(
    value: Any, target: Any, source: str, expected: Any
) -> None:
    """Its slope, or the numbers around the present one, lead there."""
    assert changes(value, target, source=source) == pytest.approx({source: expected})


def test_least_change_with_whole_numbers_in_the_way() -> None:
    """A shift takes no fractions: the other sources go without it."""
    assert changes(A + (N >> 1), 5.0, "least-change") == {"a": 3.0}
