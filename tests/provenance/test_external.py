"""Sources by hand: `create_location`."""

import re
from pathlib import Path

import pytest

from rosslt_auto.provenance import external, is_tracked, provenance, registry
from rosslt_auto.provenance.external import change_all, create_location
from rosslt_auto.provenance.registry import free_name, location_of
from rosslt_auto.provenance.sources import SourceChangeRefused


@pytest.fixture(autouse=True)
def _fresh(monkeypatch):
    monkeypatch.setattr(external, "_made", {})
    monkeypatch.setattr(registry, "_others", {})
    monkeypatch.setattr(registry, "_initial", {})


def source_of(value):
    [source] = provenance(value).sources
    return source


def changed(changes):
    change_all({source: source.check(value) for source, value in changes.items()})


def test_one_place_is_one_location():
    values = [create_location(0.5) for _ in range(3)]
    assert values == [0.5] * 3 and is_tracked(values[0])
    assert len({source_of(value) for value in values}) == 1
    assert values[0] is values[1]
    other = create_location(0.5), create_location(0.5)
    assert source_of(other[0]) is not source_of(other[1])


def test_a_change_shows_in_the_next_call():
    def speed():
        return create_location(0.5)

    source = source_of(speed())
    changed({source: 2})
    assert speed() == 2.0 and source.value == 2.0 and source.first == 0.5
    assert speed() is source.leaf


def test_it_says_where_it_is():
    def planner():
        gain = create_location(3)
        return gain

    source = source_of(planner())
    assert source.hint == "gain" and source.kind == "int"
    assert source.parameter.endswith(
        ".test_it_says_where_it_is.planner.gain"
    ) and source.parameter.startswith("rosslt.")
    assert source.file == __file__ and source.text == "gain = create_location(3)"
    line = Path(__file__).read_text().splitlines()[source.line - 1]
    assert line[source.column :] == "create_location(3)"
    assert location_of(source.parameter) is source


def test_names():
    values = {name: create_location(1, name=name) for name in ("a", "b", "sub.__c__")}
    names = [source_of(value).parameter for value in values.values()]
    prefix = names[0].removesuffix(".a")
    assert names == [f"{prefix}.a", f"{prefix}.b", f"{prefix}.sub.c"]
    again = source_of(create_location(1, name="a")).parameter
    assert again == f"{prefix}.a_2"
    assert re.fullmatch(rf"{re.escape(prefix)}\.a_\d+\.b", free_name(f"{prefix}.a.b"))
    assert free_name(f"{prefix}.sub") == f"{prefix}.sub_2"
    assert free_name(f"{prefix}.su") == f"{prefix}.su"


def test_repeated_tells_once_from_again_and_again():
    def read():
        return create_location(1)

    source = source_of(read())
    assert not source.repeated
    read()
    assert source.repeated


def test_a_getter_gives_the_value():
    device = {"v": 1}

    def read():
        return create_location(None, name="v", getter=lambda: device["v"])

    first = read()
    device["v"] = 2
    second = read()
    assert (first, second) == (1, 2)
    assert source_of(first) is source_of(second)
    assert read() is second
    device["v"] = "no number"
    with pytest.raises(TypeError, match="no number"):
        read()


def test_a_device_may_measure_nan():
    assert str(create_location(1.0, getter=lambda: float("nan"))) == "nan"


def test_a_setter_takes_the_value_and_may_clamp_it():
    device = {"v": 1.0}
    value = create_location(
        1.0, getter=lambda: device["v"], setter=lambda v: device.update(v=min(v, 3.0))
    )
    changed({source_of(value): 2})
    assert device == {"v": 2.0} and source_of(value).value == 2.0
    changed({source_of(value): 5.0})
    assert source_of(value).value == 3.0


def refusing(reason):
    def setter(value):
        raise RuntimeError(reason)

    return setter


def test_a_setter_that_raises_refuses():
    source = source_of(create_location(1, setter=refusing("too hot")))
    leaf = source.leaf
    with pytest.raises(SourceChangeRefused, match="too hot"):
        changed({source: 2})
    assert source.leaf is leaf


def test_all_or_none():
    device = []
    plain = source_of(create_location(1.0, name="plain"))
    first = source_of(create_location(1, name="first", setter=device.append))
    second = source_of(create_location(1, name="second", setter=refusing("no")))
    leaves = plain.leaf, first.leaf, second.leaf
    with pytest.raises(SourceChangeRefused, match="no"):
        changed({plain: 2.0, first: 2, second: 2})
    assert device == [2, 1]
    assert (plain.leaf, first.leaf, second.leaf) == leaves
    assert all(a is b for a, b in zip((plain.leaf, first.leaf, second.leaf), leaves, strict=True))


def test_what_cannot_be_taken_back_is_said(caplog):
    calls = []

    def stubborn(value):
        calls.append(value)
        if len(calls) > 1:
            raise RuntimeError("stuck")

    first = source_of(create_location(1, name="first", setter=stubborn))
    second = source_of(create_location(1, name="second", setter=refusing("no")))
    with pytest.raises(SourceChangeRefused, match="no"):
        changed({first: 2, second: 2})
    assert first.value == 2 and "stuck" in caplog.text


@pytest.mark.parametrize("wrong", ["x", 1.5, float("nan"), 2**63, True])
def test_other_values_are_refused(wrong):
    source = source_of(create_location(1))
    with pytest.raises(SourceChangeRefused):
        source.check(wrong)


@pytest.mark.parametrize("wrong", [None, True, [1], b"x"])
def test_only_numbers_and_texts(wrong):
    with pytest.raises(TypeError, match="a location is"):
        create_location(wrong)


def test_a_value_given_at_start(monkeypatch):
    told, device = [], []
    name = source_of(create_location(1, name="probe")).parameter.removesuffix("probe")
    registry.set_initial_values({f"{name}good": 7, f"{name}bad": "x"}, told.append)
    assert create_location(1, name="good", setter=device.append) == 7 and device == [7]
    assert create_location(1, name="bad") == 1
    assert len(told) == 1 and "bad" in told[0]


def test_a_tracked_default_is_a_plain_value():
    inner = create_location(0.5, name="inner")
    outer = create_location(inner, name="outer")
    assert source_of(outer).hint == "outer" and outer == 0.5
