"""Ranges and frozen sources: inversion keeps to them, and says so where it cannot."""

from typing import Any

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from rosslt_auto.provenance import NotInvertible
from rosslt_auto.provenance.inversion import alternatives, invert, invert_many, reached
from rosslt_auto.provenance.limits import Limits
from rosslt_auto.provenance.locations import source_of
from rosslt_auto.provenance.sources import SourceChangeRefused
from support.tracked import apply, tracked


def limited(value: Any, name: str, *ends: Any) -> Any:
    made = tracked(value, name)
    source_of(made).limits = Limits(*ends)
    return made


def frozen(value: Any, name: str) -> Any:
    made = tracked(value, name)
    source_of(made).frozen = True
    return made


A = limited(1.0, "a", 0.0, 2.0)
B = tracked(3.0, "b")
F = frozen(5.0, "f")


def changes(value: Any, target: Any, *policy: str, **options: Any) -> dict[str, Any]:
    found = invert(value, target, *policy, **options)
    assert found.exact and reached(found.value, target)
    return {source.parameter: new for source, new in found.changes.items()}


def test_left_bias_goes_on_where_a_range_or_a_frozen_literal_ends_it() -> None:
    assert changes(A + B, 5.0) == {"a": 2.0}
    assert changes(A + B, 6.0) == {"b": 5.0}
    assert changes(F * B, 30.0) == {"b": 6.0}


@pytest.mark.parametrize(
    ("value", "target", "reason"),
    [
        (A * 2.0, 5.0, "a is limited to 0.0 to 2.0, it cannot be 2.5"),
        (A + A * A, 50.0, r"a \(0.0 to 2.0\)"),
        (F, 6.0, "f is frozen"),
        (F * frozen(2.0, "g"), 6.0, "f is frozen; g is frozen"),
        (A + F, 9.0, "a is limited to 0.0 to 2.0, it cannot be 4.0"),
    ],
)
def test_refused_with_the_reason(value: Any, target: float, reason: str) -> None:
    with pytest.raises(NotInvertible, match=reason):
        invert(value, target)
    with pytest.raises(NotInvertible):
        invert(value, target, "least-change")


def test_one_that_is_named() -> None:
    """Also where rounding leads just beyond its end."""
    assert changes(limited(0.5, "x", 0.0, 0.3) * 3.0 + F, 5.9, source="x") == {"x": 0.3}
    with pytest.raises(NotInvertible, match="f is frozen"):
        invert(F * B, 30.0, source="f")
    with pytest.raises(NotInvertible, match="a is limited to"):
        invert(A + B, 30.0, source="a")


def test_alternatives_say_why_not() -> None:
    found = {source.parameter: str(answer) for source, answer in alternatives(A + B * F, 30.0)}
    assert "limited to 0.0 to 2.0" in found["a"]
    assert "frozen" in found["f"]
    assert "29.0" not in found["b"] and "5.8" in found["b"]


def test_the_other_root() -> None:
    """Of the two solutions the one in the range, though the other one is nearer."""
    x = limited(0.5, "x", -4.0, 0.6)
    assert changes(x * x - x, 6.0) == pytest.approx({"x": -2.0})


def test_jointly() -> None:
    x, y, z = limited(1.0, "x", 0.0, 1.5), tracked(1.0, "y"), limited(1.0, "z", 0.5, 9.0)
    found = invert_many([(x + y, 6.0), (y - z, 0.0)], "least-change")
    now = {source.parameter: new for source, new in found.changes.items()}
    assert now["x"] == pytest.approx(1.5)
    assert now["y"] == pytest.approx(now["z"]) == pytest.approx(4.5)


