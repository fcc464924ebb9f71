"""Truth values in message fields: plain True and False, with provenance beside them."""

import copy
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Bool
from visualization_msgs.msg import Marker, MarkerArray

from rosslt_auto.provenance import is_tracked, provenance, refresh
from rosslt_auto.provenance.inversion import invert
from rosslt_auto.provenance.sources import SourceChangeRefused
from rosslt_auto.ros import flags, header, sequences
from rosslt_auto.ros.encoding import Encoder
from rosslt_auto.ros.fields import attach, collect, tracked_fields
from support.instrumented import Instrumented, loaded

PROGRAM = """
    from std_msgs.msg import Bool
    from visualization_msgs.msg import Marker, MarkerArray

    DEBUG = True

    class Talker:
        def __init__(self):
            self.on = True
            self.mode = True
            self.kept = Bool()
            self.kept.data = True

        def stop(self):
            self.mode = False

        def toggled(self):
            self.other = not self.on
            return Bool(data=self.other)

        def of_attribute(self):
            msg = Bool()
            msg.data = self.on
            return msg

        def of_mode(self):
            return Bool(data=self.mode)

    class Plain:
        data = None

    talker = Talker()

    def assigned():
        msg = Bool()
        msg.data = True
        return msg

    def keyword():
        return Bool(data=False)

    def of_constant():
        return Bool(data=DEBUG)

    def of_local():
        ready = False
        return Bool(data=ready)

    def chosen(x):
        msg = Bool()
        msg.data = True if x else False
        return msg

    def relayed(msg):
        out = Bool()
        out.data = msg.data
        return out

    def nested():
        array = MarkerArray()
        array.markers.append(Marker())
        array.markers[0].frame_locked = True
        array.markers.append(Marker(frame_locked=True, id=3))
        return array

    def computed(x):
        return Bool(data=x > 2)

    def overwritten(x):
        msg = Bool(data=True)
        msg.data = x
        return msg

    def plain():
        thing = Plain()
        thing.data = True
        return thing

    def wrong():
        msg = Bool()
        msg.data = 1
"""


