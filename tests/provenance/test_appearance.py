"""What a program can see of a tracked value besides arithmetic: the plain value."""

from __future__ import annotations

import copy
import json
import math
import numbers
import pickle
import statistics
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rosslt_auto.provenance import Source, provenance
from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.provenance.values import is_tracked, leaf, record
from support.tracked import bits, outcome, tracked

numbers_ = st.one_of(
    st.sampled_from([0.0, -0.0, 1.5, 2.0, math.inf, math.nan, 0, 1, -7, 2**70]),
    st.floats(),
    st.integers(-(2**70), 2**70),
)


@given(numbers_, st.integers(0, pickle.HIGHEST_PROTOCOL))
def test_copies_and_pickles(value: Any, protocol: int) -> None:
    one = tracked(value)
    loaded = pickle.loads(pickle.dumps(one, protocol))
    assert type(loaded) is type(value)
    assert bits(loaded) == bits(value)
    assert copy.copy(one) is one
    assert copy.deepcopy([one])[0] is one


FORMATS = ["", ".2f", "d", "e", "+", ">20", "08.3f", "x", ",", "n", "%", "s", "nonsense"]


@given(numbers_)
def test_texts(value: Any) -> None:
    one = tracked(value)
    assert (str(one), repr(one)) == (str(value), repr(value))
    assert f"{one!r:>30} {one}" == f"{value!r:>30} {value}"
    for spec in FORMATS:
        assert outcome(format, one, spec) == outcome(format, value, spec)
    for template in ("%s", "%r", "%d", "%5.1f", "%x", "%c", "%*d", "%.3g"):
        assert outcome(lambda v, t=template: t % v, one) == outcome(
            lambda v, t=template: t % v, value
        )
    assert "{:>9} {!r}".format(one, one) == "{:>9} {!r}".format(value, value)  # noqa: UP032


@given(numbers_)
def test_json(value: Any) -> None:
    assert json.dumps([tracked(value)]) == json.dumps([value])
    assert json.dumps([tracked(value)], indent=1) == json.dumps([value], indent=1)
    assert outcome(json.dumps, {tracked(value): 1}) == outcome(json.dumps, {value: 1})


@given(numbers_, numbers_)
def test_keys_and_members(a: Any, b: Any) -> None:
    assume(a == a and b == b)
    one = tracked(a)
    assert hash(one) == hash(a)
    assert {one: "here"}[a] == "here"
    assert {a: "here"}[one] == "here"
    assert ({a, one, tracked(b)} == {a, b}) is True
    assert (one in [b, a]) is True
    assert (one in (b,)) == (a == b)
    assert [b, a].index(one) == [b, a].index(a)
    assert outcome(range(-5, 5).count, one) == outcome(range(-5, 5).count, a)


@given(st.lists(st.one_of(st.floats(allow_nan=False), st.integers(-(2**60), 2**60))))
def test_order(values: list[Any]) -> None:
    some = [tracked(value) if i % 2 else value for i, value in enumerate(values)]
    assert bits(sorted(some)) == bits(sorted(values))
    assert bits(sorted(some, reverse=True)) == bits(sorted(values, reverse=True))
    if values:
        assert (bits(min(some)), bits(max(some))) == (bits(min(values)), bits(max(values)))


@given(numbers_)
def test_looks(value: Any) -> None:
    one = tracked(value)
    kind = type(value)
    assert dir(one) == dir(value)
    assert one.__sizeof__() == value.__sizeof__()
    assert one.__class__ is kind
    assert type(one) == kind  # noqa: E721
    assert kind == type(one)  # noqa: E721
    assert (type(one) != kind) is False  # noqa: E721
    assert type(one) != str  # noqa: E721
    assert hash(type(one)) == hash(kind)
    assert {kind: "here"}[type(one)] == "here"
    assert isinstance(one, kind)
    assert isinstance(one, numbers.Real)
    assert not isinstance(one, (str, bool, complex))
    cls = type(one)
    assert repr(cls) == repr(kind)
    assert (cls.__name__, cls.__qualname__, cls.__module__, cls.__doc__) == (
        kind.__name__, kind.__qualname__, kind.__module__, kind.__doc__,
    )  # fmt: skip
    assert issubclass(cls, kind)
    assert kind.__add__(one, 1) == value + 1 or value != value


