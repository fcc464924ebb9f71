"""The provenance header: what travels on ``<topic>/_provenance`` beside each message (design 3.3).

Format, version 1
-----------------
The header topic has the type ``std_msgs/msg/UInt8MultiArray``, its ``layout`` is empty; its
``data`` is one byte with the format version, followed by a MessagePack document
(https://msgpack.org), an array:

    [checksum, sequence, outline, values]

checksum  CRC-32 (zlib, IEEE 802.3) of the serialised data message, encapsulation included,
          filled up with zeros to a multiple of four bytes, as RTPS does on its way
sequence  publication sequence number of the data message, counted from 1 for each publisher; it
          tells messages with equal bytes apart
outline   binary: another MessagePack document, see below. It is the same for message after
          message, so a decoder does well to keep what it made of it, by these very bytes.
values    one for each slot of the outline that is not a leaf, in their order

The outline is ``[names, sources, slots, fields]``:

names     strings that sources refer to by index: names of nodes and files
sources   each ``[node, parameter, kind, hint, named, file, line, column, text]``: node and file
          are indices of `names` or nil (no node owns it yet; it stands in no file); parameter is
          the name of the ROS parameter; kind is "float", "int", "str" or "bool"; hint is the name
          to show, or nil for the last token of parameter; named is a boolean: bound to a name in
          the program, not just an operand; line counts from 1, column from 0; text is the source
          line or nil. A tenth entry says what changes are allowed: ``false`` none (the literal is
          frozen), ``[low, high, step]`` numbers of this range (step nil: any of them)
slots     the nodes of all expressions, operands before what is computed from them:
          ``[source, value]``  a leaf: index of its source, and the value that it had, which does
                               not stand in `values`
          ``nil``              a plain value; it stands in `values`
          ``[name, slot...]``  an operation: name of the operator and the slots of its operands,
                               at least one of which is no plain value; the result stands in
                               `values`
fields    each ``[shared, rest, slot]``: the slot that a field of the message got its value from.
          Its path (``pose.position.x``, ``points[3].x``) is the first `shared` characters of the
          path before it in this list, followed by `rest`.

Values are MessagePack floats (64 bits), integers or strings, and the difference matters; plain
ones may be nil, too, and those of leaves true or false. Integers beyond 64 bits are extension type
1: two's complement, big endian.
The names of the operators are those of `provenance.operators.OPERATORS`.

Whoever reads a header must take it for hostile: `decode` raises HeaderError for anything that is
not exactly as above.
"""

from __future__ import annotations

import math
import re
import zlib
from typing import Any, Literal

import msgpack

from ..provenance import text_operators as _rows  # noqa: F401  (fills the table of operators)
from ..provenance.limits import Limits
from ..provenance.operators import OPERATORS, Operator
from ..provenance.registry import location_of
from ..provenance.sources import Source
from ..provenance.values import DEPTH_LIMIT, leaf, node
from .operands import FOLDED, accepts, fits

VERSION = 1
SUFFIX = "/_provenance"
"""What the name of a topic is followed by in the name of its header topic."""

MAX_SIZE = 1 << 20
"""Larger headers are not read at all; our own publishers stay far below (`encoding.LIMIT`)."""

BIG_INTEGER = 1
_MAX_BIG_INTEGER = 1024
_MAX_STRING = 4096
_MAX_PATH = 512
_OUTLINES_KEPT = 256
_BYTES_KEPT = 4 << 20
_KINDS_KEPT = 16

# Encapsulation, size of layout.dim (none) and layout.data_offset; then the size of data follows.
_LITTLE_ENDIAN = bytes([0, 1, 0, 0, *bytes(8)])
_BIG_ENDIAN = bytes(12)
_NODE_NAME = re.compile(r"(/[A-Za-z0-9_]+)+")


local_nodes: set[str] = set()
"""Names of the nodes of this process: a source of theirs is the location itself, not a copy."""


class HeaderError(ValueError):
    """Bytes that are no provenance header; the message says what is wrong with them."""


