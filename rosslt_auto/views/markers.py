"""Drag handles as interactive markers, for RViz."""

from __future__ import annotations

import math
import threading
import time
from typing import Any

from geometry_msgs.msg import Point, Pose
from geometry_msgs.msg import Quaternion as QuaternionMessage
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerControl,
    InteractiveMarkerFeedback,
    Marker,
)

from .dragging import Dragger
from .geometry import UNTURNED, Quaternion, about, product, unit
from .handles import Grip, Handle, Targets
from .marker_server import server_for
from .session import Session

DEFAULT_NAMESPACE = "/rosslt"

PATIENCE = 3.0
"""Seconds that a released marker waits where it was left until the messages have come there."""

_PERIOD = 0.05
_NEAR = 1e-2
_POINT_SCALE = 0.3

# An axis control moves along its own x axis.
_ALONG: dict[str, Quaternion] = {
    "x": UNTURNED,
    "y": about(2, math.pi / 2),
    "z": about(1, -math.pi / 2),
}


class HandleMarkers:
    """Shows the handles of a session as interactive markers, and follows their feedback."""

    def __init__(self, session: Session, node: Any, namespace: str = DEFAULT_NAMESPACE) -> None:
        self._session = session
        self._handles: dict[str, Handle] = {}
        self._draggers: dict[str, Dragger] = {}
        self._grips: dict[str, Grip] = {}
        self._waiting: dict[str, float] = {}
        self._poses: dict[str, tuple[Any, Any]] = {}
        self._lock = threading.RLock()
        self._server = server_for(node, namespace, self._on_feedback)

    def close(self) -> None:
        """Removes the markers."""
        self._server.close()

    def run(self, until: threading.Event) -> None:
        """Follows the scene until the event is set."""
        while not until.is_set():
            self.update()
            until.wait(_PERIOD)

    def update(self) -> None:
        """Shows the handles as they are now."""
        session = self._session
        found = {
            handle.key: (handle, item)
            for item in session.scene.items()
            for handle in session.handles.of(item)
        }
        with self._lock:
            for key, (handle, item) in found.items():
                known = self._handles.get(key)
                if key in self._draggers:
                    continue
                self._handles[key] = handle
                if known is None or (known.moves, known.turns) != (handle.moves, handle.turns):
                    self._server.insert(_marker(handle, item.frame_id or "map"))
                    self._poses[key] = (handle.position, handle.rotation)
                elif self._may_move(handle) and not _same(self._poses[key], handle):
                    self._server.move(key, _pose(handle.position, handle.rotation))
                    self._poses[key] = (handle.position, handle.rotation)
            for key in self._handles.keys() - found.keys() - self._draggers.keys():
                self._server.erase(key)
                del self._handles[key], self._poses[key]
                self._waiting.pop(key, None)
            self._server.apply()

    def _may_move(self, handle: Handle) -> bool:
        """Whether it has not just been released, or the messages have come where it was left."""
        until = self._waiting.get(handle.key)
        if until is None:
            return True
        position, rotation = self._poses[handle.key]
        there = math.dist(position, handle.position) < _NEAR and (
            abs(sum(a * b for a, b in zip(rotation, handle.rotation, strict=True))) > 1 - 1e-4
        )
        if there or time.monotonic() > until:
            del self._waiting[handle.key]
            return True
        return False

    def _on_feedback(self, feedback: InteractiveMarkerFeedback) -> None:
        key = feedback.marker_name
        with self._lock:
            handle = self._handles.get(key)
            if handle is None:
                return
            if feedback.event_type == InteractiveMarkerFeedback.POSE_UPDATE:
                self._drag(handle, feedback)
            elif feedback.event_type == InteractiveMarkerFeedback.MOUSE_UP:
                self._release(handle)

    def _drag(self, handle: Handle, feedback: InteractiveMarkerFeedback) -> None:
        dragger = self._draggers.get(handle.key)
        if dragger is None:
            dragger = self._session.grab(handle)
            if dragger is None:  # somebody else holds it: it stays where it is
                self._echo(handle.key, _pose(*self._poses[handle.key]))
                return
            self._draggers[handle.key] = dragger
            self._grips[handle.key] = Grip(handle, self._poses[handle.key][0])
        position, rotation = _position(feedback.pose), _rotation(feedback.pose)
        before = self._poses[handle.key]
        item = self._session.scene.get(handle.item)
        targets: Targets = {}
        if handle.moves and math.dist(before[0], position) > 0:
            targets |= self._grips[handle.key].moved(position)
        if handle.turns and item is not None and before[1] != rotation:
            targets |= handle.turned(rotation, item.tracked.fields)
        self._poses[handle.key] = (position, rotation)
        if targets:
            dragger.to(targets)
        self._echo(handle.key, feedback.pose)  # to the other clients

    def _release(self, handle: Handle) -> None:
        if handle.key not in self._draggers:
            return
        self._waiting[handle.key] = time.monotonic() + PATIENCE
        self._echo(handle.key, _pose(*self._poses[handle.key]))

        def let_go() -> None:
            self._session.let_go(handle)
            with self._lock:
                self._draggers.pop(handle.key, None)

        threading.Thread(target=let_go, name="release", daemon=True).start()

    def _echo(self, key: str, pose: Pose) -> None:
        self._server.move(key, pose)
        self._server.apply()


