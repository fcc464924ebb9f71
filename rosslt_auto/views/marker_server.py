"""The server's side of the interactive marker protocol, over visualization_msgs alone.

A client (RViz) asks `<namespace>/get_interactive_markers` for all markers and the sequence number
that this answer is good for, then follows `<namespace>/update`, whose sequence numbers rise by
exactly one; a gap makes it start anew. What people do comes on `<namespace>/feedback`. Who drags a
marker keeps it: feedback of another client is refused until a second after the last.

Where the package interactive_markers is installed, `packaged_server` puts the server in there to
work instead; `server_for` chooses.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerFeedback,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
)
from visualization_msgs.srv import GetInteractiveMarkers

EXCLUSIVE = 1.0
"""Seconds after its last feedback that a marker belongs to a client."""

_DEPTH = 100


class Markers(Protocol):
    """Interactive markers by name. Changes are collected, and sent together by `apply`."""

    def insert(self, marker: InteractiveMarker) -> None: ...

    def move(self, name: str, pose: Any) -> None: ...

    def erase(self, name: str) -> None: ...

    def apply(self) -> None: ...

    def close(self) -> None: ...


def server_for(
    node: Any, namespace: str, feedback: Callable[[InteractiveMarkerFeedback], None]
) -> Markers:
    """A server: that of the package interactive_markers if there is one, else our own."""
    try:
        from .packaged_server import PackagedServer
    except ImportError:
        return MarkerServer(node, namespace, feedback)
    return PackagedServer(node, namespace, feedback)


class MarkerServer:
    """Interactive markers by name. Changes are collected, and sent together by `apply`.

    feedback  called with each accepted feedback message, in the node's executor
    """

    def __init__(
        self,
        node: Any,
        namespace: str,
        feedback: Callable[[InteractiveMarkerFeedback], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._node = node
        self._feedback = feedback
        self._clock = clock
        self._lock = threading.RLock()
        self._markers: dict[str, InteractiveMarker] = {}
        self._inserted: dict[str, InteractiveMarker] = {}
        self._moved: set[str] = set()
        self._erased: set[str] = set()
        self._owners: dict[str, tuple[str, float]] = {}
        self.sequence = 0
        quality = QoSProfile(depth=_DEPTH)
        self._update = node.create_publisher(
            InteractiveMarkerUpdate, f"{namespace}/update", quality
        )
        self._service = node.create_service(
            GetInteractiveMarkers, f"{namespace}/get_interactive_markers", self._answer
        )
        self._subscription = node.create_subscription(
            InteractiveMarkerFeedback, f"{namespace}/feedback", self._on_feedback, quality
        )

    def close(self) -> None:
        """Erases all markers and ends."""
        with self._lock:
            for name in list(self._markers):
                self.erase(name)
            self.apply()
        self._update.wait_for_all_acked(Duration(seconds=1))  # or the last word may be lost
        self._node.destroy_subscription(self._subscription)
        self._node.destroy_service(self._service)
        self._node.destroy_publisher(self._update)

    def insert(self, marker: InteractiveMarker) -> None:
        """Adds a marker, or replaces the one of that name."""
        with self._lock:
            self._inserted[marker.name] = marker
            self._moved.discard(marker.name)
            self._erased.discard(marker.name)

    def move(self, name: str, pose: Any) -> None:
        """Gives a marker another pose; nothing if there is no such marker."""
        with self._lock:
            marker = self._inserted.get(name)
            if marker is not None:
                marker.pose = pose
            elif name in self._markers and name not in self._erased:
                self._markers[name].pose = pose
                self._moved.add(name)

    def erase(self, name: str) -> None:
        """Removes a marker; nothing if there is no such marker."""
        with self._lock:
            self._inserted.pop(name, None)
            self._moved.discard(name)
            if name in self._markers:
                self._erased.add(name)

    def apply(self) -> None:
        """Sends what has been changed since the last time, if anything."""
        with self._lock:
            if not (self._inserted or self._moved or self._erased):
                return
            update = InteractiveMarkerUpdate(type=InteractiveMarkerUpdate.UPDATE)
            for name in self._erased:
                self._markers.pop(name, None)
                self._owners.pop(name, None)
            self._markers.update(self._inserted)
            update.erases = sorted(self._erased)
            update.markers = list(self._inserted.values())
            update.poses = [self._pose(name) for name in sorted(self._moved)]
            self._inserted, self._moved, self._erased = {}, set(), set()
            self.sequence += 1
            update.seq_num = self.sequence
            self._update.publish(update)

    def _pose(self, name: str) -> InteractiveMarkerPose:
        marker = self._markers[name]
        return InteractiveMarkerPose(header=marker.header, pose=marker.pose, name=name)

    def _answer(self, request: Any, response: Any) -> Any:
        with self._lock:
            response.sequence_number = self.sequence
            response.markers = list(self._markers.values())
        return response

    def _on_feedback(self, feedback: InteractiveMarkerFeedback) -> None:
        with self._lock:
            if feedback.marker_name not in self._markers:
                return
            now = self._clock()
            owner, last = self._owners.get(feedback.marker_name, ("", -EXCLUSIVE))
            if owner != feedback.client_id and now - last < EXCLUSIVE:
                return
            self._owners[feedback.marker_name] = (feedback.client_id, now)
        self._feedback(feedback)
