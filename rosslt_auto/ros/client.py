"""Parameters of other nodes: what there is, and changing it, all or nothing.

`SourceChange` of the paper as rcl_interfaces services: typed, acknowledged, atomic for a node.
"""

from __future__ import annotations

import ast
import re
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter, parameter_value_to_python

from rosslt_auto.provenance.sources import Source

PREFIX = "rosslt"
IN_THE_FILE = "in the source file: "


class ChangeRefused(Exception):
    """A change was not made; the message says why. What was changed before has been taken back."""


class NoAnswer(Exception):
    """A node does not answer in time."""


@dataclass(frozen=True)
class Change:
    """One source that was changed, or would be."""

    node: str
    parameter: str
    old: Any
    new: Any

    def to_json(self) -> dict[str, Any]:
        return {"node": self.node, "parameter": self.parameter, "old": self.old, "new": self.new}


@dataclass(frozen=True)
class Place:
    """A location of another node, as its parameter describes it.

    first is None where the node does not say; line and column are None where there is no file.
    content is the fingerprint of the Python file that was loaded (`locations.fingerprint`), None
    for what is no literal. given is None, or what gave the literal a value at start: ``-p``, the
    path of a parameter file, "" where the node does not know. range is None or [low, high, step]
    (step None: any number between), frozen whether a remark in the file forbids changes.
    """

    node: str
    parameter: str
    file: str | None
    line: int | None
    column: int | None
    text: str
    first: Any
    value: Any
    read_only: bool
    content: str | None = None
    given: str | None = None
    range: list[Any] | None = None
    frozen: bool = False

    def to_json(self) -> dict[str, Any]:
        return dict(vars(self))


