"""Locations as ROS parameters of the node that publishes them.

The paper's `create_location` declares a parameter for each source location (Section IV-A). Here
a literal becomes a parameter of a node when it first reaches one of the node's messages, so that
only what matters shows up. To parameter clients, and to the program where it asks by name, it is
a parameter like any other; lists that the program makes of its own parameters stay as they are,
and its callbacks are not asked.

Join points: `rclpy.node.Node` where it looks up a parameter by name, sets some, is made and
destroyed; `rclpy.parameter_service.ParameterService` where it lists.
"""

from __future__ import annotations

import logging
import os
import threading
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import SimpleNamespace
from typing import Any, cast

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterEvent,
    SetParametersResult,
)
from rclpy.exceptions import ParameterImmutableException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService

from rosslt_auto.provenance import bindings, refresh
from rosslt_auto.provenance.external import LocalSource
from rosslt_auto.provenance.joinpoints import JoinPoints
from rosslt_auto.provenance.locations import Location
from rosslt_auto.provenance.registry import count_executions, location_of
from rosslt_auto.provenance.sources import Source, SourceChangeRefused
from rosslt_auto.provenance.values import untracked

from . import overrides

PREFIX = overrides.PREFIX
READ_ONLY = "read-only: the node was started with --read-only"

read_only = False
"""Whether every change is refused (`run --read-only`)."""

IN_THE_FILE = "in the source file: "
"""How a descriptor's additional constraints begin; what follows is the literal's first value."""

CONTENT = "content "
FROZEN = "frozen"
GIVEN = "given at start"
"""What may follow after a semicolon: the fingerprint of what was loaded, whether a remark beside
the literal says so, and whether (and by what) it got another value at start."""

on_first_location: list[Callable[[Any], None]] = []
"""Called with a node that is about to own its first location."""

on_release: list[Callable[[Any], None]] = []
"""Called with a node that is about to be destroyed."""

Owned = dict[str, Location | LocalSource]

_log = logging.getLogger(__name__)
_lock = threading.RLock()
_owned: weakref.WeakKeyDictionary[Any, Owned] = weakref.WeakKeyDictionary()
_nothing: Owned = {}


# ---------------------------------------------------------------- who owns what


def own(node: Any, source: Source) -> None:
    """Makes a source that has reached a message of `node` one that can be found and changed.

    A location that no node owns becomes a parameter of this one. Any other is left alone.
    """
    if source.node is None:
        _declare(node, source)


def owned(node: Any) -> Owned:
    """The locations that a node owns, by parameter name."""
    return _owned.get(node, _nothing)


def _declare(node: Any, source: Source) -> None:
    with _lock:
        if source.node is not None:
            return
        declared_by = getattr(source, "declared_by", None)  # see `declared`
        owner = declared_by() if declared_by is not None else node
        if owner is None:
            return
        begin(owner)
        source.node = owner.get_fully_qualified_name()
        if not isinstance(source, (Location, LocalSource)):
            return
        _owned[owner][source.parameter] = source
        parameter = Parameter(source.parameter, value=source.value)
    _broadcast(owner, new=[parameter])


def begin(node: Any) -> None:
    """Prepares a node for owning locations, once."""
    with _lock:
        if node in _owned:
            return
        locations: Owned = {}
        _owned[node] = locations
        weakref.finalize(node, _disown, locations).atexit = False
        for prepare in on_first_location:
            prepare(node)


def release(node: Any) -> None:
    """Forgets a node; whoever publishes its locations next owns them."""
    with _lock:
        locations = _owned.pop(node, None)
        if locations is not None:
            _disown(locations)


def _forked() -> None:
    """In a forked process: its literals belong to no node of its parent, and nobody has the lock
    that another thread may have had."""
    global _lock
    _lock = threading.RLock()
    for node in list(_owned):
        release(node)


def _disown(locations: Owned) -> None:
    # Without the lock: this is also called when a node is garbage, in whatever thread finds it,
    # even in one that is just being started by who holds the lock.
    for location in list(locations.values()):
        location.node = None
    locations.clear()


