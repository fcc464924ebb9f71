"""Publishing: messages with tracked fields are preceded by their provenance header.

Join points: `Node.create_publisher`, and the publisher handle that rclpy makes there. The handle
is what every way of publishing goes through - `Publisher.publish`, its subclasses, lifecycle
publishers - after the message was checked, so it is replaced by a subclass with advice of its own.
"""

from __future__ import annotations

import logging
import threading
import weakref
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.type_support import check_for_type_support
from std_msgs.msg import UInt8MultiArray

from ..provenance import refresh
from ..provenance.frames import unseen_methods
from ..provenance.sources import Source
from ..provenance.values import is_tracked
from . import fields, header, serving
from .encoding import Encoder
from .handles import WovenHandles, disconnect, header_qos

_SHALLOW = 32
_LOOK_AGAIN = 32  # messages

_log = logging.getLogger(__name__)

_plain_handle: Any = _rclpy.Publisher
_publish = _plain_handle.publish
_publish_raw = _plain_handle.publish_raw
_destroy = _plain_handle.destroy_when_not_in_use


class _Handle(_plain_handle):
    """rclpy's publisher handle with our advice; without `headers` it is just that."""

    headers: HeaderPublisher | None = None

    def __init__(self, node_handle: Any, *args: Any) -> None:
        woven.make(self, node_handle, *args)

    def publish(self, message: Any) -> None:
        headers = self.headers
        if headers is None:
            _publish(self, message)
            return
        found = headers.collect(message)
        if found and headers.publish(self, message, found):
            return
        with headers.lock:
            _publish(self, message)
            headers.sequence += 1
        if found:
            headers.plain_worked()

    def publish_raw(self, message: bytes) -> None:
        headers = self.headers
        if headers is None:
            _publish_raw(self, message)
            return
        with headers.lock:
            _publish_raw(self, message)
            headers.sequence += 1

    def destroy_when_not_in_use(self) -> None:
        disconnect(self)
        _destroy(self)


unseen_methods(_Handle)  # errors of the plain methods pass through as if we were not there


class HeaderPublisher:
    """What publishes the headers of one publisher.

    collect   gives the tracked fields of a message
    sequence  how many messages have been published
    lock      held while a message, with its header before it, goes out; a signal handler that
              publishes may enter it again
    """

    def __init__(self, node: Node, message_type: type, topic: str, qos: QoSProfile) -> None:
        self._node = weakref.ref(node)
        self._message_type = message_type
        self.topic = topic
        self.collect = fields.collector(message_type)
        self.sequence = 0
        self.lock = threading.RLock()
        self._encoder = Encoder(self._own)
        self._transient = qos.durability != DurabilityPolicy.VOLATILE
        self._unheard = 0
        self._warned: set[str] = set()
        self._failed: Exception | None = None
        check_for_type_support(UInt8MultiArray)
        with node.handle:
            self._handle = _plain_handle(
                node.handle, UInt8MultiArray, topic + header.SUFFIX,
                header_qos(qos).get_c_qos_profile(),
            )  # fmt: skip

    def publish(self, handle: Any, message: Any, found: list[fields.Tracked]) -> bool:
        """Publishes a message with its header; False if it is to be published without.

        Whatever goes wrong here is not the program's business: if it is the message's fault, the
        plain way of publishing will say so.
        """
        try:
            if serving.pending:  # changes that have waited for this thread
                serving.run_pending(self._node())
            values = self._current(found)
            if not values or not self._is_heard(values):
                return False
            data = _rclpy.rclpy_serialize(message, self._message_type)
            checksum = header.checksum_of(data)
            with self.lock:
                payload, kept = self._encoder.encode(checksum, self.sequence + 1, values)
                if kept:
                    _publish_raw(self._handle, header.wrap(payload))
                _publish_raw(handle, data)
                self.sequence += 1
        except Exception as error:
            self._failed = error
            return False
        if kept < len(values):
            self._warn(
                "size",
                f"the provenance header of {self.topic} would be too large, "
                f"{len(values) - kept} of {len(values)} fields are left out",
            )
        return True

    def _current(self, found: list[fields.Tracked]) -> list[tuple[str, Any]]:
        """The tracked fields as they go out: up to date, and not too deep."""
        values = []
        for field in found:
            path, value, _, _ = field
            if refresh.any_change:
                current = refresh.refreshed(value)
                if current is not value:
                    field.put(current)
                    value = current
                if not is_tracked(value):
                    continue
            value = getattr(value, "_core", value)
            self._encoder.fold(value)
            values.append((path, value))
        return values

    def _is_heard(self, values: list[tuple[str, Any]]) -> bool:
        """Whether anybody reads headers, or may do so later.

        If not, sources are made known all the same; large expressions are not searched for them
        every time.
        """
        if self._transient or self._handle.get_subscription_count():
            return True
        self._unheard += 1
        if self._unheard % _LOOK_AGAIN == 1 or all(v._depth <= _SHALLOW for _, v in values):
            with self.lock:
                self._encoder.look(values)
        return False

    def _own(self, source: Source) -> None:
        from . import parameters

        node = self._node()
        if node is not None:
            parameters.own(node, source)

    def plain_worked(self) -> None:
        """Called when a message has gone out plain: if there was an error, it was ours."""
        error, self._failed = self._failed, None
        if error is not None:
            self._warn("error", f"no provenance for a message on {self.topic}: {error!r}")

    def _warn(self, kind: str, text: str) -> None:
        if kind not in self._warned:
            self._warned.add(kind)
            _log.warning(text)

    def destroy(self) -> None:
        """Ends the header topic."""
        self._handle.destroy_when_not_in_use()


def _headers(node: Node, message_type: type, topic: str, qos: QoSProfile) -> HeaderPublisher:
    header.local_nodes.add(node.get_fully_qualified_name())
    return HeaderPublisher(node, message_type, topic, qos)


woven = WovenHandles("create_publisher", "Publisher", _Handle, _headers)
install = woven.install
uninstall = woven.uninstall

__all__ = ["HeaderPublisher", "install", "uninstall"]
