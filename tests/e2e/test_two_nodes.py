"""Talker and scaler under `run` in two processes; everybody else is a stranger to them."""

import sys
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from rcl_interfaces.msg import ParameterEvent, ParameterType
from rclpy.parameter import Parameter
from std_msgs.msg import Int32

from support.locations import literal_parameter
from support.observer import Observer, Recording
from support.process import SAMPLES, Outcome, Program, environment, rosslt_auto, start
from support.waiting import wait_until

TALKER = SAMPLES / "talker.py"
SCALER = SAMPLES / "scaler.py"

COUNT = "rosslt.talker.Talker.init.count"
METRES = "rosslt.scaler.METRES_PER_COUNT"
OFFSET = "rosslt.scaler.Scaler.init.offset"

COUNT_SOURCE = {
    "node": "/talker",
    "parameter": COUNT,
    "file": str(TALKER),
    "line": 12,
    "column": 21,
    "value": 5,
}


class Pair:
    """The two nodes and what they publish."""

    def __init__(self, observer: Observer, talker: Program, scaler: Program) -> None:
        self.observer = observer
        self.talker = talker
        self.scaler = scaler
        self.foo: Recording = observer.record(Int32, "foo")
        self.scaled: Recording = observer.record(Twist, "scaled")

    def cli(self, *arguments: str) -> Outcome:
        return rosslt_auto(*arguments, domain=self.observer.domain)

    def shows(self, foo: int, scaled: float) -> None:
        """Returns when both topics show these values; from then on they are the only ones."""
        since = len(self.foo), len(self.scaled)
        self.foo.until(lambda message: message.data == foo, since[0])
        self.scaled.until(lambda message: message.linear.x == scaled, since[1])

    def reset(self) -> None:
        """Back to the literals as they stand in the files."""
        self.observer.set("/talker", {COUNT: 5})
        self.observer.set("/scaler", {METRES: 0.25, OFFSET: 1.0, self.turn: 0.5})
        self.shows(10, 3.5)

    @cached_property
    def turn(self) -> str:
        return literal_parameter(self.observer, "/scaler", SCALER, "twist.angular.z = 0.5")


@pytest.fixture(scope="module")
def running(domain: int, observer: Observer) -> Iterator[Pair]:
    with (
        start(TALKER, domain=domain, instrumented=True) as talker,
        start(SCALER, domain=domain, instrumented=True) as scaler,
    ):
        pair = Pair(observer, talker, scaler)
        pair.shows(10, 3.5)
        observer.wait_for_parameter("/talker", COUNT)
        observer.wait_for_parameter("/scaler", METRES)
        yield pair
        assert talker.running and scaler.running, f"{talker}\n{scaler}"
        talker.stop()
        scaler.stop()
        for program in (talker, scaler):
            assert "Traceback" not in str(program), program


@pytest.fixture
def pair(running: Pair) -> Iterator[Pair]:
    yield running
    running.reset()


# echo


def test_echo_shows_the_literal_of_the_talker(pair: Pair) -> None:
    outcome = pair.cli("echo", "/foo", "--once", "--json")
    assert outcome.status == 0, outcome
    shown = outcome.json
    assert shown["topic"] == "/foo"
    assert shown["type"] == "std_msgs/msg/Int32"
    assert shown["fields"].keys() == {"data"}
    data = shown["fields"]["data"]
    assert data["value"] == 10
    assert data["expression"] == "2 * count"
    assert data["sources"][0] == COUNT_SOURCE


def test_echo_shows_the_talkers_literal_behind_the_scalers_field(pair: Pair) -> None:
    shown = pair.cli("echo", "/scaled", "--once", "--json").json
    assert shown["type"] == "geometry_msgs/msg/Twist"
    assert shown["fields"].keys() == {"linear.x", "angular.z"}
    field = shown["fields"]["linear.x"]
    assert field["value"] == 3.5
    assert field["expression"] == "2 * count * METRES_PER_COUNT + offset"
    assert field["sources"][0] == COUNT_SOURCE
    by_parameter = {source["parameter"]: source for source in field["sources"]}
    assert by_parameter[METRES] == {
        "node": "/scaler",
        "parameter": METRES,
        "file": str(SCALER),
        "line": 9,
        "column": 19,
        "value": 0.25,
    }
    assert by_parameter[OFFSET]["line"] == 15


def test_echo_of_one_field(pair: Pair) -> None:
    outcome = pair.cli("echo", "/scaled", "--field", "angular.z", "--once", "--json")
    assert outcome.json["fields"].keys() == {"angular.z"}
    assert outcome.json["fields"]["angular.z"]["value"] == 0.5