@pytest.fixture(params=[False, True], ids=["unchecked", "checked"], autouse=True)
def _woven(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for cls in (Bool, Marker, MarkerArray):
        module = __import__(cls.__module__, fromlist=["x"])
        monkeypatch.setattr(module, "ros_python_check_fields", "1" if request.param else "")
    sequences.weave(Bool)
    sequences.weave(MarkerArray)
    yield
    sequences.uninstall()


@pytest.fixture
def program(tmp_path: Path) -> Iterator[Instrumented]:
    with loaded(PROGRAM, tmp_path) as program:
        yield program


def origin(message: Any, path: str = "data") -> str:
    """Where a field came from, as its parameter's name below the module's."""
    found = provenance(tracked_fields(message)[path])
    assert found is not None
    [source] = found.sources
    return source.parameter.split(".", 2)[2]


@pytest.mark.parametrize(
    ("call", "value", "parameter"),
    [
        ("assigned()", True, "assigned.data"),
        ("keyword()", False, "keyword.data"),
        ("of_constant()", True, "DEBUG"),
        ("of_local()", False, "of_local.ready"),
        ("chosen(1)", True, "chosen.data"),
        ("chosen(0)", False, "chosen.data_2"),
        ("talker.of_attribute()", True, "Talker.init.on"),
        ("talker.of_mode()", True, "Talker.init.mode"),
        ("talker.stop() or talker.of_mode()", False, "Talker.stop.mode"),
        ("relayed(assigned())", True, "assigned.data"),
        ("talker.kept", True, "Talker.init.data"),
    ],
)
def test_the_literal_is_known(
    program: Instrumented, call: str, value: bool, parameter: str
) -> None:
    message = eval(call, vars(program.names))
    assert message.data is value and type(message.data) is bool
    assert origin(message) == parameter
    assert program.location(parameter).kind == "bool"


@pytest.mark.parametrize(
    "call",
    ["computed(3)", "overwritten(True)", "talker.toggled()", "relayed(Bool(data=True))", "Bool()"],
)
def test_what_is_not_known_is_not_claimed(program: Instrumented, call: str) -> None:
    message = eval(call, vars(program.names))
    assert type(message.data) is bool and collect(message) == []


def test_nested_messages(program: Instrumented) -> None:
    found = tracked_fields(program.names.nested())
    assert list(found) == ["markers[0].frame_locked", "markers[1].frame_locked", "markers[1].id"]
    assert origin(program.names.nested(), "markers[1].frame_locked") == "nested.frame_locked_2"


def test_other_objects_are_not_touched(program: Instrumented) -> None:
    assert vars(program.names.plain()) == {"data": True}
    assert program.names.plain().data is True


def test_the_message_is_as_plain(program: Instrumented) -> None:
    message = program.names.assigned()
    assert message == Bool(data=True) and repr(message) == repr(Bool(data=True))
    assert serialize_message(message) == serialize_message(Bool(data=True))
    assert bool(message._check_fields) is bool(Bool()._check_fields)
    assert type(pickle.loads(pickle.dumps(message))._check_fields) is bool


def test_errors_are_those_of_the_plain_setter(
    program: Instrumented, request: pytest.FixtureRequest
) -> None:
    if "unchecked" in request.node.name:
        program.names.wrong()
    else:
        with pytest.raises(AssertionError, match="must be of type 'bool'"):
            program.names.wrong()


def test_copies_keep_provenance_and_go_their_own_ways(program: Instrumented) -> None:
    message = program.names.assigned()
    for other in (copy.copy(message), copy.deepcopy(message)):
        assert origin(other) == "assigned.data"
        other.data = False
        assert collect(other) == [] and origin(message) == "assigned.data"


def test_a_value_put_in_behind_the_setter_has_no_provenance(program: Instrumented) -> None:
    message = program.names.assigned()
    message._data = False
    assert collect(message) == []


def test_what_is_executed_again_has_the_new_value(program: Instrumented) -> None:
    program.change("assigned.data", False)
    message = program.names.assigned()
    assert message.data is False and origin(message) == "assigned.data"


def test_what_is_bound_to_it_follows(program: Instrumented) -> None:
    program.change("Talker.init.on", False)
    assert program.names.talker.on is False
    program.change("DEBUG", False)
    assert program.names.DEBUG is False
    assert program.names.of_constant().data is False


def test_a_message_that_is_kept_follows_when_it_is_published(program: Instrumented) -> None:
    kept = program.names.talker.kept
    program.change("Talker.init.data", False)
    [field] = collect(kept)
    field.put(refresh.refreshed(field.value))
    assert kept.data is False and origin(kept) == "Talker.init.data"


def test_a_change_is_checked_and_found_by_inversion(program: Instrumented) -> None:
    value = tracked_fields(program.names.assigned())["data"]
    assert is_tracked(value) and value._v is True
    assert invert(value, False).changes == {program.location("assigned.data"): False}
    for wrong in (0, 1.0, "false"):
        with pytest.raises(SourceChangeRefused):
            program.change("assigned.data", wrong)


def test_headers_bring_it_to_others(program: Instrumented) -> None:
    message = program.names.nested()
    found = list(tracked_fields(message).items())
    payload, _ = Encoder(lambda _: None).encode(0, 0, found)
    received = deserialize_message(serialize_message(message), MarkerArray)
    attach(received, header.decode(payload))
    assert received.markers[1].frame_locked is True
    told = tracked_fields(received)
    assert list(told) == [path for path, _ in found]
    assert [source.kind for source in provenance(told["markers[0].frame_locked"]).sources] == [
        "bool"
    ]
    received.markers[0].frame_locked = False
    assert "markers[0].frame_locked" not in tracked_fields(received)


def test_uninstalled_setters_are_plain(program: Instrumented) -> None:
    sequences.uninstall()
    assert collect(program.names.assigned()) == []
    assert flags.leaf_of(Bool(), "_data") is None
