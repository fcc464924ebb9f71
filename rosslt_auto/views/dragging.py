"""What a drag means: the fields under a handle are forced to where it is dragged (Section V).

A drag keeps to the sources that it began with. A message that is computed from others - the next
waypoint has come - does not make it change those instead; it goes on with the last message that
knew them.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from rosslt_auto.provenance.expressions import evaluate_many, source_values, sources
from rosslt_auto.provenance.inversion import NotInvertible, invert_many, reached, solve_for
from rosslt_auto.provenance.sources import Source, SourceChangeRefused
from rosslt_auto.provenance.values import untracked

from .handles import Targets
from .scene import Item, Tracked
from .shapes import joined

INTERVAL = 0.02
"""Seconds between two changes of a drag; what is dragged in between is passed over."""


_DIGITS = (3, 4, 5, 7)
_CLOSE = 1e-3
"""Digits that are tried for what a drag adds, and which part of its way they may be wrong by."""


@dataclass(frozen=True)
class Changed:
    """A source that a drag changes."""

    source: Source
    old: Any
    new: Any


@dataclass
class Choice:
    """How sources are chosen for the fields of one message.

    policy   see `provenance.inversion.invert_many`
    sources  by path: the source that is to be changed for that field
    """

    policy: str = "left"
    sources: dict[str, Source] = field(default_factory=dict)


class Choices:
    """What people have chosen: one policy for all, sources for fields of single items.

    A field is known by its item (topic, for markers namespace and id too) and its path in there:
    where in its message a marker stands may change.
    """

    def __init__(self) -> None:
        self.policy = "left"
        self._sources: dict[tuple[str, str], Source] = {}

    def of(self, item: Item) -> Choice:
        """The choice for a drag of this item."""
        return Choice(
            self.policy,
            {
                joined(item.root, path): source
                for (key, path), source in list(self._sources.items())
                if key == item.key
            },
        )

    def choose(self, item: Item, path: str, source: Source | None) -> None:
        """The source for a field of an item, by its path in the message; None: the policy's."""
        field_of_item = (item.key, item.within(path))
        if source is None:
            self._sources.pop(field_of_item, None)
        else:
            self._sources[field_of_item] = source


class Refused(Exception):
    """A drag that cannot be followed; the message says why. Nothing has been changed."""


def solve(tracked: Tracked, targets: Targets, choice: Choice) -> list[Changed]:
    """What has to be changed so that the fields become the targets; raises Refused.

    Discrete sources are moved to the nearest value that they can have.
    """
    wanted = [(tracked.fields[path], target) for path, target in targets.items()
              if path in tracked.fields]  # fmt: skip
    if not wanted:
        raise Refused("it has no provenance any more")
    try:
        changes = _solution(tracked, targets, choice)
        values = dict(_values(tracked))
        return [Changed(s, values[s], s.check(new)) for s, new in changes.items()]
    except (NotInvertible, SourceChangeRefused) as reason:
        raise Refused(str(reason)) from None


def _solution(tracked: Tracked, targets: Targets, choice: Choice) -> dict[Source, Any]:
    """Chosen sources first, each for its field; the policy finds the others."""
    changes: dict[Source, Any] = {}
    open_targets = []
    for path, target in targets.items():
        value = tracked.fields.get(path)
        if value is None or reached(untracked(value), target):
            continue
        chosen = choice.sources.get(path)
        source = next((s for s in sources(value) if s == chosen), None)
        if source is None:
            open_targets.append((value, target))
        elif source not in changes:
            changes.update(solve_for(value, target, source).changes)
    if open_targets and changes:
        # Those that the chosen sources have moved there already need no more.
        now = evaluate_many([value for value, _ in open_targets], changes)
        open_targets = [
            one for one, value in zip(open_targets, now, strict=True) if not reached(value, one[1])
        ]
    if open_targets:
        found = invert_many(open_targets, policy=choice.policy).changes
        changes = {**found, **changes}
    return changes


def _values(tracked: Tracked) -> Mapping[Source, Any]:
    return source_values(*tracked.fields.values())


