"""Linear algebra, interpolation and statistics of tracked arrays, beside plain numpy."""

import logging
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rosslt_auto.provenance import arrays, provenance
from rosslt_auto.provenance.values import is_tracked, untracked
from support.tracked import tracked

reals = st.floats(-10, 10, allow_subnormal=False).map(lambda x: round(x, 3))


@pytest.fixture(autouse=True, scope="module")
def _woven():
    arrays.install()
    yield
    arrays.uninstall()


def advised(function, *args, **keywords):
    """The call as instrumented code makes it."""
    return arrays.ADVICE[id(function)](*args, **keywords)


def marked(rows):
    """An array whose elements are sources of their own."""
    shape = np.shape(rows)
    nodes = [tracked(float(x), f"s{i}") for i, x in enumerate(np.ravel(rows))]
    return arrays.with_elements(np.array(rows, float), nodes).reshape(shape)


def nodes_of(found):
    """The elements of a result, all of which must have provenance."""
    found = arrays.elements(found) if isinstance(found, np.ndarray) else [found]
    assert all(map(is_tracked, found))
    return found


def check(function, rows, *args, **keywords):
    """The plain value bit for bit, and an expression that gives it."""
    plain = function(np.array(rows, float), *args, **keywords)
    found = advised(function, marked(rows), *args, **keywords)
    assert type(found) == type(plain)  # noqa: E721
    np.testing.assert_array_equal(arrays.plain(found), plain)
    again = [provenance(node).evaluate({}) for node in nodes_of(found)]
    np.testing.assert_allclose(again, np.ravel(plain), rtol=1e-6, atol=1e-6)
    change = {"s0": float(rows[0] if np.ndim(rows) == 1 else rows[0][0]) + 0.001}
    return found, change


def moved(rows, change):
    other = np.array(rows, float)
    other.flat[0] = change["s0"]
    return other


def squares(size):
    return st.lists(st.lists(reals, min_size=size, max_size=size), min_size=size, max_size=size)


@pytest.mark.parametrize("size", [1, 2, 3, 4])
@pytest.mark.parametrize("function", [np.linalg.inv, np.linalg.det], ids=lambda f: f.__name__)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_matrices(function, size, data) -> None:
    rows = data.draw(squares(size))
    assume(abs(np.linalg.det(np.array(rows))) > 0.1 and np.linalg.cond(np.array(rows)) < 1e4)
    found, change = check(function, rows)
    other = moved(rows, change)
    assume(np.linalg.cond(other) < 1e4)
    expected = np.ravel(function(other))
    for node, value in zip(nodes_of(found), expected, strict=True):
        sources = {s.parameter for s in provenance(node).sources}
        got = provenance(node).evaluate(change if "s0" in sources else {})
        assert math.isclose(got, value, rel_tol=1e-5, abs_tol=1e-5)


@settings(max_examples=25, deadline=None)
@given(rows=squares(3), right=st.lists(reals.filter(bool), min_size=3, max_size=3))
def test_solve(rows, right) -> None:
    assume(np.linalg.cond(np.array(rows)) < 1e4)
    for b in (np.array(right), np.array(right)[:, None]):
        check(np.linalg.solve, rows, b)
    plain = np.linalg.solve(np.array(rows), np.array(right))
    found = advised(np.linalg.solve, np.array(rows), marked(right))
    np.testing.assert_array_equal(arrays.plain(found), plain)


@pytest.mark.parametrize("function", [np.median, np.std, np.var], ids=lambda f: f.__name__)
@settings(max_examples=25, deadline=None)
@given(
    rows=st.sampled_from([6, 9, 12])
    .flatmap(lambda size: st.lists(reals, min_size=size, max_size=size, unique=True))
    .map(lambda flat: [flat[start : start + 3] for start in range(0, len(flat), 3)])
)
def test_statistics(function, rows) -> None:
    for keywords in ({}, {"axis": 0}, {"axis": 1, "keepdims": True}):
        check(function, rows, **keywords)
    if function is not np.median:
        check(function, rows, ddof=1)


@settings(max_examples=25, deadline=None)
@given(
    points=st.lists(reals, min_size=2, max_size=5, unique=True).map(sorted),
    x=st.lists(reals, min_size=1, max_size=4),
)
def test_interp(points, x) -> None:
    values = [p * p for p in points]
    plain = np.interp(x, points, values)
    for args in ((x, points, marked(values)), (marked(x), points, marked(values))):
        found = advised(np.interp, *args)
        np.testing.assert_array_equal(arrays.plain(found), plain)
        again = [provenance(node).evaluate({}) for node in nodes_of(found)]
        np.testing.assert_allclose(again, plain, rtol=1e-9, atol=1e-9)
    one = advised(np.interp, tracked(0.5), [0.0, 1.0], [2.0, 4.0])
    assert list(provenance(one).invert(3.5).changes.values()) == [0.75]


def test_arange_follows_start_and_step() -> None:
    found = advised(np.arange, tracked(0.5, "start"), 3.0, tracked(0.5, "step"))
    np.testing.assert_array_equal(arrays.plain(found), np.arange(0.5, 3.0, 0.5))
    node = arrays.elements(found)[3]
    assert provenance(node).evaluate({"start": 1.0, "step": 1.0}) == 4.0
    assert not is_tracked(advised(np.arange, tracked(3))[1])


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64])
def test_scalars(kind) -> None:
    x = tracked(2.5)
    found = advised(kind, x)
    assert type(found) == kind and found == kind(2.5)  # noqa: E721
    assert is_tracked(found)
    assert type(advised(kind, "3")) is kind
    with pytest.raises(ValueError, match=r"could not convert|invalid literal"):
        advised(kind, "x")


@pytest.mark.parametrize("function", [np.average, np.linalg.det], ids=lambda f: f.__name__)
def test_errors_are_plain(function) -> None:
    with pytest.raises(Exception) as plain:
        function(np.zeros((2, 3)), 5)
    with pytest.raises(type(plain.value)) as ours:
        advised(function, marked(np.ones((2, 3))), 5)
    assert str(ours.value) == str(plain.value)
    with pytest.raises(np.linalg.LinAlgError):
        advised(np.linalg.inv, marked(np.zeros((2, 2))))


def test_large_matrices_are_plain(caplog) -> None:
    rows = np.eye(9) * 2
    with caplog.at_level(logging.DEBUG):
        found = advised(np.linalg.inv, marked(rows))
    np.testing.assert_array_equal(found, np.linalg.inv(rows))
    assert not arrays.has_provenance(found)


def test_polynomials_and_means() -> None:
    x = marked([1.5, 2.0, 4.0])
    assert provenance(advised(np.average, x)).invert(3.5).value == pytest.approx(3.5)
    value = advised(np.polyval, x, 2.0)
    assert untracked(value) == np.polyval([1.5, 2.0, 4.0], 2.0)
    assert provenance(value).invert(20.0).value == pytest.approx(20.0)
    power = advised(np.linalg.matrix_power, marked([[1.0, 2.0], [0.5, 1.0]]), 3)
    assert len(nodes_of(power)) == 4
