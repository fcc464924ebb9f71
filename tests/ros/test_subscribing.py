"""Messages arrive with their provenance, whoever sends and however they are received."""

import logging
import struct
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Point, Pose
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import MultiThreadedExecutor
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.subscription import Subscription
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Float64, Header, Int32, UInt8MultiArray

from rosslt_auto.provenance import is_tracked, provenance
from rosslt_auto.ros import encoding, header, publishing, subscribing
from rosslt_auto.ros.fields import tracked_fields
from rosslt_auto.ros.observer import Observer
from support.process import ROOT, Program, environment
from support.waiting import wait_until
from support.wire import Nodes, headers_of, told, tracked, wait_until_heard, woven
from support.woven import spinning

SENDER = Path(__file__).parent / "nodes" / "sender.py"
CHECKS = ["", "1"]


@pytest.fixture(params=CHECKS, ids=["unchecked", "checked"], scope="module", autouse=True)
def _check_fields(request: pytest.FixtureRequest) -> Iterator[None]:
    """With and without ROS_PYTHON_CHECK_FIELDS, which message modules read when imported."""
    with pytest.MonkeyPatch.context() as patch:
        for cls in (Point, Pose, Float64, Int32, Header, UInt8MultiArray):
            module = __import__(cls.__module__, fromlist=["x"])
            patch.setattr(module, "ros_python_check_fields", request.param)
        yield


@pytest.fixture
def nodes(domain: int) -> Iterator[Nodes]:
    with woven(), Nodes(domain) as made:
        yield made


_names = (f"topic_{i}" for i in range(1000))


@pytest.fixture
def topic() -> str:
    return next(_names)


def sender(domain: int, topic: str, *options: str) -> Program:
    """Points with provenance, from another process."""
    variables = environment(domain, PYTHONPATH=str(ROOT), ROS_PYTHON_CHECK_FIELDS="1")
    return Program([sys.executable, str(SENDER), "--topic", topic, *options], variables)


def pair(nodes: Nodes, cls: type, topic: str, callback: Any, qos: Any = 10, **more: Any) -> Any:
    """A publisher and a subscription that have found each other, headers too."""
    publisher = nodes.node("sender").create_publisher(cls, topic, qos)
    subscription = nodes.node("receiver").create_subscription(cls, topic, callback, qos, **more)
    wait_until_heard(publisher)
    return publisher, subscription


def is_whole(point: Point) -> bool:
    """Whether a point of the sender has the provenance that it was sent with."""
    x, y = provenance(point.x), provenance(point.y)
    return (
        x is not None
        and y is not None
        and x.expression == f"gain * {point.x * 2!r}".replace(".0", "")
        and [source.hint for source in x.sources] == ["gain"]
        and [source.hint for source in y.sources] == ["offset"]
        and type(point.z) is float
    )


# ---------------------------------------------------------------- between processes


def test_every_message_of_another_process_has_its_provenance(domain: int, topic: str) -> None:
    got: list[Point] = []
    with woven(), Nodes(domain) as nodes:
        subscription = nodes.node().create_subscription(Point, topic, got.append, 1000)
        with sender(domain, topic, "--count", "300", "--rate", "1000", "--depth", "1000"):
            nodes.spin_until(lambda: len(got) == 300, "300 messages")
    assert [point.z for point in got] == [float(i) for i in range(300)]
    assert all(map(is_whole, got))
    assert headers_of(subscription) is None  # uninstalled
    [source] = provenance(got[7].x).sources  # type: ignore[union-attr]
    assert (source.node, source.parameter) == ("/sender", "rosslt.sender.gain")
    assert (source.file, source.line, source.column) == ("sender.py", 1, 7)


def test_untracked_messages_between_tracked_ones(domain: int, topic: str) -> None:
    got: list[Point] = []
    with woven(), Nodes(domain) as nodes:
        nodes.node().create_subscription(Point, topic, got.append, 1000)
        options = ("--count", "200", "--rate", "1000", "--depth", "1000", "--untracked-too")
        with sender(domain, topic, *options):
            nodes.spin_until(lambda: len(got) == 200, "200 messages")
    for i, point in enumerate(got):
        assert is_whole(point) if i % 2 == 0 else not tracked_fields(point), i


