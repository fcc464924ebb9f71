"""The statements of the paper about values, as tests."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import pytest

from rosslt_auto.provenance import NotInvertible, provenance, untracked
from rosslt_auto.provenance.expressions import evaluate
from support.tracked import apply, bits, sources_by_name, tracked


def force(value: Any, target: Any, **options: Any) -> dict[str, Any]:
    """What `force_value` changes, by name."""
    solution = provenance(value).invert(target, **options)
    assert solution.exact
    return {source.parameter: new for source, new in solution.changes.items()}


class TestCommunicationPattern:
    """Section IV-A."""

    def test_example(self) -> None:
        """The quadcopter is dragged from 2 * 0.3 = 0.6 to 1.5: 1.5 / 0.3 = 5."""
        waypoint = tracked(2.0, "waypoint")
        x = waypoint * 0.3
        assert untracked(x) == 0.6
        assert force(x, 1.5) == {"waypoint": 5.0}
        assert provenance(x).evaluate({"waypoint": 5.0}) == 1.5

    def test_example_with_an_integer_waypoint(self) -> None:
        assert force(tracked(2, "waypoint") * 0.3, 1.5) == {"waypoint": 5}

    def test_left_operand_is_preferred(self) -> None:
        a, b = tracked(2.0, "a"), tracked(3.0, "b")
        for value, target in ((a + b, 7.0), (a - b, 7.0), (a * b, 12.0), (a / b, 2.0)):
            assert list(force(value, target)) == ["a"]

    def test_multiplication_by_zero_chooses_the_other_operand(self) -> None:
        a, zero = tracked(2.0, "a"), tracked(0.0, "zero")
        assert force(a * zero, 3.0) == {"zero": 1.5}
        assert force(zero * a, 3.0) == {"zero": 1.5}
        assert force(tracked(2, "a") * tracked(0, "zero"), 6) == {"zero": 3}

    def test_multiplication_by_a_plain_zero_is_refused(self) -> None:
        with pytest.raises(NotInvertible, match="zero"):
            force(tracked(2.0, "a") * 0.0, 3.0)

    def test_reevaluate(self) -> None:
        """All recorded operations are applied to the origin's current value."""
        count = tracked(3, "count")
        value = (2 * count + 1) / 4
        for current in (5, -2, 0):
            assert evaluate(value, {sources_by_name(value)["count"]: current}) == (
                (2 * current + 1) / 4
            )

    def test_all_sources_are_known(self) -> None:
        """The paper keeps one of them; here the decision is left to the one who forces."""
        value = tracked(2.0, "a") * tracked(3.0, "b") + tracked(1.0, "c")
        assert [s.parameter for s in provenance(value).sources] == ["a", "b", "c"]
        assert force(value, 10.0, source="b") == {"b": 4.5}
        assert force(value, 10.0, source="c") == {"c": 4.0}

    def test_a_discarded_provenance_takes_no_part(self) -> None:
        """Section V-A: by casting to the untracked type a source is excluded."""
        a, b = tracked(2.0, "a"), tracked(3.0, "b")
        assert force(untracked(a) * b, 12.0) == {"b": 6.0}


class TestTrigonometry:
    """Functions of module math, as far as they have an inverse."""

    @pytest.mark.parametrize(
        ("name", "start", "target"),
        [("sin", 0.3, 0.5), ("cos", 0.3, 0.5), ("asin", 0.3, 0.5), ("acos", 0.3, 2.0)],
    )
    def test_forth_and_back(self, name: str, start: float, target: float) -> None:
        value = apply(name, tracked(start))
        changed = force(value, target)["x"]
        assert math.isclose(getattr(math, name)(changed), target, rel_tol=1e-12)

    def test_the_nearest_angle_is_chosen(self) -> None:
        """Of all angles with this sine the one next to the present one."""
        for turns in (-3, 0, 5):
            angle = 2.0 + turns * 2 * math.pi
            changed = force(apply("sin", tracked(angle)), math.sin(2.2))["x"]
            assert math.isclose(changed, 2.2 + turns * 2 * math.pi, rel_tol=1e-9)


@dataclass
class Point:
    x: Any
    y: Any
    z: Any