class Header:
    """The provenance of one message.

    checksum, sequence  which message it belongs to, see above
    outline             what is the same for many messages
    size                of the payload, in bytes
    """

    __slots__ = ("_nodes", "checksum", "outline", "sequence", "size", "values")

    def __init__(
        self, checksum: int, sequence: int, outline: Outline, values: list[Any], size: int = 0
    ) -> None:
        self.checksum = checksum
        self.sequence = sequence
        self.outline = outline
        self.values = values
        self.size = size
        self._nodes: list[Any] | None = None

    def nodes(self) -> list[Any]:
        """The expressions: for each slot a tracked value, or the plain number."""
        if self._nodes is None:
            self._nodes = self._make_nodes()
        return self._nodes

    def _make_nodes(self) -> list[Any]:
        slots = self.outline.slots.copy()
        for value, (slot, op, a, b, depth) in zip(self.values, self.outline.steps, strict=True):
            if op is None:
                slots[slot] = value
                continue
            left = slots[a] if type(a) is int else tuple([slots[i] for i in a])
            right = None if b is None else slots[b]
            slots[slot] = node(value, op, left, right, depth)
        return slots

    def fields(self) -> dict[str, Any]:
        """The tracked values of the fields by path, as the sender had them."""
        nodes = self.nodes()
        return {path: nodes[slot] for path, slot in self.outline.fields}


class Outline:
    """What headers of one publisher have in common while nothing but values changes.

    slots   one entry per slot: a leaf, or None where each header has a value of its own
    steps   for each of these ``(slot, operator, a, b, depth)``; operator None: a plain number; a
            is a tuple of slots if there are more than two operands, b None if there is one
    fields  ``(path, slot)``
    plans   for `fields`: how to reach the fields in a message, by type of the message
    kinds   types of values that have been found to fit
    """

    __slots__ = ("fields", "kinds", "plans", "slots", "steps")

    def __init__(self) -> None:
        self.slots: list[Any] = []
        self.steps: list[tuple[int, Operator | None, Any, Any, int]] = []
        self.fields: list[tuple[str, int]] = []
        self.plans: dict[type, Any] = {}
        self.kinds: set[tuple[type, ...]] = set()


# ---------------------------------------------------------------- the message around it


def checksum_of(data: bytes) -> int:
    """The checksum of a serialised data message."""
    # Between processes a message arrives filled up, within one process as it was sent.
    checksum = zlib.crc32(data)
    missing = -len(data) % 4
    return zlib.crc32(bytes(missing), checksum) if missing else checksum


def wrap(payload: bytes) -> bytes:
    """The serialised UInt8MultiArray with `payload` as its data."""
    return _LITTLE_ENDIAN + len(payload).to_bytes(4, "little") + payload


def unwrap(serialised: bytes) -> bytes:
    """The data of a serialised UInt8MultiArray. Raises HeaderError."""
    if len(serialised) > MAX_SIZE:
        raise HeaderError(f"{len(serialised)} bytes are too many")
    if serialised.startswith(_LITTLE_ENDIAN):
        order: Literal["little", "big"] = "little"
    elif serialised.startswith(_BIG_ENDIAN):
        order = "big"
    else:
        raise HeaderError("not a UInt8MultiArray without layout")
    end = 16 + int.from_bytes(serialised[12:16], order)
    if end > len(serialised):
        raise HeaderError("truncated")
    return serialised[16:end]


# ---------------------------------------------------------------- decoding

_KINDS = frozenset({float, int, str, type(None)})

_outlines: dict[bytes, Outline] = {}
_bytes_kept = 0


