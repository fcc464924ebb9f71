"""The header as bytes: what goes in comes out, and nothing else gets in."""

import math
import random
import struct
import zlib
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import msgpack
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import MultiArrayDimension, UInt8MultiArray

from rosslt_auto.provenance import Source, is_tracked, provenance
from rosslt_auto.provenance.expressions import topological
from rosslt_auto.provenance.locations import LiteralInfo
from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.provenance.registry import location_of, register_literals
from rosslt_auto.provenance.texts import text
from rosslt_auto.provenance.values import leaf, record
from rosslt_auto.ros import header
from rosslt_auto.ros.encoding import FOLDED_DEPTH, HISTORY_DEPTH, LIMIT, Encoder
from rosslt_auto.ros.header import HeaderError, decode, unwrap, wrap
from rosslt_auto.ros.operands import accepts, fits
from support.wire import source, told, tracked


def encode(*fields: tuple[str, Any], checksum: int = 17, sequence: int = 4) -> bytes:
    payload, kept = Encoder(lambda _: None).encode(checksum, sequence, fields)
    assert kept == len(fields)
    return payload


def round_trip(*fields: tuple[str, Any]) -> dict[str, Any]:
    return decode(encode(*fields)).fields()


# ---------------------------------------------------------------- round trips

_SOURCES = [source(f"number_{i}", kind) for i, kind in enumerate(["float", "int", "float", "int"])]
_floats = st.floats(allow_nan=True, allow_infinity=True)
_integers = st.integers(-(2**70), 2**70)
_leaves = st.one_of(
    st.builds(leaf, st.sampled_from(_SOURCES[::2]), _floats),
    st.builds(leaf, st.sampled_from(_SOURCES[1::2]), _integers),
)


def _operation(pair: tuple[Any, Any, str]) -> Any:
    a, b, name = pair
    try:
        result = OPERATORS[name].forward(*(_plain(x) for x in (a, b)))
    except (ArithmeticError, ValueError):
        return a
    return record(OPERATORS[name], result, a, b)


def _plain(value: Any) -> Any:
    return value._v if is_tracked(value) else value


_expressions = st.recursive(
    _leaves,
    lambda inner: st.tuples(
        inner, st.one_of(inner, _floats, _integers), st.sampled_from(["add", "sub", "mul", "mod"])
    ).map(_operation),
    max_leaves=12,
).filter(is_tracked)


@given(st.lists(_expressions, min_size=1, max_size=5), st.integers(0, 2**32 - 1))
def test_expressions_come_out_as_they_went_in(values: list[Any], checksum: int) -> None:
    fields = [(f"points[{i}].x", value) for i, value in enumerate(values)]
    found = decode(encode(*fields, checksum=checksum, sequence=2**40))
    assert (found.checksum, found.sequence) == (checksum, 2**40)
    received = found.fields()
    assert list(received) == [path for path, _ in fields]
    for path, value in fields:
        assert told(received[path]) == told(value)


def test_what_is_shared_stays_shared() -> None:
    both = tracked(2.0) * 3
    received = round_trip(("x", both + 1), ("y", both + 2), ("z", both))
    assert received["x"]._a is received["y"]._a is received["z"]
    assert len(topological(received.values())) == 4


def test_order_of_sources_is_kept() -> None:
    value = tracked(2, "first") * tracked(3, "second") + tracked(4, "third")
    found = provenance(round_trip(("data", value))["data"])
    assert found is not None
    assert [one.hint for one in found.sources] == ["first", "second", "third"]
    assert found.expression == "first * second + third"


def test_operators_with_one_and_with_many_operands() -> None:
    a, b = tracked(3.0, "a"), tracked(4.0, "b")
    values = {
        "sin": record(OPERATORS["sin"], math.sin(3.0), a),
        "hypot": record(OPERATORS["hypot"], 13.0, a, b, 12.0),
        "round": round(tracked(1.234), 2),
        "powmod": pow(tracked(3, "k"), 5, 7),
        "neg": -a,
    }
    received = round_trip(*values.items())
    assert {path: told(value) for path, value in received.items()} == {
        path: told(value) for path, value in values.items()
    }


