"""Nodes in the test process whose publishers and subscriptions carry provenance."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher

from rosslt_auto.provenance import Source
from rosslt_auto.provenance.expressions import is_leaf, operands
from rosslt_auto.provenance.locations import source_of
from rosslt_auto.provenance.values import is_tracked, leaf
from rosslt_auto.ros import publishing, subscribing
from support.waiting import wait_until


@contextmanager
def woven(*aspects: Any) -> Iterator[None]:
    """Within, what nodes make has the advice of these aspects, by default of both on the wire."""
    aspects = aspects or (publishing, subscribing)
    for aspect in aspects:
        aspect.install()
    try:
        yield
    finally:
        for aspect in reversed(aspects):
            aspect.uninstall()


class Nodes:
    """Nodes of one context, which are taken care of by one executor. A context manager."""

    def __init__(self, domain: int) -> None:
        self.context = Context()
        rclpy.init(args=[], context=self.context, domain_id=domain)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.made: list[Node] = []

    def node(self, name: str = "node", **more: Any) -> Node:
        """Another node."""
        node = rclpy.create_node(
            name, context=self.context, enable_rosout=False, start_parameter_services=False, **more
        )
        self.made.append(node)
        self.executor.add_node(node)
        return node

    def spin_until(self, condition: Any, what: str) -> None:
        """Serves callbacks until the condition holds."""

        def served() -> bool:
            self.executor.spin_once(timeout_sec=0.05)
            return bool(condition())

        wait_until(served, what, interval=0)

    def __enter__(self) -> "Nodes":
        return self

    def __exit__(self, *_: object) -> None:
        self.executor.shutdown()
        for node in self.made:
            node.destroy_node()
        rclpy.try_shutdown(context=self.context)


def headers_of(entity: Any) -> Any:
    """What is beside a publisher or a subscription, None if it is plain."""
    return getattr(entity.handle, "headers", None)


def wait_until_heard(publisher: Publisher, count: int = 1) -> None:
    """Returns when the publisher, and its header topic, have so many subscribers."""
    handles = [publisher.handle]
    if headers_of(publisher) is not None:
        handles.append(headers_of(publisher)._handle)
    wait_until(
        lambda: all(handle.get_subscription_count() >= count for handle in handles),
        f"{count} subscribers of {publisher.topic}",
    )


def source(name: str = "gain", kind: str = "float", node: str | None = "/elsewhere") -> Source:
    """A source with everything that one can have."""
    return Source(
        node, f"rosslt.module.{name}", kind, name, True,
        file="/home/somebody/module.py", line=3, column=8, text=f"{name} = ...",
    )  # fmt: skip


def tracked(value: Any, name: str = "gain", node: str | None = "/elsewhere") -> Any:
    """A tracked value, as if it came from a literal in another node."""
    return leaf(source(name, type(value).__name__, node), value)


def told(value: Any) -> Any:
    """All that a tracked value knows, comparable: sources, operators, values and their types."""
    if not is_tracked(value):
        return (type(value).__name__, repr(value))
    if is_leaf(value):
        found = source_of(value)
        return (
            type(value).__name__, repr(value), found.node, found.parameter, found.kind,
            found.hint, found.named, found.file, found.line, found.column, found.text,
        )  # fmt: skip
    below = tuple(told(operand) for operand in operands(value))
    return (type(value).__name__, repr(value), value._op.name, below)