@pytest.mark.parametrize("options", [(), ("--constant",)], ids=["different", "equal"])
def test_two_publishers_of_one_topic(domain: int, topic: str, options: tuple[str, ...]) -> None:
    """Sequence numbers repeat, and equal messages have equal checksums."""
    got: list[Point] = []
    count = 150
    common = (*options, "--count", str(count), "--rate", "500", "--depth", "1000")
    with woven(), Nodes(domain) as nodes:
        nodes.node().create_subscription(Point, topic, got.append, 1000)
        with (
            sender(domain, topic, "--name", "one", *common),
            sender(domain, topic, "--name", "two", *common),
        ):
            nodes.spin_until(lambda: len(got) == 2 * count, "messages of both")
    owners = [_owner(point) for point in got]
    # A message that comes while the second publisher is being discovered may be without.
    assert owners.count("/one") >= count - 2 and owners.count("/two") >= count - 2
    assert owners.count(None) == 2 * count - owners.count("/one") - owners.count("/two")
    if not options:  # in the order of each sender
        for name in ("/one", "/two"):
            mine = [p.z for p, owner in zip(got, owners, strict=True) if owner == name]
            assert mine == sorted(mine)


def _owner(point: Point) -> str | None:
    x, y = provenance(point.x), provenance(point.y)
    if x is None and y is None:
        return None
    assert x is not None and y is not None
    [owner] = {source.node for source in [*x.sources, *y.sources]}
    return owner


def test_a_tracked_and_an_untracked_publisher(domain: int, topic: str) -> None:
    """Messages without provenance do not wait for it, and get none of the others'."""
    got: list[Point] = []
    with woven(), Nodes(domain) as nodes:
        node = nodes.node()
        node.create_subscription(Point, topic, got.append, 1000)
        other = node.create_publisher(Point, topic, 1000)
        with sender(domain, topic, "--count", "100", "--rate", "500", "--depth", "1000"):
            while sum(point.y == 0.25 for point in got) < 100:
                other.publish(Point(x=-1.0, z=-1.0))
                nodes.executor.spin_once(timeout_sec=0.001)
    for point in got:
        assert is_whole(point) if point.z >= 0 else not tracked_fields(point)


def test_late_joiners_get_headers_too(domain: int, topic: str) -> None:
    got: list[Point] = []
    qos = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    options = ("--latched", "--early", "--count", "5", "--depth", "5")
    with sender(domain, topic, *options) as program:
        program.stdout.matching("sent")
        with woven(), Nodes(domain) as nodes:
            node = nodes.node()
            subscription = node.create_subscription(Point, topic, got.append, qos)
            # Data may overtake the discovery of its headers here: nothing is taken before.
            handle = headers_of(subscription)._handle
            wait_until(handle.get_publisher_count, "the header topic")
            wait_until(lambda: headers_of(subscription).expected(), "the first header")
            nodes.spin_until(lambda: len(got) == 5, "the messages of before")
    assert [point.z for point in got] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert sum(map(is_whole, got)) >= 4


def test_best_effort(domain: int, topic: str) -> None:
    """What arrives has its provenance, whatever is lost in between."""
    got: list[Point] = []
    with woven(), Nodes(domain) as nodes:
        nodes.node().create_subscription(Point, topic, got.append, qos_profile_sensor_data)
        options = ("--best-effort", "--count", "200", "--rate", "500", "--depth", "5")
        with sender(domain, topic, *options) as program:
            nodes.spin_until(lambda: program.stdout.all and len(got) > 100, "most messages")
    assert all(map(is_whole, got))


