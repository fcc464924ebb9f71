"""What can be dragged: exactly those axes whose fields have provenance that can be inverted.

Section V: partially tracked things get fewer handles, untracked ones none.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from rosslt_auto.provenance.expressions import sources
from rosslt_auto.provenance.inversion import NotInvertible, Solution, invert_many
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.values import untracked

from .geometry import Quaternion, Vector, about, inverse, nearer, product
from .scene import Item
from .shapes import Spot

AXES = "xyz"
_TURN_FIELDS = "wxyz"
_NUDGE = 1e-3
_TURN_NUDGE = 1e-2
_STILL = 1e-5

_KEEP = 1.0
"""Seconds that an answer is kept while expressions look alike; it depends on values too."""

Targets = dict[str, Any]
"""Wanted values by path."""


@dataclass(frozen=True)
class Handle:
    """A place that can be dragged.

    key      unique; item: the key of the item that it belongs to
    spot     where it is, and the fields that say so
    moves    the axes along which it can be moved, of "xyz", in the spot's frame
    turns    the axes about which it can be turned, of its own
    """

    key: str
    item: str
    topic: str
    spot: Spot
    moves: str
    turns: str

    @property
    def position(self) -> Vector:
        """Where it is in the fixed frame."""
        return self.spot.frame.out(self.spot.position)

    @property
    def rotation(self) -> Quaternion:
        """How it is turned in the fixed frame."""
        return product(self.spot.frame.rotation, self.spot.rotation)

    def paths(self) -> list[str]:
        """The fields that a drag may change."""
        found = [field_path(self.spot.path, axis) for axis in self.moves]
        if self.turns and self.spot.turn is not None:
            found += [field_path(self.spot.turn, name) for name in _TURN_FIELDS]
        return found

    def moved(self, position: Vector, axes: Iterable[str] = AXES) -> Targets:
        """The targets of a drag to a position in the fixed frame, of those axes that can move."""
        local = self.spot.frame.into(position)
        return {
            field_path(self.spot.path, axis): local[AXES.index(axis)]
            for axis in self.moves
            if axis in axes
        }

    def turned(self, rotation: Quaternion, fields: Mapping[str, Any]) -> Targets:
        """The targets of a turn: all tracked parts of the orientation, together.

        rotation  in the fixed frame
        """
        assert self.spot.turn is not None
        local = product(inverse(self.spot.frame.rotation), rotation)
        wanted = nearer(local, self.spot.rotation)
        targets = {}
        for name, value in zip(_TURN_FIELDS, wanted, strict=True):
            path = field_path(self.spot.turn, name)
            if path in fields:
                targets[path] = value
        # The parts that move most say most: where a cosine is flat, its inverse has two answers.
        now = dict(zip(_TURN_FIELDS, self.spot.rotation, strict=True))
        return dict(sorted(targets.items(), key=lambda one: -abs(one[1] - now[one[0][-1]])))


class Grip:
    """A handle that somebody holds: only the axes along which it has been dragged have targets.

    What moves by itself along another one meanwhile goes on doing so.

    position  where it was grabbed
    """

    def __init__(self, handle: Handle, position: Vector) -> None:
        self.handle = handle
        self._start = handle.spot.frame.into(position)
        self._axes: set[str] = set()

    def moved(self, position: Vector) -> Targets:
        """The targets of a drag to a position in the fixed frame."""
        local = self.handle.spot.frame.into(position)
        for axis, now, before in zip(AXES, local, self._start, strict=True):
            if abs(now - before) > _STILL:
                self._axes.add(axis)
        return self.handle.moved(position, self._axes)


def field_path(path: str, name: str) -> str:
    """The path of a part of what stands at `path`."""
    return f"{path}.{name}" if path else name


class Handles:
    """Finds the handles of items, and remembers them as long as the provenance stays alike.

    changeable  whether a source can be changed at all, as far as is known
    """

    MAX_POINTS = 300

    def __init__(self, changeable: Callable[[Source], bool] = lambda source: True) -> None:
        self._changeable = changeable
        self._known: dict[str, tuple[Any, float, str, str]] = {}

    def of(self, item: Item) -> list[Handle]:
        """The handles of an item, none where nothing in it can be changed."""
        fields = item.tracked.fields
        if not fields:
            return []
        found = []
        points = 0
        for spot in item.picture.spots:
            points += spot.is_point
            if points > self.MAX_POINTS:
                break
            key = f"{item.key}:{item.within(spot.path)}"
            moves, turns = self._freedom(key, spot, fields)
            if moves or turns:
                found.append(Handle(key, item.key, item.topic, spot, moves, turns))
        return found

    def _freedom(self, key: str, spot: Spot, fields: Mapping[str, Any]) -> tuple[str, str]:
        values = [fields.get(field_path(spot.path, axis)) for axis in AXES]
        if spot.turn is not None:
            values += [fields.get(field_path(spot.turn, name)) for name in _TURN_FIELDS]
        if all(value is None for value in values):
            return "", ""
        alike = tuple(None if v is None else v._depth for v in values)
        now = time.monotonic()
        known = self._known.get(key)
        if known is not None and known[0] == alike and now < known[1]:
            return known[2], known[3]
        moves = "".join(
            axis for axis, value in zip(AXES, values[:3], strict=True) if self._can_move(value)
        )
        turns = "".join(
            axis for axis in AXES if spot.turn is not None and self._can_turn(axis, spot, fields)
        )
        self._known[key] = (alike, now + _KEEP, moves, turns)
        return moves, turns

    def forget(self) -> None:
        """Looks anew at everything."""
        self._known.clear()

    def _can_move(self, value: Any) -> bool:
        if value is None or type(untracked(value)) is not float:
            return False
        if not any(map(self._changeable, sources(value))):
            return False
        now = untracked(value)
        for step in (_NUDGE * max(1.0, abs(now)), -_NUDGE * max(1.0, abs(now)), 1.0, -1.0):
            if self._can_be([(value, now + step)]):
                return True
        return False

    def _can_turn(self, axis: str, spot: Spot, fields: Mapping[str, Any]) -> bool:
        """Whether a small turn changes only parts that can be changed, and these together."""
        assert spot.turn is not None
        for angle in (_TURN_NUDGE, -_TURN_NUDGE):
            wanted = product(spot.rotation, about(AXES.index(axis), angle))
            targets = []
            for name, target, now in zip(_TURN_FIELDS, wanted, spot.rotation, strict=True):
                value = fields.get(field_path(spot.turn, name))
                if value is not None:
                    targets.append((value, target))
                elif abs(target - now) > 0.1 * _TURN_NUDGE:
                    break
            else:
                targets.sort(key=lambda one: -abs(one[1] - untracked(one[0])))
                moved = any(abs(t - untracked(v)) > 0.1 * _TURN_NUDGE for v, t in targets)
                if moved and self._can_be(targets):
                    return True
        return False

    def _can_be(self, targets: list[tuple[Any, Any]]) -> bool:
        try:
            solution: Solution = invert_many(targets)
        except NotInvertible:
            return False
        return all(map(self._changeable, solution.changes))