def test_every_operator_of_the_table_can_be_read_again() -> None:
    """An operator that the encoder writes and the decoder refuses would lose whole headers."""
    counts = {"sum": 3, "hypot": 3, "affine": 5, "linear": 5, "powmod": 3}
    for op in OPERATORS.values():
        count = counts.get(op.name) or next(n for n in range(1, 6) if accepts(op, n))
        operands: list[Any] = [1.0] * count
        result: Any = 5.0
        first: Any = 2.0
        if not fits(op, float, [float] * count):  # an operator of texts
            operands = [None if op.name == "slice" else "a"] * count
            result = first = "b"
            if fits(op, float, [str] * count):  # one that reads a text
                result = 5.0
        operands[1 if op.name in ("affine", "linear") else 0] = tracked(first)
        if op.name == "repeat":
            operands[1] = 2
        value = record(op, result, *operands)
        assert told(round_trip(("x", value))["x"]) == told(value), op.name


def test_constants_of_other_types_are_numbers_on_the_wire() -> None:
    np = pytest.importorskip("numpy")
    add = OPERATORS["add"]
    received = round_trip(
        ("x", record(add, 3, tracked(2), True)),
        ("y", record(add, 2.5, tracked(2.0), np.float64(0.5))),
    )
    assert received == {"x": 3, "y": 2.5}
    assert type(received["x"]._b) is int
    assert type(received["y"]._b) is float


def test_strings_may_be_operands() -> None:
    op = OPERATORS["int"]
    value = record(op, 12, leaf(Source("/n", "rosslt.m.text", "str"), "12"))
    assert told(round_trip(("data", value))["data"]) == told(value)


def test_an_operation_on_plain_numbers_is_a_plain_number() -> None:
    """What a fold may leave behind: an operator none of whose operands is tracked."""
    value = tracked(2.0) + 1
    value._set(OPERATORS["affine"], (3.0,), None, 1)
    assert round_trip(("x", value)) == {}
    received = round_trip(("x", value), ("y", tracked(1.0) + value))
    assert list(received) == ["y"]
    assert text(received["y"]) == "gain + 3.0"


def _summed(count: int) -> Any:
    value = tracked(1.0, "start")
    step = tracked(0.5, "step")
    for _ in range(count):
        value = value + step
    return value


def test_deep_expressions_are_folded() -> None:
    value = _summed(FOLDED_DEPTH + 50)
    Encoder(lambda _: None).fold(value)
    received = round_trip(("x", value))["x"]
    assert received == value
    assert len(topological([received])) < 10
    found = provenance(received)
    assert found is not None and {one.hint for one in found.sources} == {"start", "step"}


def test_deep_expressions_that_stay_the_same_are_kept() -> None:
    encoder = Encoder(lambda _: None)
    value = _summed(FOLDED_DEPTH - 10)
    for _ in range(30):
        encoder.fold(value)
        encoder.encode(0, 0, [("x", value)])
    assert value._depth == FOLDED_DEPTH - 10


def test_histories_that_grow_from_message_to_message_are_folded_early() -> None:
    encoder = Encoder(lambda _: None)
    value = tracked(0.0, "start")
    step = tracked(0.1, "step")
    depths, sizes, plain = [], [], 0.0
    for _ in range(500):
        value = value + step
        plain += 0.1
        encoder.fold(value)
        payload, _ = encoder.encode(0, 0, [("x", value)])
        assert decode(payload).fields()["x"] == plain
        depths.append(value._depth)
        sizes.append(len(payload))
    assert max(depths) < 3 * HISTORY_DEPTH
    assert max(sizes) < 4_500


def test_names_that_cannot_be_printed_do_not_get_far() -> None:
    odd = Source("/n", "rosslt.m.a", "float", file="/tmp/\x1b[31m\udc80.py", line=1, column=0,
                 text="\ta = 1\x07")  # fmt: skip
    [found] = provenance(round_trip(("x", leaf(odd, 1.0)))["x"]).sources  # type: ignore[union-attr]
    assert found.file == "/tmp/?[31m?.py"
    assert found.text is not None and found.text.isprintable() and "a = 1" in found.text


