"""The sample nodes do the same under `run` as without: messages, output, exit status, graph."""

from collections.abc import Callable
from functools import cache

import pytest
from geometry_msgs.msg import PointStamped, Pose, Twist
from std_msgs.msg import Int32

from support.domains import reserved_domain
from support.observer import Observer, Recording
from support.process import SAMPLES, Program, start
from support.waiting import wait_until

NUMBERS = [0, 1, -1, 7, 2**31 - 1, -(2**31), 3, 1000003, 12, 5]
WARM_UP = -77

CHECKS = pytest.mark.parametrize(
    "check_fields", [None, "1"], ids=["fields-unchecked", "fields-checked"]
)


# Topic and type of each node that publishes by itself, and when to stop listening: at the same
# message of both runs where messages differ, late enough for a slow machine.
PUBLISHERS: dict[str, tuple[str, type, Callable[[Recording], object]]] = {
    "talker": ("foo", Int32, lambda recording: recording.first(15)),
    "beacon": ("beacon", PointStamped, lambda recording: recording.first(15)),
    "sweeper": (
        "sweep",
        Pose,
        lambda recording: recording.until(lambda pose: pose.position.z > 1.25),  # message 158
    ),
}


def published(node: str, instrumented: bool, check_fields: str | None) -> list[str]:
    """What the node publishes, exactly: repr tells all floats apart, and ints from floats."""
    topic, message_type, enough = PUBLISHERS[node]
    with (
        reserved_domain() as domain,
        Observer(domain) as observer,
        start(
            SAMPLES / f"{node}.py",
            domain=domain,
            instrumented=instrumented,
            ROS_PYTHON_CHECK_FIELDS=check_fields,
        ),
    ):
        recording = observer.record(message_type, topic)
        enough(recording)
        return [repr(message) for message in recording.messages]


plain_published = cache(published)


@pytest.mark.slow
@CHECKS
@pytest.mark.parametrize("node", PUBLISHERS)
def test_publishes_the_same_sequence(node: str, check_fields: str | None) -> None:
    plain = plain_published(node, False, None)
    instrumented = published(node, True, check_fields)

    # The observer finds one node a few messages earlier than the other: compare from the first
    # message that both recordings have.
    earlier, later = (plain, instrumented) if instrumented[0] in plain else (instrumented, plain)
    assert later[0] in earlier, f"no common message: {plain[:3]} ... {instrumented[:3]}"
    earlier = earlier[earlier.index(later[0]) :]
    common = min(len(earlier), len(later))
    assert common >= 15
    assert later[:common] == earlier[:common]


def scaled(instrumented: bool, check_fields: str | None) -> list[str]:
    """What the scaler makes of NUMBERS."""
    with (
        reserved_domain() as domain,
        Observer(domain) as observer,
        start(
            SAMPLES / "scaler.py",
            domain=domain,
            instrumented=instrumented,
            ROS_PYTHON_CHECK_FIELDS=check_fields,
        ),
    ):
        output = observer.record(Twist, "scaled")
        numbers = observer.publisher(Int32, "foo")
        # Until the scaler has found the observer too, what it publishes is lost.
        wait_until(
            lambda: numbers.publish(Int32(data=WARM_UP)) or len(output), "a scaled number", 30, 0.05
        )
        for number in NUMBERS:
            numbers.publish(Int32(data=number))
        warm_up = repr(output.first(1)[0])
        output.until(lambda message: repr(message) != warm_up)
        wait_until(lambda: len(_without(warm_up, output.messages)) >= len(NUMBERS), "all numbers")
        return _without(warm_up, output.messages)


def _without(unwanted: str, messages: list) -> list[str]:
    return [text for text in map(repr, messages) if text != unwanted]


@cache
def plain_scaled() -> list[str]:
    return scaled(instrumented=False, check_fields=None)


@pytest.mark.slow
@CHECKS
def test_scaler_computes_the_same(check_fields: str | None) -> None:
    plain = plain_scaled()
    assert len(plain) == len(NUMBERS)
    assert scaled(True, check_fields) == plain


def heard(instrumented: bool, check_fields: str | None) -> tuple[list[str], list[str], int]:
    """What the listener prints when it is told NUMBERS, and its exit status after Ctrl-C."""
    with (
        reserved_domain() as domain,
        Observer(domain) as observer,
        start(
            SAMPLES / "listener.py",
            domain=domain,
            instrumented=instrumented,
            ROS_PYTHON_CHECK_FIELDS=check_fields,
        ) as listener,
    ):
        numbers = observer.publisher(Int32, "foo")
        for number in NUMBERS:
            numbers.publish(Int32(data=number))
        listener.stdout.matching("I heard", len(NUMBERS))
        status = listener.stop()
        return listener.stdout.all, listener.stderr.all, status


@pytest.mark.slow
@CHECKS
def test_listener_prints_the_same(check_fields: str | None) -> None:
    plain = heard(False, None)
    assert plain[0] == [f"I heard {number}" for number in NUMBERS]
    assert heard(True, check_fields) == plain


@pytest.mark.slow
@pytest.mark.parametrize("end", [Program.interrupt, Program.terminate], ids=["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("node", ["talker", "beacon"])
def test_ends_the_same_way(node: str, end: Callable[[Program], None], own_domain: int) -> None:
    outcomes = []
    for instrumented in (False, True):
        with (
            Observer(own_domain) as observer,
            start(SAMPLES / f"{node}.py", domain=own_domain, instrumented=instrumented) as program,
        ):
            topic, message_type = ("foo", Int32) if node == "talker" else (node, PointStamped)
            observer.record(message_type, topic).first(2)
            end(program)
            outcomes.append((program.wait(), program.stdout.all, program.stderr.all))
    plain, instrumented_outcome = outcomes
    assert instrumented_outcome == plain


@pytest.mark.slow
def test_graph_differs_only_by_hidden_topics_and_the_source_change_topic() -> None:
    graphs = []
    for instrumented in (False, True):
        with (
            reserved_domain() as domain,
            Observer(domain) as observer,
            start(SAMPLES / "talker.py", domain=domain, instrumented=instrumented),
        ):
            observer.record(Int32, "foo").first(3)
            [publisher] = observer.node.get_publishers_info_by_topic("/foo")
            graphs.append(
                {
                    "topics": {
                        topic: types
                        for topic, types in observer.topics().items()
                        if "/_" not in topic and topic != "/rosslt/source_change"
                    },
                    "services": dict(
                        observer.node.get_service_names_and_types_by_node("talker", "/")
                    ),
                    "type": publisher.topic_type,
                    "hash": str(publisher.topic_type_hash),
                    "qos": str(publisher.qos_profile),
                }
            )
    plain, instrumented_graph = graphs
    assert "/foo" in plain["topics"]
    assert instrumented_graph == plain
