"""Histories that go on for ever: memory and expressions stay small, values stay what they are."""

from __future__ import annotations

import gc
import math
import random
import tracemalloc
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosslt_auto.provenance import NotInvertible, Source, folding, provenance, untracked
from rosslt_auto.provenance.excerpts import excerpts, fold_text
from rosslt_auto.provenance.expressions import evaluate, gradient, operands, topological
from rosslt_auto.provenance.folding import MAX_TERMS, fold
from rosslt_auto.provenance.forms import TERM_DEPTH, Forms
from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.provenance.values import DEPTH_LIMIT, is_tracked, leaf, record
from support.tracked import apply, bits, sources_by_name, tracked

STEPS = 100_000


def text(value: str, name: str) -> Any:
    return leaf(Source("/node", name, "str"), value)


def integrator(x: Any, dt: Any, n: int) -> Any:
    for _ in range(n):
        x = x + dt
    return x


def filtered(y: Any, a: Any, n: int, measured: Callable[[int], Any]) -> Any:
    for i in range(n):
        y = a * measured(i) + (1 - a) * y
    return y


def random_walk(values: list[Any], n: int) -> Any:
    """Mixed operations on several values that depend on each other; stays in bounds."""
    choose = random.Random(1)
    state = list(values)
    for _ in range(n):
        i, j = choose.randrange(len(state)), choose.randrange(len(state))
        kind = choose.randrange(5)
        if kind == 0:
            state[i] = state[i] * 0.5 + state[j] * 0.5
        elif kind == 1:
            state[i] = state[i] - state[j] / 3
        elif kind == 2:
            state[i] = apply("sin", state[i]) + values[j]
        elif kind == 3:
            state[i] = (state[i] * state[j]) % 7.0
        else:
            state[i] = -abs(state[i])
    return state[0] + state[1] + state[2]


def operators_of(value: Any) -> set[str]:
    return {node._op.name for node in topological([value])}


def test_integrator() -> None:
    x, dt = tracked(10.0, "x"), tracked(0.01, "dt")
    value = integrator(x, dt, STEPS)
    assert bits(untracked(value)) == bits(integrator(10.0, 0.01, STEPS))
    assert value._depth <= DEPTH_LIMIT
    assert len(topological([value])) <= DEPTH_LIMIT + 10
    assert "affine" in operators_of(value)
    assert "linear" not in operators_of(value)
    sources = sources_by_name(value)
    slopes = gradient(value)
    assert slopes[sources["x"]] == 1.0
    assert math.isclose(slopes[sources["dt"]], STEPS)
    for changes in ({"x": 0.0}, {"dt": 0.5}, {"x": -3.0, "dt": 0.001}):
        expected = changes.get("x", 10.0) + STEPS * changes.get("dt", 0.01)
        found = provenance(value).evaluate(changes)
        assert math.isclose(found, expected, rel_tol=1e-9)
    [(source, wanted)] = provenance(value).invert(0.0).changes.items()
    assert source.parameter == "x"
    assert math.isclose(wanted, -STEPS * 0.01, rel_tol=1e-9)
    [(source, wanted)] = provenance(value).invert(0.0, source="dt").changes.items()
    assert math.isclose(wanted, -10 / STEPS, rel_tol=1e-9)


def test_counter_is_exact() -> None:
    """Integers lose nothing, and give no float."""
    count, step = tracked(0, "count"), tracked(3, "step")
    value = integrator(count, step, STEPS)
    assert untracked(value) == 3 * STEPS
    assert provenance(value).evaluate({"count": 7}) == 3 * STEPS + 7
    assert type(provenance(value).evaluate({"count": 7, "step": 2})) is int
    assert provenance(value).evaluate({"count": 7, "step": 2}) == 2 * STEPS + 7
    assert provenance(value).invert(1).changes == {sources_by_name(value)["count"]: 1 - 3 * STEPS}


def test_filter() -> None:
    """y = a * x + (1 - a) * y: affine in the measurements, but not in a."""

    def measured(i: int) -> float:
        return 2.0 + (i % 7) / 10

    def tracked_measurement(i: int) -> Any:
        return tracked(measured(i), "x")

    n = 20_000
    y, a = tracked(0.0, "y"), tracked(0.05, "a")
    value = filtered(y, a, n, tracked_measurement)
    assert bits(untracked(value)) == bits(filtered(0.0, 0.05, n, measured))
    assert value._depth <= DEPTH_LIMIT
    assert len(topological([value])) < 8 * DEPTH_LIMIT
    assert "linear" in operators_of(value)
    assert bits(evaluate(value, {})) == bits(untracked(value))
    plain = filtered(y, 0.05, n, measured)
    assert "linear" not in operators_of(plain)
    assert bits(untracked(plain)) == bits(untracked(value))