def _marker(handle: Handle, frame_id: str) -> InteractiveMarker:
    marker = InteractiveMarker(name=handle.key, description=handle.key)
    marker.header.frame_id = frame_id
    marker.pose = _pose(handle.position, handle.rotation)
    marker.scale = _POINT_SCALE if handle.spot.is_point else 1.0
    if handle.spot.is_point and handle.moves == "xyz":
        marker.controls = [_ball()]
        return marker
    controls = []
    for axis in handle.moves:
        # Along the axes of the fields, however the thing itself is turned.
        along = product(handle.spot.frame.rotation, _ALONG[axis])
        controls.append(
            InteractiveMarkerControl(
                name=f"move {axis}",
                orientation=_quaternion(along),
                orientation_mode=InteractiveMarkerControl.FIXED,
                interaction_mode=InteractiveMarkerControl.MOVE_AXIS,
            )
        )
    for axis in handle.turns:
        controls.append(
            InteractiveMarkerControl(
                name=f"turn {axis}",
                orientation=_quaternion(_ALONG[axis]),
                orientation_mode=InteractiveMarkerControl.INHERIT,
                interaction_mode=InteractiveMarkerControl.ROTATE_AXIS,
            )
        )
    marker.controls = controls
    return marker


def _ball() -> InteractiveMarkerControl:
    ball = Marker(type=Marker.SPHERE, color=ColorRGBA(r=1.0, g=0.55, b=0.1, a=0.9))
    ball.scale.x = ball.scale.y = ball.scale.z = 0.4 * _POINT_SCALE
    return InteractiveMarkerControl(
        name="move",
        interaction_mode=InteractiveMarkerControl.MOVE_3D,
        always_visible=True,
        markers=[ball],
    )


def _same(pose: tuple[Any, Any], handle: Handle) -> bool:
    return pose == (handle.position, handle.rotation)


def _pose(position: Any, rotation: Quaternion) -> Pose:
    x, y, z = position
    return Pose(position=Point(x=x, y=y, z=z), orientation=_quaternion(rotation))


def _quaternion(rotation: Quaternion) -> QuaternionMessage:
    w, x, y, z = rotation
    return QuaternionMessage(w=w, x=x, y=y, z=z)


def _position(pose: Pose) -> Any:
    return (pose.position.x, pose.position.y, pose.position.z)


def _rotation(pose: Pose) -> Quaternion:
    q = pose.orientation
    return unit((q.w, q.x, q.y, q.z))
