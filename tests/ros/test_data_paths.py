"""Every way in which nodes put values into messages: what a program sees, and what is tracked."""

import textwrap
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import deserialize_message, serialize_message

from rosslt_auto.instrument import array_calls, calls
from rosslt_auto.provenance import provenance, refresh
from rosslt_auto.ros import header, sequences
from rosslt_auto.ros.encoding import Encoder
from rosslt_auto.ros.fields import attach, collect, tracked_fields
from support.instrumented import Instrumented, loaded

PROLOGUE = """
    import array, copy, math
    import numpy as np
    from builtin_interfaces.msg import Time
    from geometry_msgs.msg import (
        Point, PolygonStamped, Polygon, Point32, Pose, PoseArray, PoseStamped, PoseWithCovariance,
        Twist, TwistStamped, Vector3,
    )
    from nav_msgs.msg import OccupancyGrid, Path
    from rcl_interfaces.msg import ParameterValue
    from sensor_msgs.msg import CameraInfo, Image, Imu, Joy, JointState, LaserScan, NavSatFix
    from sensor_msgs.srv import SetCameraInfo
    from shape_msgs.msg import SolidPrimitive
    from std_msgs.msg import (
        Bool, ByteMultiArray, Float32MultiArray, MultiArrayDimension, String, UInt8MultiArray,
    )
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
    from visualization_msgs.msg import Marker, MarkerArray

    UNKNOWN = [float(c) for c in "123"]

    class Robot:
        def __init__(self):
            self.angle = 0.5
            self.kept = JointState(position=UNKNOWN)

    robot = Robot()
"""

