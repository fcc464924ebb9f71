"""YAML and JSON files as sources."""

import io
import json
import math
import os
import pathlib
from collections import OrderedDict

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosslt_auto.instrument.file_calls import call_file
from rosslt_auto.provenance import files, is_tracked, provenance, registry, untracked
from rosslt_auto.provenance.external import change_all, create_location
from rosslt_auto.provenance.file_positions import json_positions, scalars
from rosslt_auto.provenance.registry import location_of
from rosslt_auto.provenance.sources import SourceChangeRefused

MISSION = """\
# A mission
speed: 0.50   # m/s
name: 'first "flight"'
legs: 3
on: true
nothing: ~
waypoints:
  - {x: 1.0, y: -2.5, z: 1e+1}
  - x: 4
    y: &y 0x10
    z: *y
base: &base {gain: 2.0, rate: 10}
derived:
  <<: *base
  gain: 3.0
long: |
  text of
  lines
when: 2024-01-01
my-key: 1
my_key: {x: 2}
special: !!float 3
nan: .nan
"""


@pytest.fixture(autouse=True)
def _fresh(monkeypatch):
    monkeypatch.setattr(files, "_documents", {})
    monkeypatch.setattr(registry, "_others", {})
    monkeypatch.setattr(registry, "_initial", {})


@pytest.fixture
def mission(tmp_path):
    path = tmp_path / "mission.yaml"
    path.write_text(MISSION)
    return path


def load(path, function=yaml.safe_load, **keywords):
    with open(path) as file:
        return call_file(function, file, **keywords)


def source_of(value):
    [source] = provenance(value).sources
    return source


def changed(changes):
    change_all({source: source.check(value) for source, value in changes.items()})


def tracked_parts(value, path=""):
    if isinstance(value, dict):
        for key, item in value.items():
            yield from tracked_parts(item, f"{path}.{key}")
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from tracked_parts(item, f"{path}[{index}]")
    elif is_tracked(value):
        yield path.lstrip("."), value


def plain(value):
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return untracked(value)


def test_what_is_loaded_is_the_same(mission):
    with open(mission) as file:
        expected = yaml.safe_load(file)
    got = load(mission)
    assert math.isnan(got.pop("nan")) and math.isnan(expected.pop("nan"))
    assert got == expected and repr(got) == repr(expected)
    assert type(got) is dict and type(got["waypoints"]) is list


def test_scalars_know_their_place(mission):
    data = load(mission)
    found = dict(tracked_parts(data))
    assert set(found) == {
        "speed", "name", "legs", "waypoints[0].x", "waypoints[0].y", "waypoints[0].z",
        "waypoints[1].x", "waypoints[1].y", "waypoints[1].z", "base.gain", "base.rate",
        "derived.gain", "derived.rate", "my-key", "my_key.x",
    }  # fmt: skip
    lines = MISSION.splitlines()
    names = set()
    for value in found.values():
        source = source_of(value)
        start, end = source.range
        assert yaml.safe_load(MISSION[start:end]) == untracked(value)
        assert lines[source.line - 1][source.column :].startswith(MISSION[start:end])
        assert source.file == str(mission) and source.text == lines[source.line - 1].strip()
        assert location_of(source.parameter) is source
        names.add(source.parameter)
    assert source_of(data["waypoints"][0]["y"]).parameter.endswith(".mission.waypoints._0.y")
    assert source_of(data["my-key"]).parameter.endswith(".mission.my_key")
    assert source_of(data["my_key"]["x"]).parameter.endswith(".mission.my_key_2.x")
    assert not any(a != b and a.startswith(f"{b}.") for a in names for b in names)


def test_aliases_and_merged_keys_are_one_location(mission):
    data = load(mission)
    assert source_of(data["waypoints"][1]["y"]) is source_of(data["waypoints"][1]["z"])
    assert source_of(data["derived"]["rate"]) is source_of(data["base"]["rate"])
    assert source_of(data["derived"]["gain"]) is not source_of(data["base"]["gain"])