def test_best_effort_with_a_slow_receiver(domain: int, topic: str) -> None:
    """Most messages are overwritten in the queue; headers of others must not be attached."""
    got: list[Point] = []
    with woven(), Nodes(domain) as nodes:
        node = nodes.node()
        qos = QoSProfile(depth=2, reliability=ReliabilityPolicy.BEST_EFFORT)
        subscription = node.create_subscription(Point, topic, got.append, qos)
        options = ("--best-effort", "--count", "300", "--rate", "1000", "--depth", "2")
        with sender(domain, topic, *options) as program:
            pause = threading.Event()
            while not program.stdout.all:
                nodes.executor.spin_once(timeout_sec=0.01)
                pause.wait(0.01)
            nodes.spin_until(lambda: got and got[-1].z == 299.0, "the last message")
        assert len(got) < 290
        assert all(point.x == 0.5 * point.z for point in got)
        # Headers are queued for longer than data, but not for ever: a stall may lose a few.
        assert sum(map(is_whole, got)) >= 0.8 * len(got)
        assert headers_of(subscription)._count <= headers_of(subscription)._limit


def test_keep_all(domain: int, topic: str) -> None:
    got: list[Point] = []
    with woven(), Nodes(domain) as nodes:
        qos = QoSProfile(history=HistoryPolicy.KEEP_ALL)
        nodes.node().create_subscription(Point, topic, got.append, qos)
        with sender(domain, topic, "--keep-all", "--count", "300", "--rate", "2000") as program:
            program.stdout.matching("sent")
            nodes.spin_until(lambda: len(got) == 300, "all messages")
    assert all(map(is_whole, got))


def test_remapped_and_in_namespaces(domain: int, topic: str) -> None:
    got: list[Point] = []
    rules = ("--ros-args", "-r", "__ns:=/robot", "-r", f"{topic}:={topic}/moved")
    mine = ["--ros-args", "-r", f"input:=/robot/{topic}/moved", "-r", "__ns:=/station"]
    with woven(), Nodes(domain) as nodes:
        node = nodes.node("receiver", cli_args=mine)
        node.create_subscription(Point, "input", got.append, 10)
        with sender(domain, topic, "--count", "5", *rules):
            nodes.spin_until(lambda: len(got) == 5, "5 messages")
    assert all(map(is_whole, got))
    assert _owner(got[0]) == "/robot/sender"


# ---------------------------------------------------------------- ways to receive


def test_callbacks_get_the_arguments_that_they_get_without(nodes: Nodes, topic: str) -> None:
    message_only: list[Any] = []
    with_info: list[Any] = []
    raw: list[Any] = []
    raw_with_info: list[Any] = []
    node = nodes.node("receiver")
    node.create_subscription(Point, topic, message_only.append, 10)
    node.create_subscription(Point, topic, lambda m, info: with_info.append((m, info)), 10)
    node.create_subscription(Point, topic, raw.append, 10, raw=True)
    node.create_subscription(
        Point, topic, lambda m, info: raw_with_info.append((m, info)), 10, raw=True
    )
    publisher = nodes.node("sender").create_publisher(Point, topic, 10)
    wait_until(lambda: publisher.get_subscription_count() == 4, "four subscriptions")
    wait_until(lambda: headers_of(publisher)._handle.get_subscription_count() >= 2, "headers")
    message = Point(x=tracked(1.5))
    publisher.publish(message)
    nodes.spin_until(lambda: message_only and with_info and raw and raw_with_info, "all callbacks")
    assert message_only == [message] and is_tracked(message_only[0].x)
    [(found, info)] = with_info
    assert found == message and is_tracked(found.x)
    assert type(info) is dict and info.keys() == raw_with_info[0][1].keys()
    assert info["publication_sequence_number"] == 1
    assert type(raw[0]) is bytes and raw[0] == raw_with_info[0][0] == serialize_message(message)
    assert deserialize_message(raw[0], Point) == message


def test_plain_publishers_are_received_as_plain(nodes: Nodes, topic: str) -> None:
    got: list[Point] = []
    subscription = nodes.node().create_subscription(Point, topic, got.append, 10)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(subscribing, "_deserialise", lambda *_: pytest.fail("not as plain"))
        publisher = nodes.node("plain").create_publisher(Point, topic, 10)
        headers_of(publisher).destroy()
        publisher.handle.headers = None
        wait_until(lambda: not headers_of(subscription).expected(), "no header topic any more")
        wait_until_heard(publisher)
        publisher.publish(Point(x=1.0))
        nodes.spin_until(lambda: got, "the message")
    assert got == [Point(x=1.0)]


