"""Expressions from the network: whatever is asked of them, the answer comes, and is small."""

import signal
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import msgpack
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosslt_auto.provenance import provenance, refresh
from rosslt_auto.provenance.extents import TooLarge
from rosslt_auto.provenance.inversion import NotInvertible, invert
from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.ros.encoding import _big_integer
from rosslt_auto.ros.header import HeaderError, decode

HANGING = 15
"""Seconds after which an evaluation counts as one that never ends."""

MEMORY = 64 << 20


def header(
    slots: list[Any], values: list[Any], sources: list[tuple[str, Any]], result: int | None = None
) -> bytes:
    """A header with one field; `sources` are kind and value of the first slots, which are leaves.

    slots  of the operations: None, or the operator's name and slots of operands
    """
    described = [
        [0, f"rosslt.a{i}", kind, None, True, 1, 3, 4, ""] for i, (kind, _) in enumerate(sources)
    ]
    leaves = [[i, value] for i, (_, value) in enumerate(sources)]
    every = [*leaves, *slots]
    fields = [[0, "data", len(every) - 1 if result is None else result]]
    outline = msgpack.packb([["/node", "/file.py"], described, every, fields], default=_big_integer)
    return b"\x01" + msgpack.packb([17, 1, outline, values], default=_big_integer)


@contextmanager
def watched() -> Iterator[None]:
    """Within, nothing hangs."""

    def fail(*_: Any) -> None:
        raise TimeoutError("this takes for ever")

    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(HANGING)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def other(value: Any) -> Any:
    return value + "x" if type(value) is str else value + 1


def ask_everything(payload: bytes) -> int:
    """All that views, force and reevaluate ask; gives how many answers were "too large"."""
    refused = 0
    for value in decode(payload).fields().values():
        found = provenance(value)
        assert found is not None
        assert len(found.expression) < 10_000
        sources = found.sources
        changes = {s: other(v) for s in sources for v in [_value_of(value, s)]}
        try:
            found.evaluate(changes)
        except TooLarge:
            refused += 1
        except (ArithmeticError, ValueError):
            pass
        for policy in ("left", "least-change"):
            with suppress(NotInvertible):
                invert(value, other(value._v), policy)
        refresh.refreshed(value)
    return refused


def _value_of(value: Any, source: Any) -> Any:
    from rosslt_auto.provenance.expressions import leaves
    from rosslt_auto.provenance.locations import source_of

    return next(leaf._v for leaf in leaves(value) if source_of(leaf) == source)


BIG = 10**300
LONG = "x" * 4000

