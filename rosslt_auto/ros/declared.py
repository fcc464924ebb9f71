"""Parameters that a node declares itself are sources too.

Wherever the program reads one - `get_parameter`, `declare_parameter`, a set-parameters callback -
it gets a leaf of the expression graph. When the parameter is set, what was computed from it
follows if the program read it only once (design 3.2). What it reads again and again takes effect
at the next reading, and what its callbacks are handed is the program's own business: neither
changes what the program has kept of earlier values.

Join points: `rclpy.node.Node` where it stores parameters, and where a program reads them.
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Mapping
from sys import _getframe
from typing import Any, cast

from rclpy.node import Node
from rclpy.parameter import Parameter

from rosslt_auto.provenance import refresh
from rosslt_auto.provenance.joinpoints import JoinPoints
from rosslt_auto.provenance.sources import Source, SourceChangeRefused
from rosslt_auto.provenance.values import leaf, untracked

_KINDS = {
    Parameter.Type.DOUBLE: "float",
    Parameter.Type.INTEGER: "int",
    Parameter.Type.STRING: "str",
}

_sources: weakref.WeakKeyDictionary[Any, dict[str, ParameterSource]] = weakref.WeakKeyDictionary()


class ParameterSource(Source):
    """A parameter of a node of this process, declared by its program.

    declared_by  gives the node, None once it is gone
    handed       the same parameter as the node's callbacks are handed it: never followed
    """

    declared_by: Callable[[], Any]

    def __init__(self, node: Any, name: str, kind: str, value: Any, handed: bool = False) -> None:
        super().__init__(None, name, kind)
        self.declared_by = weakref.ref(node)
        self.handed = self if handed else ParameterSource(node, name, kind, value, handed=True)
        self.repeated = handed
        self._sites: set[tuple[Any, int]] = set()
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

    def read_at(self, site: tuple[Any, int]) -> None:
        """Notes from where the program reads it: twice from one place is again and again."""
        if site in self._sites:
            self.repeated = True
            self._sites.clear()
        else:
            self._sites.add(site)


# ---------------------------------------------------------------- storing


def _store_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
    """Around the one method through which every value of a declared parameter goes."""
    requested = [one for one in (args[0] if args else kwargs["parameter_list"]) if _is_number(one)]
    if not requested:
        return wrapped(*args, **kwargs)
    known = _sources.setdefault(node, {})
    sources = [_track(node, known, parameter) for parameter in requested]
    result = wrapped(*args, **kwargs)
    if result.successful:
        _follow(known, dict(zip(requested, sources, strict=True)))
    return result


def _is_number(parameter: Any) -> bool:
    kind = _KINDS.get(parameter.type_)
    # What rclpy reads itself goes to C: plain.
    return (
        kind is not None
        and type(untracked(parameter.value)).__name__ == kind
        and not parameter.name.startswith("qos_overrides.")
    )


def _track(node: Any, known: dict[str, ParameterSource], parameter: Any) -> ParameterSource:
    """Makes the value of a Parameter object what the node's callbacks are to see."""
    kind = _KINDS[parameter.type_]
    value = untracked(parameter.value)
    source = known.get(parameter.name)
    if source is None or source.kind != kind or parameter.name not in node._parameters:
        source = ParameterSource(node, parameter.name, kind, value)
    handed = source.handed
    # Until the value is accepted the source has the old one.
    parameter._value = handed.leaf if handed.value == value else leaf(handed, value)
    return source


def _follow(known: dict[str, ParameterSource], accepted: dict[Any, ParameterSource]) -> None:
    """After parameters were stored: what was computed from their old values follows."""
    changes: dict[ParameterSource, Any] = {}
    for parameter, source in accepted.items():
        known[parameter.name] = source
        source.handed.leaf = parameter._value  # what the callbacks have got is current
        value = untracked(parameter._value)
        if source.value != value:
            changes[source] = value
    if changes:
        try:
            refresh.apply(cast(Mapping[Source, Any], changes))
        except SourceChangeRefused:  # NaN or an infinity, which the node has accepted
            for source, value in changes.items():
                source.change(value)
    for parameter, source in accepted.items():
        parameter._value = source.leaf


# ---------------------------------------------------------------- reading


def _read_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
    known = _sources.get(node)
    if known:
        source = known.get(args[0] if args else kwargs.get("name", ""))
        if source is not None and not source.repeated:
            _note([source], _getframe(1))
    return wrapped(*args, **kwargs)


def _read_many_advice(wrapped: Any, node: Any, args: Any, kwargs: Any) -> Any:
    _note(list(_sources.get(node, {}).values()), _getframe(1))
    return wrapped(*args, **kwargs)


_NODE = Node.__init__.__code__.co_filename
_RCLPY = os.path.join(os.path.dirname(_NODE), "")
_READERS = frozenset({"get_parameters", "<listcomp>"})


def _note(sources: list[ParameterSource], caller: Any) -> None:
    """Notes from where the program reads; what rclpy looks up for itself does not count."""
    while caller.f_code.co_filename == _NODE and caller.f_code.co_name in _READERS:
        caller = caller.f_back
    if caller.f_code.co_filename.startswith(_RCLPY):
        return
    for source in sources:
        if not source.repeated:
            source.read_at((caller.f_code, caller.f_lasti))


# ---------------------------------------------------------------- weaving

_points = JoinPoints()


def install() -> None:
    """Weaves the advice, once."""
    if not _points:
        _points.advise(Node, "_set_parameters_atomically_common", _store_advice)
        _points.advise(Node, "get_parameter", _read_advice)
        _points.advise(Node, "get_parameter_or", _read_advice)
        _points.advise(Node, "get_parameters_by_prefix", _read_many_advice)


def uninstall() -> None:
    """Takes the advice off again."""
    _points.restore()