PATHS: dict[str, tuple[str, dict[str, str]]] = {
    "a list": (
        "msg = JointState(); msg.position = [robot.angle, 2.0 * robot.angle, UNKNOWN[0]]",
        {"position[0]": "angle", "position[1]": "2.0 * angle"},
    ),
    "a tuple": (
        "msg = JointState(); msg.position = (UNKNOWN[0], robot.angle)",
        {"position[1]": "angle"},
    ),
    "a generator": (
        "msg = JointState(); msg.position = list(x * robot.angle for x in UNKNOWN)",
        {f"position[{i}]": f"{i + 1.0} * angle" for i in range(3)},
    ),
    "an array": (
        "a = array.array('d', [robot.angle, UNKNOWN[1]]); msg = JointState(); msg.position = a",
        {"position[0]": "angle"},
    ),
    "an array that is filled": (
        "a = array.array('d'); a.append(robot.angle); msg = JointState(); msg.position = a",
        {"position[0]": "angle"},
    ),
    "an array of numpy": (
        "msg = JointState(); msg.position = list(np.array([robot.angle, 1.5]) * UNKNOWN[1])",
        {"position[0]": "angle * 2.0", "position[1]": "1.5 * 2.0"},
    ),
    "a keyword": (
        "msg = JointState(name=['a'], position=[robot.angle], velocity=(UNKNOWN[0], robot.angle))",
        {"name[0]": "name", "position[0]": "angle", "velocity[1]": "angle"},
    ),
    "appended to nothing": (
        "msg = JointState(); msg.position.append(robot.angle); msg.effort.extend([robot.angle])",
        {"position[0]": "angle", "effort[0]": "angle"},
    ),
    "appended to plain elements": (
        "msg = JointState(); msg.position = UNKNOWN; msg.position.append(robot.angle)",
        {"position[3]": "angle"},
    ),
    "appended to a keyword": (
        "msg = JointState(position=UNKNOWN); msg.position.append(robot.angle)",
        {"position[3]": "angle"},
    ),
    "inserted": (
        "msg = JointState(position=UNKNOWN); msg.position.insert(1, robot.angle)",
        {"position[1]": "angle"},
    ),
    "extended": (
        "msg = JointState(position=UNKNOWN); msg.position.extend(x * robot.angle for x in UNKNOWN)",
        {f"position[{i + 3}]": f"{i + 1.0} * angle" for i in range(3)},
    ),
    "added in place": (
        "msg = JointState(position=UNKNOWN);"
        " msg.position += array.array('d', [robot.angle])",
        {"position[3]": "angle"},
    ),
    "an element": (
        "msg = LaserScan(ranges=UNKNOWN); msg.ranges[2] = robot.angle; msg.ranges[-3] = 2.5",
        {"ranges[0]": "ranges", "ranges[2]": "angle"},
    ),
    "an element of float32": (
        "msg = LaserScan(ranges=UNKNOWN); msg.ranges[1] = 0.1",
        {"ranges[1]": "float32(ranges)"},
    ),
    "a slice": (
        "msg = JointState(position=UNKNOWN);"
        " msg.position[1:] = array.array('d', [robot.angle, UNKNOWN[0]])",
        {"position[1]": "angle"},
    ),
    "popped": (
        "msg = JointState(position=[robot.angle, UNKNOWN[0], 2.0]); msg.position.pop(0)",
        {"position[1]": "position"},
    ),
    "popped and used": (
        "a = JointState(position=[robot.angle]); msg = Point(x=a.position.pop())",
        {"x": "angle"},
    ),
    "removed": (
        "msg = JointState(position=[robot.angle, 2.0]); msg.position.remove(0.5)",
        {"position[0]": "position"},
    ),
    "deleted": (
        "msg = JointState(position=[robot.angle, 2.0]); del msg.position[0]",
        {"position[0]": "position"},
    ),
    "reversed": (
        "msg = JointState(position=[robot.angle, UNKNOWN[1]]); msg.position.reverse()",
        {"position[1]": "angle"},
    ),
    "cleared": (
        "msg = JointState(position=[robot.angle]); del msg.position[:];"
        " msg.position.append(robot.angle * 3.0)",
        {"position[0]": "angle * 3.0"},
    ),
    "read back": (
        "a = JointState(position=[robot.angle, 2.0]); msg = Point(x=a.position[0],"
        " y=a.position[-1], z=sum(a.position))",
        {"x": "angle", "y": "position", "z": "sum(0, angle, position)"},
    ),
    "read by a loop": (
        "a = JointState(position=[robot.angle, 2.0]); msg = JointState();"
        " msg.velocity = [v * UNKNOWN[1] for v in a.position]",
        {"velocity[0]": "angle * 2.0", "velocity[1]": "position * 2.0"},
    ),
    "a slice of another": (
        "a = JointState(position=[UNKNOWN[0], robot.angle, UNKNOWN[1]]); msg = JointState();"
        " msg.position = a.position[1:]",
        {"position[0]": "angle"},
    ),
    "replaced by what is not known": (
        "msg = JointState(position=[robot.angle]); msg.position = UNKNOWN",
        {},
    ),
    "integers": (
        "msg = Joy(); msg.buttons = [1, 0]; msg.buttons.append(7)",
        {"buttons[0]": "buttons", "buttons[1]": "buttons_2", "buttons[2]": "7"},
    ),
    "texts in a list": (
        "msg = JointState(); msg.name = ['a', 'b' + '_link']; msg.name.append('c')",
        {"name[0]": "name", "name[1]": "'b' + '_link'", "name[2]": "'c'"},
    ),
    "texts in a tuple": (
        "msg = JointState(); msg.name = ('a', str(UNKNOWN[0]))",
        {"name[0]": "name"},
    ),
    "a bounded sequence": (
        "msg = SolidPrimitive(type=1, dimensions=[robot.angle]); msg.dimensions.append(2.0)",
        {"type": "type", "dimensions[0]": "angle", "dimensions[1]": "2.0"},
    ),
    "a fixed array's element": (
        "msg = PoseWithCovariance(); msg.covariance[0] = 0.25; msg.covariance[35] = robot.angle",
        {"covariance[0]": "covariance", "covariance[35]": "angle"},
    ),
    "a fixed array from a list": (
        "msg = NavSatFix(); msg.position_covariance = [robot.angle] + UNKNOWN + UNKNOWN"
        " + UNKNOWN[:2]",
        {"position_covariance[0]": "angle"},
    ),
    "a fixed array from a keyword": (
        "msg = Imu(angular_velocity_covariance=[robot.angle] + UNKNOWN + UNKNOWN + UNKNOWN[:2])",
        {"angular_velocity_covariance[0]": "angle"},
    ),
    "a fixed array from numpy": (
        "msg = NavSatFix(); msg.position_covariance = np.array([robot.angle] * 9)",
        {f"position_covariance[{i}]": "angle" for i in range(9)},
    ),
    "a slice of a fixed array": (
        "msg = NavSatFix(); msg.position_covariance[:2] = [robot.angle, UNKNOWN[0]]",
        {"position_covariance[0]": "angle"},
    ),
    "an array built in place": (
        "msg = CameraInfo(); msg.k[0] = 525.0; msg.d = [robot.angle]",
        {"k[0]": "k", "d[0]": "angle"},
    ),
    "an alias": (
        "out = Twist(); msg = TwistStamped(); msg.twist.linear = out.linear;"
        " out.linear.x = robot.angle",
        {"twist.linear.x": "angle"},
    ),
    "a whole message": (
        "pose = Pose(); pose.position = Point(x=robot.angle); msg = PoseStamped(pose=pose)",
        {"pose.position.x": "angle"},
    ),
    "a copy": (
        "a = JointState(position=[robot.angle]); a.header.frame_id = 'base'; msg = copy.copy(a)",
        {"header.frame_id": "frame_id", "position[0]": "angle"},
    ),
    "a deep copy": (
        "a = JointState(position=[robot.angle]); a.header.frame_id = 'base';"
        " msg = copy.deepcopy(a); a.position[0] = UNKNOWN[0]; a.header.frame_id = str(UNKNOWN)",
        {"header.frame_id": "frame_id", "position[0]": "angle"},
    ),
    "a deep copy of a fixed array": (
        "a = PoseWithCovariance(); a.covariance[0] = robot.angle; msg = copy.deepcopy(a)",
        {"covariance[0]": "angle"},
    ),
    "a deep copy without provenance": (
        "msg = copy.deepcopy(JointState(position=UNKNOWN)); msg.position.append(robot.angle);"
        " msg.position[0] = 7.5",
        {"position[0]": "position", "position[3]": "angle"},
    ),
    "kept in a container": (
        "kept = {'a': [Pose()]}; kept['a'][0].position.y = robot.angle; msg = kept['a'][0]",
        {"position.y": "angle"},
    ),
    "kept in an attribute": (
        "robot.kept.position[1] = robot.angle; msg = robot.kept",
        {"position[1]": "angle"},
    ),
    "a message in a sequence": (
        "msg = Marker(); msg.points.append(Point(x=0.1)); msg.points[0].y = robot.angle",
        {"points[0].x": "x", "points[0].y": "angle"},
    ),
    "deep in a sequence": (
        "msg = Path(); msg.poses = [PoseStamped() for _ in range(5)];"
        " msg.poses[3].pose.position.x = 1.0",
        {"poses[3].pose.position.x": "x"},
    ),
    "sequences in sequences": (
        "msg = JointTrajectory(); msg.joint_names = ['j'];"
        " msg.points = [JointTrajectoryPoint(positions=UNKNOWN), JointTrajectoryPoint()];"
        " msg.points[0].positions[2] = robot.angle; msg.points[1].velocities.append(1.5)",
        {"joint_names[0]": "joint_names", "points[0].positions[2]": "angle",
         "points[1].velocities[0]": "1.5"},
    ),
    "a tuple of messages": (
        "msg = PolygonStamped(polygon=Polygon(points=(Point32(x=0.25), Point32())))",
        {"polygon.points[0].x": "x"},
    ),
    "messages from a loop": (
        "msg = PoseArray();"
        "\\nfor i in range(2):\\n    pose = Pose(); pose.position.x = robot.angle * i;"
        " msg.poses.append(pose)",
        {"poses[0].position.x": "angle * 0", "poses[1].position.x": "angle * 1"},
    ),
    "a layout": (
        "msg = Float32MultiArray(data=UNKNOWN);"
        " msg.layout.dim.append(MultiArrayDimension(label='x', size=3)); msg.data[1] = 0.5",
        {"layout.dim[0].label": "label", "layout.dim[0].size": "size", "data[1]": "data"},
    ),
    "a service's message": (
        "request = SetCameraInfo.Request(); request.camera_info.width = 640;"
        " request.camera_info.d = [robot.angle]; msg = request.camera_info",
        {"width": "width", "d[0]": "angle"},
    ),
    "from one message to another": (
        "a = JointState(position=[robot.angle, UNKNOWN[0]]); msg = JointState();"
        " msg.velocity = a.position",
        {"velocity[0]": "angle"},
    ),
    "bytes in a list": (
        "msg = UInt8MultiArray(data=[1, int(UNKNOWN[0]), 7]); msg.data.append(9)",
        {"data[0]": "data", "data[2]": "data_2", "data[3]": "9"},
    ),
    "signed bytes in a tuple": (
        "msg = OccupancyGrid(); msg.data = (-1, int(UNKNOWN[1]), int(robot.angle * 50))",
        {"data[0]": "data", "data[2]": "int(angle * 50)"},
    ),
    "a byte of an image": (
        "msg = Image(data=bytes(12)); msg.data[3] = 255",
        {"data[3]": "data"},
    ),
    "bytes of an image, long": (
        "msg = Image(data=[0] * 5000); msg.data[3] = 255; msg.height = 5; msg.data.append(7)",
        {"height": "height"},
    ),
    "times and durations": (
        "msg = PoseStamped(); msg.header.stamp = Time(sec=5, nanosec=int(UNKNOWN[0]))",
        {"header.stamp.sec": "sec"},
    ),
}  # fmt: skip


