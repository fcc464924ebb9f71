"""What a publisher with provenance sends, to those who know about it and to those who do not."""

import gc
import logging
import threading
import traceback
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Point, Pose
from rclpy._rclpy_pybind11 import RCLError
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Empty, Float64, Header, Int32, String, UInt8MultiArray

from rosslt_auto.provenance import Source, is_tracked, refresh
from rosslt_auto.provenance.values import leaf
from rosslt_auto.ros import encoding, handles, header, parameters, publishing
from support.observer import Observer
from support.waiting import wait_until
from support.wire import Nodes, headers_of, source, tracked, wait_until_heard, woven


@pytest.fixture(params=["", "1"], ids=["unchecked", "checked"], scope="module", autouse=True)
def _check_fields(request: pytest.FixtureRequest) -> Iterator[None]:
    """With and without ROS_PYTHON_CHECK_FIELDS, which message modules read when imported."""
    with pytest.MonkeyPatch.context() as patch:
        for cls in (Point, Pose, Float64, Int32, String, Header, UInt8MultiArray):
            module = __import__(cls.__module__, fromlist=["x"])
            patch.setattr(module, "ros_python_check_fields", request.param)
        yield


@pytest.fixture
def nodes(domain: int) -> Iterator[Nodes]:
    with woven(publishing), Nodes(domain) as made:
        yield made


class Listener:
    """A plain stranger who listens to a topic and to what is beside it."""

    def __init__(self, observer: Observer, cls: type, topic: str, depth: int = 1000) -> None:
        self.messages = observer.record(cls, topic, QoSProfile(depth=depth))
        self.payloads = observer.record(
            UInt8MultiArray, topic + header.SUFFIX, QoSProfile(depth=depth)
        )

    def headers(self, count: int) -> list[header.Header]:
        return [header.decode(bytes(m.data)) for m in self.payloads.first(count)]


_names = (f"topic_{i}" for i in range(1000))


@pytest.fixture
def topic() -> str:
    return next(_names)


def test_plain_listeners_get_the_plain_message_and_its_header(
    nodes: Nodes, observer: Observer, topic: str
) -> None:
    publisher = nodes.node().create_publisher(Point, topic, 10)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    publisher.publish(Point(x=tracked(1.5, "gain") * 2.0, y=2.0))
    [message] = listener.messages.first(1)
    assert message == Point(x=3.0, y=2.0)
    [found] = listener.headers(1)
    assert found.sequence == 1
    assert list(found.fields()) == ["x"] and found.fields()["x"] == 3.0


def test_untracked_messages_have_no_header_but_count(
    nodes: Nodes, observer: Observer, topic: str
) -> None:
    publisher = nodes.node().create_publisher(Point, topic, 10)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    publisher.publish(Point(x=1.0))
    publisher.publish(serialize_message(Point(x=2.0)))
    publisher.publish(Point(x=tracked(3.0)))
    assert [m.x for m in listener.messages.first(3)] == [1.0, 2.0, 3.0]
    [found] = listener.headers(1)
    assert found.sequence == 3
    assert len(listener.payloads) == 1


def test_checksum_is_that_of_the_bytes_that_are_sent(
    nodes: Nodes, observer: Observer, topic: str
) -> None:
    raw: list[bytes] = []
    observer.node.create_subscription(Header, topic, raw.append, 10, raw=True)
    publisher = nodes.node().create_publisher(Header, topic, 10)
    listener = Listener(observer, Header, topic)
    wait_until_heard(publisher)
    message = Header(frame_id="odd length")  # padding follows
    message.stamp.sec = tracked(5)
    publisher.publish(message)
    [found] = listener.headers(1)
    wait_until(lambda: raw, "the message as bytes")
    assert found.checksum == header.checksum_of(raw[0])
    assert deserialize_message(raw[0], Header) == message


def test_the_message_itself_is_left_alone(nodes: Nodes, topic: str) -> None:
    publisher = nodes.node().create_publisher(Point, topic, 10)
    value = tracked(1.5) * 2.0
    message = Point(x=value)
    publisher.publish(message)
    assert message.x is value


def test_nobody_listens_to_headers(nodes: Nodes, observer: Observer, topic: str) -> None:
    """No header is made, but sources become known."""
    owned: list[Source] = []
    messages = observer.record(Point, topic)
    publisher = nodes.node().create_publisher(Point, topic, 10)
    wait_until(publisher.get_subscription_count, "a subscriber")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parameters, "own", lambda node, one: owned.append(one))
        patch.setattr(header, "wrap", lambda payload: pytest.fail("a header was made"))
        publisher.publish(Point(x=tracked(1.5, node=None)))
    assert messages.first(1) == [Point(x=1.5)]
    assert [one.hint for one in owned] == ["gain"]