@given(
    st.lists(st.tuples(st.floats(-10, 10), st.floats(0.1, 20)), min_size=2, max_size=4),
    st.floats(0.0, 1.0),
)
@example([(0.0, 1.0), (0.0, 1.0)], 1.0)
def test_least_change_stays_inside_and_reaches_what_can_be(
    ranges: list[tuple[float, float]], part: float
) -> None:
    """The sum of numbers in ranges can be anything between the sums of the ends."""
    values = [limited(low + width / 3, f"v{i}", low, low + width)
              for i, (low, width) in enumerate(ranges)]  # fmt: skip
    total = sum(values[1:], values[0])
    low, high = sum(r[0] for r in ranges), sum(r[0] + r[1] for r in ranges)
    target = low + part * (high - low)
    assume(low + 1e-6 < target < high - 1e-6)
    found = invert(total, target, "least-change")
    assert reached(found.value, target)
    for source, new in found.changes.items():
        assert source.limits is not None and source.limits.low <= new <= source.limits.high


def test_steps_are_discrete() -> None:
    x = limited(0.5, "x", 0.0, 2.0, 0.1)
    assert changes(x * 2.0, 1.4) == pytest.approx({"x": 0.7})
    near = invert(x * 2.0, 1.43)
    assert not near.exact and near.value == pytest.approx(1.4)
    assert list(near.changes.values()) == [0.7]
    found = changes(x * 3.0 + B, 9.13, "least-change")
    assert found["x"] in [round(0.1 * n, 1) for n in range(21)] and found["x"] > 0.5


def test_integers_go_to_the_end_of_their_range() -> None:
    n = limited(4, "n", 0, 10)
    assert changes(n * 3, 30) == {"n": 10}
    near = invert(n * 3, 40)
    assert not near.exact and near.value == 30


@pytest.mark.parametrize("kind", [int, float])
def test_what_a_range_allows(kind: type) -> None:
    limits = Limits(kind(-2), kind(7), kind(4))
    assert [n for n in range(-5, 10) if limits.allows(kind(n))] == [-2, 2, 6, 7]  # as rclpy has it
    assert limits.around(kind(3)) == [2, 6]
    assert limits.around(kind(50)) == [7, 6]
    assert [type(one) for one in limits.around(3.3)] == [kind, kind]


def test_a_value_in_the_range_is_converted_before() -> None:
    assert source_of(A).check(2) == 2.0
    with pytest.raises(SourceChangeRefused, match="must be finite"):
        source_of(A).check(float("nan"))


MIN, MAX, V = tracked(-0.5, "low"), tracked(0.5, "high"), tracked(0.3, "v")


@pytest.mark.parametrize("speed", [V, V * 1.0, V + 0.0])
def test_idle_bounds_of_a_clamp_stay(speed: Any) -> None:
    """The lower one would give any value above it, which nobody means."""
    clamped = apply("max", MIN, apply("min", MAX, speed))
    for target in (0.4, 0.1, -0.2):
        assert changes(clamped, target) == pytest.approx({"v": target})
        assert changes(clamped, target, "least-change") == pytest.approx({"v": target})
    with pytest.raises(NotInvertible, match=r"limited to 0\.5"):
        invert(clamped, 0.8)
    with pytest.raises(NotInvertible, match=r"limited to -0\.5"):
        invert(clamped, -0.8)
    assert changes(clamped, 0.8, source="low") == {"low": 0.8}  # for whoever says so


def test_a_bound_that_holds_the_value_gives_way() -> None:
    saturated = apply("max", MIN, apply("min", MAX, V * 4.0))
    assert changes(saturated, 0.8) == {"high": 0.8}
    assert changes(saturated, 1.5, "least-change") == pytest.approx({"high": 1.5, "v": 0.375})
    assert changes(saturated, 0.2, source="v") == pytest.approx({"v": 0.05})


def test_least_change_moves_a_bound_and_what_it_holds() -> None:
    clamped = apply("max", -MAX, apply("min", tracked(0.6, "limit"), V * 2.0))
    assert changes(clamped, 0.9, "least-change") == pytest.approx({"limit": 0.9, "v": 0.45})
    with pytest.raises(NotInvertible, match=r"limited to 0\.6"):
        invert(clamped, 0.9)


def test_a_bound_alone_is_no_source_of_what_it_does_not_hold() -> None:
    with pytest.raises(NotInvertible, match="low is a bound that is not met"):
        invert(apply("max", MIN, 0.25), 0.5)
    assert changes(apply("max", MIN, -3.0), 0.5) == {"low": 0.5}