def test_echo_prints_one_document_a_line(pair: Pair) -> None:
    command = [sys.executable, "-m", "rosslt_auto", "echo", "/foo", "--json"]
    with Program(command, environment(pair.observer.domain)) as echo:
        lines = echo.stdout.matching(r'^\{.*"data".*\}$', 3)
        assert len(lines) == 3
        assert echo.stdout.all[:3] == lines
        assert echo.stop() in (0, 130)
        assert "Traceback" not in str(echo)


def test_echo_for_people_shows_place_and_source_line(pair: Pair) -> None:
    outcome = pair.cli("echo", "/foo", "--once")
    assert outcome.status == 0
    assert "talker.py:12" in outcome.stdout
    assert "self.count = 5" in outcome.stdout
    assert "2 * count" in outcome.stdout


def test_echo_of_an_unknown_field(pair: Pair) -> None:
    outcome = pair.cli("echo", "/foo", "--field", "nosuch", "--once", "--timeout", "3")
    outcome.assert_clean_failure(1, 2, says="nosuch")


# force


def test_force_through_two_nodes_changes_the_talkers_literal(pair: Pair) -> None:
    outcome = pair.cli("force", "/scaled", "linear.x=6.0", "--json")
    assert outcome.json == {
        "topic": "/scaled",
        "reached": True,
        "fields": {"linear.x": {"target": 6.0, "value": 6.0}},
        "changes": [{"node": "/talker", "parameter": COUNT, "old": 5, "new": 10}],
    }
    assert outcome.status == 0
    pair.shows(20, 6.0)
    assert pair.observer.get("/talker", COUNT) == 10
    assert pair.cli("echo", "/foo", "--once", "--json").json["fields"]["data"]["value"] == 20


def test_force_as_in_the_contract(pair: Pair) -> None:
    outcome = pair.cli("force", "/foo", "data=14", "--json")
    assert outcome.json == {
        "topic": "/foo",
        "reached": True,
        "fields": {"data": {"target": 14, "value": 14}},
        "changes": [{"node": "/talker", "parameter": COUNT, "old": 5, "new": 7}],
    }
    assert outcome.status == 0
    pair.shows(14, 4.5)


def test_force_for_people_says_what_was_changed(pair: Pair) -> None:
    outcome = pair.cli("force", "/foo", "data=14")
    assert outcome.status == 0, outcome
    assert "14" in outcome.stdout
    assert "count" in outcome.stdout
    pair.shows(14, 4.5)


def test_force_several_fields_together(pair: Pair) -> None:
    turn = pair.turn
    outcome = pair.cli("force", "/scaled", "linear.x=6.0", "angular.z=0.75", "--json")
    assert outcome.status == 0, outcome
    assert outcome.json["fields"] == {
        "linear.x": {"target": 6.0, "value": 6.0},
        "angular.z": {"target": 0.75, "value": 0.75},
    }
    assert sorted(outcome.json["changes"], key=lambda change: change["node"]) == [
        {"node": "/scaler", "parameter": turn, "old": 0.5, "new": 0.75},
        {"node": "/talker", "parameter": COUNT, "old": 5, "new": 10},
    ]
    message = pair.scaled.next(2)[-1]
    assert (message.linear.x, message.angular.z) == (6.0, 0.75)


def test_force_with_a_chosen_source(pair: Pair) -> None:
    outcome = pair.cli("force", "/scaled", "linear.x=6.0", "--source", OFFSET, "--json")
    assert outcome.json["changes"] == [
        {"node": "/scaler", "parameter": OFFSET, "old": 1.0, "new": 3.5}
    ]
    assert outcome.json["reached"] is True
    pair.shows(10, 6.0)


def test_dry_run_only_says_what_would_change(pair: Pair) -> None:
    outcome = pair.cli("force", "/scaled", "linear.x=6.0", "--dry-run", "--json")
    assert outcome.status == 0, outcome
    assert outcome.json["changes"] == [{"node": "/talker", "parameter": COUNT, "old": 5, "new": 10}]
    assert pair.observer.get("/talker", COUNT) == 5
    assert {message.linear.x for message in pair.scaled.next(5)} == {3.5}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["/nosuch", "data=1"], "nosuch"),
        (["/foo", "nosuch=1"], "nosuch"),
        (["/foo", "data.deeper=1"], "data"),
        (["/foo", "data=many"], "many"),
        (["/foo", "data=nan"], "nan"),
        (["/foo", "data=1.5"], "data|1.5"),
        (["/scaled", "linear.x=nan"], "nan"),
        (["/scaled", "linear.x=inf"], "inf"),
        (["/scaled", "linear.y=1.0"], "linear.y"),  # nothing tracked there
        (["/scaled", "linear.x=6.0", "--source", "rosslt.nosuch"], "nosuch"),
        (["/foo", "data"], "data"),
        (["/foo"], ""),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_force_that_cannot_be(pair: Pair, arguments: list[str], says: str) -> None:
    outcome = pair.cli("force", *arguments, "--timeout", "3")
    outcome.assert_clean_failure(1, 2, says=says)
    assert outcome.stdout == ""
    assert pair.observer.get("/talker", COUNT) == 5
    assert {message.linear.x for message in pair.scaled.next(3)} == {3.5}


