"""What a changed source does to values that were computed before (design 3.2).

A value computed from a literal that is executed once - a module constant, an attribute set in
``__init__`` - follows the literal; what a literal that is executed again and again has
contributed stays, and so does what has been accumulated. Nothing is ever re-evaluated before
the first change.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from typing import Any

from . import bindings
from .accumulation import held_operands
from .expressions import is_leaf, operands, topological
from .external import change_all
from .locations import Location, source_of
from .sources import Source
from .values import is_tracked, record, untracked

any_change = False
"""Whether any source of this process has been changed yet."""

_log = logging.getLogger(__name__)


def apply(changes: Mapping[Source, Any]) -> None:
    """Changes sources of this process, all or none, and everything still bound to their values.

    changes  plain values by source
    Raises SourceChangeRefused, nothing changed, if one cannot be.
    """
    checked = {source: source.check(value) for source, value in changes.items()}
    truths = [one for source, value in checked.items() for one in _rebindings(source, value)]
    change_all(checked)
    follow(truths)


def follow(truths: Sequence[bindings.Rebinding] = ()) -> None:
    """Lets everything that is bound to a value follow sources that have been changed already."""
    global any_change
    any_change = True
    bindings.replace_everywhere(refreshed, truths)


def _rebindings(source: Source, value: Any) -> list[bindings.Rebinding]:
    """What is bound to a truth value that stands in the program, if that is executed once."""
    if source.kind != "bool" or not isinstance(source, Location) or source.repeated:
        return []
    bound = source.literals.bound(source.index)
    old: bool = source.value
    if bound is None or old is value:
        return []
    return [bindings.Rebinding(source.literals.module, *bound, old, value)]


def refreshed(value: Any) -> Any:
    """`value` as current values of its sources make it; the same object if they change nothing."""
    if not is_tracked(value):
        return value
    core = getattr(value, "_core", value)
    if core is not value:  # a scalar of numpy
        new = refreshed(core)
        return value if new is core else value._like(new)
    order = topological([value])
    stale = {id(node) for node in order if is_leaf(node) and _is_stale(node)}
    if not stale:
        return value
    try:
        result = _rebuilt(value, order, stale)
    except (ArithmeticError, ValueError, TypeError) as error:
        _log.debug("a value stays as it is, its expression has no result now: %s", error)
        return value
    return result if type(untracked(result)) is type(value._v) else value


def _is_stale(leaf: Any) -> bool:
    current = source_of(leaf).leaf
    return current is not None and current is not leaf


def _rebuilt(value: Any, order: list[Any], stale: set[int]) -> Any:
    """`value` with the stale leaves replaced where it follows them, by constants where not."""
    held = held_operands(value)
    live: dict[int, Any] = {}
    kept: dict[int, Any] = {}
    for node in order:
        key = id(node)
        if is_leaf(node):
            source = source_of(node)
            kept[key] = node._v if key in stale else node
            live[key] = source.leaf if key in stale and not source.repeated else kept[key]
            continue
        below = operands(node)
        kept[key] = _kept(node, [kept.get(id(o), o) for o in below], below)
        live[key] = _live(
            node,
            [kept.get(id(o), o) if (key, i) in held else live.get(id(o), o)
             for i, o in enumerate(below)],
            below,
        )  # fmt: skip
    return live[id(value)]


def _kept(node: Any, now: list[Any], before: tuple[Any, ...]) -> Any:
    """The same value with constants for what it no longer follows."""
    if all(a is b for a, b in zip(now, before, strict=True)):
        return node
    return record(node._op, node._v, *now)


def _live(node: Any, now: list[Any], before: tuple[Any, ...]) -> Any:
    if all(a is b for a, b in zip(now, before, strict=True)):
        return node
    if all(untracked(a) is untracked(b) for a, b in zip(now, before, strict=True)):
        return record(node._op, node._v, *now)
    return record(node._op, node._op.forward(*map(untracked, now)), *now)


__all__ = ["any_change", "apply", "follow", "refreshed"]