def _broadcast(node: Any, new: Iterable[Any] = (), changed: Iterable[Any] = ()) -> None:
    """A ParameterEvent, as rclpy publishes them."""
    publisher = node._parameter_event_publisher
    if publisher is None:  # the node is being destroyed
        return
    event = ParameterEvent(node=node.get_fully_qualified_name())
    event.new_parameters = [parameter.to_parameter_msg() for parameter in new]
    event.changed_parameters = [parameter.to_parameter_msg() for parameter in changed]
    event.stamp = node.get_clock().now().to_msg()
    publisher.publish(event)


# ---------------------------------------------------------------- a location as a parameter


def parameter_of(location: Location | LocalSource) -> Parameter:
    """The parameter with its current value."""
    return Parameter(location.parameter, value=location.value)


def descriptor_of(location: Location | LocalSource) -> ParameterDescriptor:
    """The descriptor of the contract: ``<file>:<line>:<column>  <source line>``."""
    place = f"{location.file}:{location.line}:{location.column}"
    return ParameterDescriptor(
        name=location.parameter,
        type=parameter_of(location).type_.value,
        description=f"{place}  {location.text or ''}",
        additional_constraints=_constraints(location),
        read_only=read_only or location.frozen,
        **_range(location),
    )


def _range(location: Location | LocalSource) -> dict[str, Any]:
    limits = location.limits
    if limits is None:
        return {}
    if location.kind == "int":
        return {"integer_range": [IntegerRange(
            from_value=limits.low, to_value=limits.high, step=limits.step or 0)]}  # fmt: skip
    return {"floating_point_range": [FloatingPointRange(
        from_value=limits.low, to_value=limits.high, step=limits.step or 0.0)]}  # fmt: skip


def _constraints(location: Location | LocalSource) -> str:
    """``in the source file: <first>; content <fingerprint>; frozen; given at start: <how>``"""
    parts = [f"{IN_THE_FILE}{location.first!r}"]
    if isinstance(location, Location):
        if location.literals.content is not None:
            parts.append(f"{CONTENT}{location.literals.content}")
        if location.frozen:
            parts.append(FROZEN)
        if location.given:
            origin = overrides.origin(location.parameter, location.node)
            parts.append(f"{GIVEN}: {origin}" if origin else GIVEN)
    return "; ".join(parts)


def checked(location: Location | LocalSource, parameter: Any) -> Any:
    """The plain value that a request asks for; raises SourceChangeRefused."""
    if read_only:
        raise SourceChangeRefused(READ_ONLY)
    value = untracked(parameter.value)
    if value is None:
        what = "a literal" if isinstance(location, Location) else "read by the program"
        raise SourceChangeRefused(f"{location.parameter} cannot be undeclared, it is {what}")
    return location.check(value)


# ---------------------------------------------------------------- advice: by name


def _location(node: Any, name: Any) -> Location | LocalSource | None:
    if type(name) is str and name.startswith(PREFIX):
        return owned(node).get(name)
    return None