def decode(payload: bytes) -> Header:
    """The header that `payload` (the version byte and what follows) stands for.

    Raises HeaderError for anything malformed, and nothing else.
    """
    if not payload or payload[0] != VERSION:
        raise HeaderError(f"unknown format version {payload[0]}" if payload else "empty")
    if len(payload) > MAX_SIZE:
        raise HeaderError(f"{len(payload)} bytes are too many")
    document = _unpack(payload[1:])
    if type(document) is not list or len(document) != 4:
        raise HeaderError("not an array of 4")
    checksum, sequence, packed, values = document
    if type(checksum) is not int or not 0 <= checksum < 1 << 32:
        raise HeaderError("no checksum")
    if type(sequence) is not int or not 0 <= sequence < 1 << 64:
        raise HeaderError("no sequence number")
    if type(packed) is not bytes or type(values) is not list:
        raise HeaderError("no outline, or no values")
    outline = _outlines.get(packed) or _keep(packed, _outline(packed))
    if len(values) != len(outline.steps):
        raise HeaderError(f"{len(values)} values for {len(outline.steps)} slots")
    kinds = tuple(map(type, values))
    if kinds not in outline.kinds:
        _check_kinds(outline, kinds)
    return Header(checksum, sequence, outline, values, len(payload))


def _check_kinds(outline: Outline, kinds: tuple[type, ...]) -> None:
    """Raises HeaderError if operators have operands or results that they cannot have."""
    if not _KINDS.issuperset(kinds):
        raise HeaderError("not a value")
    all_kinds = [type(None) if slot is None else type(slot._v) for slot in outline.slots]
    for kind, (slot, op, a, b, _) in zip(kinds, outline.steps, strict=True):
        all_kinds[slot] = kind
        if op is None:
            continue
        below = [
            all_kinds[i] for i in ((a, b) if b is not None else a if type(a) is tuple else (a,))
        ]
        if kind is type(None) or not fits(op, kind, below):
            raise HeaderError(f"{op.name} of something else")
    if len(outline.kinds) < _KINDS_KEPT:
        outline.kinds.add(kinds)


def _keep(packed: bytes, outline: Outline) -> Outline:
    global _bytes_kept
    if len(_outlines) >= _OUTLINES_KEPT or _bytes_kept + len(packed) > _BYTES_KEPT:
        _outlines.clear()
        _bytes_kept = 0
    _outlines[packed] = outline
    _bytes_kept += len(packed)
    return outline


def _unpack(packed: bytes) -> Any:
    try:
        return msgpack.unpackb(packed, ext_hook=_extension, strict_map_key=True)
    except HeaderError:
        raise
    except Exception as error:  # msgpack has a good dozen of them
        raise HeaderError(f"no MessagePack document: {error or type(error).__name__}") from error


def _extension(code: int, data: bytes) -> int:
    if code != BIG_INTEGER or len(data) > _MAX_BIG_INTEGER:
        raise HeaderError(f"unknown extension {code}")
    return int.from_bytes(data, "big", signed=True)


def _outline(packed: bytes) -> Outline:
    document = _unpack(packed)
    if type(document) is not list or len(document) != 4:
        raise HeaderError("the outline is not an array of 4")
    if not all(type(part) is list for part in document):
        raise HeaderError("the outline is not made of arrays")
    names, sources, slots, fields = document
    for name in names:
        _string(name)
    known = [_source(source, names) for source in sources]
    outline = Outline()
    depths: list[int] = []  # -1 for plain numbers
    for slot in slots:
        _add_slot(outline, depths, slot, known)
    path = ""
    seen = set()
    for field in fields:
        path, slot = _field(field, path, depths)
        if path in seen:
            raise HeaderError(f"field {path} occurs twice")
        seen.add(path)
        outline.fields.append((path, slot))
    return outline


def _source(described: Any, names: list[str]) -> Source:
    if type(described) is not list or len(described) not in (9, 10):
        raise HeaderError("a source is not an array of 9 or 10")
    node, parameter, kind, hint, named, file, line, column, text = described[:9]
    node_name = None if node is None else names[_index(node, len(names))]
    if node_name is not None and not _NODE_NAME.fullmatch(node_name):
        raise HeaderError("not the name of a node")
    file_name = None if file is None else names[_index(file, len(names))]
    if kind not in ("float", "int", "str", "bool") or type(named) is not bool:
        raise HeaderError("unknown kind of source")
    _string(parameter)
    for string in (hint, text):
        if string is not None:
            _string(string)
    for number in (line, column):
        if number is not None:
            _index(number, 1 << 31)
    if node_name in local_nodes and parameter.startswith("rosslt."):
        local = location_of(parameter)
        if local is not None and local.node == node_name and local.kind == kind:
            return local
    source = Source(node_name, parameter, kind, hint, named, file_name, line, column, text)
    if len(described) == 10:
        _allow(source, described[9])
    return source


