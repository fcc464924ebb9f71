"""Drags of what is in arrays, whose order may change under the hand."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("visualization_msgs")

from geometry_msgs.msg import Point, Pose
from visualization_msgs.msg import Marker, MarkerArray

from rosslt_auto.views import markers
from rosslt_auto.views.handles import Handle
from rosslt_auto.views.markers import HandleMarkers
from rosslt_auto.views.session import Session
from rosslt_auto.views.shapes import MARKER_ARRAY
from support.tracked import tracked


@dataclass
class Message:
    message: Any
    fields: dict[str, Any] = field(default_factory=dict)


class Parameters:
    """Of all nodes: what has been set."""

    def __init__(self) -> None:
        self.set_to: dict[str, Any] = {}

    def set(self, changes: Any, timeout: float) -> None:
        self.set_to |= {one.parameter: one.new for one in changes}


def array(*numbers: int) -> Message:
    """Markers with these ids, the x of each from a literal called after it."""
    message = Message(MarkerArray())
    for i, number in enumerate(numbers):
        pose = Pose(position=Point(x=float(number)))
        message.message.markers.append(Marker(ns="m", id=number, type=Marker.CUBE, pose=pose))
        message.fields[f"markers[{i}].pose.position.x"] = tracked(float(number), f"x{number}")
    return message


def handle_of(session: Session, number: int) -> Handle:
    item = session.scene.get(f"/t/m/{number}")
    assert item is not None
    [handle] = session.handles.of(item)
    return handle


def test_a_marker_keeps_its_handle_where_the_order_changes() -> None:
    session = Session(SimpleNamespace())  # type: ignore[arg-type]
    session.scene.receive("/t", MARKER_ARRAY, array(1, 2))
    before = handle_of(session, 2)
    session.scene.receive("/t", MARKER_ARRAY, array(2, 1))
    after = handle_of(session, 2)
    assert before.key == after.key == "/t/m/2:pose.position"
    assert (before.spot.path, after.spot.path) == (
        "markers[1].pose.position",
        "markers[0].pose.position",
    )


def test_a_drag_stays_with_its_marker_where_the_order_changes() -> None:
    parameters = Parameters()
    session = Session(SimpleNamespace(parameters=parameters))  # type: ignore[arg-type]
    session.scene.receive("/t", MARKER_ARRAY, array(1, 2))
    handle = handle_of(session, 2)
    dragger = session.grab(handle)
    assert dragger is not None
    session.scene.receive("/t", MARKER_ARRAY, array(2, 1))  # before anything has been dragged
    dragger.to(handle.moved((5.0, 0.0, 0.0)))
    session.let_go(handle)
    assert parameters.set_to == {"x2": 5.0}


class Server:
    """An interactive marker server that keeps what it is given."""

    def __init__(self, *given: Any) -> None:
        self.markers: dict[str, Any] = {}

    def insert(self, marker: Any) -> None:
        self.markers[marker.name] = marker

    def apply(self) -> None:
        pass


def test_each_handle_is_in_the_frame_of_its_marker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(markers, "server_for", Server)
    session = Session(SimpleNamespace())  # type: ignore[arg-type]
    message = array(1, 2, 3)
    for marker, frame_id in zip(message.message.markers, ("map", "", "arm"), strict=True):
        marker.header.frame_id = frame_id
    session.scene.receive("/t", MARKER_ARRAY, message)
    shown = HandleMarkers(session, None)
    shown.update()
    frames = [marker.header.frame_id for marker in shown._server.markers.values()]  # type: ignore[attr-defined]
    assert frames == ["map", "map", "arm"]