LIMITS: dict[str, tuple[str, str, str]] = {
    "more than 4096 numbers": (
        "msg = JointState(position=[robot.angle] * 5000)", "position[0]",
        "long sequences are data, to look at each element takes longer than to send it",
    ),
    "a truth value handed on": (
        "def put(flag): msg.data = flag\nmsg = Bool()\nput(True)", "data",
        "True has no place for where it came from, only the place of an assignment tells",
    ),
    "a truth value from a dictionary": (
        "options = {'on': True}; msg = Bool(data=options['on'])", "data",
        "True has no place for where it came from, only the place of an assignment tells",
    ),
    "a comparison": (
        "msg = Bool(data=robot.angle > 0.25)", "data",
        "a comparison gives a plain True, and no threshold is solved for",
    ),
    "a sequence of truth values": (
        "msg = ParameterValue(bool_array_value=[True, False])", "bool_array_value[0]",
        "its elements are plain True and False",
    ),
    "a sequence of octets": (
        "msg = ByteMultiArray(data=[b'a', b'b'])", "data[0]",
        "bytes objects are not tracked",
    ),
    "an untracked float left of a computed integer": (
        "n = Joy(buttons=[3]).buttons[0]; msg = Point(x=UNKNOWN[1] * n)", "x",
        "float multiplies by any subclass of int itself, our operator is not asked",
    ),
    "packed and unpacked": (
        "import struct; msg = Point(x=struct.unpack('d', struct.pack('d', robot.angle))[0])", "x",
        "bytes carry no provenance",
    ),
    "pickled": (
        "import pickle; msg = Point(x=pickle.loads(pickle.dumps(robot.angle)))", "x",
        "a pickle must load where we are not",
    ),
}  # fmt: skip
"""Where provenance ends by what is documented: a program, the field that has none, and why."""