def test_values_are_what_plain_receiving_gives(nodes: Nodes, topic: str) -> None:
    got: list[Pose] = []
    publisher, _ = pair(nodes, Pose, topic, got.append)
    pose = Pose()
    pose.position.x = tracked(1.5, "a") * 2
    pose.position.y = tracked(-0.0)
    publisher.publish(pose)
    nodes.spin_until(lambda: got, "the message")
    [arrived] = got
    plain = deserialize_message(serialize_message(pose), Pose)
    assert arrived == plain and repr(arrived) == repr(plain)
    for own, other in ((arrived.position.x, plain.position.x), (arrived.position.y, -0.0)):
        assert is_tracked(own) and not is_tracked(other)
        assert type(own) == type(other) and own.__class__ is float  # noqa: E721
        assert struct.pack("d", own) == struct.pack("d", other)
    assert type(arrived.orientation.w) is float


def test_messages_of_odd_length(nodes: Nodes, domain: int, topic: str) -> None:
    """RTPS pads them between processes, not within one; both have to match."""
    got: list[Header] = []
    publisher, _ = pair(nodes, Header, topic, got.append)
    for length in range(9):
        message = Header(frame_id="x" * length)
        message.stamp.sec = tracked(length)
        publisher.publish(message)
        nodes.spin_until(lambda length=length: len(got) == length + 1, "the message")
        assert got[-1] == message and is_tracked(got[-1].stamp.sec)


def test_wait_for_message(domain: int, topic: str) -> None:
    with woven(), Nodes(domain) as nodes:
        node = nodes.node()
        options = ("--early", "--count", "2000", "--rate", "100")
        with sender(domain, topic, *options) as program:
            found = []

            def whole() -> bool:
                assert program.running, program
                done, message = wait_for_message(Point, node, topic, time_to_wait=1.0)
                found.append(message)
                return done and is_tracked(message.x)

            wait_until(whole, "a message with provenance")
        assert is_whole(found[-1])


def test_many_threads_and_a_reentrant_group(domain: int, topic: str) -> None:
    got: list[Point] = []
    with woven(), Nodes(domain) as nodes:
        node = rclpy.create_node("receiver", context=nodes.context)
        node.create_subscription(
            Point, topic, got.append, 1000, callback_group=ReentrantCallbackGroup()
        )
        options = ("--count", "300", "--rate", "1000", "--depth", "1000")
        try:
            with (
                spinning(node, MultiThreadedExecutor(4, context=nodes.context)),
                sender(domain, topic, *options),
            ):
                wait_until(lambda: len(got) == 300, "300 messages")
        finally:
            node.destroy_node()
    assert sorted(point.z for point in got) == [float(i) for i in range(300)]
    assert all(map(is_whole, got))


def test_polling_by_hand(nodes: Nodes, topic: str) -> None:
    publisher, subscription = pair(nodes, Point, topic, lambda _: None)
    publisher.publish(Point(x=tracked(1.0)))
    taken: list[Any] = []

    def take() -> bool:
        taken.append(subscription.handle.take_message(Point, False))
        return taken[-1] is not None

    wait_until(take, "the message")
    assert is_tracked(taken[-1][0].x)
    assert subscription.handle.take_message(Point, False) is None


