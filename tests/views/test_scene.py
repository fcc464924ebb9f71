"""What is shown: RViz's rules for markers."""

import threading
from dataclasses import dataclass, field
from typing import Any

import pytest

pytest.importorskip("visualization_msgs")

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, Pose
from visualization_msgs.msg import Marker, MarkerArray

from rosslt_auto.views.scene import Scene
from rosslt_auto.views.shapes import MARKER, MARKER_ARRAY


@dataclass
class Message:
    message: Any
    fields: dict[str, Any] = field(default_factory=dict)


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def scene(clock: Clock) -> Scene:
    return Scene(clock)


def add(scene: Scene, number: int = 0, ns: str = "a", topic: str = "/t", **values: Any) -> None:
    scene.receive(topic, MARKER, Message(Marker(ns=ns, id=number, type=Marker.CUBE, **values)))


def keys(scene: Scene) -> list[str]:
    return [item.key for item in scene.items()]


def test_namespace_and_id_tell_markers_apart(scene: Scene) -> None:
    add(scene, 0)
    add(scene, 1)
    add(scene, 0, ns="b")
    add(scene, 0, topic="/u")
    assert keys(scene) == ["/t/a/0", "/t/a/1", "/t/b/0", "/u/a/0"]


def test_add_replaces(scene: Scene) -> None:
    add(scene, pose=Pose(position=Point(x=1.0)))
    [before] = scene.items()
    add(scene, pose=Pose(position=Point(x=2.0)))
    [item] = scene.items()
    assert item.picture.shapes[0].frame.position == (2.0, 0.0, 0.0)
    assert item.revision > before.revision


def test_delete_removes_one(scene: Scene) -> None:
    add(scene, 0)
    add(scene, 1)
    add(scene, 0, action=Marker.DELETE)
    assert keys(scene) == ["/t/a/1"]
    add(scene, 7, action=Marker.DELETE)  # not there: nothing to do
    assert keys(scene) == ["/t/a/1"]


def test_delete_all_removes_those_of_the_topic(scene: Scene) -> None:
    add(scene, 0)
    add(scene, 1, ns="b")
    add(scene, 0, topic="/u")
    add(scene, 9, ns="", action=Marker.DELETEALL)
    assert keys(scene) == ["/u/a/0"]


def test_delete_all_with_a_namespace_removes_those_of_the_namespace(scene: Scene) -> None:
    add(scene, 0)
    add(scene, 1, ns="b")
    add(scene, 0, topic="/u")
    add(scene, 9, action=Marker.DELETEALL)
    assert keys(scene) == ["/t/b/1", "/u/a/0"]


def test_lifetime_ends(scene: Scene, clock: Clock) -> None:
    add(scene, 0, lifetime=Duration(sec=1, nanosec=500_000_000))
    add(scene, 1)
    clock.now += 1.4
    assert keys(scene) == ["/t/a/0", "/t/a/1"]
    clock.now += 0.2
    assert scene.get("/t/a/0") is None
    assert keys(scene) == ["/t/a/1"]


def test_add_renews_the_lifetime(scene: Scene, clock: Clock) -> None:
    add(scene, lifetime=Duration(sec=1))
    clock.now += 0.9
    add(scene, lifetime=Duration(sec=1))
    clock.now += 0.9
    assert keys(scene) == ["/t/a/0"]
    add(scene)
    clock.now += 1000.0
    assert keys(scene) == ["/t/a/0"]


def test_an_array_is_markers_one_after_another(scene: Scene) -> None:
    markers = [
        Marker(ns="old", id=0),
        Marker(action=Marker.DELETEALL),
        Marker(ns="a", id=0),
        Marker(ns="a", id=1),
    ]
    scene.receive("/t", MARKER_ARRAY, Message(MarkerArray(markers=markers)))
    assert [(item.key, item.root) for item in scene.items()] == [
        ("/t/a/0", "markers[2]"),
        ("/t/a/1", "markers[3]"),
    ]
    assert scene.items()[1].picture.spots[0].path == "markers[3].pose.position"


def test_what_cannot_be_shown_is_named_and_comes_back(scene: Scene) -> None:
    add(scene)
    scene.receive("/t", MARKER, Message(Marker(ns="a", id=1, type=77)))
    assert keys(scene) == ["/t/a/0"]
    assert scene.problems == {"/t/a/1": "unknown marker type 77"}
    add(scene, 1)
    assert keys(scene) == ["/t/a/0", "/t/a/1"]
    assert scene.problems == {}


def test_an_unknown_action_changes_nothing(scene: Scene) -> None:
    add(scene)
    add(scene, action=9)
    assert keys(scene) == ["/t/a/0"]
    assert scene.problems == {"/t/a/0": "unknown marker action 9"}


def test_other_messages_replace_the_one_before(scene: Scene) -> None:
    for x in (1.0, 2.0):
        message = Message(Pose(position=Point(x=x)))
        scene.receive("/p", "geometry_msgs/msg/Pose", message)
    [item] = scene.items()
    assert item.key == "/p"
    assert item.picture.shapes[0].frame.position == (2.0, 0.0, 0.0)


def test_a_topic_can_be_forgotten(scene: Scene) -> None:
    add(scene)
    add(scene, topic="/u")
    scene.forget("/t")
    assert keys(scene) == ["/u/a/0"]


def test_waiting_ends_with_a_message(scene: Scene) -> None:
    threading.Timer(0.05, add, [scene]).start()
    scene.wait(30.0)
    assert keys(scene) == ["/t/a/0"]