def test_force_out_of_reach_gives_the_reason_as_json(pair: Pair) -> None:
    outcome = pair.cli("force", "/scaled", "linear.y=1.0", "--timeout", "3", "--json")
    assert outcome.status == 1
    assert outcome.json["reached"] is False
    assert outcome.json["reason"]
    assert outcome.json["topic"] == "/scaled"


def test_force_of_a_topic_without_provenance(pair: Pair) -> None:
    node = pair.observer.node
    publisher = node.create_publisher(Int32, "untracked", 10)
    timer = node.create_timer(0.05, lambda: publisher.publish(Int32(data=3)))
    try:
        outcome = pair.cli("force", "/untracked", "data=4", "--timeout", "3", "--json")
        assert outcome.status == 1
        assert outcome.json["reached"] is False
        assert "provenance" in outcome.json["reason"]
        echo = pair.cli("echo", "/untracked", "--once", "--timeout", "5", "--json")
        assert echo.json["fields"] == {}
    finally:
        pair.observer.destroy(timer, publisher)


# locations


def locations(pair: Pair, *arguments: str) -> list[dict[str, Any]]:
    outcome = pair.cli("locations", *arguments, "--json")
    assert outcome.status == 0, outcome
    documents = outcome.json_lines
    return documents[0] if len(documents) == 1 and isinstance(documents[0], list) else documents


def test_locations_lists_what_can_be_changed(pair: Pair) -> None:
    found = {(place["node"], place["parameter"]): place for place in locations(pair)}
    assert {("/talker", COUNT), ("/scaler", METRES), ("/scaler", OFFSET)} <= found.keys()
    count = found["/talker", COUNT]
    assert {key: count[key] for key in COUNT_SOURCE} == COUNT_SOURCE
    # Only what has reached a message: neither the queue sizes nor the timer's period.
    assert not {12, 10} & {place["value"] for place in found.values()}
    assert not any(place["line"] in (13, 14) for place in found.values() if "talker" in str(place))


def test_locations_of_one_node_with_first_and_current_value(pair: Pair) -> None:
    pair.observer.set("/talker", {COUNT: 8})
    found = {place["parameter"]: place for place in locations(pair, "/talker")}
    assert {place["node"] for place in found.values()} == {"/talker"}
    assert (found[COUNT]["first"], found[COUNT]["value"]) == (5, 8)


def test_locations_for_people(pair: Pair) -> None:
    outcome = pair.cli("locations", "/talker")
    assert outcome.status == 0
    assert "talker.py:12:21" in outcome.stdout
    assert "self.count = 5" in outcome.stdout


def test_locations_of_an_unknown_node(pair: Pair) -> None:
    pair.cli("locations", "/nosuch").assert_clean_failure(1, says="nosuch")


# Parameters, for any client


def test_literals_are_listed_as_parameters(pair: Pair) -> None:
    names = pair.observer.list_parameters("/talker")
    assert COUNT in names
    assert "use_sim_time" in names
    for one in names:
        assert not any(other.startswith(f"{one}.") for other in names), f"{one} is a prefix"


def test_a_literal_is_described(pair: Pair) -> None:
    descriptor = pair.observer.describe("/talker", COUNT)
    assert descriptor.name == COUNT
    assert descriptor.type == ParameterType.PARAMETER_INTEGER
    assert descriptor.description == f"{TALKER}:12:21  self.count = 5"
    assert pair.observer.describe("/scaler", METRES).type == ParameterType.PARAMETER_DOUBLE


def test_get_and_set(pair: Pair) -> None:
    assert pair.observer.get("/talker", COUNT) == 5
    [result] = pair.observer.set("/talker", {COUNT: 8})
    assert result.successful, result.reason
    pair.shows(16, 5.0)
    assert pair.observer.get("/talker", COUNT) == 8


