"""An ordinary, uninstrumented ROS node in the test process, to see nodes as others see them."""

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import rclpy
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.task import Future

from support.waiting import DEADLINE, DeadlineMissed, wait_until


class Recording:
    """The messages of one topic, in order, from the moment of its making."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self._messages: list[Any] = []
        self._changed = threading.Condition()

    def add(self, message: Any) -> None:
        """Called with each message."""
        with self._changed:
            self._messages.append(message)
            self._changed.notify_all()

    @property
    def messages(self) -> list[Any]:
        """All messages up to now."""
        with self._changed:
            return list(self._messages)

    def first(self, count: int, deadline: float = DEADLINE) -> list[Any]:
        """The first `count` messages, as soon as they are there."""
        with self._changed:
            if not self._changed.wait_for(lambda: len(self._messages) >= count, deadline):
                raise DeadlineMissed(f"{len(self._messages)} of {count} messages on {self.topic}")
            return self._messages[:count]

    def next(self, count: int = 1, deadline: float = DEADLINE) -> list[Any]:
        """The next `count` messages from now on."""
        with self._changed:
            start = len(self._messages)
        return self.first(start + count, deadline)[start:]

    def until(
        self, condition: Callable[[Any], bool], since: int = 0, deadline: float = DEADLINE
    ) -> Any:
        """The first message after the first `since` ones for which `condition` holds."""
        index = since
        found: list[Any] = []

        def seen() -> bool:
            nonlocal index
            while index < len(self._messages) and not found:
                if condition(self._messages[index]):
                    found.append(self._messages[index])
                index += 1
            return bool(found)

        with self._changed:
            if not self._changed.wait_for(seen, deadline):
                last = self._messages[-1:]
                raise DeadlineMissed(f"{index} messages on {self.topic}, none fits; last: {last}")
            return found[0]

    def __len__(self) -> int:
        with self._changed:
            return len(self._messages)


class Observer:
    """A node with a context and a thread of its own; a context manager."""

    def __init__(self, domain: int, name: str = "observer") -> None:
        self.domain = domain
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = rclpy.create_node(
            name, context=self._context, start_parameter_services=False, enable_rosout=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()
        self._clients: dict[str, AsyncParameterClient] = {}

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):
            self._executor.spin()

    def close(self) -> None:
        """Ends node, thread and context."""
        self._executor.shutdown()
        self._thread.join(DEADLINE)
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    def __enter__(self) -> "Observer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # Topics

    def record(self, message_type: type, topic: str, qos: QoSProfile | None = None) -> Recording:
        """Records the messages of a topic from now on."""
        recording = Recording(topic)
        profile = qos or QoSProfile(depth=1000)
        self.node.create_subscription(message_type, topic, recording.add, profile)
        return recording

    def publisher(self, message_type: type, topic: str, subscribers: int = 1) -> Publisher:
        """A publisher that `subscribers` others have found."""
        publisher = self.node.create_publisher(message_type, topic, QoSProfile(depth=1000))
        wait_until(
            lambda: publisher.get_subscription_count() >= subscribers,
            f"{subscribers} subscribers of {topic}",
        )
        return publisher

    def destroy(self, *entities: Any) -> None:
        """Destroys publishers, subscriptions or timers, between two waits of the node's thread.

        From another thread it could happen while they are being waited for, which ends that.
        """

        def do() -> None:
            for entity in entities:
                if isinstance(entity, Publisher):
                    self.node.destroy_publisher(entity)
                elif isinstance(entity, Subscription):
                    self.node.destroy_subscription(entity)
                else:
                    self.node.destroy_timer(entity)

        self.result(self._executor.create_task(do), "destroy entities")

    def topics(self) -> dict[str, list[str]]:
        """All topics that are known now, hidden ones too, with their types."""
        return dict(self.node.get_topic_names_and_types())

    # Parameters, as any parameter client

    def result(self, future: Future, what: str) -> Any:
        """The result of a future, when it is there."""
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        if not done.wait(DEADLINE):
            raise DeadlineMissed(f"no answer: {what}")
        return future.result()

    def _parameters(self, node: str) -> AsyncParameterClient:
        client = self._clients.get(node)
        if client is None:
            client = self._clients[node] = AsyncParameterClient(self.node, node)
        wait_until(client.services_are_ready, f"parameter services of {node}")
        return client

    def list_parameters(self, node: str, *prefixes: str) -> list[str]:
        """The names of the node's parameters below the prefixes, or of all."""
        future = self._parameters(node).list_parameters(prefixes=list(prefixes) or None)
        return list(self.result(future, f"list {node}").result.names)

    def wait_for_parameter(self, node: str, name: str) -> None:
        """Returns when the node has declared the parameter."""
        wait_until(lambda: name in self.list_parameters(node), f"parameter {name} of {node}")

    def describe(self, node: str, name: str) -> ParameterDescriptor:
        """The descriptor of a parameter."""
        future = self._parameters(node).describe_parameters([name])
        return self.result(future, f"describe {name}").descriptors[0]

    def get(self, node: str, name: str) -> Any:
        """The value of a parameter, None if it is not declared."""
        future = self._parameters(node).get_parameters([name])
        values = self.result(future, f"get {name}").values
        return parameter_value_to_python(values[0]) if values else None

    def set(self, node: str, values: dict[str, Any]) -> list[SetParametersResult]:
        """Sets parameters, each for itself."""
        future = self._parameters(node).set_parameters(_messages(values))
        return list(self.result(future, f"set {list(values)}").results)

    def set_atomically(self, node: str, values: dict[str, Any]) -> SetParametersResult:
        """Sets all parameters or none."""
        future = self._parameters(node).set_parameters_atomically(_messages(values))
        return self.result(future, f"set {list(values)} atomically").result


def _messages(values: dict[str, Any]) -> Sequence[Any]:
    return [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
