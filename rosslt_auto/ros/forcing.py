"""`force_value` of the paper (Section IV-A): fields of a topic's next messages get wanted values.

The arithmetic behind the fields is inverted, the sources are changed in the nodes that own them,
and the next messages have to show it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rosslt_auto.provenance.expressions import evaluate, source_values, topological
from rosslt_auto.provenance.folding import APPROXIMATE
from rosslt_auto.provenance.inversion import (
    POLICIES,
    NotInvertible,
    alternatives,
    invert_many,
    reached,
    rounding,
)
from rosslt_auto.provenance.sources import Source, SourceChangeRefused
from rosslt_auto.provenance.values import untracked

from . import journal, paths
from .client import Change, ChangeRefused, NoAnswer, change_of
from .observer import HEADER_SUFFIX, Observer, TopicSubscription, TrackedMessage

NO_HEADERS = 0.5
"""Seconds after the first message when a topic without headers counts as untracked."""

_PREPARED = 16


class CannotForce(Exception):
    """A field cannot be forced; the message says why. Nothing has been changed."""


@dataclass
class Forced:
    """What has come out of a `force`.

    fields   by path: the target, the value in the last message that was looked at, and "moving"
             if the field moves by itself: the forced message would have had the target
    changes  what was changed, or would be in a dry run
    reason   why it was not reached, else None
    alternatives  in a dry run by path: what each single source could do, or why it cannot
    policies      in a dry run by policy: the changes that it would make, or why there are none
    """

    topic: str
    dry_run: bool = False
    reached: bool = False
    fields: dict[str, dict[str, Any]] = field(default_factory=dict)
    changes: list[Change] = field(default_factory=list)
    reason: str | None = None
    alternatives: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    policies: dict[str, dict[str, Any]] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """The document of contract.md."""
        document: dict[str, Any] = {
            "topic": self.topic,
            "reached": self.reached,
            "fields": self.fields,
            "changes": [change.to_json() for change in self.changes],
        }
        if self.dry_run:
            document["dry_run"] = True
            document["alternatives"] = self.alternatives
            document["policies"] = self.policies
        if self.reason is not None:
            document["reason"] = self.reason
        return document


@dataclass
class Wanted:
    """A field and its target, as the field's type holds it."""

    path: str
    kind: str
    target: Any

    def shown_by(self, value: Any, before: Any) -> bool:
        """Whether a received value is the target.

        before  the tracked value that was forced: how exactly such a value is computed
        """
        tolerance, finest = 1e-9, rounding(before)
        if self.kind == "float":  # of a message: 32 bits
            tolerance, finest = 1e-6, finest * 2**29
        return reached(untracked(value), self.target, tolerance, finest)


def force(
    observer: Observer,
    topic: str,
    targets: Mapping[str, Any],
    policy: str = "left",
    source: str | None = None,
    dry_run: bool = False,
    timeout: float = 5.0,
) -> Forced:
    """Makes fields of the next messages have the target values, together.

    targets  by path: texts, parsed as the field's type, or numbers
    policy   see `provenance.inversion.invert`; source: the only parameter that may be changed
    timeout  seconds for the first message, and again for the one that shows the targets
    Raises CannotObserve, CannotForce, ChangeRefused, NoAnswer: then nothing has been changed.
    """
    deadline = time.monotonic() + timeout
    subscription = observer.subscribe(topic, deadline=deadline)
    if not dry_run:  # matched while the first message is on its way
        observer.parameters.prepare(sorted(observer.nodes_with_locations())[:_PREPARED])
    try:
        wanted = wanted_fields(subscription.message_type, targets)
        message = _first_tracked(observer, subscription, wanted, deadline)
        result = Forced(subscription.topic, dry_run=dry_run)
        result.fields = {
            one.path: {"target": one.target, "value": untracked(message.fields[one.path])}
            for one in wanted
        }
        if dry_run:
            return _tell(result, message, wanted, policy, source)
        solution = solve(message, wanted, policy, source)
        result.changes = changes_for(message, solution)
        observer.parameters.set(result.changes, timeout)
        journal.add(result.changes)
        _verify(subscription, wanted, message, solution, result, timeout)
        return result
    finally:
        observer.unsubscribe(subscription)


def undo(observer: Observer, timeout: float = 5.0) -> tuple[list[Change], list[str]]:
    """Takes the latest `force` of this domain back: its sources get their old values again.

    Returns what was changed back, and for each source that was left alone, in words, why: its node
    has ended since, or somebody else has changed it. Both are empty if nothing was forced.
    Raises ChangeRefused, NoAnswer: then nothing has been changed.
    """
    forced = journal.last()
    if not forced:
        return [], []
    now = _current(observer, forced, timeout)
    back = [Change(c.node, c.parameter, c.new, c.old) for c in forced if now.get(c) == c.new]
    observer.parameters.set(back, timeout)
    journal.drop_last()
    return back, [_left(c, now) for c in forced if now.get(c) != c.new]


