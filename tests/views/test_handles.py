"""What can be dragged: the axes whose fields can be changed where they come from."""

import math
from dataclasses import dataclass, field
from typing import Any

import pytest

pytest.importorskip("visualization_msgs")

from geometry_msgs.msg import Point, Pose
from visualization_msgs.msg import Marker

from rosslt_auto.provenance.values import untracked
from rosslt_auto.views.dragging import Choice, solve
from rosslt_auto.views.geometry import about
from rosslt_auto.views.handles import Grip, Handle, Handles
from rosslt_auto.views.scene import Scene
from rosslt_auto.views.shapes import MARKER
from support.tracked import apply, tracked


@dataclass
class Message:
    message: Any
    fields: dict[str, Any] = field(default_factory=dict)


def pose_handles(**fields: Any) -> list[Handle]:
    """Of a Pose with these tracked fields; `position__x` stands for position.x."""
    return handles_of(pose_message(**fields), "geometry_msgs/msg/Pose")


def pose_message(**fields: Any) -> Message:
    message = Message(Pose())
    for name, value in fields.items():
        part, _, axis = name.partition("__")
        setattr(getattr(message.message, part), axis, untracked(value))
        message.fields[f"{part}.{axis}"] = value
    return message


def handles_of(message: Message, type_name: str) -> list[Handle]:
    scene = Scene()
    scene.receive("/t", type_name, message)
    return [handle for item in scene.items() for handle in Handles().of(item)]


def yawed(yaw: float) -> dict[str, Any]:
    leaf = tracked(yaw, "yaw")
    return {
        "orientation__z": apply("sin", leaf / 2),
        "orientation__w": apply("cos", leaf / 2),
    }


def test_nothing_tracked_no_handles() -> None:
    assert pose_handles() == []


def test_only_tracked_axes_can_move() -> None:
    [handle] = pose_handles(position__x=tracked(1.0), position__z=2 * tracked(1.5, "z"))
    assert (handle.moves, handle.turns) == ("xz", "")
    assert handle.paths() == ["position.x", "position.z"]
    assert handle.position == (1.0, 0.0, 3.0)


def test_what_cannot_be_inverted_cannot_be_dragged() -> None:
    x = tracked(1.0)
    [handle] = pose_handles(position__x=x, position__y=0.0 * x, position__z=x - x)
    assert handle.moves == "x"


def test_a_moved_handle_gives_targets_of_its_axes_only() -> None:
    [handle] = pose_handles(position__x=tracked(1.0), position__y=tracked(1.0, "y"))
    assert handle.moved((5.0, 6.0, 7.0)) == {"position.x": 5.0, "position.y": 6.0}


def test_a_grip_has_targets_of_the_axes_that_were_dragged() -> None:
    fields = {f"position__{axis}": tracked(1.0, axis) for axis in "xyz"}
    [handle] = pose_handles(**fields)
    grip = Grip(handle, (1.0, 1.0, 1.2))  # z had been moving
    assert grip.moved((1.0, 1.0, 1.2)) == {}
    assert grip.moved((2.0, 1.0, 1.2)) == {"position.x": 2.0}
    assert grip.moved((1.0, 1.0, 1.2)) == {"position.x": 1.0}  # back again
    assert grip.moved((1.0, 3.0, 1.2)) == {"position.x": 1.0, "position.y": 3.0}


@pytest.mark.parametrize("yaw", [0.0, 0.8, -0.8, 3.0, -3.0])
@pytest.mark.parametrize("by", [0.1, -0.1])
def test_a_yaw_can_be_turned_about_z_only(yaw: float, by: float) -> None:
    message = pose_message(**yawed(yaw))
    [handle] = handles_of(message, "geometry_msgs/msg/Pose")
    assert (handle.moves, handle.turns) == ("", "z")
    targets = handle.turned(about(2, yaw + by), message.fields)
    [change] = solve(message, targets, Choice())
    assert (change.source.parameter, change.new) == ("yaw", pytest.approx(yaw + by))


def test_points_can_be_dragged_in_the_frame_of_their_marker() -> None:
    marker = Marker(type=Marker.LINE_STRIP, points=[Point(), Point(x=2.0)])
    marker.pose.position.y = 1.0
    marker.pose.orientation.z = marker.pose.orientation.w = math.sqrt(0.5)
    message = Message(marker, {"points[1].x": tracked(2.0)})
    [handle] = handles_of(message, MARKER)
    assert (handle.key, handle.moves) == ("/t//0:points[1]", "x")
    assert handle.position == pytest.approx((0.0, 3.0, 0.0))
    assert handle.moved((0.0, 5.0, 0.0)) == {"points[1].x": pytest.approx(4.0)}


def test_sources_that_cannot_be_changed_give_no_handle() -> None:
    scene = Scene()
    scene.receive("/t", "geometry_msgs/msg/Pose", pose_message(position__x=tracked(1.0)))
    [item] = scene.items()
    assert Handles(lambda source: False).of(item) == []
    assert Handles(lambda source: True).of(item) != []


def test_many_points_get_a_limited_number_of_handles() -> None:
    count = Handles.MAX_POINTS + 50
    marker = Marker(type=Marker.POINTS, points=[Point() for _ in range(count)])
    fields = {f"points[{i}].x": tracked(0.0, f"x{i}") for i in range(count)}
    assert len(handles_of(Message(marker, fields), MARKER)) == Handles.MAX_POINTS