def test_sources_of_a_node_of_this_process_are_its_locations(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    infos = [LiteralInfo("rosslt.own.module.gain", "gain", True, 1, 7, 1, 10)]
    literals = register_literals(
        "test_header own", "own.module", "own/module.py", (1.5,), lambda: infos, lambda _: None
    )
    location = location_of("rosslt.own.module.gain")
    assert location is not None
    location.node = "/own/node"
    monkeypatch.setattr(header, "local_nodes", {"/own/node"})
    monkeypatch.setattr(header, "_outlines", {})
    received = round_trip(("x", location.leaf * 2.0))["x"]
    assert received._a is literals.table[0]
    location.change(2.5)
    header._outlines.clear()
    received = round_trip(("x", leaf(location, 1.5)))["x"]
    assert received is not literals.table[0]  # an old value of it
    assert provenance(received).sources == [location]  # type: ignore[union-attr]


# ---------------------------------------------------------------- the encoder


def test_outline_is_the_same_while_only_values_change() -> None:
    encoder = Encoder(lambda _: None)
    gain = tracked(2.0)
    outlines = set()
    for time in range(5):
        payload, _ = encoder.encode(time, time, [("x", gain * time), ("y", gain)])
        outlines.add(msgpack.unpackb(payload[1:])[2])
        assert decode(payload).fields()["x"] == 2.0 * time
    assert len(outlines) == 1
    other, _ = encoder.encode(0, 0, [("x", gain + 1), ("y", gain)])
    assert msgpack.unpackb(other[1:])[2] not in outlines


def test_sources_without_node_are_owned_first_and_described_with_their_node() -> None:
    asked = []

    def own(one: Source) -> None:
        asked.append(one)
        one.node = "/me"

    encoder = Encoder(own)
    gain = tracked(2.0, node=None)
    for _ in range(2):
        payload, _ = encoder.encode(0, 0, [("x", gain * 2)])
        [found] = provenance(decode(payload).fields()["x"]).sources  # type: ignore[union-attr]
        assert found.node == "/me"
    assert len(asked) == 1
    asked[0].node = None  # its node was destroyed
    encoder.encode(0, 0, [("x", gain * 2)])
    assert len(asked) == 2
    asked[0].node = "/another"
    payload, _ = encoder.encode(0, 0, [("x", gain * 2)])
    assert provenance(decode(payload).fields()["x"]).sources[0].node == "/another"  # type: ignore[union-attr]


def test_too_large_a_header_loses_whole_fields() -> None:
    encoder = Encoder(lambda _: None)
    fields = [(f"points[{i}].x", tracked(float(i), f"number_{i}")) for i in range(3000)]
    for _ in range(2):  # the second time it knows
        payload, kept = encoder.encode(0, 0, fields)
        assert LIMIT // 2 < len(payload) <= LIMIT
        assert 0 < kept < len(fields)
        assert list(decode(payload).fields()) == [path for path, _ in fields[:kept]]
    payload, kept = encoder.encode(0, 0, fields[:10])
    assert kept == 10


def test_hundreds_of_fields_find_place() -> None:
    gain = tracked(2.0)
    fields = [
        (f"markers[{i}].pose.position.{axis}", gain * (i + 0.5))
        for i in range(500)
        for axis in "xyz"
    ]
    payload, kept = Encoder(lambda _: None).encode(0, 0, fields)
    assert kept == 1500
    assert list(decode(payload).fields().items()) == fields


def test_a_field_that_cannot_be_written_costs_only_itself() -> None:
    odd = record(OPERATORS["add"], 3.0, tracked(2.0), object())
    payload, kept = Encoder(lambda _: None).encode(0, 0, [("x", odd), ("y", tracked(1.0))])
    assert kept == 1
    assert list(decode(payload).fields()) == ["y"]


# ---------------------------------------------------------------- the message around it


@pytest.mark.parametrize("size", [0, 1, 2, 3, 4, 5, 1000])
def test_bytes_are_those_of_a_serialised_message(size: int) -> None:
    payload = bytes(i % 256 for i in range(size))
    message = deserialize_message(wrap(payload), UInt8MultiArray)
    assert bytes(message.data) == payload
    assert unwrap(wrap(payload)) == payload
    assert unwrap(serialize_message(message)) == payload


def test_the_other_byte_order_is_understood() -> None:
    big_endian = b"\0\0\0\0" + struct.pack(">III", 0, 0, 3) + b"abc"
    assert unwrap(big_endian) == b"abc"


def test_padding_makes_no_difference_to_the_checksum() -> None:
    for size in range(1, 9):
        data = bytes(range(1, size + 1))
        padded = data + bytes(-size % 4)
        assert header.checksum_of(data) == header.checksum_of(padded) == zlib.crc32(padded)


def test_a_layout_is_refused() -> None:
    message = UInt8MultiArray(data=b"abc")
    message.layout.dim = [MultiArrayDimension(label="bytes", size=3, stride=1)]
    with pytest.raises(HeaderError):
        unwrap(serialize_message(message))


@pytest.mark.parametrize("bad", [b"", b"\0\1", wrap(b"abc")[:-1], wrap(b"")[:-4] + b"\xff" * 4,
                                 b"\0\1\0\0\xff\xff\xff\xff" + bytes(12)])  # fmt: skip
def test_truncated_messages(bad: bytes) -> None:
    with pytest.raises(HeaderError):
        unwrap(bad)


# ---------------------------------------------------------------- hostile input


def _document(**changes: Any) -> bytes:
    """A small header with parts of it replaced."""
    parts: dict[str, Any] = {
        "version": 1,
        "checksum": 1,
        "sequence": 1,
        "names": ["/node", "file.py"],
        "sources": [[0, "rosslt.a", "float", None, True, 1, 3, 4, "a = 1.5"]],
        "slots": [[0, 1.5], None, ["mul", 0, 1]],
        "fields": [[0, "x", 2]],
        "values": [2.0, 3.0],
    }
    parts |= changes
    outline = msgpack.packb([parts[k] for k in ("names", "sources", "slots", "fields")])
    document = [
        parts["checksum"],
        parts["sequence"],
        parts.get("outline", outline),
        parts["values"],
    ]
    return bytes([parts["version"]]) + msgpack.packb(document)


def test_the_document_that_the_next_tests_damage_is_good() -> None:
    assert text(decode(_document()).fields()["x"]) == "a * 2.0"


def _source(**changes: Any) -> list[list[Any]]:
    keys = ("node", "parameter", "kind", "hint", "named", "file", "line", "column", "text")
    good = [0, "rosslt.a", "float", None, True, 1, 3, 4, "a = 1.5"]
    return [list((dict(zip(keys, good, strict=True)) | changes).values())]


@pytest.mark.parametrize(
    "changes",
    [
        {"version": 0},
        {"version": 2},
        {"checksum": -1},
        {"checksum": 2**32},
        {"checksum": 1.0},
        {"checksum": True},
        {"sequence": -1},
        {"sequence": None},
        {"outline": b""},
        {"outline": "text"},
        {"outline": msgpack.packb([1, 2, 3, 4])},
        {"outline": msgpack.packb([[], [], []])},
        {"names": [1]},
        {"names": ["no node", "file.py"]},
        {"names": ["/node", "\x1b[2J"]},
        {"names": ["/node", "x" * 5000]},
        {"sources": [[]]},
        {"sources": [None]},
        {"sources": _source(node=2)},
        {"sources": _source(node=-1)},
        {"sources": _source(node="/node")},
        {"sources": _source(parameter=None)},
        {"sources": _source(parameter="\n")},
        {"sources": _source(kind="complex")},
        {"sources": _source(kind=["float"])},
        {"sources": _source(named=1)},
        {"sources": _source(line=-1)},
        {"sources": _source(line=2**31)},
        {"sources": _source(column=0.5)},
        {"sources": _source(text=5)},
        {"slots": [[0, 1.5], None, ["mul", 0, 2]]},  # itself
        {"slots": [[0, 1.5], None, ["mul", 0, 3]]},
        {"slots": [[0, 1.5], None, ["mul", 0, -1]]},
        {"slots": [[0, 1.5], None, ["mul", 0, True]]},
        {"slots": [[0, 1.5], None, ["mul", 0]]},
        {"slots": [[0, 1.5], None, ["mul", 0, 1, 1]]},
        {"slots": [[0, 1.5], None, ["mul", 1, 1]]},  # nothing tracked in it
        {"slots": [[0, 1.5], None, ["evil", 0, 1]]},
        {"slots": [[0, 1.5], None, ["literal", 0, 1]]},
        {"slots": [[0, 1.5], None, ["deferred", 0]]},
        {"slots": [[0, 1.5], None, ["mul"]]},
        {"slots": [[0, 1.5], None, []]},
        {"slots": [[0, 1.5], None, "mul"]},
        {"slots": [[1, 1.5], None, ["mul", 0, 1]]},
        {"slots": [[0, 1], None, ["mul", 0, 1]]},  # an int from a float source
        {"slots": [[0, None], None, ["mul", 0, 1]]},
        {"slots": [[0, [1.5]], None, ["mul", 0, 1]]},
        {"slots": [[0, 1.5], None, ["affine", 1, 0, 1, 1]]},
        {"slots": [[0, 1.5], None, ["affine", 0, 0, 1, 1, 1]]},
        {"fields": [[0, "x", 1]]},  # a plain number
        {"fields": [[0, "x", 3]]},
        {"fields": [[1, "x", 2]]},
        {"fields": [[0, "x", 2], [0, "x", 0]]},
        {"fields": [[0, None, 2]]},
        {"fields": [[0, "x" * 600, 2]]},
        {"fields": [[0, "x"]]},
        {"fields": {"x": 2}},
        {"values": [2.0]},
        {"values": [2.0, 3.0, 4.0]},
        {"values": [2.0, None]},  # a result
        {"values": [2.0, True]},
        {"values": [2.0, [3.0]]},
        {"values": [2.0, msgpack.ExtType(2, b"x")]},
        {"values": [2.0, msgpack.ExtType(1, bytes(2000))]},
        {"values": [2.0, msgpack.Timestamp(0)]},
        {"values": 5},
    ],
    ids=repr,
)  # fmt: skip
def test_damaged_documents(changes: dict[str, Any]) -> None:
    with pytest.raises(HeaderError):
        decode(_document(**changes))


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"\x01",
        b"\x01\xc1",
        b"\x01\xdd\xff\xff\xff\xff",
        b"\x01" + b"\x91" * 100_000,
        b"\x01" + msgpack.packb([1, 2, 3]),
        b"\x01" + msgpack.packb({"a": 1}),
        _document() + b"\0",
        bytes(header.MAX_SIZE + 1),
        b"\x01" + bytes(header.MAX_SIZE),
    ],
    ids=lambda payload: repr(payload[:12]),
)
def test_no_documents_at_all(payload: bytes) -> None:
    with pytest.raises(HeaderError):
        decode(payload)