def test_first_order_form_is_right_for_small_changes() -> None:
    """And is shown to be one."""
    a = tracked(0.999, "a")
    value = a
    plain = {0.999: 0.999, 0.99901: 0.99901}
    for _ in range(3000):
        value = value * a + 0.001
        plain = {start: old * start + 0.001 for start, old in plain.items()}
    assert bits(untracked(value)) == bits(plain[0.999])
    found = provenance(value).evaluate({"a": 0.99901})
    assert math.isclose(found, plain[0.99901], rel_tol=1e-2)
    assert found != untracked(value)
    fold(value)
    assert provenance(value).expression.startswith("≈")
    assert "linear" in operators_of(value)


def test_random_walk() -> None:
    start = [0.5, 1.5, -2.0]
    values = [tracked(v, f"v{i}") for i, v in enumerate(start)]
    found = random_walk(values, 30_000)
    assert bits(untracked(found)) == bits(untracked(random_walk(start, 30_000)))
    assert found._depth <= DEPTH_LIMIT
    assert len(topological([found])) < 16 * DEPTH_LIMIT
    assert bits(evaluate(found, {})) == bits(untracked(found))
    assert provenance(found).expression


def neighbours(cells: list[Any], steps: int) -> list[Any]:
    """Heat that spreads on a ring: every value soon depends on every other."""
    count = len(cells)
    for _ in range(steps):
        cells = [(cells[i - 1] + cells[i] + cells[(i + 1) % count]) / 3 for i in range(count)]
    return cells


def test_many_values_that_depend_on_each_other() -> None:
    count, steps = 20, 500
    start = [float(i % 7) for i in range(count)]
    cells = [tracked(value, f"cell{i}") for i, value in enumerate(start)]
    found = neighbours(cells, steps)
    assert bits([untracked(cell) for cell in found]) == bits(neighbours(start, steps))
    assert len(topological(found)) < 20_000 < 3 * count * steps
    assert max(cell._depth for cell in found) <= DEPTH_LIMIT
    assert provenance(found[0]).sources
    assert bits(evaluate(found[0], {})) == bits(untracked(found[0]))


def test_a_wide_expression_is_folded_once_for_all() -> None:
    """Not the same part again for each value that is built on it."""
    folded = []

    class Counting(Forms):
        def fold(self, chosen: set[int]) -> None:
            folded.append(len(self.order))
            super().fold(chosen)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(folding, "Forms", Counting)
        neighbours([tracked(float(i), f"cell{i}") for i in range(20)], 400)
    assert 0 < len(folded) < 10
    assert sum(folded) < 4 * 20 * 3 * 400


def test_a_product_of_sources_is_added_up_exactly() -> None:
    """``x += speed * dt``: the product is the same whenever it is added."""
    x, speed, dt = tracked(1.0, "x"), tracked(0.5, "speed"), tracked(0.01, "dt")
    value, steps = x, 5 * DEPTH_LIMIT
    for _ in range(steps):
        value = value + speed * dt
    fold(value)
    assert operators_of(value) == {"source", "mul", "affine"}
    assert provenance(value).expression.endswith(" + 5120 * (speed * dt - 0.005)")
    found = provenance(value).evaluate({"speed": 2.0, "dt": 0.1, "x": 0.0})
    assert math.isclose(found, steps * 2.0 * 0.1, rel_tol=1e-9)
    [answer] = provenance(value).invert(0.0, source="dt").changes.values()
    assert math.isclose(1.0 + steps * 0.5 * answer, 0.0, abs_tol=1e-9)


def test_what_is_around_an_exact_part_is_kept() -> None:
    """``cos(angle)`` of an angle with a long history, as it travels."""
    angle, step, radius = tracked(0.5, "angle"), tracked(0.001, "step"), tracked(2.0, "radius")
    turned = integrator(angle, step, 700)
    value = apply("cos", turned) * radius
    before = untracked(value)
    fold(value)
    assert bits(untracked(value)) == bits(before) == bits(evaluate(value, {}))
    assert operators_of(value) == {"source", "affine", "cos", "mul"}
    assert value._depth == 3
    for target in (0.25, -1.5, 2.0):
        [answer] = provenance(value).invert(target, source="angle").changes.values()
        assert math.isclose(2.0 * math.cos(answer + 0.7), target, rel_tol=1e-9)
    [answer] = provenance(value).invert(1.0, source="step").changes.values()
    assert math.isclose(2.0 * math.cos(0.5 + 700 * answer), 1.0, rel_tol=1e-9)