def test_kept_and_republished(nodes: Nodes, topic: str) -> None:
    """A relay in between: the sources stay those of the first node, its own join them."""
    got: list[Point] = []
    kept: list[Point] = []
    relay = nodes.node("relay")
    onward = relay.create_publisher(Point, f"{topic}_2", 10)
    gain = tracked(3.0, "relay_gain", "/relay")

    def forward(point: Point) -> None:
        kept.append(point)
        onward.publish(Point(x=point.x * gain, y=point.x))

    relay.create_subscription(Point, topic, forward, 10)
    publisher = nodes.node("first").create_publisher(Point, topic, 10)
    nodes.node("last").create_subscription(Point, f"{topic}_2", got.append, 10)
    wait_until_heard(publisher)
    wait_until_heard(onward)
    publisher.publish(Point(x=tracked(2.0, "first_gain", "/first") + 1.0))
    nodes.spin_until(lambda: got, "what was relayed")
    found = provenance(got[0].x)
    assert found is not None and found.expression == "(first_gain + 1.0) * relay_gain"
    assert [(s.node, s.hint) for s in found.sources] == [
        ("/first", "first_gain"), ("/relay", "relay_gain"),
    ]  # fmt: skip
    assert told(got[0].y) == told(kept[0].x)


def test_a_loop_of_two_nodes_stays_bounded(nodes: Nodes, topic: str) -> None:
    """Each adds to what it got from the other: the history goes round and round."""
    rounds = 400
    last: list[Float64] = []
    ends = [nodes.node("a"), nodes.node("b")]
    names = [f"{topic}_a", f"{topic}_b"]
    publishers = [
        node.create_publisher(Float64, name, 10)
        for node, name in zip(ends, reversed(names), strict=True)
    ]
    sizes: list[int] = []

    def answer(index: int, message: Float64) -> None:
        last.append(message)
        if len(last) < rounds:
            step = tracked(0.5, f"step_{index}")
            publishers[index].publish(Float64(data=message.data + step))

    for i, (node, name) in enumerate(zip(ends, names, strict=True)):
        node.create_subscription(Float64, name, lambda m, i=i: answer(i, m), 10)
    for publisher in publishers:
        wait_until_heard(publisher)
        own = headers_of(publisher)
        inner = own._encoder.encode

        def measured(*args: Any, inner: Any = inner) -> Any:
            payload, kept = inner(*args)
            sizes.append(len(payload))
            return payload, kept

        own._encoder.encode = measured
    publishers[0].publish(Float64(data=tracked(0.0, "start")))
    nodes.spin_until(lambda: len(last) >= rounds, "all rounds")
    assert last[-1].data == 0.5 * (rounds - 1)
    assert is_tracked(last[-1].data)
    assert len(sizes) >= rounds and max(sizes) < encoding.LIMIT // 2


# ---------------------------------------------------------------- what may go wrong


class _Forger:
    """Publishes data as it likes, and headers of its own making."""

    def __init__(self, nodes: Nodes, topic: str) -> None:
        node = nodes.node("forger")
        self.data = node.create_publisher(Point, topic, 100)
        headers_of(self.data).destroy()
        self.data.handle.headers = None
        self.headers = node.create_publisher(UInt8MultiArray, topic + header.SUFFIX, 100)

    def wait(self) -> None:
        wait_until(
            lambda: self.data.get_subscription_count() and self.headers.get_subscription_count(),
            "the receiver",
        )

    def send(self, message: Any, payload: bytes | None = None, path: str = "x") -> None:
        data = serialize_message(message)
        if payload is None:
            payload, _ = encoding.Encoder(lambda _: None).encode(
                header.checksum_of(data), 77, [(path, tracked(message.x))]
            )
        self.headers.publish(UInt8MultiArray(data=payload))
        self.data.publish(data)


@pytest.fixture
def forged(nodes: Nodes, topic: str) -> tuple[_Forger, list[Point], Subscription]:
    got: list[Point] = []
    forger = _Forger(nodes, topic)
    subscription = nodes.node("receiver").create_subscription(Point, topic, got.append, 100)
    forger.wait()
    return forger, got, subscription


BAD = [b"", b"\x02rest", b"\x01", b"\x01\xc1", bytes(100), b"\x01" + b"\x91" * 1000]


