"""Sees the messages of other nodes with their provenance: for the command line and the views."""

from __future__ import annotations

import importlib
import os
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.validate_full_topic_name import validate_full_topic_name

from . import changes, subscribing
from .client import NoAnswer, ParameterClient, wait_until
from .fields import tracked_fields
from .header import SUFFIX as HEADER_SUFFIX

SETTLE = 1.0
"""Seconds that a message without header is held back while the topic's headers are on their way."""

QUIET = 1.5
"""Seconds without news after which the graph counts as discovered."""

_DEPTH = 100

_NOT_YET_KNOWN = "_NODE_NAME_UNKNOWN_"
"""What rmw calls a node whose endpoints it has heard of before the node itself."""


class CannotObserve(Exception):
    """A topic cannot be looked at; the message says why."""


class TrackedMessage:
    """A message with its provenance.

    message  as a callback would get it
    fields   its tracked values by path
    """

    __slots__ = ("fields", "message")

    def __init__(self, message: Any) -> None:
        self.message = message
        self.fields: dict[str, Any] = tracked_fields(message)


class TopicSubscription:
    """The messages of one topic from now on. Made by `Observer.subscribe`.

    topic, type_name, message_type   of what is subscribed
    """

    def __init__(self, observer: Observer, topic: str, type_name: str, message_type: Any) -> None:
        self.topic = topic
        self.type_name = type_name
        self.message_type = message_type
        self._observer = observer
        self._messages: deque[TrackedMessage] = deque(maxlen=10 * _DEPTH)
        self._arrived = threading.Condition()
        self._callback: Callable[[TrackedMessage], None] | None = None
        self._settled = False
        self._first_at: float | None = None
        self.handle: Any = None

    def next(self, deadline: float | None = None) -> TrackedMessage:
        """The next message, as soon as it is there. Raises NoAnswer after the deadline.

        deadline  on the clock of time.monotonic; None waits for ever
        """
        with self._arrived:
            while not self._messages:
                left = None if deadline is None else deadline - time.monotonic()
                if left is not None and left <= 0:
                    raise NoAnswer(f"no message on {self.topic} in time")
                self._arrived.wait(1.0 if left is None else min(left, 1.0))
            return self._messages.popleft()

    def drain(self) -> None:
        """Forgets what has arrived."""
        with self._arrived:
            self._messages.clear()

    def _receive(self, message: Any) -> None:
        tracked = TrackedMessage(message)
        if not self._settled and not self._settle(tracked):
            return
        if self._callback is not None:
            self._callback(tracked)
            return
        with self._arrived:
            self._messages.append(tracked)
            self._arrived.notify_all()

    def _settle(self, tracked: TrackedMessage) -> bool:
        """The first messages may overtake the discovery of their headers: those are passed over."""
        now = time.monotonic()
        if self._first_at is None:
            self._first_at = now
        late = now - self._first_at > SETTLE
        if tracked.fields or late or not self._observer.has_headers(self.topic):
            self._settled = True
        return self._settled