def test_a_change_rewrites_just_its_range(mission):
    data = load(mission)
    speed, x = source_of(data["speed"]), source_of(data["waypoints"][1]["x"])
    changed({speed: 1.25})
    expected = MISSION.replace("speed: 0.50 ", "speed: 1.25 ")
    assert mission.read_text() == expected
    changed({speed: 10, x: 12345, source_of(data["name"]): "it's"})
    expected = expected.replace("1.25 ", "10.00 ").replace("x: 4", "x: 12345")
    expected = expected.replace("'first \"flight\"'", "'it''s'")
    assert mission.read_text() == expected
    for value in dict(tracked_parts(data)).values():
        source = source_of(value)
        start, end = source.range
        assert yaml.safe_load(expected[start:end]) == source.value
        assert expected.splitlines()[source.line - 1].strip() == source.text
    again = load(mission)
    assert source_of(again["waypoints"][1]["x"]) is x and again["waypoints"][1]["x"] == 12345


def test_two_loads_give_the_same_locations(mission):
    first, second = load(mission), load(mission)
    pairs = zip(tracked_parts(first), tracked_parts(second), strict=True)
    assert all(a[1] is b[1] for a, b in pairs)
    assert source_of(first["speed"]).repeated
    loaded = load(mission, yaml.load, Loader=yaml.FullLoader)
    assert source_of(loaded["speed"]) is source_of(first["speed"])


def test_a_file_that_was_edited_is_refused_until_it_is_read_again(mission):
    data = load(mission)
    speed, legs = source_of(data["speed"]), source_of(data["legs"])
    edited = "# new\n" + MISSION.replace("0.50", "0.75").replace("legs: 3\n", "")
    mission.write_text(edited)
    with pytest.raises(SourceChangeRefused, match=r"not what was loaded: lines"):
        changed({speed: 1.0})
    assert mission.read_text() == edited and speed.value == 0.5
    data = load(mission)
    assert source_of(data["speed"]) is speed and data["speed"] == 0.75 and speed.line == 3
    changed({speed: 1.0})
    assert mission.read_text() == edited.replace("0.75", "1.00")
    with pytest.raises(SourceChangeRefused, match="does not have it any more"):
        changed({legs: 4})


def test_a_key_that_changes_its_type_keeps_its_name(mission):
    before = source_of(load(mission)["legs"])
    mission.write_text(MISSION.replace("legs: 3", "legs: 3.5\nnew: 1"))
    data = load(mission)
    after = source_of(data["legs"])
    assert after.kind == "float" and after.parameter == before.parameter
    assert location_of(before.parameter) is after
    assert source_of(data["new"]).parameter.endswith(".mission.new")
    with pytest.raises(SourceChangeRefused):
        before.check(4)


def test_a_refusal_by_another_source_leaves_the_file(mission):
    def setter(value):
        raise RuntimeError("no")

    speed = source_of(load(mission)["speed"])
    device = source_of(create_location(1, name="device", setter=setter))
    leaf = speed.leaf
    with pytest.raises(SourceChangeRefused, match="no"):
        changed({speed: 9.0, device: 2})
    assert mission.read_text() == MISSION and speed.leaf is leaf


@pytest.mark.parametrize("wrong", ["fast", float("inf"), True])
def test_wrong_values_are_refused(mission, wrong):
    source = source_of(load(mission)["speed"])
    with pytest.raises(SourceChangeRefused):
        changed({source: wrong})
    assert mission.read_text() == MISSION


def test_a_value_given_at_start_does_not_touch_the_file(mission):
    name = source_of(load(mission)["speed"]).parameter
    files._documents.clear()
    registry._others.clear()
    registry.set_initial_values({name: 2.0}, pytest.fail)
    data = load(mission)
    assert data["speed"] == 2.0 and mission.read_text() == MISSION
    assert load(mission)["speed"] == 2.0
    changed({source_of(data["speed"]): 3.0})
    assert mission.read_text() == MISSION.replace("0.50", "3.00")


