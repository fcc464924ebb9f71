"""What is shown now: the last messages of all topics, by RViz's rules.

A marker is known by topic, namespace and id; ADD replaces it, DELETE and DELETEALL (of a topic, or
of the namespace that it names) remove it, and so does the end of its lifetime. Any other message
replaces the one before it on its topic. Nothing here knows ROS or a view: messages come in through
`Scene.receive`, and a view asks for what there is.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from .geometry import HERE, Frame
from .shapes import (
    MARKER,
    MARKER_ARRAY,
    PICTURES,
    Picture,
    Unshown,
    picture_of_marker,
)

ADD, DELETE, DELETE_ALL = 0, 2, 3


class Tracked(Protocol):
    """A message with its provenance, such as `ros.observer.TrackedMessage`.

    fields  tracked values by path
    """

    @property
    def message(self) -> Any: ...

    @property
    def fields(self) -> Mapping[str, Any]: ...


@dataclass
class Item:
    """One thing that is shown.

    key      unique, and the same for what replaces it
    topic    where it came from; root: path of its part of the message
    tracked  the message
    frame_id the frame that its positions are in, "" if it does not say; place: where that stands
    until    when it disappears by itself, on the scene's clock; None: never
    """

    key: str
    topic: str
    root: str
    tracked: Tracked
    frame_id: str = ""
    place: Frame = HERE
    until: float | None = None
    revision: int = 0
    _draw: Callable[[Any, str], Picture] = field(default=lambda message, root: Picture())
    _part: Any = None
    _picture: Picture | None = None

    @property
    def picture(self) -> Picture:
        """What it looks like; worked out when somebody looks. Raises Unshown."""
        if self._picture is None:
            self._picture = self._draw(self._part, self.root).placed(self.place)
        return self._picture

    def within(self, path: str) -> str:
        """A path in the message as one in this part of it, wherever that stands in the next."""
        return path.removeprefix(f"{self.root}.") if self.root else path


class Scene:
    """All items.

    clock  in seconds; the lifetime of markers is measured with it
    place  where a frame stands in the fixed frame; without it all are the fixed frame
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        place: Callable[[str], Frame] = lambda frame_id: HERE,
    ) -> None:
        self._clock = clock
        self._place = place
        self._items: dict[str, Item] = {}
        self._lock = threading.RLock()
        self._revision = 0
        self._arrived = threading.Condition(self._lock)
        self.problems: dict[str, str] = {}
        """What could not be shown and why, by key."""

    def receive(self, topic: str, type_name: str, tracked: Tracked) -> None:
        """Takes in a message of one of `shapes.types()`; of any other it raises KeyError."""
        with self._lock:
            if type_name == MARKER:
                self._marker(topic, "", tracked.message, tracked)
            elif type_name == MARKER_ARRAY:
                for i, marker in enumerate(tracked.message.markers):
                    self._marker(topic, f"markers[{i}]", marker, tracked)
            else:
                draw, message = PICTURES[type_name], tracked.message
                frame_id = str(message.header.frame_id) if hasattr(message, "header") else ""
                self._put(Item(topic, topic, "", tracked, frame_id, _draw=draw, _part=message))
            self._arrived.notify_all()

    def _marker(self, topic: str, root: str, marker: Any, tracked: Tracked) -> None:
        key = marker_key(topic, str(marker.ns), int(marker.id))
        action = int(marker.action)
        if action == ADD:
            lifetime = marker.lifetime.sec + marker.lifetime.nanosec * 1e-9
            until = self._clock() + float(lifetime) if lifetime > 0 else None
            frame_id = str(marker.header.frame_id)
            self._put(
                Item(key, topic, root, tracked, frame_id, HERE, until, 0,
                     picture_of_marker, marker)
            )  # fmt: skip
        elif action == DELETE:
            self._remove(key)
        elif action == DELETE_ALL:
            self._delete_all(topic, str(marker.ns))
        else:
            self.problems[key] = f"unknown marker action {action}"

    def _delete_all(self, topic: str, namespace: str) -> None:
        """Of a topic, or if a namespace is named: of this namespace only."""
        for item in [item for item in self._items.values() if item.topic == topic]:
            if namespace in ("", str(item._part.ns)):
                self._remove(item.key)

    def _put(self, item: Item) -> None:
        self._note_news(item)
        self.problems.pop(item.key, None)
        self._items[item.key] = item

    def _note_news(self, item: Item) -> None:
        """It has to be drawn again."""
        self._revision += 1
        item.revision = self._revision
        item.place = self._place(item.frame_id)
        item._picture = None

    def _remove(self, key: str) -> None:
        self._items.pop(key, None)
        self.problems.pop(key, None)

    def forget(self, topic: str) -> None:
        """Removes all that came from a topic."""
        with self._lock:
            for item in [item for item in self._items.values() if item.topic == topic]:
                self._remove(item.key)

    def items(self) -> list[Item]:
        """What is to be shown now; what cannot be is left out and stands in `problems`."""
        now = self._clock()
        with self._lock:
            for key, item in list(self._items.items()):
                if item.until is not None and item.until <= now:
                    self._remove(key)
            found = list(self._items.values())
            for item in found:
                if item.place != self._place(item.frame_id):
                    self._note_news(item)
        return list(self._drawable(found))

    def _drawable(self, items: list[Item]) -> Iterator[Item]:
        for item in items:
            try:
                item.picture  # noqa: B018  it is made here
            except Unshown as reason:
                self.problems[item.key] = str(reason)
            else:
                yield item

    def get(self, key: str) -> Item | None:
        """The item as it is now."""
        with self._lock:
            item = self._items.get(key)
            if item is None or (item.until is not None and item.until <= self._clock()):
                return None
            return item

    def wait(self, timeout: float) -> None:
        """Returns when the next message comes, or after the timeout."""
        with self._lock:
            self._arrived.wait(timeout)


def marker_key(topic: str, namespace: str, number: int) -> str:
    """The key of a marker."""
    return f"{topic}/{namespace}/{number}"