def test_many_different_products_become_first_order() -> None:
    """A form does not keep them all."""
    a, value = tracked(0.05, "a"), tracked(0.0, "y")
    for i in range(3 * DEPTH_LIMIT):
        value = value + a * tracked(float(i), "x")
    assert len(topological([value])) < 4 * DEPTH_LIMIT
    fold(value)
    assert "linear" in operators_of(value)
    assert len(topological([value])) < 2 * MAX_TERMS


def test_what_drops_sources_is_no_exact_form() -> None:
    """Of a sum over more sources than a folded form keeps the rest is forgotten."""
    value = tracked(0.0, "first")
    for i in range(MAX_TERMS // 2):
        value = value + tracked(1.0, f"x{i}")
    fold(value)
    assert operators_of(value) == {"source", "affine"}
    for i in range(3 * MAX_TERMS):
        value = value + tracked(1.0, f"y{i}")
    fold(value)
    assert operators_of(value) == {"source", "linear"}
    assert len(sources_by_name(value)) <= MAX_TERMS


@pytest.mark.parametrize("length", [20, 200])
def test_a_text_that_grows_and_is_cut(length: int) -> None:
    """It stays text, and remembers the pieces of its latest part."""
    word, other = text("ab", "word"), text("c", "other")
    value: Any = text("", "start")
    plain = ""
    sizes = []
    for i in range(6000):
        value = (value + (other if i % 3 else word))[-length:]
        plain = (plain + ("c" if i % 3 else "ab"))[-length:]
        if i % 1000 == 999:
            sizes.append(len(topological([value])))
            assert value._depth <= DEPTH_LIMIT
    assert untracked(value) == plain
    assert evaluate(value, {}) == plain
    assert {"word", "other"} <= set(sources_by_name(value))
    assert max(sizes) < 3 * DEPTH_LIMIT
    for folded in (False, True):
        if folded:
            fold(value)
            assert operators_of(value) == {"excerpts" if length == 20 else "remembered", "source"}
        if length == 200 and folded:
            continue
        found = provenance(value).invert(plain.replace("ab", "xy")).changes
        assert {source.parameter: new for source, new in found.items()} == {"word": "xy"}
        changes = {"word": "no", "other": "!"}
        expected = plain.replace("ab", "no").replace("c", "!")
        assert provenance(value).evaluate(changes) == expected


def test_a_text_that_grows_is_folded_exactly() -> None:
    """Numbers in it can still be read back, and texts may have other lengths."""
    word, count = text("ab", "word"), tracked(3, "count")
    value: Any = ""
    for i in range(8):
        piece = record(OPERATORS["pieces"], f"{count._v:d};", count, None, "d", ";", None, "")
        value = value + (piece if i == 4 else word)
    fold_text(value, TERM_DEPTH)
    assert operators_of(value) == {"join", "pieces", "source"}
    assert provenance(value).evaluate({"word": "."}) == "....3;..."
    assert untracked(value) == "abababab3;ababab"
    found = provenance(value).invert("xyxyxyxy4;xyxyxy").changes
    assert {s.parameter: new for s, new in found.items()} == {"word": "xy", "count": 4}


@given(st.lists(st.tuples(st.sampled_from("+s%jp"), st.integers(-5, 12), st.integers(-5, 12))))
def test_excerpts_are_what_a_text_is_made_of(steps: list[tuple[str, int, int]]) -> None:
    word, other = text("word", "word"), text("_o_", "other")
    value: Any = word
    for kind, i, j in steps:
        before = untracked(value)
        match kind:
            case "+":
                value = value + (word, other, "plain")[i % 3]
            case "s" if before[i:j]:
                value = value[i:j]
            case "p" if before[i : i + 1]:
                value = value[i]
            case "%":
                value = other % () + value
            case "j":
                value = other.join([value, word, "x"][: 1 + j % 3])
    found = excerpts(topological([value])) if is_tracked(value) else []
    if found is None:
        return
    assert "".join(untracked(part.value()) for part in found) == (untracked(value) if found else "")
    assert all(part.start < part.stop for part in found)
    if found and fold_text(value, DEPTH_LIMIT):
        assert provenance(value).evaluate({}) == untracked(value)


@pytest.mark.parametrize("target", ["abXabc", "abcab", "xycxyd"])
def test_texts_that_cannot_be_aligned(target: str) -> None:
    word = text("ab", "word")
    value = (word + "c" + word + "c")[:]
    with pytest.raises(NotInvertible):
        provenance(value).invert(target)


def test_text_of_a_folded_value_is_short() -> None:
    value = integrator(tracked(10.0, "x"), tracked(0.5, "dt"), 3000)
    assert len(provenance(value).expression) < 500
    fold(value)
    assert provenance(value).expression == "1510.0 + (x - 10.0) + 3000 * (dt - 0.5)"


def test_short_histories_are_kept_as_they_are() -> None:
    """A thousand operations, as in the benchmark."""
    value = integrator(tracked(0.0, "x"), 1.0, 1000)
    assert operators_of(value) == {"source", "add"}


@pytest.mark.parametrize("width", [1, 10, 300])
def test_values_built_on_a_long_history_do_not_fold_it_again(width: int) -> None:
    """The history is folded once, for all of them."""
    base = integrator(tracked(0.0, "x"), tracked(0.5, "dt"), DEPTH_LIMIT - 2)
    derived = [((base + i) * 2.0 - 1.0) / 3.0 for i in range(width)]
    assert base._depth <= DEPTH_LIMIT
    again = [((base + i) * 2.0 - 1.0) / 3.0 for i in range(width)]
    assert all(value._depth < DEPTH_LIMIT // 2 for value in again)
    for i, value in enumerate(derived):
        assert math.isclose(
            provenance(value).evaluate({"x": 1.0}),
            ((1.0 + 0.5 * (DEPTH_LIMIT - 2) + i) * 2 - 1) / 3,
            rel_tol=1e-9,
        )
    total = sum(map(untracked, derived))
    deep = derived[0]
    for value in derived[1:]:
        deep = deep + value
    assert math.isclose(untracked(deep), total)


def test_depths_are_true() -> None:
    """Also of what was folded in place."""
    value = random_walk([tracked(v, f"v{v}") for v in (0.5, 1.5, -2.0)], 3000)
    for node in topological([value]):
        below = [o._depth for o in operands(node) if hasattr(o, "_depth")]
        assert not below or node._depth > max(below)


@pytest.mark.parametrize("name", ["integrator", "counter", "filter", "walk"])
def test_memory_stays_flat(name: str) -> None:
    """Between some thousand steps and many times as many."""
    x, dt = tracked(10.0, "x"), tracked(0.01, "dt")
    state: list[Any] = {
        "integrator": [x], "counter": [tracked(0, "n")], "filter": [x], "walk": [x, dt, x + dt],
    }[name]  # fmt: skip

    def go_on(steps: int) -> None:
        if name == "integrator":
            state[0] = integrator(state[0], dt, steps)
        elif name == "counter":
            state[0] = integrator(state[0], 1, steps)
        elif name == "filter":
            state[0] = filtered(state[0], dt, steps, lambda i: i % 5)
        else:
            for i in range(steps):
                j = i % 3
                state[j] = apply("tanh", state[j] + state[j - 1] * 0.5 - dt)

    go_on(2 * DEPTH_LIMIT)
    tracemalloc.start()
    try:
        most = []
        for _ in range(2):
            tracemalloc.reset_peak()
            for _ in range(4):
                go_on(DEPTH_LIMIT // 2)
            gc.collect()
            most.append(tracemalloc.get_traced_memory()[1])
    finally:
        tracemalloc.stop()
    assert most[1] - most[0] < 500_000


def test_the_longest_chain_does_not_overflow() -> None:
    """No walk recurses, and letting go of a deep graph does not either."""
    value = integrator(tracked(0.0, "x"), tracked(1.0, "dt"), DEPTH_LIMIT - 1)
    copies = [value * i for i in range(50)]
    del value
    assert provenance(copies[-1]).evaluate({"x": 1.0}) == 49 * DEPTH_LIMIT
    del copies
    gc.collect()


@pytest.mark.parametrize("wide", [1, -1])
def test_factors_that_are_too_large_for_a_float(wide: int) -> None:
    """The integers of a decimal number with thousands of digits."""
    value, factor = tracked(3), tracked(10, "f")
    for _ in range(2 * DEPTH_LIMIT):
        value = value * factor * wide // 1
    assert untracked(value) == 3 * 10 ** (2 * DEPTH_LIMIT) * wide ** (2 * DEPTH_LIMIT)
    fold(value)
    assert provenance(value).evaluate({}) == untracked(value)
