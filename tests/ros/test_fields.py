"""Finding tracked fields in messages, and giving received messages their provenance."""

import array
import math
import struct
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import (
    Point,
    Point32,
    Polygon,
    Pose,
    PoseStamped,
    PoseWithCovariance,
    Quaternion,
    TransformStamped,
    Vector3,
)
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import Bool, ColorRGBA, Empty, Float32, Float64, Int32, String, UInt8
from visualization_msgs.msg import Marker, MarkerArray

from rosslt_auto.provenance import is_tracked, provenance
from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.ros import fields, header
from rosslt_auto.ros.encoding import Encoder
from rosslt_auto.ros.fields import attach, collect, trackable, tracked_fields
from rosslt_auto.ros.header import Header, HeaderError
from support.wire import told, tracked

_TYPES = (
    Point, Point32, Polygon, Pose, Quaternion, Float32, Float64, Int32, UInt8, Marker, MarkerArray,
    Vector3, ColorRGBA, JointState, PoseStamped, TransformStamped,
)  # fmt: skip


@pytest.fixture(params=["", "1"], ids=["unchecked", "checked"], autouse=True)
def _check_fields(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """With and without ROS_PYTHON_CHECK_FIELDS, which message modules read when imported."""
    for cls in _TYPES:
        module = __import__(cls.__module__, fromlist=["x"])
        monkeypatch.setattr(module, "ros_python_check_fields", request.param)


def received(message: Any, **changes: Any) -> tuple[Any, Header]:
    """A message as it arrives, still plain, and its header."""
    found = list(tracked_fields(message).items())
    payload, kept = Encoder(lambda _: None).encode(0, 0, found)
    assert kept == len(found)
    return deserialize_message(serialize_message(message), type(message)), header.decode(payload)


def sent_and_received(message: Any) -> Any:
    plain, its_header = received(message)
    attach(plain, its_header)
    return plain


def markers(count: int) -> MarkerArray:
    made = []
    for i in range(count):
        marker = Marker(id=i)
        marker.pose.position.y = tracked(float(i), f"y{i}") * 2
        marker.points = [Point(x=tracked(0.5, "x")), Point()]
        marker.color.r = tracked(0.25, "red")
        made.append(marker)
    return MarkerArray(markers=made)


# ---------------------------------------------------------------- collecting


def test_nothing_is_found_in_plain_messages() -> None:
    for cls in (Pose, PoseStamped, Image, JointState, String, Empty, TransformStamped):
        assert collect(cls()) == []
    assert collect(Marker(points=[Point(x=1.0)])) == []


def test_paths_are_those_one_types() -> None:
    message = PoseStamped()
    message.header.stamp.sec = tracked(5)
    message.pose.position.x = tracked(1.5)
    message.pose.orientation.w = tracked(0.5)
    found = collect(message)
    assert [field.path for field in found] == [
        "header.stamp.sec", "pose.position.x", "pose.orientation.w",
    ]  # fmt: skip
    for field in found:
        assert getattr(field.owner, field.slot) is field.value
        assert eval(f"message.{field.path}") is field.value


def test_sequences_of_messages() -> None:
    message = markers(300)
    found = tracked_fields(message)
    assert len(found) == 900
    assert found["markers[299].pose.position.y"] == 598.0
    assert found["markers[7].points[0].x"] is message.markers[7].points[0].x
    for path, value in found.items():
        assert eval(f"message.{path}") is value


def test_sequences_in_a_tuple_and_other_sequences() -> None:
    assert list(tracked_fields(Polygon(points=(Point32(), Point32(x=tracked(1.0)))))) == [
        "points[1].x"
    ]


def test_only_values_that_arrive_as_what_they_are() -> None:
    """A float in an int field, an int in a float field: plain sends garbage, or nothing."""
    unchecked = Point(check_fields=False)
    unchecked.x = tracked(3)
    assert collect(unchecked) == []
    number = Int32(check_fields=False)
    number.data = tracked(3.0)
    assert collect(number) == []


def test_odd_messages_have_no_tracked_fields() -> None:
    class Half(Pose):
        def __init__(self) -> None:  # slots stay unset
            pass

    class Own:
        x = tracked(1.0)

    assert collect(Half()) == []
    assert collect(Own()) == []
    assert collect(None) == []
    assert collect(b"\0\1\0\0") == []
    pose = Pose(check_fields=False)
    pose.position = None
    pose.orientation = Own()
    assert collect(pose) == []


def test_subclasses_of_nested_messages() -> None:
    class Named(Point):
        pass

    pose = Pose()
    pose.position = Named(x=tracked(1.0))
    assert list(tracked_fields(pose)) == ["position.x"]


def test_a_failure_in_the_middle_keeps_what_was_found() -> None:
    pose = Pose()
    pose.position.x = tracked(1.0)
    del pose.orientation._w
    assert list(tracked_fields(pose)) == ["position.x"]


@pytest.mark.parametrize(
    ("cls", "expected"),
    [(Pose, True), (Image, True), (Int32, True), (MarkerArray, True), (PoseWithCovariance, True),
     (String, True), (Empty, False), (Bool, True), (DiagnosticStatus, True)],
)  # fmt: skip
def test_types_whose_values_can_be_tracked(cls: type, expected: bool) -> None:
    assert trackable(cls) is expected


# ---------------------------------------------------------------- attaching


def test_expressions_arrive() -> None:
    gain, offset = tracked(2.0, "gain"), tracked(0.25, "offset")
    pose = Pose()
    scaled = gain * 3
    pose.position.x = scaled + offset
    pose.position.y = offset
    pose.orientation.w = -scaled
    arrived = sent_and_received(pose)
    assert arrived == pose
    assert told(arrived.position.x) == told(pose.position.x)
    assert told(arrived.position.y) == told(offset)
    assert told(arrived.orientation.w) == told(pose.orientation.w)
    assert arrived.orientation.w._a is arrived.position.x._a  # still shared
    assert type(arrived.position.z) is float


def test_many_elements_arrive() -> None:
    message = markers(100)
    arrived = sent_and_received(message)
    assert arrived == message
    sent = tracked_fields(message)
    found = tracked_fields(arrived)
    assert found.keys() == sent.keys()
    assert all(told(value)[3:] == told(sent[path])[3:] for path, value in found.items())


@pytest.mark.parametrize("value", [0.0, -0.0, math.inf, -math.inf, math.nan, 5e-324, 1.0, -1.5])
def test_values_arrive_bit_for_bit(value: float) -> None:
    message = Float64(check_fields=False)
    message.data = tracked(1.0) * 0 + 0  # something tracked, to be replaced
    for sent in (tracked(value), _computed(value)):
        message.data = sent
        arrived = sent_and_received(message).data
        assert is_tracked(arrived)
        assert struct.pack("d", arrived) == struct.pack("d", value)
        assert arrived.__class__ is float and type(arrived) == float  # noqa: E721


def _computed(value: float) -> Any:
    from rosslt_auto.provenance.values import record

    return record(OPERATORS["mul"], value, tracked(1.0), value)


@pytest.mark.parametrize("value", [0, 1, -1, 2**31 - 1, -(2**31)])
def test_integers_arrive(value: int) -> None:
    arrived = sent_and_received(Int32(data=tracked(value))).data
    assert is_tracked(arrived) and arrived == value and type(arrived) == int  # noqa: E721
    arrived = sent_and_received(Int32(data=tracked(value, "k") * 1)).data
    assert told(arrived) == told(tracked(value, "k") * 1)


def test_float32_fields_are_rounded_on_their_way() -> None:
    plain = deserialize_message(serialize_message(Float32(data=0.1)), Float32).data
    for sent in (tracked(0.1), tracked(0.05) * 2):
        arrived = sent_and_received(Float32(data=sent)).data
        assert arrived == plain != 0.1
        found = provenance(arrived)
        assert found is not None
        assert found.evaluate({}) == plain
        [source] = found.sources
        assert found.evaluate({source: source.check(0.0)}) == 0.0
        solution = found.invert(0.5)
        assert solution.exact
    arrived = sent_and_received(Float32(data=tracked(0.5))).data
    assert told(arrived) == told(tracked(0.5))  # nothing was rounded


def test_a_value_that_is_not_the_received_one_is_not_attached() -> None:
    message = Point(x=tracked(1.5), y=tracked(2.5) * 2, z=tracked(3.5))
    plain, its_header = received(message)
    plain.x, plain.y = 1.25, 5.25
    attach(plain, its_header)
    assert list(tracked_fields(plain)) == ["z"]
    assert (plain.x, plain.y) == (1.25, 5.25)


def test_zero_is_not_minus_zero() -> None:
    plain, its_header = received(Point(x=tracked(0.0), y=tracked(2.0) * 0.0))
    plain.x = plain.y = -0.0
    attach(plain, its_header)
    assert collect(plain) == []


def test_one_header_for_several_messages_and_types() -> None:
    plain, its_header = received(Point(x=tracked(1.5)))
    vector = Vector3(x=1.5)
    attach(plain, its_header)
    attach(vector, its_header)
    assert plain.x is vector.x


def _header(path: str, value: Any = None) -> Header:
    payload, _ = Encoder(lambda _: None).encode(0, 0, [(path, value or tracked(0.0))])
    return header.decode(payload)


@pytest.mark.parametrize(
    "path",
    ["q", "x.y", "x[0]", "_x", "__class__", "", ".", "x.", "SLOT_TYPES", "check_fields", "X",
     "_check_fields", "x y", "x\u0661"],
)  # fmt: skip
def test_fields_that_do_not_exist(path: str) -> None:
    point = Point()
    with pytest.raises(HeaderError):
        attach(point, _header(path))
    assert collect(point) == []


@pytest.mark.parametrize("path", ["points[5].x", "points[0]x", "points[-1].x", "points.x", "ns.x"])
def test_elements_that_do_not_exist(path: str) -> None:
    marker = Marker(points=[Point()])
    with pytest.raises(HeaderError):
        attach(marker, _header(path))


@pytest.mark.parametrize(
    ("message", "path"),
    [(String(data="0.0"), "data"), (Pose(), "position"),
     (Marker(points=[Point()]), "points[0]"), (Bool(), "data")],
    ids=repr,
)  # fmt: skip
def test_fields_that_only_later_versions_track_are_passed_over(message: Any, path: str) -> None:
    its_header = _header(path)
    attach(message, its_header)
    assert collect(message) == []


def test_arrays_of_types_that_are_not_woven_stay_what_they_are() -> None:
    state = JointState(position=[tracked(1.0), 2.0])
    assert type(state.position) is array.array
    assert collect(state) == []


def test_republished_fields_keep_their_history() -> None:
    """What arrived is an operand like any other, and travels on."""
    arrived = sent_and_received(Point(x=tracked(2.0, "gain") * 3)).x
    again = sent_and_received(Point(x=arrived, y=arrived + tracked(1.0, "offset", "/second")))
    assert told(again.x) == told(tracked(2.0, "gain") * 3)
    found = provenance(again.y)
    assert found is not None
    assert found.expression == "gain * 3 + offset"
    assert [(one.node, one.hint) for one in found.sources] == [
        ("/elsewhere", "gain"), ("/second", "offset"),
    ]  # fmt: skip


def test_walkers_are_generated_once() -> None:
    assert fields.collector(Pose) is fields.collector(Pose)


def test_types_that_refer_to_others_of_their_package_are_woven_while_it_is_imported() -> None:
    import subprocess
    import sys

    program = (
        "from rosslt_auto.ros import weave; weave.prepare([]); import rclpy.node\n"
        "from geometry_msgs.msg import Accel, Pose, Vector3\n"
        "from rosslt_auto.ros import sequences\n"
        "print({Accel, Pose, Vector3} <= set(sequences._plain))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("True\n", "")