def _current(observer: Observer, forced: list[Change], timeout: float) -> dict[Change, Any]:
    """The values that forced sources have now; nothing for those of nodes that are not there."""
    found: dict[Change, Any] = {}
    for node in dict.fromkeys(change.node for change in forced):
        changes = [change for change in forced if change.node == node]
        try:
            values = observer.parameters.get(node, [c.parameter for c in changes], timeout)
        except NoAnswer:
            if observer.knows_node(node):
                raise
            continue
        found.update(zip(changes, values, strict=True))
    return found


def _left(change: Change, now: Mapping[Change, Any]) -> str:
    """Why a change is not taken back."""
    what = f"{change.parameter} of {change.node}, forced from {change.old!r} to {change.new!r},"
    if change not in now:
        return f"{what} has ended with its node"
    value = now[change]
    if value is None:
        return f"{what} is not there any more: the node has been started anew"
    return f"{what} is {value!r} now: the node has been started anew, or somebody else has set it"


def _tell(
    result: Forced, message: TrackedMessage, wanted: list[Wanted], policy: str, source: str | None
) -> Forced:
    """The result of a dry run: what would change, and what else could, also where nothing can."""
    try:
        result.changes = changes_for(message, solve(message, wanted, policy, source))
    except CannotForce as refusal:
        result.reason = str(refusal)
    result.alternatives = {
        one.path: _alternatives(message.fields[one.path], one.target) for one in wanted
    }
    result.policies = {name: _by_policy(message, wanted, name) for name in POLICIES}
    return result


def _alternatives(value: Any, target: Any) -> list[dict[str, Any]]:
    """For each source, left bias first: the value with which it alone gives the target."""
    found = []
    now = source_values(value)
    for source, answer in alternatives(value, target):
        entry: dict[str, Any] = {"node": source.node, "parameter": source.parameter}
        if isinstance(answer, NotInvertible):
            entry["reason"] = str(answer)
        else:
            entry["new"] = answer.changes.get(source, now[source])
        found.append(entry)
    return found


def _by_policy(message: TrackedMessage, wanted: list[Wanted], policy: str) -> dict[str, Any]:
    """What all targets together come to under a policy."""
    try:
        changes = changes_for(message, solve(message, wanted, policy))
    except CannotForce as refusal:
        return {"reason": str(refusal)}
    return {"changes": [change.to_json() for change in changes]}


def wanted_fields(message_type: Any, targets: Mapping[str, Any]) -> list[Wanted]:
    """The targets as the fields' types hold them; raises CannotForce."""
    wanted = []
    try:
        for path, text in targets.items():
            path = paths.normal(path)
            kind = paths.field_type(message_type, path)
            wanted.append(Wanted(path, kind, paths.parse(kind, path, text)))
    except paths.FieldError as error:
        raise CannotForce(str(error)) from None
    return wanted


def _first_tracked(
    observer: Observer, subscription: TopicSubscription, wanted: list[Wanted], deadline: float
) -> TrackedMessage:
    """The first message in which all wanted fields have provenance."""
    topic = subscription.topic
    first_at = None
    while True:
        try:
            message = subscription.next(deadline)
        except NoAnswer:
            if first_at is None:
                raise
            raise CannotForce(_untracked(observer, topic, wanted[0].path)) from None
        for one in wanted:
            try:
                paths.get(message.message, one.path)
            except paths.FieldError as error:
                raise CannotForce(str(error)) from None
        missing = [one.path for one in wanted if one.path not in message.fields]
        if not missing:
            return message
        first_at = first_at or time.monotonic()
        if message.fields:
            raise CannotForce(f"{missing[0]} has no provenance: no literal or parameter is in it")
        if time.monotonic() - first_at > NO_HEADERS and not observer.has_headers(topic):
            raise CannotForce(_untracked(observer, topic, missing[0]))


def _untracked(observer: Observer, topic: str, path: str) -> str:
    if observer.has_headers(topic):
        return f"{path} has no provenance in the messages on {topic}"
    return (
        f"{topic} has no provenance: nobody publishes {topic + HEADER_SUFFIX}; "
        "start the node with `python -m rosslt_auto run`"
    )


def solve(
    message: TrackedMessage, wanted: list[Wanted], policy: str = "left", source: str | None = None
) -> dict[Source, Any]:
    """New values of sources that give all fields their targets together; raises CannotForce."""
    values = [message.fields[one.path] for one in wanted]
    if source is None and all(map(Wanted.shown_by, wanted, values, values)):
        return {}
    try:
        found = invert_many([(v, one.target) for v, one in zip(values, wanted, strict=True)],
                            policy=policy, source=source)  # fmt: skip
    except NotInvertible as refusal:
        names, reason = ", ".join(one.path for one in wanted), str(refusal)
        joint = " is " if len(wanted) == 1 and reason.startswith("limited to ") else ": "
        raise CannotForce(f"{names}{joint}{reason}") from None
    if not found.exact:
        raise CannotForce(_nearest(wanted, found.values))
    return found.changes