GAP = partial(pytest.mark.xfail, strict=True, raises=AssertionError)


@pytest.fixture(params=[False, True], ids=["unchecked", "checked"], autouse=True)
def checked(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[bool]:
    """With and without ROS_PYTHON_CHECK_FIELDS, which message modules read when imported."""
    exec(textwrap.dedent(PROLOGUE), {})
    import sys

    for name, module in list(sys.modules.items()):
        if sequences._is_generated(name) or name.startswith("builtin_interfaces.msg._"):
            value = "1" if request.param else ""
            monkeypatch.setattr(module, "ros_python_check_fields", value, raising=False)
    calls.publish()
    array_calls.install()
    sequences.install()
    yield request.param
    sequences.uninstall()
    array_calls.uninstall()


Load = Callable[[str], Instrumented]


@pytest.fixture
def load(tmp_path: Path) -> Iterator[Load]:
    from contextlib import ExitStack

    with ExitStack() as stack:
        yield lambda body: stack.enter_context(
            loaded(textwrap.dedent(PROLOGUE) + body.replace("\\n", "\n") + "\n", tmp_path)
        )


def plain_result(body: str) -> Any:
    """The message that the program makes without us."""
    sequences.uninstall()
    names: dict[str, Any] = {"__name__": "plain"}
    exec(textwrap.dedent(PROLOGUE) + body.replace("\\n", "\n"), names)
    sequences.install()
    return names["msg"]


def on_the_wire(message: Any) -> Any:
    return deserialize_message(serialize_message(message), type(message))


def expressions(message: Any) -> dict[str, str]:
    found = {path: provenance(value) for path, value in tracked_fields(message).items()}
    return {path: known.expression for path, known in found.items() if known is not None}


@pytest.mark.parametrize(("body", "expected"), PATHS.values(), ids=PATHS)
def test_provenance_arrives(load: Load, body: str, expected: dict[str, str]) -> None:
    message = load(body).names.msg
    plain = plain_result(body)
    assert message == plain and repr(message) == repr(plain)
    assert on_the_wire(message) == on_the_wire(plain)
    assert expressions(message) == expected


@pytest.mark.parametrize(("body", "expected"), PATHS.values(), ids=PATHS)
def test_a_received_message_has_it_and_passes_it_on(
    load: Load, body: str, expected: dict[str, str]
) -> None:
    message = load(body).names.msg
    for _ in range(2):
        found = [(path, getattr(v, "_core", v)) for path, v in tracked_fields(message).items()]
        payload, _ = Encoder(lambda _: None).encode(0, 0, found)
        received = deserialize_message(serialize_message(message), type(message))
        if payload:
            attach(received, header.decode(payload))
        assert tracked_fields(received).keys() == expected.keys()
        message = received


@pytest.mark.parametrize(("body", "expected"), PATHS.values(), ids=PATHS)
def test_fields_follow_a_change(load: Load, body: str, expected: dict[str, str]) -> None:
    program = load(body)
    message = program.names.msg
    program.change("Robot.init.angle", 1.25)
    for field in collect(message):
        new = refresh.refreshed(field.value)
        if new is not field.value:
            field.put(new)
    after = expressions(message)
    assert after == expected
    for path, expression in expected.items():
        if expression == "angle":
            assert tracked_fields(message)[path] == 1.25
            assert eval(f"message.{path}") == 1.25


@pytest.mark.parametrize(
    ("body", "path"),
    [
        pytest.param(body, path, id=name, marks=GAP(reason=reason))
        for name, (body, path, reason) in LIMITS.items()
    ],
)
def test_where_provenance_ends(load: Load, body: str, path: str) -> None:
    assert path in expressions(load(body).names.msg)


@pytest.mark.parametrize("body", [body for body, _, _ in LIMITS.values()], ids=LIMITS)
def test_nothing_else_ends_there(load: Load, body: str) -> None:
    message, plain = load(body).names.msg, plain_result(body)
    assert message == plain and repr(message) == repr(plain)


def test_texts_in_a_tuple_follow(load: Load) -> None:
    program = load("msg = JointState(name=('a', 'b'))")
    program.change("name", "c")
    message = program.names.msg
    for field in collect(message):
        field.put(refresh.refreshed(field.value))
    assert message.name == ("c", "b") and type(message.name) is tuple


def test_the_programs_own_array_stays_its_own(load: Load, checked: bool) -> None:
    body = (
        "a = array.array('d', UNKNOWN); msg = JointState(); msg.position = a; a.append(4.5);"
        " same = msg.position is a"
    )
    program = load(body)
    assert program.names.same is checked
    assert program.names.msg == plain_result(body)


def test_types_imported_later_are_woven(load: Load) -> None:
    import sys

    for name in [name for name in sys.modules if name.startswith("stereo_msgs")]:
        del sys.modules[name]
    program = load("from stereo_msgs.msg import DisparityImage; msg = DisparityImage(f=0.5)")
    assert type(program.names.DisparityImage) is type(program.names.msg).__class__
    assert program.names.DisparityImage in sequences._plain
