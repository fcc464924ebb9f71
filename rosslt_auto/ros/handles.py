"""Weaving the handles behind publishers and subscriptions.

rclpy makes a handle of its C extension for each entity of a node, and everything that happens to
the entity goes through it. Join points: the method of `Node` that makes entities of a kind, and the
class of their handles, which a subclass with advice of its own replaces.

The header topic's own handle is made first: the middleware makes endpoints known in that order, so
that whoever can get a message can get its header.
"""

from __future__ import annotations

import logging
import threading
import weakref
from collections.abc import Callable
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints
from . import fields, sequences

INFRASTRUCTURE = frozenset({"/rosout", "/parameter_events", "/clock", "/rosslt/source_change"})
"""Topics that the client library itself serves."""

_MIN_DEPTH = 32
_KEEP_ALL_DEPTH = 1000

_installed: set[str] = set()
"""Kinds of entities; messages are woven as long as there is one."""

_log = logging.getLogger(__name__)


class WovenHandles:
    """The weaving of one kind of entities.

    method   the method of `Node` that makes them
    kind     the name of the class of their handles in rclpy's extension
    handle   the subclass that replaces it; its attribute `headers` is None for a plain entity,
             else something with a method ``destroy()``
    connect  gives the `headers` for an entity: of a node, for messages of a class, with the
             resolved name of its topic and its quality of service
    """

    def __init__(
        self,
        method: str,
        kind: str,
        handle: Any,
        connect: Callable[[Node, type, str, QoSProfile], Any],
    ) -> None:
        self._method = method
        self._kind = kind
        self._handle: Any = handle
        self._plain = handle.__bases__[0]
        self._connect = connect
        self._join_points = JoinPoints()
        self._users: set[Any] = set()
        self._making = threading.local()  # the node that is making an entity
        self.connected: weakref.WeakSet[Any] = weakref.WeakSet()
        handle.__name__ = handle.__qualname__ = self._plain.__name__
        handle.__module__ = self._plain.__module__

    def install(self, user: Any = None) -> None:
        """Weaves the advice in; entities made before stay plain.

        user  on whose behalf: the advice stays until nobody needs it any more
        """
        self._users.add(user)
        if not self._join_points:
            self._join_points.advise(Node, self._method, self._create_advice)
            self._join_points.replace(_rclpy, self._kind, lambda plain: self._handle)
            _installed.add(self._kind)
            sequences.install()

    def uninstall(self, user: Any = None) -> None:
        """Takes the advice off with its last user; entities made in between become plain."""
        self._users.discard(user)
        if self._users:
            return
        self._join_points.restore()
        _installed.discard(self._kind)
        if not _installed:
            sequences.uninstall()
        for handle in list(self.connected):
            disconnect(handle)

    def _create_advice(self, wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
        before = getattr(self._making, "node", None)
        self._making.node = node
        try:
            return wrapped(*args, **kwargs)
        finally:
            self._making.node = before

    @unseen
    def make(self, handle: Any, node_handle: Any, *args: Any) -> None:
        """Does what the plain class does to make a handle; the headers come first."""
        headers = self._headers(*args)
        try:
            self._plain.__init__(handle, node_handle, *args)
        except BaseException:
            if headers is not None:
                headers.destroy()
            raise
        handle.headers = headers
        if headers is not None:
            self.connected.add(handle)

    def _headers(self, message_type: type, topic: str, qos: Any, *_: Any) -> Any:
        node = getattr(self._making, "node", None)
        if node is None:
            return None
        try:
            topic = node.resolve_topic_name(topic)
            if not has_headers(message_type, topic):
                return None
            sequences.weave(message_type)  # if it was not imported as others are
            return self._connect(node, message_type, topic, QoSProfile(**qos.to_dict()))
        except Exception as error:
            _log.warning("no provenance on %s: %r", topic, error)
            return None


@unseen  # errors pass through as if we were not there
def disconnect(handle: Any) -> None:
    """Ends the headers of an entity, if it has any: it is plain from now on."""
    headers, handle.headers = handle.headers, None
    if headers is not None:
        headers.destroy()


def has_headers(message_type: type, topic: str) -> bool:
    """Whether there is a header topic beside a topic (given by its resolved name)."""
    return (
        topic not in INFRASTRUCTURE
        and not topic_or_service_is_hidden(topic)
        and fields.is_message_type(message_type)
        and fields.trackable(message_type)
    )


def header_qos(qos: QoSProfile) -> QoSProfile:
    """The quality of service of the header topic of a topic that has `qos`.

    A header lost is provenance lost, so it is reliable in any case. Its queue is a little longer:
    the next header may arrive before the message of this one is taken.
    """
    if qos.history == HistoryPolicy.KEEP_ALL:
        depth = _KEEP_ALL_DEPTH
    else:
        depth = max(2 * qos.depth, _MIN_DEPTH)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=qos.durability,
    )


__all__ = ["INFRASTRUCTURE", "WovenHandles", "disconnect", "has_headers", "header_qos"]
