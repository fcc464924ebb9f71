"""Where what has been clicked comes from, and which of its sources a drag is to change.

viser tells of clicks, not of what the pointer is over: there it only changes a colour.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

from rosslt_auto.provenance.expressions import source_values, sources
from rosslt_auto.provenance.inversion import POLICIES
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.texts import text
from rosslt_auto.provenance.values import untracked

from . import panel
from .dragging import Refused, solve
from .handles import Handle
from .listing import Literal
from .scene import Item
from .session import Session

_AUTOMATIC = "automatic"
_MANY = 30
"""Fields of an item without handles that are shown."""

_NUDGE = 0.01


class Origin:
    """The fields of what is selected, with their sources, and the choice of policy and source.

    gui  of the viser server; the controls are put where it is at
    """

    def __init__(self, gui: Any, session: Session) -> None:
        self._session = session
        self._key = ""
        self._handle: Handle | None = None
        self._offered: str | None = None
        self._options: dict[str, list[tuple[str, Source]]] = {}
        self._policy = gui.add_dropdown("Policy", tuple(POLICIES), initial_value="left")
        self._source = gui.add_dropdown("Change", (_AUTOMATIC,), visible=False)
        self._html = gui.add_html("")
        self._policy.on_update(self._policy_chosen)
        self._source.on_update(self._source_chosen)

    def draw(self, key: str, handle: Handle | None) -> None:
        """Shows an item or one of its handles as it is now.

        key  of the handle or, if it has none, of the item; "" for nothing
        """
        self._key, self._handle = key, handle
        item = self._item()
        if item is None:
            content = panel.origin("Click something to see where it comes from.", [])
        else:
            paths = handle.paths() if handle else _paths_of(item)
            paths = [path for path in paths if path in item.tracked.fields]
            self._session.note_sources(item, paths)
            rows = [self._row(item, path) for path in paths]
            title = f"{item.topic}  {handle.spot.path if handle else item.root}"
            content = panel.origin(title if rows else f"{title}: no provenance", rows)
        if self._html.content != content:
            self._html.content = content
        self._offer(item)

    def _item(self) -> Item | None:
        return self._session.scene.get(self._handle.item if self._handle else self._key)

    def _row(self, item: Item, path: str) -> tuple[str, Any, str, list[tuple[Literal, bool]]]:
        value = item.tracked.fields[path]
        now = source_values(value)
        will = self._will_change(item, path)
        literals = []
        for source in sources(value):
            known = self._session.listing.get(source) or Literal(
                source.node or "", source.parameter, source.file, source.line, source.column,
                source.text or "", None, now[source],
            )  # fmt: skip
            literals.append((known, source in will))
        return path, untracked(value), text(value), literals

    def _will_change(self, item: Item, path: str) -> set[Source]:
        value = untracked(item.tracked.fields[path])
        if type(value) is not float:
            return set()
        choice = self._session.choices.of(item)
        try:
            return {one.source for one in solve(item.tracked, {path: value + _NUDGE}, choice)}
        except Refused:
            return set()

    # The choice

    def _offer(self, item: Item | None) -> None:
        """The sources of the handle's fields, by what people call them."""
        options = [
            (path, source)
            for path in (self._handle.paths() if self._handle and item else [])
            if item is not None and path in item.tracked.fields
            for source in sources(item.tracked.fields[path])
        ]
        self._options = named(options)
        if self._source.visible != bool(options):
            self._source.visible = bool(options)
        labels = (_AUTOMATIC, *self._options)
        if tuple(self._source.options) != labels or self._offered != self._key:
            self._offered = self._key
            self._source.options = labels
            self._source.value = self._chosen(item)

    def _chosen(self, item: Item | None) -> str:
        """What the dropdown has to say, which viser sets back with new options."""
        if item is None:
            return _AUTOMATIC
        chosen = set(self._session.choices.of(item).sources.items())
        found = (label for label, ways in self._options.items() if chosen & set(ways))
        return next(found, _AUTOMATIC)

    def _policy_chosen(self, event: Any) -> None:
        self._session.choices.policy = self._policy.value

    def _source_chosen(self, event: Any) -> None:
        item = self._item()
        if event.client is None or item is None:  # not by somebody, but by `_offer`
            return
        label, choices = self._source.value, self._session.choices
        if label == _AUTOMATIC:
            for path in self._handle.paths() if self._handle else []:
                choices.choose(item, path, None)
        for path, source in self._options.get(label, []):
            choices.choose(item, path, source)


def named(options: list[tuple[str, Source]]) -> dict[str, list[tuple[str, Source]]]:
    """Fields with their sources by a text for people, longer where it would say too little.

    options  paths of fields, each with a source
    """
    labels = {one: f"{_field(one[0])}: {_name(one[1])}" for one in options}
    often = Counter(labels.values())
    found: dict[str, list[tuple[str, Source]]] = {}
    for one, label in labels.items():
        if often[label] > 1:
            label += f" {one[1].parameter}"
        found.setdefault(label, []).append(one)
    return found


def _field(path: str) -> str:
    """`x` of a position, `orientation.x`."""
    parts = path.split(".")
    return ".".join(parts[-2:] if "orientation" in parts[:-1] else parts[-1:])


def _name(source: Source) -> str:
    return f"{source.hint} ({source.node})" if source.node else source.hint


def _paths_of(item: Item) -> list[str]:
    prefix = f"{item.root}." if item.root else ""
    return [path for path in item.tracked.fields if path.startswith(prefix)][:_MANY]
