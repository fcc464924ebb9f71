"""Calls that would lose provenance: the plain value, the plain error, and provenance beside it."""

import math
import sys
import traceback

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosslt_auto.instrument import calls
from rosslt_auto.instrument.call_sites import MATH_CALLS
from rosslt_auto.provenance.expressions import provenance
from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.values import is_tracked, leaf, untracked


class _Source:
    hint = "x"
    named = True


def tracked(value):
    return leaf(_Source(), value)


def outcome(function, *args, **keywords):
    """Result with its type, or error with its text."""
    try:
        value = function(*args, **keywords)
    except Exception as error:
        return type(error), str(error)
    value = tuple(map(untracked, value)) if type(value) is tuple else untracked(value)
    return type(value), repr(value)  # repr tells NaN, and 0.0 from -0.0


numbers = st.one_of(st.floats(), st.integers(-(2**70), 2**70))
# Of factorial and perm there is an int for every int: too many digits to try.
UNARY = [float, int, type, *(
    getattr(math, n) for n in sorted(MATH_CALLS - {"factorial", "perm"}) if hasattr(math, n)
)]  # fmt: skip


@pytest.mark.parametrize("function", UNARY, ids=lambda f: f.__name__)
@given(x=numbers)
def test_one_argument(function, x) -> None:
    expected = outcome(function, x)
    assert outcome(calls.call_1, function, x) == expected
    assert outcome(calls.call_1, function, tracked(x)) == expected
    if function is not type:  # rewritten only where it has one argument
        assert outcome(calls.call_any, function, tracked(x)) == expected


BINARY = [
    "atan2",
    "comb",
    "copysign",
    "fmod",
    "gcd",
    "hypot",
    "lcm",
    "perm",
    "ldexp",
    "log",
    "pow",
    "remainder",
    "nextafter",
]


@pytest.mark.parametrize("name", BINARY)
@given(x=numbers, y=numbers)
def test_two_arguments(name, x, y) -> None:
    function = getattr(math, name)
    if name in ("comb", "perm"):
        x, y = (z % 50 if type(z) is int else z for z in (x, y))
    if name == "ldexp":
        y = int(y) % 100 if y == y and abs(y) != math.inf else 3
    expected = outcome(function, x, y)
    for a, b in ((x, y), (tracked(x), y), (x, tracked(y)), (tracked(x), tracked(y))):
        assert outcome(calls.call_2, function, a, b) == expected
        assert outcome(calls.call_any, function, a, b) == expected


@given(
    xs=st.lists(st.one_of(numbers, st.booleans())),
    which=st.integers(0, 3),
    start=st.sampled_from([0, 1, 0.5, "", [], None]),
)
def test_sum(xs, which, start) -> None:
    marked = [tracked(x) if i % 4 == which and type(x) is not bool else x for i, x in enumerate(xs)]
    expected = outcome(sum, xs, start)
    assert outcome(calls.call_items, sum, marked) == outcome(sum, xs)
    assert outcome(calls.call_items, sum, iter(marked)) == outcome(sum, xs)
    assert outcome(calls.call_any, sum, marked, start) == expected
    assert outcome(calls.call_any, sum, iter(marked), start) == expected
    assert outcome(calls.call_any, sum, tuple(marked), start=start) == expected
    assert outcome(calls.call_any, sum, marked, tracked(1)) == outcome(sum, xs, 1)


@given(xs=st.lists(numbers), default=numbers, which=st.sampled_from([min, max]))
def test_extremes_with_a_default(xs, default, which) -> None:
    marked = [tracked(x) for x in xs]
    expected = outcome(which, xs, default=default)
    assert outcome(calls.call_any, which, marked, default=default) == expected
    assert outcome(calls.call_any, which, iter(marked), default=tracked(default)) == expected
    if len(xs) > 1:
        found = provenance(calls.call_any(which, marked, default=default))
        assert len(found.sources) == len(xs)


@given(x=numbers, specification=st.sampled_from(["", ".2f", "+08.3g", "n", "x", "wrong"]))
def test_format(x, specification) -> None:
    expected = outcome(format, x, specification)
    assert outcome(calls.call_2, format, tracked(x), specification) == expected
    assert outcome(calls.call_2, format, tracked(x), tracked(specification)) == expected
    assert outcome(calls.call_1, format, tracked(x)) == outcome(format, x)


def test_a_formatted_number_is_read_back() -> None:
    speed = leaf(Source("/node", "speed", "float"), 0.5)
    text = calls.call_2(format, speed, ".2f")
    assert list(provenance(text).invert("0.75").changes.values()) == [0.75]


@given(st.lists(st.tuples(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9)), min_size=1))
def test_dist(points) -> None:
    p, q = zip(*points, strict=True)
    result = calls.call_any(math.dist, [tracked(x) for x in p], q)
    assert untracked(result) == math.dist(p, q)
    assert provenance(result).evaluate({}) == math.dist(p, q)