def test_a_change_is_broadcast(pair: Pair) -> None:
    events = pair.observer.record(ParameterEvent, "/parameter_events")
    wait_until(
        lambda: pair.observer.node.count_publishers("/parameter_events") >= 2,
        "publishers of events",
    )
    value = iter(range(100, 1000))

    def change() -> bool:  # again and again: the publishers find the new subscriber when they do
        pair.observer.set("/talker", {COUNT: next(value)})
        return any(
            parameter.name == COUNT and event.node == "/talker"
            for event in events.messages
            for parameter in event.changed_parameters
        )

    wait_until(change, "an event", interval=0.1)


def test_an_integer_for_a_float_location_is_converted(pair: Pair) -> None:
    [result] = pair.observer.set("/scaler", {METRES: 1})
    assert result.successful, result.reason
    value = pair.observer.get("/scaler", METRES)
    assert (type(value), value) == (float, 1.0)
    pair.shows(10, 11.0)


@pytest.mark.parametrize(
    ("node", "parameter", "value"),
    [
        ("/talker", COUNT, 7.5),
        ("/talker", COUNT, 7.0),
        ("/talker", COUNT, "7"),
        ("/talker", COUNT, True),
        ("/talker", COUNT, [7]),
        ("/scaler", METRES, "0.5"),
        ("/scaler", METRES, True),
        ("/scaler", METRES, float("nan")),
        ("/scaler", METRES, float("inf")),
    ],
)
def test_anything_else_is_refused_with_a_reason(
    pair: Pair, node: str, parameter: str, value: Any
) -> None:
    before = pair.observer.get(node, parameter)
    [result] = pair.observer.set(node, {parameter: value})
    assert not result.successful
    assert result.reason
    assert pair.observer.get(node, parameter) == before
    assert {message.linear.x for message in pair.scaled.next(2)} == {3.5}


def test_atomic_changes_are_made_together_or_not_at_all(pair: Pair) -> None:
    refused = pair.observer.set_atomically("/scaler", {OFFSET: 2.0, METRES: float("nan")})
    assert not refused.successful
    assert refused.reason
    assert pair.observer.get("/scaler", OFFSET) == 1.0
    assert {message.linear.x for message in pair.scaled.next(2)} == {3.5}

    since = len(pair.scaled)
    done = pair.observer.set_atomically("/scaler", {OFFSET: 2.0, METRES: 0.5})
    assert done.successful, done.reason
    pair.scaled.until(lambda message: message.linear.x == 7.0, since)
    # Never one without the other.
    assert {message.linear.x for message in pair.scaled.messages[since:]} <= {3.5, 7.0}


def test_source_change_topic(pair: Pair) -> None:
    changes = pair.observer.publisher(ParameterEvent, "/rosslt/source_change", subscribers=2)
    for node, value in (
        ("/talker", 9),
        ("/scaler", 1),  # not one of the scaler's
        ("/talker", "x"),  # of the wrong type
    ):
        parameter = Parameter(COUNT, value=value).to_parameter_msg()
        changes.publish(ParameterEvent(node=node, changed_parameters=[parameter]))
    pair.shows(18, 5.5)
    assert pair.observer.get("/talker", COUNT) == 9
    pair.observer.destroy(changes)


# undo and alternatives


def test_a_force_is_taken_back(pair: Pair) -> None:
    assert pair.cli("force", "/scaled", "linear.x=6.0").status == 0
    pair.shows(20, 6.0)
    undone = pair.cli("force", "--undo", "--json")
    assert undone.status == 0, undone
    assert undone.json["changes"] == [{"node": "/talker", "parameter": COUNT, "old": 10, "new": 5}]
    pair.shows(10, 3.5)


def test_nothing_to_take_back(domain: int, tmp_path) -> None:
    outcome = rosslt_auto("force", "--undo", domain=domain, XDG_STATE_HOME=str(tmp_path))
    assert outcome.status == 1
    assert len(outcome.stderr.splitlines()) == 1, outcome


def test_a_dry_run_lists_what_each_source_could_do(pair: Pair) -> None:
    shown = pair.cli("force", "/scaled", "linear.x=4.0", "--dry-run", "--json").json
    alternatives = {entry["parameter"]: entry for entry in shown["alternatives"]["linear.x"]}
    assert alternatives[METRES]["new"] == 0.3
    assert alternatives[OFFSET]["new"] == 1.5
    assert alternatives[COUNT]["new"] == 6
    assert "int" in alternatives["rosslt.talker.Talker.on_timer.data"]["reason"]  # 2.4