@pytest.mark.parametrize("value", [1.5, 3, "text"])
def test_classes_show_no_slots(value: Any) -> None:
    one = record(OPERATORS["same"], value, leaf(Source("/node", "x", "float"), 1.5))
    assert is_tracked(one)
    assert not hasattr(one, "__slots__") and not hasattr(type(one), "__slots__")


@pytest.mark.parametrize("value", [1.5, 3, "text", np.float64(1.5), np.int32(3)])
@pytest.mark.parametrize("name", ["__module__", "__dict__"])
def test_instances_have_no_attributes_of_their_class(value: Any, name: str) -> None:
    import rosslt_auto.provenance.arrays as arrays

    arrays.install()
    one = record(OPERATORS["same"], value, leaf(Source("/node", "x", "float"), 1.5))
    arrays.uninstall()
    assert is_tracked(one)
    assert outcome(getattr, one, name) == outcome(getattr, value, name)
    assert outcome(vars, one) == outcome(vars, value)
    with pytest.raises(AttributeError) as caught:
        getattr(one, name)
    assert len(caught.traceback) == 1
    assert type(one).__module__ == type(value).__module__


def test_used_as_an_index_or_a_size() -> None:
    two = tracked(2)
    assert [0] * two == [0, 0]
    assert "ab" * two == two * "ab" == "abab"
    assert [1, 2, 3][two] == 3
    assert [1, 2, 3][:two] == [1, 2]
    assert list(range(two)) == [0, 1]
    assert bytes(two) == b"\0\0"
    assert round(2.345, two) == round(2.345, 2)
    text = "ab"
    text *= two
    assert text == "abab"
    two *= "ab"
    assert two == "abab"


def test_types_of_a_class_of_ones_own() -> None:
    """Libraries compute with ``type(x)(...)``: they get plain values."""
    for made, plain in (
        (type(tracked(1.5))(2), 2.0),
        (type(tracked(3))("12"), 12),
        (type(tracked(1.5)).fromhex("0x1p-1"), 0.5),
        (type(tracked(3)).from_bytes(b"\x02", "big"), 2),
    ):
        assert made == plain
        assert bits(made + 1) == bits(plain + 1)
        assert bits(2 * made) == bits(2 * plain)
        assert outcome(getattr, made, "nonsense") == outcome(getattr, plain, "nonsense")
        assert outcome(copy.deepcopy, made) == outcome(copy.deepcopy, plain)
        assert type(made) is type(plain)
        assert provenance(made) is None
    assert statistics.mean([tracked(1.0), tracked(2.5)]) == 1.75
    assert statistics.fmean([tracked(1), tracked(4)]) == 2.5


def test_matching() -> None:
    for value in (tracked(3), tracked(1.5)):
        match value:
            case int():
                found = "int"
            case float():
                found = "float"
        assert found == type(value).__name__


def test_an_error_shows_no_more_than_a_plain_one() -> None:
    """Where Python can raise the error itself, the traceback is the plain one."""
    for action in (
        lambda x: x / 0.0, lambda x: 1.0 / (x - x), lambda x: x % 0.0, lambda x: x + "a",
    ):  # fmt: skip
        with pytest.raises((ZeroDivisionError, TypeError)) as caught:
            action(tracked(2.5))
        frames = [frame.name for frame in caught.traceback]
        assert frames[-1] == "<lambda>"


@pytest.mark.parametrize("value", [0.5, 3, "text"])
def test_methods_are_called_what_they_are_called(value: Any) -> None:
    one = leaf(Source("/node", "x", type(value).__name__), value)
    for name in set(dir(value)) - {"__class__"}:
        plain = getattr(value, name)
        if callable(plain):
            method = getattr(one, name)
            assert (method.__name__, method.__qualname__) == (plain.__name__, plain.__qualname__)