# ---------------------------------------------------------------- JSON

JSON = '{"a": [1, 2.50, "x\\u00e9"], "b": {"c": -1E3, "a": null}, "t": true, "d": 1, "d": 2}\r\n'


@pytest.fixture
def settings_file(tmp_path):
    path = tmp_path / "settings.json"
    path.write_bytes(JSON.encode())
    return path


def load_methods():
    def opened(path):
        return load(path, json.load)

    def binary(path):
        with open(path, "rb") as file:
            return call_file(json.load, file)

    def text(path):
        with open(path) as file:
            return call_file(json.loads, call_file(file.read))

    def path_text(path):
        return call_file(json.loads, call_file(pathlib.Path(path).read_text, encoding="utf-8"))

    def ordered(path):
        return load(path, json.load, object_pairs_hook=OrderedDict)

    def with_yaml(path):
        return call_file(yaml.full_load, call_file(pathlib.Path(path).read_text))

    return [opened, binary, text, path_text, ordered, with_yaml]


@pytest.mark.parametrize("method", load_methods(), ids=lambda method: method.__name__)
def test_json_in_all_ways_of_loading(settings_file, method):
    data = method(settings_file)
    if method.__name__ != "with_yaml":  # YAML 1.1 has no such number as -1E3
        assert data == json.loads(JSON)
        assert {path for path, _ in tracked_parts(data)} == {"a[0]", "a[1]", "a[2]", "b.c", "d"}
    changed({source_of(data["a"][1]): 3, source_of(data["d"]): 10})
    assert settings_file.read_bytes().decode() == JSON.replace("2.50", "3.00").replace(
        '"d": 2', '"d": 10'
    )


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda below: (
        st.lists(below, max_size=4) | st.dictionaries(st.text(max_size=4), below, max_size=4)
    ),
    max_leaves=12,
)


@settings(max_examples=60)
@given(json_values, st.sampled_from([None, 1, "\t"]), st.booleans())
def test_positions_in_any_json(value, indent, ascii_only):
    text = json.dumps(value, indent=indent, ensure_ascii=ascii_only)
    for scalar in scalars(json_positions(text)):
        assert json.loads(text[scalar.start : scalar.end]) == scalar.value


@settings(max_examples=60, deadline=None)
@given(json_values, st.booleans(), st.data())
def test_any_yaml_and_json_survives_changes(tmp_path_factory, value, flow, data):
    path = tmp_path_factory.mktemp("any") / "x.yaml"
    path.write_text(yaml.safe_dump(value, default_flow_style=flow, allow_unicode=True))
    got = load(path)
    expected = yaml.safe_load(path.read_text())
    assert repr(got) == repr(expected)
    parts = [part for _, part in tracked_parts(got)]
    if not parts:
        return
    source = source_of(data.draw(st.sampled_from(parts)))
    kinds = {
        "float": st.floats(allow_nan=False, allow_infinity=False),
        "int": st.integers(-(2**63), 2**63 - 1),
        "str": st.text(max_size=5),
    }
    new = data.draw(kinds[source.kind])
    changed({source: new})
    again = load(path)
    assert [source_of(p) for _, p in tracked_parts(again)] == [source_of(p) for p in parts]
    assert source.value == new and repr(plain(again)) == repr(yaml.safe_load(path.read_text()))


# ---------------------------------------------------------------- what is left alone


def nothing_tracked(value):
    return not list(tracked_parts({"value": value}))


def test_hooks_and_other_sources_are_left_alone(settings_file, mission):
    assert nothing_tracked(load(settings_file, json.load, object_hook=lambda d: d))
    assert nothing_tracked(load(settings_file, json.load, parse_int=int))
    assert nothing_tracked(call_file(json.loads, JSON))
    assert nothing_tracked(call_file(json.load, io.StringIO(JSON)))
    assert nothing_tracked(call_file(json.loads, JSON.encode()))

    class Loader(yaml.SafeLoader):
        def construct_object(self, node, deep=False):
            return 5

    assert nothing_tracked(load(mission, yaml.load, Loader=Loader))
    assert nothing_tracked(call_file(yaml.safe_load, MISSION))