class Drag:
    """One drag from grab to release: from where a handle is, to changes of sources.

    changed  all sources that it has changed: the values before the drag, and now
    """

    def __init__(self, tracked: Tracked, choice: Choice) -> None:
        self._tracked = tracked
        self._choice = Choice(choice.policy, dict(choice.sources))
        self._policy_open = choice.policy != "left"
        self._began: dict[str, Any] = {}
        self.changed: dict[Source, Changed] = {}

    def to(self, latest: Tracked | None, targets: Targets) -> list[Changed]:
        """What has to be changed now; raises Refused.

        latest  the last message, None if there is none any more
        """
        for path in targets:
            self._began.setdefault(path, untracked(self._tracked.fields.get(path)))
        if latest is not None and self._knows(latest, targets):
            self._tracked = latest
        found = solve(self._tracked, targets, self._choice)
        self._keep_to(found, targets)
        return self._written_short(found, targets)

    def _written_short(self, changes: list[Changed], targets: Targets) -> list[Changed]:
        """The same with no more digits than the hand that drags can mean; they are read and saved.

        Taken are the fewest with which the fields get as far as they are dragged, all but a
        thousandth of the way.
        """
        values = [self._tracked.fields[path] for path in targets if path in self._tracked.fields]
        began = [self._began[path] for path in targets if path in self._tracked.fields]
        wanted = evaluate_many(values, {one.source: one.new for one in changes})
        for digits in _DIGITS:
            short = [self._short(one, digits) for one in changes]
            with suppress(ArithmeticError, ValueError):
                there = evaluate_many(values, {one.source: one.new for one in short})
                if all(
                    abs(value - want) <= _CLOSE * abs(want - start)
                    for value, want, start in zip(there, wanted, began, strict=True)
                ):
                    return short
        return changes

    def _short(self, change: Changed, digits: int) -> Changed:
        """With so many digits of what the drag has added to the value."""
        before = self.changed.get(change.source, change).old
        if type(change.new) is not float or change.new == before:
            return change
        places = digits - 1 - math.floor(math.log10(abs(change.new - before)))
        try:
            return replace(change, new=change.source.check(round(change.new, places)))
        except SourceChangeRefused:  # out of its range by that
            return change

    def made(self, changes: Sequence[Changed]) -> None:
        """Notes that these changes have been made."""
        for one in changes:
            before = self.changed.get(one.source)
            old = one.old if before is None else before.old
            self.changed[one.source] = Changed(one.source, old, one.new)

    def _knows(self, tracked: Tracked, targets: Targets) -> bool:
        """Whether the fields of this message come from what the drag has been changing."""
        for path in targets:
            value = tracked.fields.get(path)
            if value is None:
                return False
            kept = self._choice.sources.get(path)
            if kept is not None and kept not in sources(value):
                return False
        return True

    def _keep_to(self, changes: Sequence[Changed], targets: Targets) -> None:
        if self._policy_open:
            return
        changed = {one.source for one in changes}
        for path in targets:
            value = self._tracked.fields.get(path)
            if value is None or path in self._choice.sources:
                continue
            source = next((s for s in sources(value) if s in changed), None)
            if source is not None:
                self._choice.sources[path] = source


class Dragger:
    """Follows one drag in a thread of its own: the last target wins, the very last one is reached.

    drag     the drag; latest: gives the last message
    apply    makes changes; raises an exception whose text is the reason
    report   is told the reason when something is refused, and "" when it goes on
    """

    def __init__(
        self,
        drag: Drag,
        latest: Callable[[], Tracked | None],
        apply: Callable[[Sequence[Changed]], None],
        report: Callable[[str], None] = lambda reason: None,
        interval: float = INTERVAL,
    ) -> None:
        self.drag = drag
        self._latest = latest
        self._apply = apply
        self._report = report
        self._interval = interval
        self._wanted: Targets | None = None
        self._released = False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._follow, name="drag", daemon=True)
        self._thread.start()

    def to(self, targets: Targets) -> None:
        """The handle has been dragged there. Returns at once."""
        with self._news:
            self._wanted = targets
            self._news.notify()

    def release(self, timeout: float | None = None) -> None:
        """The handle has been let go; returns when the last target has been dealt with."""
        with self._news:
            self._released = True
            self._news.notify()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout)

    def _follow(self) -> None:
        while True:
            with self._news:
                while self._wanted is None and not self._released:
                    self._news.wait()
                targets, self._wanted = self._wanted, None
                if targets is None:
                    return
                if not targets:
                    continue
            began = time.monotonic()
            self._step(targets)
            with self._news:
                left = began + self._interval - time.monotonic()
                while left > 0 and not self._released:
                    self._news.wait(left)
                    left = began + self._interval - time.monotonic()

    def _step(self, targets: Targets) -> None:
        try:
            changes = self.drag.to(self._latest(), targets)
            if changes:
                self._apply(changes)
                self.drag.made(changes)
        except Exception as reason:  # whatever it is, the next step may succeed
            self._report(str(reason) or type(reason).__name__)
        else:
            self._report("")