def test_sources_become_parameters_of_the_publishing_node(nodes: Nodes, topic: str) -> None:
    first, second = nodes.node("first"), nodes.node("second")
    seen: list[tuple[Any, str]] = []

    def own(node: Any, one: Source) -> None:
        seen.append((node, one.hint))
        one.node = node.get_fully_qualified_name()

    publishers = [node.create_publisher(Point, topic, 10) for node in (first, second)]
    gain = tracked(1.5, "gain", node=None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parameters, "own", own)
        for publisher in publishers * 2:
            publisher.publish(Point(x=gain * 2.0, y=tracked(1.0, "remote")))
    assert seen == [(first, "gain")]


def test_failing_owner_does_not_stop_the_message(
    nodes: Nodes, observer: Observer, topic: str, caplog: pytest.LogCaptureFixture
) -> None:
    publisher = nodes.node().create_publisher(Point, topic, 10)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)

    def fail(node: Any, one: Source) -> None:
        raise RuntimeError("no parameter today")

    with caplog.at_level(logging.WARNING), pytest.MonkeyPatch.context() as patch:
        patch.setattr(parameters, "own", fail)
        for x in (1.5, 2.5):
            publisher.publish(Point(x=tracked(x, node=None)))
    assert listener.messages.first(2) == [Point(x=1.5), Point(x=2.5)]
    assert [r.message for r in caplog.records if "no parameter today" in r.message] == [
        f"no provenance for a message on /{topic}: RuntimeError('no parameter today')"
    ]
    publisher.publish(Point(x=tracked(3.5)))
    assert listener.headers(1)[0].sequence == 3


def test_errors_are_those_of_plain_publishing(domain: int, topic: str) -> None:
    def wrong() -> Iterator[Any]:
        yield Pose()
        yield None
        yield "text"
        broken = Point(x=tracked(1.0))
        broken._y = "text"
        yield broken
        incomplete = Point(x=tracked(1.0))
        del incomplete._z
        yield incomplete

    with Nodes(domain) as made:
        plain = made.node("plain").create_publisher(Point, topic, 10)
        with woven(publishing):
            publisher = made.node().create_publisher(Point, topic, 10)
            assert headers_of(plain) is None and headers_of(publisher) is not None
            for own, other in zip(wrong(), wrong(), strict=True):
                assert _outcome(publisher, own) == _outcome(plain, other)


def _outcome(publisher: Publisher, message: Any) -> Any:
    try:
        publisher.publish(message)
    except Exception as error:
        return type(error), str(error)
    return None


def test_shut_down_context(domain: int, topic: str, caplog: pytest.LogCaptureFixture) -> None:
    with woven(publishing), Nodes(domain) as made:
        publisher = made.node().create_publisher(
            Point, topic, QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        )
        assert headers_of(publisher) is not None
        rclpy.shutdown(context=made.context)
        with pytest.raises(RCLError) as plain:
            publisher.publish(Point(x=1.0))
        with pytest.raises(RCLError) as found:
            publisher.publish(Point(x=tracked(1.0)))
        assert str(found.value) == str(plain.value)
        for error in (plain, found):
            frames = [Path(frame.filename).name for frame in traceback.extract_tb(error.tb)]
            assert frames == ["test_publishing.py", "publisher.py"]
    assert not caplog.records


def test_destroyed_publisher(nodes: Nodes, observer: Observer, topic: str) -> None:
    node = nodes.node()
    publisher = node.create_publisher(Point, topic, 10)
    kept = headers_of(publisher)
    wait_until(lambda: f"/{topic}{header.SUFFIX}" in observer.topics(), "the header topic")
    node.destroy_publisher(publisher)
    wait_until(lambda: f"/{topic}{header.SUFFIX}" not in observer.topics(), "no header topic")
    with pytest.raises(Exception) as found:
        publisher.publish(Point(x=tracked(1.0)))
    assert type(found.value).__name__ == "InvalidHandle"
    assert kept is not None


def test_destroyed_node(nodes: Nodes, observer: Observer, topic: str) -> None:
    node = nodes.node()
    node.create_publisher(Point, topic, 10)
    wait_until(lambda: f"/{topic}{header.SUFFIX}" in observer.topics(), "the header topic")
    nodes.executor.remove_node(node)
    node.destroy_node()
    wait_until(lambda: f"/{topic}{header.SUFFIX}" not in observer.topics(), "no header topic")


def test_nodes_are_not_kept_alive(nodes: Nodes, topic: str) -> None:
    node = nodes.node()
    publisher = node.create_publisher(Point, topic, 10)
    publisher.publish(Point(x=tracked(1.0)))
    gone = weakref.ref(node)
    nodes.executor.remove_node(node)
    nodes.made.remove(node)
    node.destroy_node()
    del node, publisher
    gc.collect()
    assert gone() is None