def test_too_deep_expressions_are_refused() -> None:
    slots: list[Any] = [[0, 1.5]] + [["neg", i] for i in range(3000)]
    with pytest.raises(HeaderError):
        decode(_document(slots=slots, values=[1.0] * 3000, fields=[[0, "x", 3000]]))


def test_truncation_anywhere() -> None:
    payload = _document()
    for end in range(len(payload)):
        with pytest.raises(HeaderError):
            decode(payload[:end])


def _use(payload: bytes) -> None:
    """Everything that is done with a header that passed; it must not fail then."""
    for value in decode(payload).fields().values():
        assert is_tracked(value)
        text(value)
        found = provenance(value)
        assert found is not None
        found.sources  # noqa: B018


def _mutations(flip: Callable[[int], int]) -> Callable[[bytes], bytes]:
    def mutated(payload: bytes) -> bytes:
        damaged = bytearray(payload)
        for _ in range(1 + flip(3)):
            damaged[flip(len(damaged))] = flip(256)
        return bytes(damaged)

    return mutated


def test_random_damage_gives_an_error_or_a_header() -> None:
    a, b = tracked(3.0, "a"), tracked(4, "b")
    good = encode(
        ("position.x", a * b + 2.5),
        ("position.y", record(OPERATORS["sin"], math.sin(3.0), a)),
        ("points[3].x", record(OPERATORS["hypot"], 13.0, a, 4.0, 12.0)),
    )
    chosen = random.Random(7)
    mutated = _mutations(chosen.randrange)
    passed = 0
    for _ in range(20_000):
        try:
            _use(mutated(good))
            passed += 1
        except HeaderError:
            pass
    assert passed > 100  # it is the damage that is refused, not everything


@settings(max_examples=300)
@given(st.binary(max_size=200))
@example(b"\x01\x94\x00\x00\xc4\x00\x90")
def test_any_bytes(payload: bytes) -> None:
    for candidate in (payload, b"\x01" + payload, b"\x01\x94" + payload):
        with suppress(HeaderError):
            _use(candidate)


_json = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 5) | st.floats() | st.text(max_size=4)
    | st.sampled_from(["mul", "add", "affine", "float", "/node"]) | st.binary(max_size=4),
    lambda inner: st.lists(inner, max_size=9),
    max_leaves=20,
)  # fmt: skip


@settings(max_examples=300)
@given(st.sampled_from(["names", "sources", "slots", "fields", "values"]), _json)
def test_any_document(part: str, content: Any) -> None:
    with suppress(HeaderError):
        _use(_document(**{part: content}))


def test_outlines_are_not_kept_for_ever() -> None:
    for i in range(1000):
        decode(_document(names=["/node", f"file{i}.py"]))
    assert len(header._outlines) <= header._OUTLINES_KEPT
    for i in range(200):
        decode(_document(names=["/node", f"file{i}" + "x" * 4000] + ["y" * 4000] * 20))
    assert sum(map(len, header._outlines)) <= header._BYTES_KEPT