def test_bad_headers_are_counted_and_warned_about_once(
    nodes: Nodes, forged: Any, caplog: pytest.LogCaptureFixture
) -> None:
    forger, got, subscription = forged
    with caplog.at_level(logging.WARNING):
        for i, payload in enumerate(BAD):
            forger.send(Point(x=float(i)), payload)
        nodes.spin_until(lambda: len(got) == len(BAD), "all messages")
        forger.send(Point(x=9.0))  # a good one
        nodes.spin_until(lambda: len(got) == len(BAD) + 1, "the last message")
    assert [point.x for point in got] == [*map(float, range(len(BAD))), 9.0]
    assert [is_tracked(point.x) for point in got] == [False] * len(BAD) + [True]
    assert headers_of(subscription).malformed == len(BAD)
    assert len(caplog.records) == 1
    assert "provenance header" in caplog.records[0].message
    assert subscription.topic in caplog.records[0].message


def test_a_header_for_other_fields_is_malformed(nodes: Nodes, forged: Any) -> None:
    forger, got, subscription = forged
    forger.send(Point(x=1.0), path="position.x")
    nodes.spin_until(lambda: got, "the message")
    assert got == [Point(x=1.0)] and not tracked_fields(got[0])
    assert headers_of(subscription).malformed == 1


def test_a_wrong_checksum_matches_nothing(nodes: Nodes, forged: Any) -> None:
    forger, got, subscription = forged
    payload, _ = encoding.Encoder(lambda _: None).encode(12345, 1, [("x", tracked(1.0))])
    for _ in range(3):
        forger.send(Point(x=1.0), payload)
    nodes.spin_until(lambda: len(got) == 3, "the messages")
    assert not any(map(tracked_fields, got))
    assert headers_of(subscription).matched == 0


def test_a_header_of_another_sequence_number_still_matches(nodes: Nodes, forged: Any) -> None:
    """Not every middleware has them."""
    forger, got, subscription = forged
    for i in range(10):
        forger.send(Point(x=float(i)))
        nodes.spin_until(lambda i=i: len(got) == i + 1, "the message")
    assert all(is_tracked(point.x) for point in got)
    assert not headers_of(subscription).trusted


def test_headers_without_messages_are_not_kept_for_ever(nodes: Nodes, forged: Any) -> None:
    forger, got, subscription = forged
    headers = headers_of(subscription)
    for i in range(2000):
        payload, _ = encoding.Encoder(lambda _: None).encode(i, i, [("x", tracked(1.0))])
        forger.headers.publish(UInt8MultiArray(data=payload))
        if i % 50 == 0:
            forger.data.publish(Point(x=float(i)))
            nodes.executor.spin_once(timeout_sec=0.01)
        assert headers._count <= headers._limit
        assert headers._count == sum(map(len, headers._waiting.values()))
    for i in range(headers._limit + 2):
        forger.data.publish(Point(x=float(i)))
        nodes.spin_until(lambda: got and got[-1].x == float(i), "a message")  # noqa: B023
    headers.match(b"\0\1\0\0", {"publication_sequence_number": 1})
    assert headers._count < headers._limit