def _named(args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    return args[0] if args else kwargs.get("name")


def _by_name(answer: Callable[[Location | LocalSource], Any]) -> Any:
    """Advice that answers for our locations and lets rclpy answer for all others."""

    def advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
        location = _location(node, _named(args, kwargs))
        return wrapped(*args, **kwargs) if location is None else answer(location)

    return advice


def _immutable(location: Location | LocalSource) -> None:
    raise ParameterImmutableException(location.parameter)


_ANSWERS: dict[str, Callable[[Location | LocalSource], Any]] = {
    "has_parameter": lambda location: True,
    "get_parameter": parameter_of,
    "get_parameter_or": parameter_of,
    "get_parameter_type": lambda location: parameter_of(location).type_.value,
    "describe_parameter": descriptor_of,
    "undeclare_parameter": _immutable,
    "set_descriptor": _immutable,
}


# ---------------------------------------------------------------- advice: setting


def _set_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
    """Sets our part of a request and the node's own, both or none."""
    requested = args[0] if args else kwargs["parameter_list"]
    if not owned(node):
        return wrapped(*args, **kwargs)
    ours, others = [], []
    for parameter in requested:
        location = _location(node, getattr(parameter, "name", None))
        if location is None:
            others.append(parameter)
        else:
            ours.append((location, parameter))
    if not ours:
        return wrapped(*args, **kwargs)
    try:
        changes = {location: checked(location, parameter) for location, parameter in ours}
    except SourceChangeRefused as refusal:
        return SetParametersResult(successful=False, reason=str(refusal))
    if others:
        result = wrapped(others)
        if not result.successful:
            return result
    return _apply(node, changes)


def _apply(node: Any, changes: Mapping[Location | LocalSource, Any]) -> SetParametersResult:
    try:
        refresh.apply(cast(Mapping[Source, Any], changes))
    except SourceChangeRefused as refusal:
        return SetParametersResult(successful=False, reason=str(refusal))
    _broadcast(node, changed=[parameter_of(location) for location in changes])
    return SetParametersResult(successful=True)


# ---------------------------------------------------------------- advice: listing for others


def _list_advice(wrapped: Any, service: Any, args: Any, kwargs: Any) -> Any:
    """Adds our names to what a client is told; `Node.list_parameters` itself stays plain."""
    request, _ = args
    response = wrapped(*args, **kwargs)
    ours = owned(service._get_node())
    if ours:
        try:
            # rclpy's own rules for prefixes and depth, asked about our names.
            found = Node.list_parameters(
                SimpleNamespace(_parameters=dict(ours)), list(request.prefixes), request.depth
            )
        except (TypeError, ValueError):
            return response
        result = response.result
        result.names = [*result.names, *found.names]
        result.prefixes = list(dict.fromkeys([*result.prefixes, *found.prefixes]))
    return response


# ---------------------------------------------------------------- advice: a node's life


def _declare_many_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
    """Values for literals are no parameters that a node declares from its overrides by itself."""
    if kwargs.get("ignore_override") and not hasattr(node, "_time_source") and len(args) == 2:
        namespace, parameters = args
        args = (namespace, [one for one in parameters if not one[0].startswith(PREFIX)])
    return wrapped(*args, **kwargs)


def _init_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> None:
    count_executions()
    wrapped(*args, **kwargs)
    bindings.add_root(node)
    _take_overrides(node)


def _take_overrides(node: Any) -> None:
    """Applies what rcl has found for this very node and `overrides` could not know of."""
    given = {
        name: parameter.value
        for name, parameter in _for_literals(node._parameter_overrides)
        if not overrides.is_given(name, parameter.value)
    }
    for name in [name for name, _ in _for_literals(node._parameter_overrides)]:
        del node._parameter_overrides[name]
    if not given:
        return
    overrides.add(given)
    changes: dict[Source, Any] = {}
    for name, value in given.items():
        location = location_of(name)
        if location is not None:
            try:
                value = location.check(untracked(value))
                if isinstance(location, LocalSource):
                    location.start_with(value)  # what is behind it stays as it is
                    refresh.follow()
                else:
                    changes[location] = value
            except SourceChangeRefused as refusal:
                overrides.refuse(str(refusal))
    if changes:
        refresh.apply(changes)
        for location in changes:
            cast(Location, location).given = True


def _for_literals(parameters: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    return ((name, one) for name, one in list(parameters.items()) if name.startswith(PREFIX))


def _destroy_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
    if node in _owned:
        for forget in on_release:
            forget(node)
    try:
        return wrapped(*args, **kwargs)
    finally:
        release(node)


# ---------------------------------------------------------------- weaving

_points = JoinPoints()
os.register_at_fork(after_in_child=_forked)


def install() -> None:
    """Weaves the advice, once."""
    if _points:
        return
    for name, answer in _ANSWERS.items():
        _points.advise(Node, name, _by_name(answer))
    _points.advise(Node, "_set_parameters_atomically", _set_advice)
    _points.advise(Node, "declare_parameters", _declare_many_advice)
    _points.advise(Node, "__init__", _init_advice)
    _points.advise(Node, "destroy_node", _destroy_advice)
    _points.advise(ParameterService, "_list_parameters_callback", _list_advice)


def uninstall() -> None:
    """Takes the advice off again; parameters that are declared by then are gone."""
    _points.restore()
    for node in list(_owned):
        release(node)
