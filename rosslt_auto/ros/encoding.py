"""Writing provenance headers; the format is documented in `header`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import msgpack

from ..provenance.folding import fold
from ..provenance.locations import source_of
from ..provenance.operators import DEFERRED, LITERAL, SOURCE
from ..provenance.sources import Source
from ..provenance.values import TrackedFloat, settle
from .header import BIG_INTEGER, VERSION

_Kind: type = type(TrackedFloat)  # of all tracked classes, see `values.is_tracked`

LIMIT = 64 << 10
"""Bytes that a header has at most; fields that do not fit are dropped (design 3.4)."""

FOLDED_DEPTH = 256
"""Deeper expressions are folded before they travel."""

HISTORY_DEPTH = 32
"""The same for those that are another one in every message: they are growing histories."""

_MAX_TEXT = 160
_OUTLINES_KEPT = 64
_NEW_IN_A_ROW = 8
_TRY_AGAIN = 100  # messages


class Encoder:
    """Writes the headers of one publisher. Not for several threads at once.

    own  is called with sources that no node owns, before they are described
    """

    def __init__(self, own: Callable[[Source], None]) -> None:
        self._own = own
        self._outlines: dict[tuple[Any, ...], _Outline] = {}
        self._packer = msgpack.Packer(default=_big_integer)
        self._too_many = 0
        self._few = 0
        self._try_again = 0
        self._new = 0  # outlines in a row that had not been there before

    def fold(self, value: Any) -> None:
        """Folds the expression of `value`, in place, if it is too deep to travel."""
        depth = FOLDED_DEPTH if self._new < _NEW_IN_A_ROW else HISTORY_DEPTH
        if value._depth > depth:
            fold(value)

    def encode(
        self, checksum: int, sequence: int, fields: Sequence[tuple[str, Any]]
    ) -> tuple[bytes, int]:
        """The header for a message and how many of its fields found place in it.

        fields  path and tracked value of each, in the order in which they are to be kept
        """
        given = len(fields)
        if self._try_again and given >= self._too_many:  # it was too much before
            self._try_again -= 1
            fields = fields[: self._few]
        while fields:
            try:
                outline, values = self._outline(fields)
                payload = _VERSION + self._packer.pack((checksum, sequence, outline.packed, values))
            except (TypeError, ValueError):
                fields = self._packable(fields)
                continue
            if len(payload) <= LIMIT:
                return payload, len(fields)
            # What stands in it once - sources - makes the next one smaller than proportional.
            fields = fields[: len(fields) * LIMIT * 9 // (len(payload) * 10)]
            self._too_many, self._few, self._try_again = given, len(fields), _TRY_AGAIN
        return b"", 0

    def _packable(self, fields: Sequence[tuple[str, Any]]) -> list[tuple[str, Any]]:
        """The fields in whose expressions there is nothing but numbers and strings."""
        found = []
        for field in fields:
            try:
                self._packer.pack(self._outline([field])[1])
            except (TypeError, ValueError):
                continue
            found.append(field)
        if len(found) == len(fields):
            raise TypeError("an expression that cannot be written")
        return found

    def look(self, fields: Sequence[tuple[str, Any]]) -> None:
        """Has the sources owned that would be in a header, without writing one."""
        self._outline(fields)

    def _outline(self, fields: Sequence[tuple[str, Any]]) -> tuple[_Outline, list[Any]]:
        key, values, leaves = _walk(fields)
        found = self._outlines.get(key)
        if found is None or not found.valid(self._own):
            found = _Outline(key, leaves, [path for path, _ in fields], self._own)
            if len(self._outlines) >= _OUTLINES_KEPT:
                self._outlines.clear()
            self._outlines[key] = found
            self._new += 1
        else:
            self._new = 0
        return found, values


_VERSION = bytes([VERSION])


def _walk(fields: Sequence[tuple[str, Any]]) -> tuple[tuple[Any, ...], list[Any], list[Any]]:
    """What makes the outline (the same key: the same outline), the values beside it, the leaves.

    The key has an entry per slot - the id of a leaf, None for a plain number, operator and
    operand slots of an operation - followed by ``path, slot`` of each field.
    """
    slots: dict[int, int] = {}
    key: list[Any] = []
    values: list[Any] = []
    leaves: list[Any] = []
    ends: list[Any] = []
    for path, root in fields:
        if not root._depth and id(root) not in slots:
            slots[id(root)] = len(key)
            key.append(id(root))
            leaves.append(root)
        stack = [root]
        while stack:
            node = stack[-1]
            if id(node) in slots:
                stack.pop()
                continue
            if node._op is DEFERRED:
                settle(node)
            op = node._op
            a = node._a
            b = node._b
            if op is LITERAL or op is SOURCE:  # a deferred one
                operands: tuple[Any, ...] = ()
            elif b is not None:
                operands = (a, b)
            elif type(a) is tuple:
                operands = a
            else:
                operands = (a,)
            pending = False
            for operand in operands:
                if type(type(operand)) is _Kind and id(operand) not in slots:
                    if operand._depth:
                        stack.append(operand)
                        pending = True
                    else:
                        slots[id(operand)] = len(key)
                        key.append(id(operand))
                        leaves.append(operand)
            if pending:
                continue
            stack.pop()
            if not operands:
                slots[id(node)] = len(key)
                key.append(id(node))
                leaves.append(node)
                continue
            entry: list[Any] = [op]
            for operand in operands:
                slot = slots.get(id(operand))
                if slot is None:
                    slot = len(key)
                    key.append(None)
                    kind = type(operand)
                    values.append(operand if kind is float or kind is int else _plain(operand))
                entry.append(slot)
            slots[id(node)] = len(key)
            key.append(tuple(entry))
            values.append(node._v)
        ends.append(path)
        ends.append(slots[id(root)])
    return (*key, *ends), values, leaves


def _plain(operand: Any) -> Any:
    """A constant of a less usual type, such as True or numpy.float64(2), as the wire knows it."""
    if operand is None:
        return None
    for kind in (int, float, str):
        if isinstance(operand, kind):
            return kind(operand)
    raise TypeError(f"{type(operand).__name__} in an expression")


class _Outline:
    """A packed outline and what it depends on.

    The ids of leaves that `_walk` puts into keys are theirs as long as this one keeps the leaves.
    """

    def __init__(
        self,
        key: tuple[Any, ...],
        leaves: list[Any],
        paths: list[str],
        own: Callable[[Source], None],
    ) -> None:
        self.leaves = leaves
        ends = len(key) - 2 * len(paths)
        numbers: dict[tuple[Source, str], int] = {}
        slots = _slots(key[:ends], leaves, numbers)
        sources = [source for source, _ in numbers]
        for source in sources:
            if source.node is None:
                own(source)
        self.owners = [(source, source.node, source.moves) for source in sources]
        names: dict[str, int] = {}
        described = [_described(source, names) for source in sources]
        fields = _fields(paths, key[ends + 1 :: 2], slots)
        self.packed: bytes = msgpack.packb(
            [list(names), described, slots, fields], default=_big_integer
        )

    def valid(self, own: Callable[[Source], None]) -> bool:
        """Whether all sources still belong to the same nodes and stand in the same places."""
        for source, node, moves in self.owners:
            if source.node is None:
                own(source)
            if source.node != node or source.moves != moves:
                return False
        return True


def _slots(
    key: tuple[Any, ...], leaves: list[Any], numbers: dict[tuple[Source, str], int]
) -> list[Any]:
    """Numbers are those of the sources, with their kind: equal ones may differ in that."""
    slots: list[Any] = []
    following = iter(leaves)
    for entry in key:
        if type(entry) is int:
            node = next(following)
            source = source_of(node)
            number = numbers.setdefault((source, source.kind), len(numbers))
            slots.append([number, node._v])
        elif entry is None or all(slots[slot] is None for slot in entry[1:]):
            slots.append(None)  # an operation on plain numbers is a plain number, too
        else:
            slots.append([entry[0].name, *entry[1:]])
    return slots


def _fields(paths: list[str], roots: tuple[int, ...], slots: list[Any]) -> list[Any]:
    fields: list[Any] = []
    before = ""
    for path, slot in zip(paths, roots, strict=True):
        if slots[slot] is not None:
            shared = 0
            for a, b in zip(before, path, strict=False):
                if a != b:
                    break
                shared += 1
            fields.append([shared, path[shared:], slot])
            before = path
    return fields


def _described(source: Source, names: dict[str, int]) -> list[Any]:
    node = None if source.node is None else names.setdefault(source.node, len(names))
    file = None if source.file is None else names.setdefault(_printable(source.file), len(names))
    hint = None if source.hint == source.parameter.rpartition(".")[2] else _printable(source.hint)
    text = None if source.text is None else _printable(source.text.expandtabs(4))[:_MAX_TEXT]
    described = [
        node, source.parameter, source.kind, hint, source.named,
        file, source.line, source.column, text,
    ]  # fmt: skip
    if source.frozen:
        return [*described, False]
    return described if source.limits is None else [*described, list(source.limits)]


def _printable(string: str) -> str:
    if string.isprintable():
        return string
    return "".join(c if c.isprintable() else "?" for c in string)


def _big_integer(value: Any) -> Any:
    """Called by msgpack for what it cannot pack."""
    if not isinstance(value, int):
        raise TypeError(f"{type(value).__name__} in an expression")
    size = value.bit_length() // 8 + 1
    return msgpack.ExtType(BIG_INTEGER, int(value).to_bytes(size, "big", signed=True))


__all__ = ["FOLDED_DEPTH", "HISTORY_DEPTH", "LIMIT", "Encoder"]
