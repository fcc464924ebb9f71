"""Texts as the excerpts of other texts that they are made of: how a text that grows and is cut is
folded, and changed.

As long as all texts keep their lengths it is known where each character comes from.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from .expressions import is_leaf, operands, topological
from .operators import OPERATORS
from .text_operators import formatted, pieces_of
from .values import is_tracked, record, untracked

MOST = 64
"""Excerpts that a folded text keeps."""

FOLLOWED = 256
"""A text of more excerpts is not followed."""


class Excerpt(NamedTuple):
    """The characters from `start` to `stop` of a text, a tracked or a plain one."""

    text: Any
    start: int
    stop: int

    @property
    def is_whole(self) -> bool:
        return self.start == 0 and self.stop == len(self.text)

    def value(self) -> Any:
        """As a value, tracked if the text is."""
        if self.is_whole:
            return self.text
        plain = untracked(self.text)[self.start : self.stop]
        if not is_tracked(self.text):
            return plain
        return record(OPERATORS["slice"], plain, self.text, self.start, self.stop, None)


Excerpts = list[Excerpt]


def excerpts(order: Iterable[Any]) -> Excerpts | None:
    """What the last of some nodes is made of; None if that is too much.

    order  a text and all nodes below it, operands before what uses them
    """
    known: dict[int, Excerpts | None] = {}
    found: Excerpts | None = None
    for node in order:
        if type(node._v) is str:
            take = None if is_leaf(node) else _TAKE.get(node._op.name)
            found = take(operands(node), known) if take else [Excerpt(node, 0, len(node._v))]
            known[id(node)] = found
    return found


def fold_text(value: Any, deepest: int) -> bool:
    """Makes a text, in place, one operator over its excerpts; false if they are too many, too deep
    or not tracked.

    deepest  the greatest depth of what is kept as it is
    """
    order = topological([value])
    found = excerpts(order)
    if found is None or len(found) > MOST:
        return False
    parts = [excerpt.value() for excerpt in found]
    depth = max((part._depth for part in parts if is_tracked(part)), default=-1)
    if not 0 <= depth <= deepest + 1:
        return False
    was_cut = any(node._op.name in ("slice", "excerpts") for node in order if not is_leaf(node))
    if was_cut:
        value._set(OPERATORS["excerpts"], tuple(parts), None, depth + 1)
    else:
        value._set(OPERATORS["join"], ("", *parts), None, depth + 1)
    return True


def aligned(value: Any, target: str) -> list[tuple[Any, str]] | None:
    """(tracked text, wanted text) for the texts that have to change, character by character.

    None where the lengths differ, where a character would have to be two at once, and where one
    comes from nowhere.
    """
    found = excerpts(topological([value])) if len(value) == len(target) else None
    wanted: dict[int, tuple[Any, dict[int, str]]] = {}
    end = 0
    for text, start, stop in found or ():
        begin, end = end, end + stop - start
        if not is_tracked(text):
            if target[begin:end] != text[start:stop]:
                return None
            continue
        _, letters = wanted.setdefault(id(text), (text, {}))
        for at, letter in enumerate(target[begin:end], start):
            if letters.setdefault(at, letter) != letter:
                return None
    changed = []
    for text, letters in wanted.values():
        new = "".join(letters.get(at, old) for at, old in enumerate(untracked(text)))
        if new != untracked(text):
            changed.append((text, new))
    return changed or None


# ---------------------------------------------------------------- by operator

_Known = dict[int, "Excerpts | None"]


def _of(texts: Iterable[Any], known: _Known) -> Excerpts | None:
    """The excerpts of several texts in a row; what continues one before is part of it."""
    found: Excerpts = []
    for text in texts:
        plain = [Excerpt(text, 0, len(text))] if text else []
        more = known.get(id(text), plain) if is_tracked(text) else plain
        if more is None or len(found) + len(more) > FOLLOWED:
            return None
        if found and more:
            found[-1:] = _continued(found[-1], more[0])
            found += more[1:]
        else:
            found += more
    return found


def _continued(last: Excerpt, following: Excerpt) -> Excerpts:
    if last.text is following.text and last.stop == following.start:
        return [last._replace(stop=following.stop)]
    if is_tracked(last.text) or is_tracked(following.text):
        return [last, following]
    both = last.value() + following.value()
    return [Excerpt(both, 0, len(both))]


def _concat(below: tuple[Any, ...], known: _Known) -> Excerpts | None:
    return _of(below, known)


def _join(below: tuple[Any, ...], known: _Known) -> Excerpts | None:
    separated = [text for part in below[1:] for text in (below[0], part)]
    return _of(separated[1:], known)


def _pieces(below: tuple[Any, ...], known: _Known) -> Excerpts | None:
    texts = []
    for value, conversion, spec in pieces_of(below):
        text = formatted(untracked(value), conversion, spec)
        if not is_tracked(value):
            texts.append(text)
        elif type(value._v) is str and text == value._v:
            texts.append(value)
        else:
            piece = record(OPERATORS["pieces"], text, value, conversion, spec)
            known[id(piece)] = [Excerpt(piece, 0, len(text))]
            texts.append(piece)
    return _of(texts, known)


def _slice(below: tuple[Any, ...], known: _Known) -> Excerpts | None:
    text, *bounds = below
    if any(map(is_tracked, bounds)) or not is_tracked(text):
        return None
    part = slice(*bounds) if len(bounds) > 1 else slice(bounds[0], bounds[0] + 1 or None)
    span = range(len(text))[part]
    whole = known.get(id(text))
    if whole is None or span.step != 1:
        return None
    found = []
    end = 0
    for excerpt in whole:
        begin, end = end, end + excerpt.stop - excerpt.start
        first, last = max(begin, span.start), min(end, span.stop)
        if first < last:
            offset = excerpt.start - begin
            found.append(Excerpt(excerpt.text, first + offset, last + offset))
    return found


_TAKE: dict[str, Callable[[tuple[Any, ...], _Known], Excerpts | None]] = {
    "concat": _concat,
    "excerpts": _concat,
    "join": _join,
    "pieces": _pieces,
    "slice": _slice,
}