def _allow(source: Source, allowed: Any) -> None:
    """Notes what changes of a remote source its node allows."""
    if allowed is False:
        source.frozen = True
        return
    kinds = {"float": float, "int": int}
    if type(allowed) is not list or len(allowed) != 3 or source.kind not in kinds:
        raise HeaderError("no range")
    low, high, step = allowed
    if {type(low), type(high), type(high if step is None else step)} != {kinds[source.kind]}:
        raise HeaderError("a range of another type")
    if not -math.inf < low < high < math.inf or not (step is None or 0 < step <= high - low):
        raise HeaderError("no proper range")
    source.limits = Limits(low, high, step)


def _leaf_of(source: Source, value: Any) -> Any:
    if type(value).__name__ != source.kind:
        raise HeaderError(f"{source.parameter} is no {type(value).__name__}")
    current = source.leaf  # of a location of this very process: its own leaf, if still valid
    if current is not None and current._v == value and str(current._v) == str(value):
        return current
    return leaf(source, value)


def _add_slot(outline: Outline, depths: list[int], slot: Any, sources: list[Source]) -> None:
    number = len(depths)
    if slot is None:
        depths.append(-1)
        outline.slots.append(None)
        outline.steps.append((number, None, None, None, 0))
        return
    if type(slot) is not list or len(slot) < 2:
        raise HeaderError("a slot is neither nil nor an array")
    if type(slot[0]) is not str:
        if len(slot) != 2 or type(slot[1]) not in (float, int, str, bool):
            raise HeaderError("a leaf is not an array of 2")
        depths.append(0)
        outline.slots.append(_leaf_of(sources[_index(slot[0], len(sources))], slot[1]))
        return
    op = OPERATORS.get(slot[0])
    if op is None:
        raise HeaderError("unknown operator")
    operands = slot[1:]
    for operand in operands:
        _index(operand, number)
    tracked = [depths[operand] >= 0 for operand in operands]
    if not accepts(op, len(operands)) or not any(tracked):
        raise HeaderError(f"wrong operands of {op.name}")
    if op.name in FOLDED and any(t and i % 4 != 1 for i, t in enumerate(tracked)):
        raise HeaderError(f"wrong operands of {op.name}")
    depth = max(depths[operand] for operand in operands) + 1
    if depth > DEPTH_LIMIT:
        raise HeaderError("too deep an expression")
    depths.append(depth)
    outline.slots.append(None)
    if len(operands) > 2:
        outline.steps.append((number, op, tuple(operands), None, depth))
    else:
        b = operands[1] if len(operands) == 2 else None
        outline.steps.append((number, op, operands[0], b, depth))


def _field(field: Any, before: str, depths: list[int]) -> tuple[str, int]:
    if type(field) is not list or len(field) != 3:
        raise HeaderError("a field is not an array of 3")
    shared, rest, slot = field
    _index(shared, len(before) + 1)
    path = before[:shared] + _string(rest)
    if len(path) > _MAX_PATH:
        raise HeaderError("too long a path")
    if depths[_index(slot, len(depths))] < 0:
        raise HeaderError("a field without provenance")
    return path, slot


def _index(value: Any, end: int) -> int:
    if type(value) is not int or not 0 <= value < end:
        raise HeaderError("index out of range")
    return value


def _string(value: Any) -> str:
    # Printable: these strings end up on terminals.
    if type(value) is not str or len(value) > _MAX_STRING or not value.isprintable():
        raise HeaderError("not a proper string")
    return value


__all__ = [
    "MAX_SIZE",
    "SUFFIX",
    "VERSION",
    "Header",
    "HeaderError",
    "Outline",
    "checksum_of",
    "decode",
    "unwrap",
    "wrap",
]
