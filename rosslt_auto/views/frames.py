"""Where frames stand, from /tf and /tf_static, where the types of these topics are installed.

The fixed frame is the one above all others in its tree (REP 105: map, or odom without a map). Trees
that nothing connects, and frames that no transform mentions, share one fixed frame. The last
transform counts, whatever time it is of: this shows what is now.
"""

from __future__ import annotations

import importlib
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile

from .geometry import Frame, is_finite, unit

_DEPTH = 100


class Frames:
    """The tree of frames, as far as it is known."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[str, Frame]] = {}

    def receive(self, message: Any) -> None:
        """Takes in a tf2_msgs/msg/TFMessage; transforms that are none are left out."""
        for stamped in message.transforms:
            at, turn = stamped.transform.translation, stamped.transform.rotation
            numbers = (at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z)
            parent, child = _name(stamped.header.frame_id), _name(stamped.child_frame_id)
            if child and child != parent and is_finite(*numbers):
                rotation = unit((turn.w, turn.x, turn.y, turn.z))
                self._known[child] = (parent, Frame((at.x, at.y, at.z), rotation))

    def place(self, frame_id: str) -> Frame:
        """Where a frame stands in the one above all others."""
        name = _name(frame_id)
        place, passed = Frame(), {name}
        while name in self._known:
            name, frame = self._known[name]
            if name in passed:  # transforms in a circle say nothing
                return Frame()
            passed.add(name)
            place = frame.around(place)
        return place

    def follow(self, node: Any) -> bool:
        """Subscribes a node to the transforms; False where their type is not installed."""
        try:
            message_type = importlib.import_module("tf2_msgs.msg").TFMessage
        except ImportError:
            return False
        latched = QoSProfile(depth=_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(message_type, "/tf", self.receive, QoSProfile(depth=_DEPTH))
        node.create_subscription(message_type, "/tf_static", self.receive, latched)
        return True


def _name(frame_id: Any) -> str:
    """Before tf2, frame ids began with a slash."""
    return str(frame_id).removeprefix("/")
