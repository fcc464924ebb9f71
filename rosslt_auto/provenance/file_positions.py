"""Where the scalars of a YAML or JSON text stand.

The same structure as the values that a loader makes of the text, with positions. What is not
certainly a plain number or text - custom tags, constructors, blocks - is left out.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import Any


class Scalar:
    """A number or text: its value, and where it is written (offsets of characters)."""

    __slots__ = ("end", "start", "value")

    def __init__(self, value: Any, start: int, end: int) -> None:
        self.value = value
        self.start = start
        self.end = end


class Mapping:
    """Items by key; of equal keys the last one counts, as for the loaders."""

    __slots__ = ("items",)

    def __init__(self) -> None:
        self.items: dict[Any, Node] = {}


class Sequence:
    """Items in order."""

    __slots__ = ("items",)

    def __init__(self) -> None:
        self.items: list[Node] = []


Node = Scalar | Mapping | Sequence | None
"""None: something that is not tracked."""


def scalars(node: Node) -> list[Scalar]:
    """All scalars at and below `node`, each once."""
    found: dict[int, Scalar] = {}
    seen: set[int] = set()
    stack = [node]
    while stack:
        node = stack.pop()
        if isinstance(node, Scalar):
            found[id(node)] = node
        elif node is not None and id(node) not in seen:
            seen.add(id(node))
            items: Iterable[Node] = node.items
            stack += node.items.values() if isinstance(node, Mapping) else items
    return list(found.values())


# ---------------------------------------------------------------- JSON

_SPACE = re.compile(r"[ \t\n\r]*")
_NUMBER = re.compile(r"-?(?:0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?")
_WORD = re.compile(r"true|false|null|NaN|-?Infinity")


def json_positions(text: str) -> Node:
    """Positions in a JSON text (RFC 8259); raises ValueError if it is none."""
    node, end = _json_value(text, _space(text, 0))
    if _space(text, end) != len(text):
        raise ValueError("text behind the value")
    return node


def _space(text: str, at: int) -> int:
    return _SPACE.match(text, at).end()  # type: ignore[union-attr]


def _json_value(text: str, at: int) -> tuple[Node, int]:
    char = text[at : at + 1]
    if char == "{":
        return _json_object(text, at + 1)
    if char == "[":
        return _json_array(text, at + 1)
    if char == '"':
        value, end = _json_string(text, at)
        return Scalar(value, at, end), end
    if (word := _WORD.match(text, at)) is not None:
        return None, word.end()
    if (number := _NUMBER.match(text, at)) is not None:
        convert = float if number[1] or number[2] else int
        return Scalar(convert(number[0]), at, number.end()), number.end()
    raise ValueError(f"no value at {at}")


def _json_string(text: str, at: int) -> tuple[str, int]:
    if text[at : at + 1] != '"':
        raise ValueError(f"no text at {at}")
    return json.decoder.scanstring(text, at + 1, False)  # type: ignore[attr-defined]


def _json_object(text: str, at: int) -> tuple[Node, int]:
    node = Mapping()
    at = _space(text, at)
    if text[at : at + 1] == "}":
        return node, at + 1
    while True:
        key, at = _json_string(text, _space(text, at))
        at = _space(text, at)
        if text[at : at + 1] != ":":
            raise ValueError(f"no colon at {at}")
        node.items[key], at = _json_value(text, _space(text, at + 1))
        at = _space(text, at)
        if text[at : at + 1] == "}":
            return node, at + 1
        if text[at : at + 1] != ",":
            raise ValueError(f"no comma at {at}")
        at += 1


def _json_array(text: str, at: int) -> tuple[Node, int]:
    node = Sequence()
    at = _space(text, at)
    if text[at : at + 1] == "]":
        return node, at + 1
    while True:
        item, at = _json_value(text, _space(text, at))
        node.items.append(item)
        at = _space(text, at)
        if text[at : at + 1] == "]":
            return node, at + 1
        if text[at : at + 1] != ",":
            raise ValueError(f"no comma at {at}")
        at += 1


# ---------------------------------------------------------------- YAML

_TAG = "tag:yaml.org,2002:"
_SCALARS = {f"{_TAG}{kind}": kind for kind in ("float", "int", "str")}
_KEYS = frozenset({*_SCALARS, f"{_TAG}bool", f"{_TAG}null"})
_PROPERTIES = re.compile(r"(?:&[^\s,\[\]{}]+\s+)*")
_METHODS = (
    "__init__", "get_single_node", "compose_document", "compose_node", "compose_scalar_node",
    "resolve", "get_single_data", "construct_document", "construct_object", "construct_scalar",
    "construct_mapping", "construct_sequence", "flatten_mapping",
)  # fmt: skip


def is_known_loader(loader: Any) -> bool:
    """Whether a class loads as PyYAML's own loaders do, but for resolvers and constructors."""
    return isinstance(loader, type) and all(
        str(getattr(getattr(loader, name, None), "__module__", "yaml")).partition(".")[0] == "yaml"
        for name in _METHODS
    )


def yaml_positions(text: str, loader: Any) -> Node:
    """Positions in a YAML text as `loader`, a class of loaders, understands it.

    Raises what the loader raises.
    """
    instance = loader(text)
    try:
        root = instance.get_single_node()
        return _YamlNodes(text, instance).node(root) if root is not None else None
    finally:
        instance.dispose()


class _YamlNodes:
    """Turns PyYAML's nodes into ours; an alias gives the same node again."""

    def __init__(self, text: str, loader: Any) -> None:
        self.text = text
        self.loader = loader
        self.known: dict[int, Node] = {}

    def node(self, node: Any) -> Node:
        if id(node) in self.known:
            return self.known[id(node)]
        if not self._is_standard(node.tag):
            return None
        if node.id == "scalar":
            made: Node = self._scalar(node)
            self.known[id(node)] = made
        elif node.id == "sequence" and node.tag == f"{_TAG}seq":
            made = self.known[id(node)] = Sequence()
            made.items += [self.node(item) for item in node.value]
        elif node.id == "mapping" and node.tag == f"{_TAG}map":
            made = self.known[id(node)] = Mapping()
            self._fill(made, node)
        else:
            made = None
        return made

    def _is_standard(self, tag: str) -> bool:
        """Whether the loader does with a tag what PyYAML does."""
        constructor = self.loader.yaml_constructors.get(tag)
        module = getattr(constructor, "__module__", "yaml.") or ""
        return tag.startswith(_TAG) and module.partition(".")[0] == "yaml"

    def _fill(self, made: Mapping, node: Any) -> None:
        if hasattr(self.loader, "flatten_mapping"):
            self.loader.flatten_mapping(node)  # merge keys
        for key, value in node.value:
            if key.id == "scalar" and key.tag in _KEYS and self._is_standard(key.tag):
                made.items[self.loader.construct_object(key)] = self.node(value)

    def _scalar(self, node: Any) -> Scalar | None:
        if node.tag not in _SCALARS:
            return None
        start, end = node.start_mark.index, node.end_mark.index
        start = _PROPERTIES.match(self.text, start, end).end()  # type: ignore[union-attr]
        if self.text[start : start + 1] in ("!", "|", ">", "&", ""):
            return None
        value = self.loader.construct_object(node)
        if type(value).__name__ not in ("float", "int", "str"):
            return None
        return Scalar(value, start, end)
