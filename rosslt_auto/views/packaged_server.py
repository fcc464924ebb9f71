"""The server of the package interactive_markers behind the interface of `marker_server`.

Importing this raises ImportError where the package is not installed: it comes with a sourced ROS 2.
Around the package's server stands one lock, because it numbers and sends an update after its own
lock has been released, and drags come in one thread, messages in another: numbers would be sent
twice or in the wrong order. That it refuses feedback in a marker's first second stays so.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from interactive_markers import InteractiveMarkerServer
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

_DEPTH = 100


class _InOrder(InteractiveMarkerServer):
    """Sends updates in the order of their numbers; an answer has the number of what is in it."""

    def __init__(self, *args: Any, **options: Any) -> None:
        self.order = threading.RLock()  # requests may come before the base has been made
        super().__init__(*args, **options)

    def applyChanges(self) -> None:
        with self.order:
            super().applyChanges()

    def getInteractiveMarkersCallback(self, request: Any, response: Any) -> Any:
        with self.order:
            return super().getInteractiveMarkersCallback(request, response)


class PackagedServer:
    """See `marker_server.MarkerServer`, whose methods these are."""

    def __init__(
        self,
        node: Any,
        namespace: str,
        feedback: Callable[[InteractiveMarkerFeedback], None],
    ) -> None:
        self._feedback = feedback
        self._erased: set[str] = set()
        quality = QoSProfile(depth=_DEPTH)
        self._server = _InOrder(
            node, namespace, update_pub_qos=quality, feedback_sub_qos=quality
        )  # a depth of 1, its default for feedback, loses the last pose before a release

    def close(self) -> None:
        """Erases all markers and ends."""
        self._server.clear()
        self._server.applyChanges()
        self._server.update_pub.wait_for_all_acked(Duration(seconds=1))
        self._server.shutdown()

    def insert(self, marker: InteractiveMarker) -> None:
        """Adds a marker, or replaces the one of that name."""
        with self._server.order:
            self._erased.discard(marker.name)
            self._server.insert(marker, feedback_callback=self._feedback)

    def move(self, name: str, pose: Any) -> None:
        """Gives a marker another pose; nothing if there is no such marker."""
        with self._server.order:
            if name in self._erased or self._server.get(name) is None:
                return
            if not self._server.setPose(name, pose):  # it has not been sent yet
                self._server.get(name).pose = pose

    def erase(self, name: str) -> None:
        """Removes a marker; nothing if there is no such marker."""
        with self._server.order:
            self._erased.add(name)

    def apply(self) -> None:
        """Sends what has been changed since the last time, if anything."""
        with self._server.order:
            erased, self._erased = self._erased, set()
            # Once more where feedback in between has made a move of the erasure.
            while any([self._server.erase(name) for name in erased]):
                self._server.applyChanges()
            self._server.applyChanges()
