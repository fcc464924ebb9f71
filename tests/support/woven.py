"""Literals without a program, and nodes in the test process that own them."""

import itertools
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node

from rosslt_auto.provenance.locations import LiteralInfo, Location
from rosslt_auto.provenance.registry import count_executions, register_literals

_numbers = itertools.count()


class Table:
    """The literals of a made-up module; what a program reads are the entries of `table`."""

    def __init__(self, **values: Any) -> None:
        number = next(_numbers)
        self.prefix = f"rosslt.made_up_{number}"
        self.table: list[Any] = []
        infos = [
            LiteralInfo(f"{self.prefix}.{name}", name, True, line, 4, line, 8, False)
            for line, name in enumerate(values, start=1)
        ]
        count_executions()  # as if a node had been made
        self._literals = register_literals(
            f"table {number}", f"made_up_{number}", f"/made/up_{number}.py",
            tuple(values.values()), lambda: infos, self._publish,
        )  # fmt: skip
        self._indices = {name: index for index, name in enumerate(values)}

    def _publish(self, table: list[Any]) -> None:
        self.table = table

    def name(self, hint: str) -> str:
        """The parameter name of a literal."""
        return f"{self.prefix}.{hint}"

    def location(self, hint: str) -> Location:
        """The location of a literal."""
        return self._literals.location(self._indices[hint])

    def read(self, hint: str) -> Any:
        """What the program gets when it executes the literal now."""
        return self.table[self._indices[hint]]


@contextmanager
def node_in(domain: int, name: str = "robot", **options: Any) -> Iterator[Node]:
    """A node with a context of its own, as a program would have it."""
    context = Context()
    rclpy.init(args=options.pop("args", []), context=context, domain_id=domain)
    node = Node(name, context=context, **options)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


@contextmanager
def spinning(node: Node, executor: Executor | None = None) -> Iterator[None]:
    """A thread "the program's" that spins a node; in an executor of its own if none is given."""
    executor = executor or SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin, name="the program's")
    thread.start()
    try:
        yield
    finally:
        executor.shutdown()
        thread.join()