@dataclass
class Bezier:
    """Listing 2 in Python, as a program has it that knows nothing of tracking."""

    b0: Point
    b1: Point
    b2: Point
    tau: float

    def get_trajectory_point(self, t: float) -> Point:
        if t <= 0:
            return self.b0
        if t >= self.tau:
            return self.b2
        t /= self.tau
        return Point(*[
            t * t * getattr(self.b2, axis)
            + 2 * t * (1 - t) * getattr(self.b1, axis)
            + (1 - t) * (1 - t) * getattr(self.b0, axis)
            for axis in "xyz"
        ])  # fmt: skip


class TestBezier:
    """Listing 2, with the aliasing that Section V-A calls a limitation: b1 is made of b0 and b2."""

    def curve(self, wrap: Any) -> Bezier:
        b0 = Point(wrap(0.5, "b0.x"), wrap(0.0, "b0.y"), wrap(1.0, "b0.z"))
        b2 = Point(wrap(4.0, "b2.x"), wrap(2.0, "b2.y"), wrap(1.5, "b2.z"))
        b1 = Point((b0.x + b2.x) / 2, b0.y, b2.z * 1.5)
        return Bezier(b0, b1, b2, wrap(5.0, "tau"))

    @pytest.mark.parametrize("t", [-1.0, 0.0, 1.0, 2.5, 4.9, 5.0, 7.0])
    def test_values(self, t: float) -> None:
        plain = self.curve(lambda value, name: value).get_trajectory_point(t)
        found = self.curve(tracked).get_trajectory_point(t)
        for axis in "xyz":
            assert bits(untracked(getattr(found, axis))) == bits(getattr(plain, axis))

    @pytest.mark.parametrize("source", ["b0.x", "b2.x", "tau"])
    def test_aliased_sources(self, source: str) -> None:
        """Each of them occurs more than once."""
        point = self.curve(tracked).get_trajectory_point(2.0)
        changes = force(point.x, 2.2, source=source)
        assert list(changes) == [source]

        def changed(value: float, name: str) -> float:
            return changes.get(name, value)

        assert math.isclose(self.curve(changed).get_trajectory_point(2.0).x, 2.2, rel_tol=1e-9)

    def test_all_control_points_together(self) -> None:
        point = self.curve(tracked).get_trajectory_point(2.0)
        changes = force(point.x, 2.2, policy="least-change")
        assert {"b0.x", "b2.x"} <= set(changes)

    def test_power_instead_of_a_multiplication(self) -> None:
        """Section V-A's way around aliasing gives the same as the aliased form here."""
        x = tracked(3.0)
        assert force(x**2, 16.0)["x"] == pytest.approx(4.0)
        assert force(x * x, 16.0)["x"] == pytest.approx(4.0)


class TestLists:
    """Listing 1: elements keep their provenance, whatever is done to the list."""

    def test_elements(self) -> None:
        vec = [tracked(v, f"v{v}") for v in (1, 2, 3)]
        i = vec[0]
        vec.append(5)
        vec.append(tracked(7, "last"))
        assert provenance(i).sources[0].parameter == "v1"
        assert provenance(vec[3]) is None
        assert provenance(vec.pop()).sources[0].parameter == "last"
        assert [provenance(v) is not None for v in vec] == [True, True, True, False]
        assert [provenance(2 * v).expression for v in vec[:2]] == ["2 * v1", "2 * v2"]
        assert vec == [1, 2, 3, 5]
        vec.insert(0, vec.pop(1))
        vec.reverse()
        assert [provenance(v).sources[0].parameter for v in vec[1:]] == ["v3", "v1", "v2"]
        vec.sort()
        assert provenance(vec[0]).sources[0].parameter == "v1"
        vec.clear()
        assert vec == []

    def test_fields(self) -> None:
        """IntPair of Listing 1."""

        @dataclass
        class IntPair:
            a: int
            b: int

        pair = IntPair(tracked(1, "a"), tracked(2, "b"))
        x = pair.a
        pair.b = x
        assert provenance(pair.b).sources[0].parameter == "a"
        assert pair == IntPair(1, 1)
