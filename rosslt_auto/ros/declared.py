"""Parameters that a node declares itself are sources too.

Wherever the program reads one - `get_parameter`, `declare_parameter`, a set-parameters callback -
it gets a leaf of the expression graph. What it has computed from it follows when the parameter
is set, also where the program read it only once (design 3.2).

Join points: `rclpy.node.Node` where it stores parameters.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter

from rosslt_auto.provenance import refresh
from rosslt_auto.provenance.locations import Source, SourceChangeRefused
from rosslt_auto.provenance.values import leaf, untracked

from .joinpoints import JoinPoints

_KINDS = {Parameter.Type.DOUBLE: "float", Parameter.Type.INTEGER: "int"}

_sources: weakref.WeakKeyDictionary[Any, dict[str, ParameterSource]] = weakref.WeakKeyDictionary()


class ParameterSource(Source):
    """A parameter of a node of this process, declared by its program.

    declared_by  gives the node, None once it is gone
    """

    declared_by: Callable[[], Any]

    def __init__(self, node: Any, name: str, kind: str, value: Any) -> None:
        super().__init__(None, name, kind)
        self.declared_by = weakref.ref(node)
        self.change(value)

    # One parameter, one object; `node` is filled in later.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def change(self, value: Any) -> None:
        """The value that the node has stored."""
        self.leaf = leaf(self, value)

    @property
    def value(self) -> Any:
        return self.leaf._v


def source_of(node: Any, name: str) -> ParameterSource | None:
    """The source for a parameter that a node of this process has declared, if it is a number."""
    return _sources.get(node, {}).get(name)


def _store_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
    """Around the one method through which every value of a declared parameter goes."""
    requested = [one for one in (args[0] if args else kwargs["parameter_list"]) if _is_number(one)]
    if not requested:
        return wrapped(*args, **kwargs)
    known = _sources.setdefault(node, {})
    for parameter in requested:
        _track(node, known, parameter)
    result = wrapped(*args, **kwargs)
    if result.successful:
        _follow(node, known, requested)
    return result


def _is_number(parameter: Any) -> bool:
    kind = _KINDS.get(parameter.type_)
    # What rclpy reads itself goes to C: plain.
    return (
        kind is not None
        and type(untracked(parameter.value)).__name__ == kind
        and not parameter.name.startswith("qos_overrides.")
    )


def _track(node: Any, known: dict[str, ParameterSource], parameter: Any) -> None:
    """Makes the value of a Parameter object a leaf of its source."""
    kind = _KINDS[parameter.type_]
    value = untracked(parameter.value)
    source = known.get(parameter.name)
    if source is None or source.kind != kind or parameter.name not in node._parameters:
        source = ParameterSource(node, parameter.name, kind, value)
    # A new leaf: until the value is accepted the source has the old one.
    parameter._value = source.leaf if source.value == value else leaf(source, value)


def _follow(node: Any, known: dict[str, ParameterSource], parameters: Iterable[Any]) -> None:
    """After parameters were set: everything computed from their old values follows."""
    changes = {}
    for parameter in parameters:
        source = parameter._value._a
        known[parameter.name] = source
        if source.value != untracked(parameter._value):
            changes[source] = untracked(parameter._value)
    if not changes:
        return
    try:
        refresh.apply(changes)
    except SourceChangeRefused:  # NaN or an infinity, which the node has accepted
        for source, value in changes.items():
            source.change(value)
    for parameter in parameters:
        parameter._value = known[parameter.name].leaf


_points = JoinPoints()


def install() -> None:
    """Weaves the advice, once."""
    if not _points:
        _points.advise(Node, "_set_parameters_atomically_common", _store_advice)


def uninstall() -> None:
    """Takes the advice off again."""
    _points.restore()