def test_dist_of_what_only_converts_to_numbers() -> None:
    class Like:
        def __float__(self) -> float:
            return 1.0

    assert outcome(calls.call_any, math.dist, [tracked(4.0)], [Like()]) == (float, "3.0")


def test_everything_with_an_operator_keeps_provenance() -> None:
    names = {name for name in OPERATORS if callable(getattr(math, name, None))}
    names -= {"floor", "ceil", "trunc", "prod"}  # these ask the operand itself
    lost = []
    for name in names - {"pow"} | {"fpow"}:
        function = getattr(math, "pow" if name == "fpow" else name)
        for args in ((0.5,), (1.5,), (0.5, 2), (0.5, 0.25)):
            try:
                function(*args)
            except (TypeError, ValueError):
                continue
            helper = (calls.call_1, calls.call_2)[len(args) - 1]
            if not is_tracked(helper(function, tracked(args[0]), *args[1:])):
                lost.append((name, args))
    assert not lost


def test_kept_without_help() -> None:
    x = tracked(2.5)
    for value in (abs(x), round(x), pow(x, 2), divmod(x, 2)[1], math.floor(x), math.ceil(x)):
        assert is_tracked(value)
    assert is_tracked(max(x, 1)) and is_tracked(math.prod([2, x]))


def test_float_of_a_float_is_the_float_itself() -> None:
    x = tracked(2.5)
    assert calls.call_1(float, x) is x
    assert provenance(calls.call_1(int, x)).expression == "int(x)"


def test_type_is_the_plain_type() -> None:
    assert calls.call_1(type, tracked(2.5)) is float
    assert calls.call_1(type, tracked(2)) is int
    assert calls.call_1(type, "x") is str


def test_functions_of_the_same_name_are_called_as_they_are() -> None:
    class Unhashable:
        __hash__ = None

        def __call__(self, *args, **keywords):
            return args, keywords

    x = tracked(1.0)
    function = Unhashable()
    assert calls.call_1(function, x)[0][0] is x
    assert calls.call_2(function, x, 2)[0][0] is x
    assert calls.call_items(function, [x])[0][0][0] is x
    assert calls.call_any(function, x, k=x)[1]["k"] is x


@pytest.mark.parametrize(
    ("args", "keywords"), [((), {}), ((1, 2), {}), ((1, 2, 3), {}), ((), {"x": 1}), (("a",), {})]
)
@pytest.mark.parametrize("function", [float, math.sin, sum, math.hypot], ids=lambda f: f.__name__)
def test_wrong_calls_fail_as_plain_ones(function, args, keywords) -> None:
    marked = [tracked(a) if type(a) is int else a for a in args]
    expected = outcome(function, *args, **keywords)
    assert outcome(calls.call_any, function, *marked, **keywords) == expected
    if len(args) == 2 and not keywords:
        assert outcome(calls.call_2, function, *marked) == expected
    if len(args) == 1 and not keywords:
        assert outcome(calls.call_items, function, *marked) == expected


def test_items_are_consumed_as_by_the_plain_function() -> None:
    def consumed(function):
        taken = []

        def items():
            for item in (1, tracked(2), "x", 4):
                taken.append(untracked(item))
                yield item

        with pytest.raises(TypeError):
            function(items())
        return taken

    assert consumed(lambda items: calls.call_any(sum, items)) == consumed(sum)


@pytest.mark.parametrize(
    "call",
    [
        lambda: calls.call_1(math.sqrt, tracked(-1.0)),
        lambda: calls.call_1(math.sqrt, -1.0),
        lambda: calls.call_1(int, tracked(math.inf)),
        lambda: calls.call_2(math.fmod, tracked(1.0), 0.0),
        lambda: calls.call_any(sum, [tracked(1.0), "x"]),
        lambda: calls.call_any(sum, (x for x in [tracked(1.0), "x"])),
        lambda: calls.call_any(math.hypot, tracked(1.0), "x", 3),
        lambda: calls.call_any(math.dist, [tracked(1.0)], [1, 2]),
    ],
)
def test_tracebacks_are_plain(call) -> None:
    with pytest.raises((ValueError, TypeError, OverflowError)) as caught:
        call()
    frames = [frame.name for frame in traceback.extract_tb(caught.tb)]
    assert frames == ["test_tracebacks_are_plain", "<lambda>"]


@pytest.mark.skipif(sys.version_info < (3, 12), reason="new in 3.12")
def test_sumprod() -> None:
    p, q = [0.1, tracked(0.2), 0.3], [tracked(1e16), 1.0, -1e16]
    expected = math.sumprod(map(untracked, p), map(untracked, q))
    assert untracked(calls.call_any(math.sumprod, p, q)) == expected
