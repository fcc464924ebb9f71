"""Tracked strings: the same texts as plain Python, and parsed back when a text is forced."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosslt_auto.provenance import NotInvertible, TrackedStr, provenance, strings
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.values import is_tracked, leaf

texts = st.text(max_size=12)


def source(name: str, value, named: bool = True):
    """A leaf of a source in some other node."""
    return leaf(Source("/node", name, type(value).__name__, named=named), value)


def changes(value, target, **options) -> dict:
    """What forcing `target` would change, by parameter name."""
    found = provenance(value).invert(target, **options)
    assert found.value == target
    return {changed.parameter: new for changed, new in found.changes.items()}


def interpolate(template, *values):
    """What the rewriter makes of an f-string: `template` makes the text from noted values."""
    parts, build = template
    interpolation = strings.Interpolation(parts)
    token = interpolation.begin()
    return interpolation.end(token, build(*(interpolation.value(v) for v in values)))


BATTERY = (
    ((None, None, ""), (" ", None, ""), (None, None, "d"), (" of 10", None, "")),
    lambda label, n: f"{label} {n:d} of 10",
)


@given(texts, texts, st.integers(-3, 5), st.integers(-15, 15), st.integers(-15, 15))
def test_operators_give_the_plain_texts(a, b, count, start, stop):
    x, y = source("a", a), source("b", b)
    for got, plain in (
        (x + y, a + b),
        (x + b, a + b),
        (a + y, a + b),
        (x * count, a * count),
        (count * x, a * count),
        (x[start:stop], a[start:stop]),
        (x[::-1], a[::-1]),
        (x.join([y, "z", y]), a.join([b, "z", b])),
        (x.upper(), a.upper()),
        (x.strip(), a.strip()),
        (strings.tracked_str(x), a),
    ):
        assert got == plain and hash(got) == hash(plain) and repr(got) == repr(plain)
        assert is_tracked(got)
        assert provenance(got).evaluate({}) == plain


@given(texts, st.integers(), st.floats(allow_nan=False, allow_infinity=False), texts)
def test_templates_give_the_plain_texts(label, n, x, after):
    tracked = source("n", n), source("x", x)
    percent = label.replace("%", "%%") + "%d|%.3f|%5s|%%" + after.replace("%", "%%")
    braces = "{0}{1:.3f}{{" + after.replace("{", "{{").replace("}", "}}") + "{0!r:>8}"
    for got, plain in (
        (source("t", percent) % (*tracked, "s"), percent % (n, x, "s")),
        (source("t", braces).format(*tracked), braces.format(n, x)),
        (source("t", "{a}-{b:+}").format(a=tracked[0], b=tracked[1]), f"{n}-{x:+}"),
    ):
        assert got == plain and type(got) is TrackedStr
        assert provenance(got).evaluate({}) == plain


@given(texts, st.integers())
def test_an_f_string_keeps_its_pieces(label, n):
    text = interpolate(BATTERY, source("label", label), source("n", n))
    assert text == f"{label} {n:d} of 10" and type(text) is TrackedStr
    assert [s.parameter for s in provenance(text).sources] == ["label", "n"]


def test_an_f_string_of_plain_values_is_a_plain_str():
    assert not is_tracked(interpolate(BATTERY, "x", 3))


def test_nested_and_interrupted_f_strings_do_not_mix():
    outer = strings.Interpolation(((None, None, ""), (None, None, "")))
    inner = strings.Interpolation(((None, None, ""),))
    n = source("n", 4)
    with pytest.raises(ZeroDivisionError):
        outer.end(outer.begin(), f"{outer.value(n)}{outer.value(1 // 0)}")
    text = outer.end(
        outer.begin(),
        f"{outer.value(n)}{outer.value(inner.end(inner.begin(), f'{inner.value(7)}'))}",
    )
    assert text == "47"
    assert provenance(text).expression == "f'{n}7'"


@pytest.mark.parametrize(
    ("target", "expected"),
    [
        ("battery 4 of 10", {"n": 4}),
        ("volts 3 of 10", {"label": "volts"}),
        ("volts 4 of 10", {"label": "volts", "n": 4}),
    ],
)
def test_a_forced_text_is_parsed_back_into_its_parts(target, expected):
    text = interpolate(BATTERY, source("label", "battery"), source("n", 3))
    assert changes(text, target) == expected


@pytest.mark.parametrize("target", ["battery four of 10", "battery 4 of 11", "", "3"])
def test_a_text_of_another_form_is_refused(target):
    text = interpolate(BATTERY, source("label", "battery"), source("n", 3))
    with pytest.raises(NotInvertible, match=r"\w"):
        provenance(text).invert(target, source="n")


@pytest.mark.parametrize(
    ("spec", "old", "shown", "new"),
    [
        ("d", 3, "12", 12),
        ("04d", 3, "0012", 12),
        ("x", 10, "ff", 255),
        (",", 3, "1,234", 1234),
        ("b", 1, "101", 5),
        (".2f", 0.5, "0.75", 0.75),
        ("8.3f", 0.5, "   1.250", 1.25),
        ("*>8.3f", 0.5, "***1.250", 1.25),
        ("e", 0.5, "2.500000e-01", 0.25),
        (".1%", 0.5, "75.0%", 0.75),
        ("+.1f", 0.5, "-2.5", -2.5),
    ],
)
def test_format_specifications_are_read_backwards(spec, old, shown, new):
    template = (((None, None, spec),), lambda value: format(value, spec))
    assert changes(interpolate(template, source("v", old)), shown) == {"v": new}


def test_templates_are_inverted_in_values_and_in_their_own_text():
    n, x = source("n", 3), source("x", 0.5)
    text = source("fmt", "at %d (%.2f)") % (n, x)
    assert changes(text, "at 7 (0.50)") == {"n": 7}
    assert changes(text, "at 3 (0.75)") == {"x": 0.75}
    assert changes(text, "on 3 (0.50)!") == {"fmt": "on %d (%.2f)!"}
    text = source("fmt", "{0} is {1:.1f} {{ok}}").format(n, x)
    assert changes(text, "3 is 0.9 {ok}") == {"x": 0.9}
    assert changes(text, "3 was 0.5 {fine}") == {"fmt": "{0} was {1:.1f} {{fine}}"}


def test_concatenations_slices_and_joins_are_inverted():
    label = source("label", "battery")
    assert changes(label + " x", "cell x") == {"label": "cell"}
    assert changes("x " + label, "x cell") == {"label": "cell"}
    assert changes(label * 2, "cellcell") == {"label": "cell"}
    assert changes(label[1:3], "XX") == {"label": "bXXtery"}
    joined = source("sep", ", ").join([source("a", "aa"), "b", source("c", "cc")])
    assert changes(joined, "aa, b, dd") == {"c": "dd"}
    assert changes(strings.tracked_str(source("x", 0.5)) + " m", "0.75 m") == {"x": 0.75}


def test_arithmetic_below_a_text_is_inverted_too():
    x = source("x", 0.5)
    text = strings.tracked_str(2 * x) + " m"
    assert changes(text, "3.0 m") == {"x": 1.5}
    squared = strings.tracked_str(x * x)
    assert changes(squared, "0.0625")["x"] == pytest.approx(0.25)


def test_a_tracked_text_works_where_a_plain_one_does():
    class Holder:
        name = 1

    name = source("name", "name")
    assert {name: 1}["name"] == 1 and {"name": 2}[name] == 2
    assert getattr(Holder, name) == 1
    assert name in {"name"} and name.split("a") == ["n", "me"]
    assert type(name) == str and name.__class__ is str and isinstance(name, str)  # noqa: E721
    assert "".join([name, "x"]) == "namex"


@pytest.mark.parametrize("other", [5, None, b"x", 1.5])
def test_errors_are_those_of_a_plain_text(other):
    plain, tracked = "x", source("s", "x")
    for attempt in (lambda s: s + other, lambda s: other + s):
        with pytest.raises(TypeError) as expected:
            attempt(plain)
        with pytest.raises(TypeError) as got:
            attempt(tracked)
        assert str(got.value) == str(expected.value)


def test_a_growing_text_stays_bounded():
    text = source("s", "")
    for i in range(5000):
        text = (text + source(f"s{i % 3}", "x"))[-50:]
    assert text == "x" * 50
    assert text._depth <= 1100
    assert {s.parameter for s in provenance(text).sources} >= {"s0", "s1", "s2"}
