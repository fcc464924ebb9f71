"""Where frames stand, from transforms as they come on /tf."""

import math
import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from geometry_msgs.msg import Point, PoseStamped, TransformStamped
from rclpy.qos import DurabilityPolicy
from visualization_msgs.msg import Marker

from rosslt_auto.views.frames import Frames
from rosslt_auto.views.geometry import ORIGIN, UNTURNED, Frame, about
from rosslt_auto.views.handles import Handle
from rosslt_auto.views.scene import Scene


class TFMessage:
    """What tf2_msgs/msg/TFMessage is; its package is not among the wheels."""

    def __init__(self, *transforms: TransformStamped) -> None:
        self.transforms = transforms


def transform(
    parent: str, child: str, at: tuple[float, float, float] = ORIGIN, yaw: float = 0.0
) -> TransformStamped:
    stamped = TransformStamped(child_frame_id=child)
    stamped.header.frame_id = parent
    translation, rotation = stamped.transform.translation, stamped.transform.rotation
    translation.x, translation.y, translation.z = at
    rotation.w, rotation.x, rotation.y, rotation.z = about(2, yaw)
    return stamped


def frames(*transforms: TransformStamped) -> Frames:
    found = Frames()
    found.receive(TFMessage(*transforms))
    return found


def test_without_transforms_all_frames_are_one() -> None:
    assert frames().place("map") == frames().place("") == Frame()


def test_a_chain_of_frames_is_followed_to_its_top() -> None:
    known = frames(
        transform("odom", "base", (1.0, 0.0, 0.0), math.pi / 2),
        transform("base", "arm", (2.0, 0.0, 0.0)),
    )
    assert known.place("odom") == Frame()
    assert known.place("arm").position == pytest.approx((1.0, 2.0, 0.0))
    assert known.place("arm").rotation == pytest.approx(about(2, math.pi / 2))
    known.receive(TFMessage(transform("map", "odom", (0.0, 0.0, 5.0))))
    assert known.place("arm").position == pytest.approx((1.0, 2.0, 5.0))


def test_the_last_transform_counts_and_a_leading_slash_does_not() -> None:
    known = frames(transform("/map", "/base", (1.0, 0.0, 0.0)))
    known.receive(TFMessage(transform("map", "base", (3.0, 0.0, 0.0))))
    assert known.place("base").position == known.place("/base").position == (3.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "bad",
    [
        [transform("a", "b", (1.0, 0.0, 0.0)), transform("b", "a", (1.0, 0.0, 0.0))],
        [transform("b", "b", (1.0, 0.0, 0.0))],
        [transform("a", "b", (math.nan, 0.0, 0.0))],
        [transform("a", "", (1.0, 0.0, 0.0))],
    ],
    ids=["a circle", "itself", "not finite", "no name"],
)
def test_what_is_no_tree_of_frames_is_ignored(bad: list[TransformStamped]) -> None:
    assert frames(*bad).place("b") == frames(*bad).place("") == Frame()


def test_a_rotation_without_direction_turns_nothing() -> None:
    stamped = transform("map", "base", (1.0, 0.0, 0.0))
    stamped.transform.rotation.w = 0.0
    assert frames(stamped).place("base") == Frame((1.0, 0.0, 0.0), UNTURNED)


class Tracked:
    """A message without provenance."""

    def __init__(self, message: Any) -> None:
        self.message = message
        self.fields: dict[str, Any] = {}


def test_things_stand_where_their_frames_are_and_move_with_them() -> None:
    known = frames(transform("map", "base", (1.0, 0.0, 0.0), math.pi / 2))
    scene = Scene(place=known.place)
    marker = Marker(type=Marker.LINE_STRIP, points=[Point(), Point(x=1.0)])
    marker.header.frame_id = "base"
    marker.pose.position.x = 2.0
    stamped = PoseStamped()
    stamped.header.frame_id = "base"
    scene.receive("/marker", "visualization_msgs/msg/Marker", Tracked(marker))
    scene.receive("/pose", "geometry_msgs/msg/PoseStamped", Tracked(stamped))

    line, pose = scene.items()
    assert line.picture.shapes[0].frame.position == pytest.approx((1.0, 2.0, 0.0))
    assert pose.picture.shapes[0].frame.rotation == pytest.approx(about(2, math.pi / 2))
    end = line.picture.spots[-1]
    assert end.frame.out(end.position) == pytest.approx((1.0, 3.0, 0.0))

    seen = line.revision
    assert scene.items()[0].revision == seen  # nothing new
    known.receive(TFMessage(transform("map", "base", (5.0, 0.0, 0.0))))
    [line, _] = scene.items()
    assert line.revision > seen
    assert line.picture.shapes[0].frame.position == (7.0, 0.0, 0.0)


def test_a_drag_is_taken_back_into_the_frame_of_the_fields() -> None:
    known = frames(transform("map", "base", (1.0, 0.0, 0.0), math.pi / 2))
    scene = Scene(place=known.place)
    stamped = PoseStamped()
    stamped.header.frame_id = "base"
    scene.receive("/pose", "geometry_msgs/msg/PoseStamped", Tracked(stamped))
    [item] = scene.items()
    handle = Handle("key", item.key, item.topic, item.picture.spots[0], "xyz", "z")
    assert handle.position == (1.0, 0.0, 0.0)
    assert handle.rotation == pytest.approx(about(2, math.pi / 2))

    targets = handle.moved((1.0, 2.0, 0.0))
    assert targets["pose.position.x"] == pytest.approx(2.0)
    assert targets["pose.position.y"] == pytest.approx(0.0)

    parts = {f"pose.orientation.{name}": None for name in "wxyz"}
    turn = handle.turned(about(2, math.pi), parts)
    assert turn["pose.orientation.z"] == pytest.approx(math.sin(math.pi / 4))


class Node:
    """Notes what is subscribed."""

    def __init__(self) -> None:
        self.subscribed: dict[str, tuple[Any, Any, Any]] = {}

    def create_subscription(self, kind: Any, topic: str, callback: Any, quality: Any) -> None:
        self.subscribed[topic] = (kind, callback, quality)


def test_transforms_are_followed_where_their_type_is_installed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    package = ModuleType("tf2_msgs")
    package.msg = SimpleNamespace(TFMessage=TFMessage)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "tf2_msgs", package)
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", package.msg)
    known, node = Frames(), Node()
    assert known.follow(node)
    assert set(node.subscribed) == {"/tf", "/tf_static"}
    kind, receive, quality = node.subscribed["/tf_static"]
    assert kind is TFMessage
    assert quality.durability == DurabilityPolicy.TRANSIENT_LOCAL
    receive(TFMessage(transform("map", "base", (1.0, 0.0, 0.0))))
    assert known.place("base").position == (1.0, 0.0, 0.0)


def test_without_their_type_nothing_is_subscribed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tf2_msgs", None)
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", None)
    known, node = Frames(), Node()
    assert not known.follow(node)
    assert node.subscribed == {}