def test_infrastructure_and_hidden_topics_have_none(nodes: Nodes, observer: Observer) -> None:
    node = nodes.node()
    for name in ("/rosout", "/clock", "_hidden", "a/_b/c"):
        assert headers_of(node.create_publisher(Float64, name, 10)) is None
    assert headers_of(node.create_publisher(Empty, "switches", 10)) is None
    shown = [p.topic for p in node.publishers if headers_of(p) is not None]
    assert shown == []


def test_node_keeps_its_plain_list_of_publishers(nodes: Nodes, topic: str) -> None:
    node = nodes.node()
    before = list(node.publishers)
    publisher = node.create_publisher(Point, topic, 10)
    assert list(node.publishers) == [*before, publisher]
    assert type(publisher) is Publisher
    assert type(publisher.handle).__name__ == "Publisher"


def test_namespaces_and_remapping(domain: int, observer: Observer) -> None:
    rules = ["--ros-args", "-r", "points:=moved/points", "-r", "__ns:=/robot"]
    with woven(publishing), Nodes(domain) as made:
        publisher = made.node("remapped", cli_args=rules).create_publisher(Point, "points", 10)
        private = made.node("n").create_publisher(Point, "~/own", 10)
        assert publisher.topic_name == "/robot/moved/points"
        listener = Listener(observer, Point, publisher.topic_name)
        own = Listener(observer, Point, "/n/own")
        wait_until_heard(publisher)
        wait_until_heard(private)
        publisher.publish(Point(x=tracked(1.0)))
        private.publish(Point(x=tracked(2.0)))
        assert listener.headers(1)[0].fields() == {"x": 1.0}
        assert own.headers(1)[0].fields() == {"x": 2.0}


@pytest.mark.parametrize(
    ("qos", "depth"),
    [
        (QoSProfile(depth=1), 32),
        (QoSProfile(depth=100), 200),
        (QoSProfile(history=HistoryPolicy.KEEP_ALL), 1000),
        (QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL), 32),
    ],
)
def test_quality_of_service(qos: QoSProfile, depth: int) -> None:
    found = handles.header_qos(qos)
    assert found.depth == depth
    assert found.durability == qos.durability
    assert found.history == HistoryPolicy.KEEP_LAST


def test_event_callbacks_still_work(nodes: Nodes, observer: Observer, topic: str) -> None:
    events: list[Any] = []
    node = nodes.node()
    node.create_publisher(
        Point, topic, 10, event_callbacks=PublisherEventCallbacks(matched=events.append)
    )
    observer.record(Point, topic)
    nodes.spin_until(lambda: events, "a matched event")


def test_publishers_of_a_class_of_their_own(nodes: Nodes, observer: Observer, topic: str) -> None:
    class Loud(Publisher):
        said: list[Any] = []

        def publish(self, message: Any) -> None:
            self.said.append(message)
            super().publish(message)

    publisher = nodes.node().create_publisher(Point, topic, 10, publisher_class=Loud)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    publisher.publish(Point(x=tracked(1.0)))
    assert listener.headers(1)[0].fields() == {"x": 1.0}
    assert len(Loud.said) == 1


class _Lifecycle(LifecycleNode):
    def on_configure(self, state: Any) -> TransitionCallbackReturn:
        return TransitionCallbackReturn.SUCCESS


def test_lifecycle_publishers_only_publish_while_active(
    nodes: Nodes, observer: Observer, topic: str
) -> None:
    node = _Lifecycle("lifecycle", context=nodes.context)
    nodes.made.append(node)
    publisher = node.create_lifecycle_publisher(Point, topic, 10)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    publisher.publish(Point(x=tracked(1.0)))
    node.trigger_configure()
    node.trigger_activate()
    publisher.publish(Point(x=tracked(2.0)))
    assert listener.messages.first(1) == [Point(x=2.0)]
    [found] = listener.headers(1)
    assert (found.sequence, found.fields()) == (1, {"x": 2.0})


