"""The paper's operations for programs (Section IV-A): `force_value` and `reevaluate`.

Sources of this process are read where they are; those of other nodes are asked for and changed
through their parameters, by a hidden node with a thread of its own, so that a callback may wait.
"""

from __future__ import annotations

import atexit
import copy
import threading
from collections.abc import Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from rosslt_auto.provenance.expressions import is_leaf, operands, topological
from rosslt_auto.provenance.inversion import invert_many
from rosslt_auto.provenance.locations import source_of
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.values import is_tracked, leaf, record, untracked

if TYPE_CHECKING:
    from .client import Change
    from .observer import Observer

TIMEOUT = 2.0
"""Seconds that other nodes have for an answer."""


def force_value(
    value: Any, target: Any, policy: str = "left", timeout: float = TIMEOUT
) -> Future[list[Change]]:
    """Changes sources so that a value, or fields of a message, become what is wanted.

    value   a tracked value and `target` a plain one; or a message and `target` {path: plain value}
    policy  how sources are chosen, see `provenance.inversion.invert_many`

    Returns a future of what was changed, a list of `Change` (node, parameter, old, new). Its
    exception is ChangeRefused or NoAnswer if a node did not do it; then nothing is changed.
    Raises NotInvertible, FieldError or ValueError at once if there is nothing to be changed.
    """
    targets = _targets(value, target)
    solution = invert_many(targets, policy)
    if not solution.exact:
        raise ValueError(f"the nearest that can be reached is {solution.values}")
    return _worker().submit(_change, [value for value, _ in targets], solution.changes, timeout)


def reevaluate(value_or_message: Any, timeout: float = TIMEOUT) -> Any:
    """What a value, or a message, would be with the current values of all its sources.

    Returns a value with the same provenance, or a copy of the message with such fields; the same
    object where nothing has changed. Raises NoAnswer if another node does not tell in time.
    """
    if is_tracked(value_or_message):
        return _reevaluated([value_or_message], timeout)[0]
    if not hasattr(value_or_message, "get_fields_and_field_types"):
        return value_or_message
    return _reevaluated_message(value_or_message, timeout)


# ---------------------------------------------------------------- forcing


def _targets(value: Any, target: Any) -> list[tuple[Any, Any]]:
    if not isinstance(target, Mapping):
        return [(value, untracked(target))]
    from . import paths
    from .fields import tracked_fields

    fields = tracked_fields(value)
    targets = []
    for path, wanted in target.items():
        path = paths.normal(path)
        kind = paths.field_type(type(value), path)
        if path not in fields:
            raise ValueError(f"{path} has no provenance")
        targets.append((fields[path], paths.parse(kind, path, untracked(wanted))))
    return targets


def _change(values: Iterable[Any], solution: Mapping[Source, Any], timeout: float) -> list[Change]:
    from .client import change_of

    old = {source_of(node): node._v for node in topological(values) if is_leaf(node)}
    changes = [change_of(source, old[source], new) for source, new in solution.items()]
    _observer().parameters.set(changes, timeout)
    return changes


# ---------------------------------------------------------------- reevaluating


def _reevaluated(values: list[Any], timeout: float) -> list[Any]:
    order = topological(values)
    sources = {source_of(node): node for node in order if is_leaf(node)}
    remote = [source for source in sources if source.leaf is None and source.node is not None]
    now = _remote_values(remote, timeout)
    built: dict[int, Any] = {}
    for node in order:
        built[id(node)] = _with_current(node, built, now)
    return [built.get(id(value), value) for value in values]


def _with_current(node: Any, built: Mapping[int, Any], now: Mapping[Source, Any]) -> Any:
    if is_leaf(node):
        source = source_of(node)
        if source.leaf is not None:
            return source.leaf
        if source not in now or now[source] == node._v:
            return node
        return leaf(source, now[source])
    before = operands(node)
    after = [built.get(id(operand), operand) for operand in before]
    if all(a is b for a, b in zip(after, before, strict=True)):
        return node
    return record(node._op, node._op.forward(*map(untracked, after)), *after)


def _reevaluated_message(message: Any, timeout: float) -> Any:
    from .fields import collect

    found = collect(message)
    values = [tracked.value for tracked in found]
    after = _reevaluated(values, timeout)
    if all(a is b for a, b in zip(after, values, strict=True)):
        return message
    copied = copy.deepcopy(message)
    for tracked, value in zip(collect(copied), after, strict=True):
        setattr(tracked.owner, tracked.slot, value)
    return copied


def _remote_values(sources: list[Source], timeout: float) -> dict[Source, Any]:
    if not sources:
        return {}
    by_node: dict[str, list[Source]] = {}
    for source in sources:
        by_node.setdefault(str(source.node), []).append(source)
    found: dict[Source, Any] = {}
    for node, wanted in by_node.items():
        names = [source.parameter for source in wanted]
        values = _observer().parameters.get(node, names, timeout)
        found |= {s: v for s, v in zip(wanted, values, strict=True) if type(v).__name__ == s.kind}
    return found


# ---------------------------------------------------------------- the hidden node

_lock = threading.Lock()
_shared: dict[str, Any] = {}


def _observer() -> Observer:
    with _lock:
        if "observer" not in _shared:
            from .observer import Observer

            _shared["observer"] = Observer("operations").__enter__()
            atexit.register(_end)
        return _shared["observer"]


def _worker() -> ThreadPoolExecutor:
    with _lock:
        if "worker" not in _shared:
            _shared["worker"] = ThreadPoolExecutor(1, thread_name_prefix="rosslt force")
        return _shared["worker"]


def _end() -> None:
    with _lock:
        observer = _shared.pop("observer", None)
    if observer is not None:
        observer.__exit__()
