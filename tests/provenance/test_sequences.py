"""`array.array` with provenance: what primitive sequence fields of messages hold."""

import array
import collections
import copy
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosslt_auto.provenance import Source, is_tracked, provenance, sequences, untracked
from rosslt_auto.provenance.elements import all_exact
from rosslt_auto.provenance.values import leaf


def tracked(name: str, value: Any) -> Any:
    return leaf(Source("/node", name, type(value).__name__), value)


X, Y = tracked("x", 1.5), tracked("y", -2.5)


def assigned(items: Any, typecode: str = "d") -> Any:
    """What a field holds after `items` was assigned."""
    return sequences.shadow(typecode, array.array(typecode, list(map(untracked, items))), items)


def texts(items: Any) -> list[Any]:
    return [provenance(item).expression if is_tracked(item) else item for item in items]


def test_elements_of_lower_precision_are_rounded() -> None:
    field = assigned([tracked("x", 0.1) * 3, tracked("y", 0.5)], "f")
    assert texts(field) == ["float32(x * 3)", "y"]
    found = provenance(field[0])
    assert found is not None and found.evaluate({}) == field[0] != 0.1 * 3


def test_elements_keep_their_provenance() -> None:
    field = assigned([X, 2.0, Y * 2])
    assert texts(field) == ["x", 2.0, "y * 2"]
    assert field[0] is X and texts(field[1:]) == [2.0, "y * 2"] and texts([field[-1]]) == ["y * 2"]
    assert texts(field.tolist()) == texts(list(field)) == texts(sequences.elements(field))
    assert texts(reversed(field)) == ["y * 2", 2.0, "x"]


def test_untracked_stays_plain() -> None:
    plain = array.array("d", [1.0, 2.0])
    for items in ([1.0, 2.0], (1.0, 2.0), plain, collections.deque([1.0, 2.0]), range(2)):
        assert sequences.shadow("d", plain, items) is plain
    assert sequences.elements(plain) is None


@pytest.mark.parametrize("make", [tuple, list, collections.deque])
def test_what_can_be_assigned(make: Any) -> None:
    assert texts(assigned(make([X, 1.0]))) == ["x", 1.0]
    field = assigned([X, 1.0])
    assert sequences.shadow("d", field, field) is field


def test_it_passes_for_an_array() -> None:
    field, plain = assigned([X, 2.0]), array.array("d", [1.5, 2.0])
    assert type(field) == array.array and isinstance(field, array.array)  # noqa: E721
    assert field.__class__ is array.array and dir(field) == dir(plain)
    assert field == plain and plain == field and repr(field) == repr(plain)
    assert bytes(memoryview(field)) == plain.tobytes() and field.tobytes() == plain.tobytes()
    assert not hasattr(field, "__dict__")
    loaded = pickle.loads(pickle.dumps(field))
    assert type(loaded) is array.array and loaded == plain
    with pytest.raises(TypeError):
        hash(field)


def test_other_type_codes() -> None:
    field = assigned([tracked("g", 0.1), 1.0], "f")
    assert texts(field) == ["float32(g)", 1.0]
    assert field[0] == array.array("f", [0.1])[0]
    assert texts(assigned([tracked("n", 3), 1], "i")) == ["n", 1]
    assert texts(assigned([tracked("n", 3), 1.0], "d")) == ["float(n)", 1.0]


def test_copies_keep_provenance() -> None:
    field = assigned([X, 2.0])
    for made in (copy.copy(field), copy.deepcopy(field), field[:]):
        assert texts(made) == ["x", 2.0]
        made[0] = 7.0
    assert texts(field) == ["x", 2.0]


def test_a_change_behind_our_back_ends_provenance() -> None:
    field = assigned([X, Y])
    memoryview(field)[0] = 9.0
    assert texts(field) == [9.0, "y"]
    array.array.append(field, 1.0)
    assert texts(field) == [9.0, -2.5, 1.0]


def test_plain_fields_can_take_provenance() -> None:
    field = sequences.trackable(array.array("d"))
    field.append(X)
    field.extend([1.0, Y])
    assert texts(field) == ["x", 1.0, "y"]
    assert texts(sequences.with_elements(array.array("d", [1.5, 1.0]), [X, 1.0])) == ["x", 1.0]


def test_arrays_made_by_the_program() -> None:
    make = sequences.ADVICE[id(array.array)]
    assert texts(make("d", [X, 1.0])) == ["x", 1.0]
    assert texts(make("d", (v for v in (X, 1.0)))) == ["x", 1.0]
    assert type(make("d", [1.0])) is array.array
    assert make("B", b"ab").tolist() == [97, 98] and make("d") == array.array("d")
    with pytest.raises(TypeError, match="must be real number"):
        make("d", ["a"])


def test_replaced_elements() -> None:
    field = assigned([X, 2.0, Y])
    new = tracked("x", 8.0)
    assert sequences.replace_elements(field, lambda e: new if e is X else e)
    assert field.tolist() == [8.0, 2.0, -2.5] and field[0] is new
    assert not sequences.replace_elements(field, lambda e: e)


# ---------------------------------------------------------------- against a plain array