def test_threads_do_not_mix_headers_up(nodes: Nodes, observer: Observer, topic: str) -> None:
    count, threads = 50, 4
    publisher = nodes.node().create_publisher(Point, topic, count * threads)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    sent = [
        [
            Point(x=tracked(float(i)), z=float(t)) if i % 3 else Point(z=float(t))
            for i in range(count)
        ]
        for t in range(threads)
    ]
    workers = [
        threading.Thread(target=lambda mine=mine: [publisher.publish(m) for m in mine])
        for mine in sent
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    messages = listener.messages.first(count * threads)
    wanted = sum(is_tracked(m.x) for mine in sent for m in mine)
    for found in listener.headers(wanted):
        assert messages[found.sequence - 1].x == found.fields()["x"]


def test_a_signal_handler_may_publish_while_publishing(
    nodes: Nodes, observer: Observer, topic: str
) -> None:
    """The same thread enters twice: it must not wait for itself."""
    publisher = nodes.node().create_publisher(Point, topic, 10)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    with headers_of(publisher).lock:
        publisher.publish(Point(x=tracked(1.0)))
    assert listener.headers(1)[0].fields() == {"x": 1.0}


def test_values_go_out_refreshed(
    nodes: Nodes, observer: Observer, topic: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    publisher = nodes.node().create_publisher(Point, topic, 10)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    new: dict[float, Any] = {1.0: tracked(7.0, "new"), 2.0: 8.0}
    monkeypatch.setattr(refresh, "any_change", True)
    monkeypatch.setattr(refresh, "refreshed", lambda value: new.get(value, value))
    message = Point(x=tracked(1.0), y=tracked(2.0), z=tracked(3.0))
    publisher.publish(message)
    assert listener.messages.first(1) == [Point(x=7.0, y=8.0, z=3.0)] == [message]
    assert listener.headers(1)[0].fields() == {"x": 7.0, "z": 3.0}


def test_too_large_headers(
    nodes: Nodes, observer: Observer, topic: str, caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(encoding, "LIMIT", 400)
    publisher = nodes.node().create_publisher(Pose, topic, 10)
    listener = Listener(observer, Pose, topic)
    wait_until_heard(publisher)
    pose = Pose()
    pose.position.x = tracked(1.0, "a")
    pose.position.y = tracked(2.0, "b" * 50)
    pose.position.z = tracked(3.0, "c" * 50)
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            publisher.publish(pose)
    assert listener.messages.first(3) == [pose] * 3
    for found in listener.headers(3):
        assert "position.x" in found.fields() and len(found.fields()) < 3
    assert len([r for r in caplog.records if "too large" in r.message]) == 1


def test_nothing_fits(nodes: Nodes, observer: Observer, topic: str, monkeypatch: Any) -> None:
    monkeypatch.setattr(encoding, "LIMIT", 10)
    publisher = nodes.node().create_publisher(Point, topic, 10)
    listener = Listener(observer, Point, topic)
    wait_until_heard(publisher)
    publisher.publish(Point(x=tracked(1.0)))
    assert listener.messages.first(1) == [Point(x=1.0)]
    assert len(listener.payloads) == 0


def test_growing_values_stay_bounded(nodes: Nodes, observer: Observer, topic: str) -> None:
    publisher = nodes.node().create_publisher(Float64, topic, 1000)
    listener = Listener(observer, Float64, topic)
    wait_until_heard(publisher)
    angle: Any = tracked(0.0, "start")
    step = tracked(0.1, "step")
    expected = 0.0
    for _ in range(700):
        angle += step
        expected += 0.1
        publisher.publish(Float64(data=angle))
    assert listener.messages.first(700)[-1].data == expected
    sizes = [len(m.data) for m in listener.payloads.first(700)]
    assert max(sizes) < 4_500
    last = listener.headers(700)[-1].fields()["data"]
    assert last == expected


def test_unheard_deep_values_are_searched_now_and_then(nodes: Nodes, topic: str) -> None:
    seen: list[str] = []
    publisher = nodes.node().create_publisher(Float64, topic, 10)
    value: Any = tracked(0.0, "start", node=None)
    for i in range(100):
        value = value + leaf(source(f"step{i}", node=None), 1.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parameters, "own", lambda node, one: seen.append(one.hint))
        for _ in range(3):
            publisher.publish(Float64(data=value))
        assert len(set(seen)) == 101
        first = len(seen)
        assert first == 101


def _install_twice(action: Callable[[], None]) -> None:
    action()
    action()


def test_installing_is_idempotent_and_reversible(domain: int, topic: str) -> None:
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.node import Node

    before = Node.__dict__["create_publisher"], rclpy_implementation.Publisher
    _install_twice(publishing.install)
    try:
        with Nodes(domain) as made:
            publisher = made.node().create_publisher(Point, topic, 10)
            assert headers_of(publisher) is not None
            _install_twice(publishing.uninstall)
            assert headers_of(publisher) is None
            publisher.publish(Point(x=tracked(1.0)))
            later = made.node("later").create_publisher(Point, topic, 10)
            assert type(later.handle) is before[1]
    finally:
        publishing.uninstall()
    assert (Node.__dict__["create_publisher"], rclpy_implementation.Publisher) == before