def test_large_headers_are_bounded_in_bytes(
    nodes: Nodes, forged: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, _, subscription = forged
    monkeypatch.setattr(subscribing, "_MAX_BYTES", 10_000)
    headers = headers_of(subscription)
    for i in range(60):
        payload, _ = encoding.Encoder(lambda _: None).encode(i, i, [("x", tracked(1.0, "n" * 900))])
        headers._keep(header.decode(payload))
        assert headers._bytes <= 10_000
    assert 5 <= headers._count <= 10


def test_undeserialisable_data_is_passed_over_as_without(nodes: Nodes, forged: Any) -> None:
    forger, got, _ = forged
    forger.data.publish(b"\0\1\0\0abc")
    forger.send(Point(x=1.0))
    nodes.spin_until(lambda: got, "the good message")
    assert got == [Point(x=1.0)]


def test_untracked_messages_wait_hardly_for_headers_that_do_not_come(
    nodes: Nodes, forged: Any
) -> None:
    """Patience is for topics whose headers have been late before."""
    forger, got, subscription = forged
    forger.send(Point(x=1.0))
    nodes.spin_until(lambda: got, "the first message")
    headers = headers_of(subscription)
    waits = []
    inner = subscribing.time.sleep
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(subscribing.time, "sleep", lambda s: (waits.append(s), inner(s)))
        for i in range(50):
            forger.data.publish(Point(x=2.0 + i))
        nodes.spin_until(lambda: len(got) == 51, "the others")
    assert sum(waits) <= 5 * subscribing.PATIENCE
    assert not headers._worth_waiting()


@pytest.mark.parametrize("trusted_numbers", [False, True])
@pytest.mark.parametrize("patience", ["PATIENCE", "PATIENCE_AT_FIRST"])
def test_a_late_header_is_waited_for(
    nodes: Nodes, forged: Any, patience: str, trusted_numbers: bool
) -> None:
    forger, got, subscription = forged
    if patience == "PATIENCE":
        forger.send(Point(x=1.0))
        nodes.spin_until(lambda: got, "the first message")
    headers = headers_of(subscription)
    wait_until(headers.expected, "the publisher of headers")
    data = serialize_message(Point(x=2.0))
    payload, _ = encoding.Encoder(lambda _: None).encode(
        header.checksum_of(data), 2, [("x", tracked(2.0))]
    )
    late = [None, None, header.decode(payload)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(subscribing, patience, 10.0)
        patch.setattr(headers, "_read", lambda: late.pop(0) if late else None)
        info = {"publication_sequence_number": 2}
        found = headers.match_sequence(info) if trusted_numbers else headers.match(data, info)
    assert found is not None and found.fields() == {"x": 2.0}


# ---------------------------------------------------------------- life and death


def test_destroyed_with_its_subscription(nodes: Nodes, topic: str) -> None:
    node = nodes.node()
    publisher = nodes.node("sender").create_publisher(Point, topic, 10)
    for _ in range(2):
        subscription = node.create_subscription(Point, topic, lambda _: None, 10)
        wait_until_heard(publisher)
        handle = headers_of(publisher)._handle
        node.destroy_subscription(subscription)
        wait_until(lambda: not handle.get_subscription_count(), "no header subscription")  # noqa: B023


def test_destroyed_in_its_own_callback(nodes: Nodes, topic: str) -> None:
    got: list[Point] = []
    node = nodes.node()

    def once(point: Point) -> None:
        got.append(point)
        node.destroy_subscription(subscription)

    subscription = node.create_subscription(Point, topic, once, 10)
    publisher = nodes.node("sender").create_publisher(Point, topic, 10)
    wait_until_heard(publisher)
    for _ in range(3):
        publisher.publish(Point(x=tracked(1.0)))
    nodes.spin_until(lambda: got, "one message")
    for _ in range(5):
        nodes.executor.spin_once(timeout_sec=0.01)
    assert len(got) == 1


def test_context_shut_down_while_taking(domain: int, topic: str) -> None:
    with woven(), Nodes(domain) as nodes:
        publisher, subscription = pair(nodes, Point, topic, lambda _: None)
        publisher.publish(Point(x=tracked(1.0)))
        rclpy.shutdown(context=nodes.context)
        subscription.handle.take_message(Point, False)  # whatever comes, no crash


def test_infrastructure_and_hidden_topics_have_none(nodes: Nodes) -> None:
    node = nodes.node()
    for name in ("/clock", "/rosout", "_hidden", "a/_action/status"):
        assert headers_of(node.create_subscription(Float64, name, lambda _: None, 10)) is None


def test_what_a_node_knows_of_itself_is_as_plain(nodes: Nodes, topic: str) -> None:
    node = nodes.node()
    before = list(node.subscriptions)
    subscription = node.create_subscription(Point, topic, lambda _: None, 10)
    assert list(node.subscriptions) == [*before, subscription]
    assert type(subscription) is Subscription
    assert type(subscription.handle).__name__ == "Subscription"


def test_event_callbacks_still_work(nodes: Nodes, topic: str) -> None:
    events: list[Any] = []
    nodes.node().create_subscription(
        Point, topic, lambda _: None, 10,
        event_callbacks=SubscriptionEventCallbacks(matched=events.append),
    )  # fmt: skip
    nodes.node("sender").create_publisher(Point, topic, 10)
    nodes.spin_until(lambda: events, "a matched event")


def test_an_error_in_a_callback_is_the_programs_own(nodes: Nodes, topic: str) -> None:
    def fail(_: Point) -> None:
        raise LookupError("mine")

    publisher, _ = pair(nodes, Point, topic, fail)
    publisher.publish(Point(x=tracked(1.0)))
    with pytest.raises(LookupError) as found:
        nodes.spin_until(lambda: False, "the error")
    files = [str(entry.path) for entry in found.traceback]
    assert not any("rosslt_auto" in name for name in files)


def test_installing_is_idempotent_and_reversible(domain: int, topic: str) -> None:
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.node import Node

    before = Node.__dict__["create_subscription"], rclpy_implementation.Subscription
    subscribing.install()
    subscribing.install()
    try:
        with Nodes(domain) as made:
            node = made.node()
            subscription = node.create_subscription(Point, topic, lambda _: None, 10)
            assert headers_of(subscription) is not None
            subscribing.uninstall()
            subscribing.uninstall()
            assert headers_of(subscription) is None
            assert subscription.handle.take_message(Point, False) is None
            later = node.create_subscription(Point, topic, lambda _: None, 10)
            assert type(later.handle) is before[1]
    finally:
        subscribing.uninstall()
    assert (Node.__dict__["create_subscription"], rclpy_implementation.Subscription) == before


def test_an_observer_weaves_for_itself_alone(
    own_domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a command or a view does in this process leaves nothing behind, and takes nothing."""
    from rclpy.node import Node

    monkeypatch.setenv("ROS_DOMAIN_ID", str(own_domain))
    before = Node.__dict__["create_subscription"]
    with Observer("first"):
        with Observer("second"):
            assert Node.__dict__["create_subscription"] is not before
        assert Node.__dict__["create_subscription"] is not before
    assert Node.__dict__["create_subscription"] is before
    with woven(subscribing), Nodes(own_domain) as made:
        woven_create = Node.__dict__["create_subscription"]
        with Observer("third"):
            pass
        assert Node.__dict__["create_subscription"] is woven_create
        subscription = made.node().create_subscription(Point, "point", lambda _: None, 10)
        assert headers_of(subscription) is not None


def test_headers_can_be_heard_before_messages(nodes: Nodes, topic: str) -> None:
    """Whoever finds the publisher of messages has found that of headers; and the other way."""
    made = []

    def noted(init: Any, entities: str) -> Any:
        def first(self: Any, node: Any, *args: Any) -> None:
            made.append([one.topic for one in getattr(node, entities)])
            init(self, node, *args)

        return first

    with pytest.MonkeyPatch.context() as patch:
        for cls, entities in (
            (publishing.HeaderPublisher, "publishers"),
            (subscribing.Headers, "subscriptions"),
        ):
            patch.setattr(cls, "__init__", noted(cls.__init__, entities))
        node = nodes.node()
        publisher = node.create_publisher(Point, topic, 10)
        subscription = node.create_subscription(Point, topic, print, 10)
    before, then = made
    assert publisher.topic not in before and publisher.topic in [p.topic for p in node.publishers]
    assert subscription.topic not in then


@pytest.mark.parametrize("make", ["create_publisher", "create_subscription"])
def test_what_cannot_be_made_leaves_no_headers(nodes: Nodes, topic: str, make: str) -> None:
    node = nodes.node()

    class Wrong:
        def __init__(self, *args: Any, **keywords: Any) -> None:
            raise LookupError("no such thing")

    kinds = {"create_publisher": "publisher_class", "create_subscription": "event_callbacks"}
    wrong = Wrong if make == "create_publisher" else object()
    arguments = (Point, topic, 10) if make == "create_publisher" else (Point, topic, print, 10)
    with pytest.raises((LookupError, AttributeError)):
        getattr(node, make)(*arguments, **{kinds[make]: wrong})
    beside = node.resolve_topic_name(topic) + header.SUFFIX
    wait_until(
        lambda: not node.count_publishers(beside) and not node.count_subscribers(beside),
        "the header topic is gone",
    )