class Observer:
    """A hidden node with a context and a thread of its own. A context manager.

    purpose  becomes part of the node's name
    """

    def __init__(self, purpose: str = "observer") -> None:
        self._purpose = purpose

    def __enter__(self) -> Observer:
        self._context = Context()
        rclpy.init(args=[], context=self._context)
        self.node = rclpy.create_node(
            f"_rosslt_{self._purpose}_{os.getpid()}",
            context=self._context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name="rosslt observer", daemon=True)
        self._thread.start()
        self.parameters = ParameterClient(self.node)
        subscribing.install(self)
        return self

    def __exit__(self, *_: object) -> None:
        # First the executor: an entity must not go while it is waited for.
        self._executor.shutdown()
        self._thread.join(5.0)
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)
        subscribing.uninstall(self)

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):
            self._executor.spin()

    # Topics

    def topics(self) -> dict[str, list[str]]:
        """All topics that are known now, hidden ones too, with their types."""
        return dict(self.node.get_topic_names_and_types())

    def has_headers(self, topic: str) -> bool:
        """Whether somebody publishes provenance for the topic."""
        return self.node.count_publishers(topic + HEADER_SUFFIX) > 0

    def subscribe(
        self,
        topic: str,
        callback: Callable[[TrackedMessage], None] | None = None,
        deadline: float | None = None,
    ) -> TopicSubscription:
        """Subscribes to a topic whose type and quality of service are found out.

        callback  called in the observer's thread with each message; without it they are kept
                  for `TopicSubscription.next`
        deadline  until when the topic may appear
        Raises CannotObserve.
        """
        topic = full_name(topic)
        if deadline is None:
            deadline = time.monotonic()
        try:
            wait_until(lambda: self.node.count_publishers(topic) > 0, deadline, "")
        except NoAnswer:
            raise CannotObserve(f"nobody publishes {topic}") from None
        [type_name, *others] = dict(self.node.get_topic_names_and_types())[topic]
        if others:
            raise CannotObserve(f"{topic} has several types: {', '.join([type_name, *others])}")
        subscription = TopicSubscription(self, topic, type_name, message_class(type_name))
        subscription._callback = callback
        subscription.handle = self.node.create_subscription(
            subscription.message_type, topic, subscription._receive, self._quality(topic)
        )
        return subscription

    def unsubscribe(self, subscription: TopicSubscription) -> None:
        """Ends a subscription."""
        self.node.destroy_subscription(subscription.handle)

    def _quality(self, topic: str) -> QoSProfile:
        """What matches all publishers of the topic."""
        offered = [info.qos_profile for info in self.node.get_publishers_info_by_topic(topic)]
        reliable = all(one.reliability == ReliabilityPolicy.RELIABLE for one in offered)
        latched = all(one.durability == DurabilityPolicy.TRANSIENT_LOCAL for one in offered)
        return QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=(DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE),
        )

    # Nodes

    def nodes_with_locations(self) -> set[str]:
        """The nodes that listen to source changes: those that own locations."""
        return {
            f"{info.node_namespace.rstrip('/')}/{info.node_name}"
            for info in self.node.get_subscriptions_info_by_topic(changes.TOPIC)
            if info.node_name != _NOT_YET_KNOWN
        }

    def knows_node(self, name: str) -> bool:
        """Whether the node is in the graph as it is known now."""
        return name in self.node.get_fully_qualified_node_names()

    def settle(self, deadline: float) -> None:
        """Returns when somebody was found and nobody new for a while, or at the deadline.

        There is no way to know that everybody has been found.
        """
        own = self.node.get_fully_qualified_name()
        seen: Any = None
        since = time.monotonic()
        while time.monotonic() < deadline:
            nodes = set(self.node.get_fully_qualified_node_names()) - {own}
            now = (nodes, self.nodes_with_locations())
            if now != seen:
                seen, since = now, time.monotonic()
            elif nodes and time.monotonic() - since > QUIET:
                return
            time.sleep(0.02)


def full_name(topic: str) -> str:
    """The full name of a topic. Raises CannotObserve if it cannot be a name."""
    name = topic if topic.startswith("/") else f"/{topic}"
    try:
        validate_full_topic_name(name)
    except InvalidTopicNameException as error:
        reason = str(error).splitlines()[0].removeprefix("Invalid topic name: ")
        raise CannotObserve(f"{topic!r} is no topic name: {reason}") from None
    return name


def message_class(type_name: str) -> Any:
    """The class of ``package/msg/Name``. Raises CannotObserve if it is not installed."""
    package, _, rest = type_name.partition("/")
    module, _, name = rest.rpartition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{module.replace('/', '.')}"), name)
    except (ImportError, AttributeError):
        raise CannotObserve(f"the message type {type_name} is not installed here") from None