numbers = st.sampled_from([X, Y, 0.0, 1.0, -2.5, X * 2])
places = st.integers(-7, 7)
CHANGES = st.one_of(
    st.tuples(st.just("append"), numbers),
    st.tuples(st.just("extend"), st.lists(numbers, max_size=3)),
    st.tuples(st.just("fromlist"), st.lists(numbers, max_size=3)),
    st.tuples(st.just("insert"), places, numbers),
    st.tuples(st.just("pop"), places),
    st.tuples(st.just("pop")),
    st.tuples(st.just("remove"), numbers),
    st.tuples(st.just("reverse")),
    st.tuples(st.just("__setitem__"), places, numbers),
    st.tuples(st.just("__delitem__"), places),
    st.tuples(st.just("__delitem__"), st.slices(6)),
    st.tuples(st.just("__imul__"), st.integers(-1, 2)),
    st.tuples(st.just("__setitem__"), st.slices(6), st.lists(numbers, max_size=3).map(tuple)),
)


def applied(target: Any, change: tuple[Any, ...], convert: Any) -> Any:
    name, *args = change
    if args and type(args[-1]) is tuple:  # only an array can be assigned to a slice
        args[-1] = convert(list(args[-1]))
    try:
        return getattr(target, name)(*args)
    except (IndexError, ValueError) as error:
        return type(error), str(error)


@given(st.lists(numbers, max_size=5), st.lists(CHANGES, max_size=8))
def test_it_changes_like_a_plain_array(items: list[Any], changes: list[Any]) -> None:
    """The same content as a plain array; elements in the place where a list has them."""
    plain = array.array("d", list(map(untracked, items)))
    field = sequences.trackable(array.array("d"))
    field.extend(items)
    model = list(items)
    for change in changes:
        bare = tuple(
            type(arg)(map(untracked, arg)) if type(arg) in (list, tuple) else untracked(arg)
            for arg in change
        )
        before = len(plain)
        wanted = applied(plain, bare, lambda given: array.array("d", given))
        found = applied(field, change, assigned)
        if isinstance(wanted, tuple):
            assert found == wanted
            continue
        if wanted is plain:
            assert found is field
        else:
            assert untracked(found) == wanted
        name = "extend" if change[0] == "fromlist" else change[0]
        if name == "remove":
            del model[list(map(untracked, model)).index(bare[1])]
        else:
            applied(model, (name, *change[1:]), list)
        assert len(field) == len(plain) == len(model), before
    assert field.tobytes() == plain.tobytes()
    assert texts(field) == texts(model)


@given(st.lists(numbers, max_size=4), st.lists(numbers, max_size=4), st.integers(0, 3))
def test_sums_and_multiples(first: list[Any], second: list[Any], count: int) -> None:
    a, b = assigned(first), assigned(second)
    assert texts(a + b) == texts(first + second)
    assert texts(a * count) == texts(count * a) == texts(first * count)
    a += b
    assert list(map(untracked, a)) == list(map(untracked, first + second))


def test_what_can_be_filled_reads_as_array_itself_does() -> None:
    field = sequences.trackable(array.array("d", [1.0, 2.0]))
    assert type(field).__getitem__ is array.array.__getitem__
    assert type(field).__iter__ is array.array.__iter__
    field.append(3.0)
    field[0] = 4.0
    field += array.array("d", [5.0])
    field.extend(array.array("d", [6.0]))
    assert field.tolist() == [4.0, 2.0, 3.0, 5.0, 6.0]
    assert sequences.elements(field) is None


@pytest.mark.parametrize("fill", ["set", "append", "insert", "extend", "fromlist", "add", "slice"])
def test_the_first_tracked_element_makes_it_tracked(fill: str) -> None:
    item = tracked("a", 1.5)
    other = sequences.shadow("d", array.array("d", [1.5]), [item])
    field = sequences.trackable(array.array("d", [1.0]))
    plain = array.array("d", [1.0])
    fills: dict[str, Any] = {
        "set": lambda a, x, _: a.__setitem__(0, x),
        "append": lambda a, x, _: a.append(x),
        "insert": lambda a, x, _: a.insert(0, x),
        "extend": lambda a, x, _: a.extend([x]),
        "fromlist": lambda a, x, _: a.fromlist([x]),
        "add": lambda a, _, xs: a.__iadd__(xs),
        "slice": lambda a, _, xs: a.__setitem__(slice(0, 1), xs),
    }
    fills[fill](field, item, other)
    fills[fill](plain, 1.5, array.array("d", [1.5]))
    assert field == plain and repr(field) == repr(plain)
    found = sequences.elements(field)
    assert found is not None and [is_tracked(x) for x in found] == [x == 1.5 for x in plain]


def test_sums_with_what_can_be_filled() -> None:
    item = tracked("a", 1.5)
    other = sequences.shadow("d", array.array("d", [1.5]), [item])
    field = sequences.trackable(array.array("d", [1.0]))
    for whole in (field + other, other + field):
        found = sequences.elements(whole)
        assert found is not None and sum(map(is_tracked, found)) == 1


@given(st.lists(st.one_of(st.floats(), st.integers(), st.booleans(), st.none()), max_size=40))
def test_only_exact_floats_are_taken_for_them(items: list[Any]) -> None:
    assert not all_exact(items) or all(type(item) is float for item in items)
    for length in (3, 40):
        floats = [0.5] * length
        assert all_exact(floats) and all_exact(tuple(floats))
        for other in (tracked("a", 0.5), True, 1, np.float32(0.5), np.float64(0.5), None):
            assert not all_exact([*floats[1:], other])
            assert not all_exact([other, *floats[1:]])
