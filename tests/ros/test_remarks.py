"""What a remark beside a literal says, on its way to other nodes."""

from typing import Any

import msgpack
import pytest

from rosslt_auto.provenance import provenance
from rosslt_auto.provenance.limits import Limits
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.values import leaf
from rosslt_auto.ros.encoding import Encoder
from rosslt_auto.ros.header import HeaderError, decode


def sent(value: Any, **remark: Any) -> bytes:
    source = Source("/n", "rosslt.m.a", type(value).__name__)
    vars(source).update(remark)
    return Encoder(lambda _: None).encode(1, 1, [("x", leaf(source, value))])[0]


def received(payload: bytes) -> Source:
    [source] = provenance(decode(payload).fields()["x"]).sources  # type: ignore[union-attr]
    return source


@pytest.mark.parametrize("limits", [Limits(0.0, 2.0), Limits(-1.5, 2.0, 0.5)])
def test_ranges_travel(limits: Limits) -> None:
    source = received(sent(1.0, limits=limits))
    assert source.limits == limits and not source.frozen
    assert received(sent(1, limits=Limits(-3, 2))).limits == Limits(-3, 2)


def test_frozen_travels() -> None:
    source = received(sent(1.0, frozen=True))
    assert source.frozen and source.limits is None
    assert not received(sent(1.0)).frozen


def with_remark(remark: Any, value: Any = 1.0) -> bytes:
    payload = sent(value, frozen=True)
    document = msgpack.unpackb(payload[1:])
    outline = msgpack.unpackb(document[2])
    outline[1][0][9] = remark
    document[2] = msgpack.packb(outline)
    return payload[:1] + msgpack.packb(document)


@pytest.mark.parametrize(
    "remark",
    [True, None, 1, "off", [], [0.0, 1.0], [0.0, 1.0, None, 1], [0, 2, None], [0.0, "1", None],
     [2.0, 0.0, None], [float("nan"), 1.0, None], [0.0, float("inf"), None], [0.0, 1.0, 0.0],
     [0.0, 1.0, 2.0], [0.0, 1.0, float("nan")], [0.0, 1.0, 1], [False, True, None]],
    ids=repr,
)  # fmt: skip
def test_others_are_malformed(remark: Any) -> None:
    assert received(with_remark([0.0, 2.0, None])).limits == Limits(0.0, 2.0)
    with pytest.raises(HeaderError):
        decode(with_remark(remark))


def test_texts_have_no_range() -> None:
    with pytest.raises(HeaderError):
        decode(with_remark([0.0, 1.0, None], "a text"))
