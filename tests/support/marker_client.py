"""A client of the interactive marker protocol that takes it at its word, as RViz does."""

import threading
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from visualization_msgs.msg import (
    InteractiveMarkerFeedback,
    InteractiveMarkerUpdate,
)
from visualization_msgs.srv import GetInteractiveMarkers

from support.observer import Observer
from support.waiting import wait_until


class StrictClient:
    """Follows a server. Whatever breaks the protocol stands in `mistakes`.

    markers  by name, as the server has said
    """

    def __init__(self, observer: Observer, namespace: str, name: str = "client") -> None:
        self._observer = observer
        self._node = observer.node
        self._lock = threading.RLock()
        self._early: list[InteractiveMarkerUpdate] | None = []
        self._last: int | None = None
        self.name = name
        self.markers: dict[str, Any] = {}
        self.mistakes: list[str] = []
        self.updates: list[InteractiveMarkerUpdate] = []
        quality = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
        self._node.create_subscription(
            InteractiveMarkerUpdate, f"{namespace}/update", self._on_update, quality
        )
        self._feedback = self._node.create_publisher(
            InteractiveMarkerFeedback, f"{namespace}/feedback", QoSProfile(depth=1)
        )
        self._client = self._node.create_client(
            GetInteractiveMarkers, f"{namespace}/get_interactive_markers"
        )

    def connect(self) -> None:
        """Gets all markers, and the updates from there on."""
        wait_until(self._client.service_is_ready, "the server is there")
        wait_until(self._feedback.get_subscription_count, "the server listens")
        future = self._client.call_async(GetInteractiveMarkers.Request())
        answer = self._observer.result(future, "all markers")
        with self._lock:
            self.markers = {marker.name: marker for marker in answer.markers}
            early, self._early = self._early or [], None
            for update in early:
                if update.seq_num > answer.sequence_number:
                    self._apply(update)

    def _on_update(self, update: InteractiveMarkerUpdate) -> None:
        with self._lock:
            if update.type != InteractiveMarkerUpdate.UPDATE:
                self.mistakes.append(f"update of type {update.type}")
            if self._last is not None and update.seq_num != self._last + 1:
                self.mistakes.append(f"{update.seq_num} after {self._last}")
            self._last = update.seq_num
            self.updates.append(update)
            if self._early is not None:
                self._early.append(update)
            else:
                self._apply(update)

    def _apply(self, update: InteractiveMarkerUpdate) -> None:
        for name in update.erases:
            if self.markers.pop(name, None) is None:
                self.mistakes.append(f"{name} is erased and was not there")
        for marker in update.markers:
            self.markers[marker.name] = marker
        for pose in update.poses:
            if pose.name in self.markers:
                self.markers[pose.name].pose = pose.pose
            else:
                self.mistakes.append(f"a pose for {pose.name}, which is not there")

    def feedback(self, marker: str, event: int, pose: Any, control: str = "move x") -> None:
        """Says that something has been done to a marker."""
        self._feedback.publish(
            InteractiveMarkerFeedback(
                client_id=self.name,
                marker_name=marker,
                control_name=control,
                event_type=event,
                pose=pose,
            )
        )

    def position(self, marker: str) -> tuple[float, float, float] | None:
        """Where a marker is, as far as the server has said; None if it is not there."""
        with self._lock:
            found = self.markers.get(marker)
            if found is None:
                return None
            at = found.pose.position
            return (at.x, at.y, at.z)