class ParameterClient:
    """Calls parameter services from a thread that does not spin; another one must.

    node  the rclpy node to call from
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self._clients: dict[tuple[type, str], Any] = {}
        self._lock = threading.Lock()

    def prepare(self, nodes: Iterable[str]) -> None:
        """Makes the clients that `set` needs, so that they are matched by then."""
        for node in nodes:
            self._client(SetParametersAtomically, node, "set_parameters_atomically")

    def set(self, changes: Iterable[Change], timeout: float) -> None:
        """Makes all changes, each node's together.

        Raises ChangeRefused or NoAnswer if a node does not; then the others have their old values.
        """
        done: list[list[Change]] = []
        by_node: dict[str, list[Change]] = {}
        for change in changes:
            by_node.setdefault(change.node, []).append(change)
        for node, wanted in by_node.items():
            try:
                self._set(node, {change.parameter: change.new for change in wanted}, timeout)
            except (ChangeRefused, NoAnswer):
                self._take_back(done, timeout)
                raise
            done.append(wanted)

    def _take_back(self, done: list[list[Change]], timeout: float) -> None:
        for changed in reversed(done):
            try:
                old = {change.parameter: change.old for change in changed}
                self._set(changed[0].node, old, timeout)
            except (ChangeRefused, NoAnswer):
                continue  # the reason that comes first is the one to tell

    def _set(self, node: str, values: Mapping[str, Any], timeout: float) -> None:
        request = SetParametersAtomically.Request()
        request.parameters = [
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
        ]
        answer = self._call(
            SetParametersAtomically, node, "set_parameters_atomically", request, timeout
        )
        if not answer.result.successful:
            raise ChangeRefused(f"{node}: {answer.result.reason or 'refused without a reason'}")

    def get(self, node: str, names: list[str], timeout: float) -> list[Any]:
        """The values of parameters, None for one that is not there. Raises NoAnswer."""
        answer = self._call(
            GetParameters, node, "get_parameters", GetParameters.Request(names=names), timeout
        )
        values = [parameter_value_to_python(value) for value in answer.values]
        return values if len(values) == len(names) else [None] * len(names)

    def places(self, node: str, timeout: float) -> list[Place]:
        """The locations that a node owns now. Raises NoAnswer."""
        listed = self._call(
            ListParameters, node, "list_parameters",
            ListParameters.Request(prefixes=[PREFIX], depth=0), timeout,
        )  # fmt: skip
        names = [name for name in listed.result.names if name.startswith(f"{PREFIX}.")]
        if not names:
            return []
        described = self._call(
            DescribeParameters, node, "describe_parameters",
            DescribeParameters.Request(names=names), timeout,
        )  # fmt: skip
        values = self.get(node, names, timeout)
        return [
            _place(node, descriptor, value)
            for descriptor, value in zip(described.descriptors, values, strict=False)
        ]

    def _client(self, service: Any, node: str, name: str) -> Any:
        key = (service, node)
        with self._lock:
            client = self._clients.get(key)
            if client is None:
                client = self._node.create_client(service, f"{node}/{name}")
                self._clients[key] = client
            return client

    def _call(self, service: Any, node: str, name: str, request: Any, timeout: float) -> Any:
        client = self._client(service, node, name)
        deadline = time.monotonic() + timeout
        wait_until(client.service_is_ready, deadline, f"{node} has no parameter services in reach")
        done = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: done.set())
        if not done.wait(max(0.0, deadline - time.monotonic())):
            client.remove_pending_request(future)
            raise NoAnswer(f"{node} does not answer")
        return future.result()


def wait_until(condition: Callable[[], bool], deadline: float, otherwise: str) -> None:
    """Returns when the condition holds; for the ROS graph, which tells nobody that it changes."""
    while not condition():
        if time.monotonic() > deadline:
            raise NoAnswer(otherwise)
        time.sleep(0.003)


_DESCRIPTION = re.compile(r"(?P<file>.*?):(?P<line>\d+):(?P<column>\d+)  (?P<text>.*)", re.DOTALL)


def _place(node: str, descriptor: Any, value: Any) -> Place:
    found = _DESCRIPTION.fullmatch(descriptor.description)
    first, content, frozen, given = _constraints(descriptor.additional_constraints)
    return Place(
        node=node,
        parameter=descriptor.name,
        file=found["file"] if found else None,
        line=int(found["line"]) if found else None,
        column=int(found["column"]) if found else None,
        text=found["text"] if found else descriptor.description,
        first=first,
        value=value,
        read_only=descriptor.read_only,
        content=content,
        given=given,
        range=_range(descriptor),
        frozen=frozen,
    )


def _range(descriptor: Any) -> list[Any] | None:
    for found in (*descriptor.floating_point_range, *descriptor.integer_range):
        return [found.from_value, found.to_value, found.step or None]
    return None


_MORE = re.compile(
    r"(?:; content ([0-9a-f]{8}))?(; frozen)?(?:; given at start(?:: (.*)|()))?", re.DOTALL
)


def _constraints(text: str) -> tuple[Any, str | None, bool, str | None]:
    """First value, content, whether it is frozen, and what gave it at start, as `parameters` puts
    them into words."""
    if not text.startswith(IN_THE_FILE):
        return None, None, False, None
    text = text.removeprefix(IN_THE_FILE)
    # The value may be a text with semicolons: no beginning of its repr can be evaluated.
    for end in [*(found.start() for found in re.finditer("; ", text)), len(text)]:
        more = _MORE.fullmatch(text, end)
        if more is None:
            continue
        try:
            value = ast.literal_eval(text[:end])
        except (ValueError, SyntaxError, MemoryError, RecursionError):
            continue
        given = more[3] if more[3] is not None else more[4]
        return value, more[1], more[2] is not None, given
    return None, None, False, None


def change_of(source: Source, old: Any, new: Any) -> Change:
    """The change of a source that some node owns. Raises ChangeRefused if none does."""
    if source.node is None:
        raise ChangeRefused(f"{source.parameter} belongs to no node")
    return Change(source.node, source.parameter, old, new)