def _nearest(wanted: list[Wanted], values: list[Any]) -> str:
    """Why a discrete source is not set to what comes nearest; that takes another target."""
    found = "; ".join(
        f"{one.path} cannot become {one.target!r}, the nearest that can be reached is {value!r}"
        for one, value in zip(wanted, values, strict=True)
    )
    pairs = zip(wanted, values, strict=True)
    return f"{found}: force {' '.join(f'{one.path}={value!r}' for one, value in pairs)} for that"


def changes_for(message: TrackedMessage, solution: Mapping[Source, Any]) -> list[Change]:
    """What a solution changes, with the old values that the message tells; raises CannotForce."""
    old = source_values(*message.fields.values())
    try:
        return [
            change_of(source, old[source], source.check(new))
            for source, new in solution.items()
            if new != old[source]
        ]
    except (ChangeRefused, SourceChangeRefused) as refusal:
        raise CannotForce(str(refusal)) from None


def _verify(
    subscription: TopicSubscription,
    wanted: list[Wanted],
    forced: TrackedMessage,
    solution: Mapping[Source, Any],
    result: Forced,
    timeout: float,
) -> None:
    """Waits for the message that shows the targets; tells what came instead."""
    deadline = time.monotonic() + timeout
    seen = 0
    why = ""
    motions = [_Motion(one, forced, solution) for one in wanted]
    while True:
        try:
            message = subscription.next(deadline)
        except NoAnswer:
            result.reason = _not_shown(result, seen, why)
            return
        seen += 1
        moved = [motion.seen_in(message) for motion in motions]
        for one, moves in zip(wanted, moved, strict=True):
            try:
                value = paths.get(message.message, one.path)
            except paths.FieldError:  # a sequence has become shorter
                break
            result.fields[one.path]["value"] = untracked(value)
            if one.shown_by(value, forced.fields[one.path]):
                continue
            if not moves or not _carries_change(one, message, forced, solution):
                why = _explanation(one, message, forced, solution)
                break
            result.fields[one.path]["moving"] = True
        else:
            result.reached = True
            return


class _Motion:
    """Whether a field moves by itself: it differs while the sources to be changed do not.

    A program that has taken another path shows another value once, and then that again.
    """

    def __init__(self, one: Wanted, forced: TrackedMessage, solution: Mapping[Source, Any]) -> None:
        self._path = one.path
        self._sources = list(solution)
        self._last: dict[tuple[Any, ...], Any] = {}
        self._moves = False
        self.seen_in(forced)

    def seen_in(self, message: TrackedMessage) -> bool:
        """Whether it has moved up to this message."""
        value = message.fields.get(self._path)
        if value is not None:
            now = source_values(value)
            state = tuple(now.get(source) for source in self._sources)
            plain = untracked(value)
            self._moves |= self._last.setdefault(state, plain) != plain
        return self._moves


def _carries_change(
    one: Wanted, message: TrackedMessage, forced: TrackedMessage, solution: Mapping[Source, Any]
) -> bool:
    """Whether a field that moves by itself carries the change.

    Then its message was computed from the new values of the sources, and would differ from the
    forced one without them too. That the forced one's expression gives the target with them has
    been checked.
    """
    value = message.fields.get(one.path)
    if value is None or _is_approximate(forced.fields[one.path]):
        return False
    now = source_values(value)
    concerned = {s: new for s, new in solution.items() if s in now}
    if not concerned or any(now[source] != new for source, new in concerned.items()):
        return False
    before = forced.fields[one.path]
    old = source_values(before)
    try:
        by_itself = evaluate(value, {s: old[s] for s in concerned if s in old})
    except (ArithmeticError, ValueError):
        return False
    return not reached(by_itself, untracked(before), finest=rounding(before))


def _is_approximate(value: Any) -> bool:
    """Whether part of the history was replaced by its first-order form (`folding`)."""
    return any(node._op in APPROXIMATE for node in topological([value]))


def _explanation(
    one: Wanted, message: TrackedMessage, forced: TrackedMessage, solution: Mapping[Source, Any]
) -> str:
    """Why a message does not show a target, as far as its own expression tells."""
    if _is_approximate(forced.fields[one.path]):
        return f"the long history of {one.path} is known to first order only"
    value = message.fields.get(one.path)
    now = source_values(value) if value is not None else {}
    if any(source in now and now[source] != new for source, new in solution.items()):
        return f"{one.path} is still computed from the old values"
    return "with the new values the program took another path"


UNDO = "`python -m rosslt_auto force --undo` restores the old values"


def _not_shown(result: Forced, seen: int, why: str) -> str:
    """One line: what is there instead, why, and how to get back to where it was."""
    topic = result.topic
    if not seen:
        found = f"changed, but no message on {topic} in time"
    else:
        shown = ", ".join(f"{path} is {entry['value']!r}" for path, entry in result.fields.items())
        found = f"changed, but no message on {topic} shows it: {shown}"
    return "; ".join(filter(None, [found, why, UNDO if result.changes else ""]))