TOO_LARGE = {
    "power": header([None, ["pow", 0, 1]], [BIG, 1], [("int", 3)]),
    "power of a power": header(
        [["pow", 0, 0], *(["pow", i, i] for i in range(1, 30))], [1] * 30, [("int", 9)]
    ),
    "squares": header([["mul", i, i] for i in range(60)], [1] * 60, [("int", BIG)]),
    "shift": header([None, ["lshift", 0, 1]], [BIG, 1], [("int", 3)]),
    "modular power": header(
        [None, None, ["powmod", 0, 1, 2]], [10**2000, 10**2000 + 1, 1], [("int", 3)]
    ),
    "digits": header([None, ["round", 0, 1]], [-(10**9), 0], [("int", 3)]),
    "repetition": header([None, ["repeat", 0, 1]], [10**12, ""], [("str", "ab")]),
    "doubling": header([["concat", i, i] for i in range(60)], [""] * 60, [("str", LONG)]),
    "join": header([["join", *[i] * 50] for i in range(20)], [""] * 20, [("str", LONG)]),
    "representation": header([["repr", i] for i in range(60)], [""] * 60, [("str", "'\\\"")]),
    "width": header(
        [None, None, ["pieces", 0, 1, 2]], [None, "1000000000d", ""], [("int", 3)]
    ),
    "precision": header(
        [None, None, ["pieces", 0, 1, 2]], [None, ".999999999f", ""], [("float", 3.5)]
    ),
    "percent": header([None, ["percent", 1, 0]], ["%0999999999d", ""], [("int", 3)]),
    "percent with a computed width": header(
        [None, None, ["percent", 1, 2, 0]], ["%*d", 10**9, ""], [("int", 3)]
    ),
    "format": header([None, ["format", 1, 0]], ["{:>999999999}", ""], [("int", 3)]),
    "format with a computed width": header(
        [None, None, ["format", 1, 0, 2]], ["{:>{}}", 10**9, ""], [("int", 3)]
    ),
    "format that repeats": header(
        [None, ["format", 1, 0]], ["{0}" * 4000, ""], [("str", LONG)]
    ),
    "many long texts": header(
        [["concat", 0, 0], *(["upper", 1] for _ in range(2000)), ["join", *range(1, 2002)]],
        [""] * 2002, [("str", LONG)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("payload", TOO_LARGE.values(), ids=TOO_LARGE)
def test_what_would_be_too_large_is_refused(payload: bytes) -> None:
    tracemalloc.start()
    try:
        with watched():
            assert ask_everything(payload) > 0
        assert tracemalloc.get_traced_memory()[1] < MEMORY
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("slots", "values"),
    [
        ([["sin", 0]], [0.5]),
        ([["concat", 0, 0]], [1.5]),
        ([None, None, ["pieces", 0, 1, 2]], [3, "d", ""]),
        ([None, None, ["pieces", 0, 1, 2]], [None, 3, ""]),
        ([None, ["slice", 0, 1]], ["1", "a"]),
        ([None, ["affine", 1, 0, 1, 1, 1]], ["a", 1.0]),
        ([["upper", 0]], [7]),
    ],
)
def test_operands_of_other_kinds_are_malformed(slots: list[Any], values: list[Any]) -> None:
    kind = ("str", "abc") if slots[-1][0] not in ("concat", "upper") else ("float", 1.5)
    with pytest.raises(HeaderError, match="of something else"):
        decode(header(slots, values, [kind]))


_numbers = st.one_of(st.integers(-5, 5), st.sampled_from([BIG, -BIG, 2**63, 10**9]), st.floats())
_texts = st.sampled_from(["", "ab", LONG, "%d", "%999999999d", "{:>999999999}", "{}{}", "9999999d"])
_values = st.one_of(_numbers, _texts, st.none())


@st.composite
def _expressions(draw: Any) -> bytes:
    sources = draw(
        st.lists(
            st.one_of(
                st.tuples(st.just("int"), st.sampled_from([0, 3, -2, BIG])),
                st.tuples(st.just("float"), st.sampled_from([0.0, 1.5, 1e300, -1e-300])),
                st.tuples(st.just("str"), _texts),
            ),
            min_size=1,
            max_size=3,
        )
    )
    count = len(sources)
    slots: list[Any] = []
    for number in range(count, count + draw(st.integers(1, 12))):
        name = draw(st.one_of(st.none(), st.sampled_from(sorted(OPERATORS))))
        if name is None:
            slots.append(None)
        else:
            operand = st.integers(0, number - 1)
            slots.append([name, *draw(st.lists(operand, min_size=1, max_size=5))])
    values = [draw(_values) for _ in slots]
    return header(slots, values, sources)


@settings(max_examples=150, deadline=None)
@given(_expressions())
@example(header([["add", 0, 0]], [2], [("int", 1)]))
def test_any_expression(payload: bytes) -> None:
    with watched(), suppress(HeaderError):
        ask_everything(payload)


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(list(TOO_LARGE.values())), st.data())
def test_any_damage(payload: bytes, data: st.DataObject) -> None:
    damaged = bytearray(payload)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    with watched(), suppress(HeaderError):
        ask_everything(bytes(damaged))