def test_constructors_and_tags_of_the_program(tmp_path):
    class Loader(yaml.SafeLoader):
        pass

    Loader.add_constructor("!twice", lambda loader, node: 2 * int(node.value))
    Loader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(node.value))
    path = tmp_path / "x.yaml"
    path.write_text("a: !twice 2\nb: 3\nc: 1.5\n")
    data = load(path, yaml.load, Loader=Loader)
    assert data == {"a": 4, "b": 3, "c": 1.5}
    assert [name for name, _ in tracked_parts(data)] == ["c"]


def test_changed_values_and_large_files_are_left_alone(tmp_path, monkeypatch):
    path = tmp_path / "x.json"
    path.write_text("[1, 2]")
    monkeypatch.setattr(files, "LIMIT", 5)
    assert nothing_tracked(load(path, json.load))
    monkeypatch.setattr(files, "LIMIT", 6)
    monkeypatch.setattr(files, "SCALARS", 1)
    assert nothing_tracked(load(path, json.load))
    files._documents.clear()
    monkeypatch.setattr(files, "SCALARS", 2)
    assert not nothing_tracked(load(path, json.load))


def test_a_renamed_file_is_left_alone(settings_file):
    with open(settings_file) as file:
        os.replace(settings_file, settings_file.with_suffix(".old"))
        settings_file.write_text(JSON)
        assert nothing_tracked(call_file(json.load, file))


@pytest.mark.parametrize("text", ["{", '{"a": 1} x', ""])
def test_errors_are_those_of_the_plain_function(tmp_path, text):
    path = tmp_path / "x.json"
    path.write_text(text)
    with open(path) as file, pytest.raises(ValueError, match=r"\w") as expected:
        json.load(file)
    with pytest.raises(ValueError, match=r"\w") as got:
        load(path, json.load)
    assert str(got.value) == str(expected.value)


def test_cycles_and_shared_containers(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text("a: &a [1, *a]\nb: &b {x: 2}\nc: *b\n5: 6\ntrue: 7\n")
    data = load(path)
    assert data["a"][1] is data["a"] and data["b"] is data["c"]
    assert is_tracked(data["a"][0]) and is_tracked(data["b"]["x"])
    assert source_of(data[5]).parameter.endswith(".x._5")


@pytest.mark.parametrize(
    "content",
    [
        b"a: 1\r\nb: 2.5 # c\r\n",
        b"\xef\xbb\xbfa: 1\nb: 2.5\n",
        "ä: 'häß' # 🚁\na: 1\nb: 2.5\n".encode(),
        b"a: 1\nb: 2.5",
        b"a: 1 #\tx\nb: 2.5 #\t2.4",
    ],
)
@pytest.mark.parametrize("mode", ["r", "rb"])
@pytest.mark.parametrize("loader", [yaml.SafeLoader, yaml.CSafeLoader])
def test_line_ends_marks_and_umlauts(tmp_path, content, mode, loader):
    path = tmp_path / "x.yaml"
    path.write_bytes(content)
    with open(path, mode) as file:
        data = call_file(yaml.load, file, loader)
    changed({source_of(data["a"]): 20, source_of(data["b"]): 3.25})
    assert path.read_bytes() == content.replace(b"a: 1", b"a: 20").replace(b"2.5", b"3.25")


def test_the_calling_module_is_named(settings_file):
    program = {"__name__": "pkg.node", "call_file": call_file, "json": json, "path": settings_file}
    exec("with open(path) as f: data = call_file(json.load, f)", program)
    assert source_of(program["data"]["d"]).parameter == "rosslt.pkg.node.settings.d"
