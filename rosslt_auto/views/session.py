"""A scene that is connected to ROS: topics come in, drags go out, and can be undone."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol

from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_parameter_events

from rosslt_auto.provenance.expressions import source_values, sources
from rosslt_auto.provenance.sources import Source
from rosslt_auto.ros.client import Change, ChangeRefused, NoAnswer, Place, change_of
from rosslt_auto.ros.observer import CannotObserve, Observer, TopicSubscription, full_name
from rosslt_auto.ros.saving import given_by

from . import shapes
from .dragging import Changed, Choices, Drag, Dragger
from .frames import Frames
from .handles import Handle, Handles
from .listing import Listing, Literal
from .scene import Item, Scene

TIMEOUT = 1.0
"""Seconds that a node may take to accept a change."""

_LOOK = 0.1
_ASK = 1.0
"""Seconds between two looks at the graph, and two questions for a node's locations."""


class Saver(Protocol):
    """Writes changed literals into their files."""

    def diff(self, literals: Sequence[Literal]) -> str:
        """The unified diff of what `save` would write. Raises an exception with the reason."""

    def save(self, literals: Sequence[Literal]) -> str:
        """Writes; returns what it has done, for people. Raises an exception with the reason."""


class Session:
    """What a view needs. A context manager; `observer` has been entered.

    topics  only these are shown; without any: all whose type can be shown
    saver   writes changes into files, None where nobody can
    frames  where frames stand; without it all are one fixed frame, and who shows them knows better

    scene, handles, listing   what is shown, what can be dragged, the literals behind it
    choices                   how sources are chosen
    messages                  called with text for people, "" when it is over
    """

    def __init__(
        self,
        observer: Observer,
        topics: Sequence[str] = (),
        saver: Saver | None = None,
        frames: Frames | None = None,
    ) -> None:
        self._observer = observer
        self._only = {full_name(topic) for topic in topics}
        self.saver = saver
        self._frames = frames
        self.scene = Scene() if frames is None else Scene(place=frames.place)
        self.listing = Listing()
        self.handles = Handles(lambda source: not self.listing.frozen(source))
        self.choices = Choices()
        self.messages: list[Callable[[str], None]] = []
        self.topics: dict[str, str] = {}
        self._subscriptions: dict[str, TopicSubscription] = {}
        self._drags: dict[str, Dragger] = {}
        self._undo: list[list[Changed]] = []
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._threads = [
            threading.Thread(target=run, name=f"view {run.__name__}", daemon=True)
            for run in (self._look_for_topics, self._ask_nodes)
        ]

    def __enter__(self) -> Session:
        node = self._observer.node
        node.create_subscription(
            ParameterEvent, "/parameter_events", self._on_event, qos_profile_parameter_events
        )
        latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(Log, "/rosout", self._on_log, latched)
        if self._frames is not None:
            self._frames.follow(node)
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        for thread in self._threads:
            thread.join(5.0)
        for subscription in self._subscriptions.values():
            self._observer.unsubscribe(subscription)

    def say(self, text: str) -> None:
        """Tells people something; "" when it is over."""
        for tell in list(self.messages):
            tell(text)

    # What comes in

    def _look_for_topics(self) -> None:
        known = set(shapes.types())
        while not self._ended.is_set():
            for topic, types in self._observer.topics().items():
                if (self._only and topic not in self._only) or topic in self._subscriptions:
                    continue
                if len(types) == 1 and types[0] in known:
                    self._subscribe(topic, types[0])
            self._ended.wait(_LOOK)

    def _subscribe(self, topic: str, type_name: str) -> None:
        receive = partial(self.scene.receive, topic, type_name)
        try:
            self._subscriptions[topic] = self._observer.subscribe(topic, receive)
        except CannotObserve:
            return  # its publisher has gone already
        self.topics[topic] = type_name

    def _ask_nodes(self) -> None:
        seen: set[str] = set()
        while not self._ended.is_set():
            nodes = self._observer.nodes_with_locations()
            seen |= nodes
            self._note_ended(seen - nodes)
            for node in nodes:
                try:
                    places = self._observer.parameters.places(node, TIMEOUT)
                except NoAnswer:
                    continue
                for place in places:
                    self.listing.place(_literal(place))
                self.listing.forget(node, but=[place.parameter for place in places])
            if nodes:
                self._observer.parameters.prepare(nodes)
            self.listing.look()
            self._ended.wait(_ASK)

    def _note_ended(self, nodes: set[str]) -> None:
        if nodes != self.listing.ended:
            self.listing.ended = nodes
            self.handles.forget()

    def _on_event(self, event: Any) -> None:
        for parameter in event.changed_parameters:
            value = parameter_value_to_python(parameter.value)
            self.listing.value(event.node, parameter.name, value)

    def _on_log(self, log: Any) -> None:
        level = log.level if isinstance(log.level, int) else ord(log.level)
        if level >= 40:
            self.listing.complaint(log.msg)

    # What goes out

    def grab(self, handle: Handle) -> Dragger | None:
        """A drag begins; None if somebody else holds the handle."""
        item = self.scene.get(handle.item)
        with self._lock:
            if item is None or handle.key in self._drags:
                return None
            dragger = Dragger(
                Drag(item.tracked, self.choices.of(item)),
                partial(self._latest, handle.item, item.root),
                self._apply,
                self.say,
            )
            self._drags[handle.key] = dragger
            return dragger

    def _latest(self, key: str, root: str) -> Any:
        """The last message that has the item where the drag's paths say it is."""
        item = self.scene.get(key)
        return None if item is None or item.root != root else item.tracked

    def let_go(self, handle: Handle) -> None:
        """The drag ends: its last target is dealt with, then it can be undone."""
        dragger = self._drags.get(handle.key)
        if dragger is None:
            return
        dragger.release(2 * TIMEOUT)
        changed = list(dragger.drag.changed.values())
        with self._lock:
            self._drags.pop(handle.key, None)
            if changed:
                self._undo.append(changed)

    def is_held(self, key: str) -> bool:
        """Whether somebody drags this handle now."""
        return key in self._drags

    def _apply(self, changes: Sequence[Changed]) -> None:
        self._set([change_of(one.source, one.old, one.new) for one in changes])

    def _set(self, changes: list[Change]) -> None:
        self._observer.parameters.set(changes, TIMEOUT)
        for change in changes:
            self.listing.value(change.node, change.parameter, change.new)

    @property
    def can_undo(self) -> bool:
        return bool(self._undo)

    def undo(self) -> str:
        """Takes the last drag back; returns what was done, for people."""
        with self._lock:
            if not self._undo:
                return "there is nothing to undo"
            last = self._undo.pop()
        try:
            self._set([change_of(one.source, one.new, one.old) for one in last])
        except (ChangeRefused, NoAnswer) as reason:
            with self._lock:
                self._undo.append(last)
            return f"not undone: {reason}"
        return "undone: " + ", ".join(
            f"{one.source.hint} {one.new!r} → {one.old!r}" for one in last
        )

    def diff(self) -> str:
        """What `save` would write. Raises an exception with the reason."""
        if self.saver is None:
            raise RuntimeError("saving is not available")
        return self.saver.diff(self.listing.changed())

    def save(self) -> str:
        """Writes the changed literals into their files. Raises an exception with the reason."""
        if self.saver is None:
            raise RuntimeError("saving is not available")
        return self.saver.save(self.listing.changed())

    # What to show

    def note_sources(self, item: Item, paths: Sequence[str]) -> None:
        """Makes the sources of an item's fields known to the listing."""
        for path in paths:
            value = item.tracked.fields.get(path)
            if value is not None:
                now = source_values(value)
                for i, source in enumerate(sources(value)):
                    self.listing.source(source, now[source], 1 if i else 2)

    def wait_for_handles(self, timeout: float) -> bool:
        """Returns when something can be dragged, or after the timeout."""
        deadline = time.monotonic() + timeout
        while time.monotonic() < deadline:
            if any(self.handles.of(item) for item in self.scene.items()):
                return True
            self.scene.wait(0.1)
        return False


def _literal(place: Place) -> Literal:
    return Literal(
        place.node, place.parameter, place.file, place.line, place.column, place.text,
        place.first, place.value, frozen=place.read_only or place.frozen,
        given=given_by(place), in_data=place.file is not None and place.content is None,
    )  # fmt: skip


__all__ = ["Saver", "Session", "Source"]
