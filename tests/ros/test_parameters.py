"""Locations as parameters of a node: for clients, for the program, and who owns them."""

import os
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from rcl_interfaces.msg import ParameterEvent, ParameterType, SetParametersResult
from rclpy.exceptions import ParameterImmutableException, ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter

from rosslt_auto.provenance import is_tracked
from rosslt_auto.ros import changes, declared, parameters
from support.observer import Observer
from support.waiting import wait_until
from support.woven import Table, node_in, spinning


@pytest.fixture(autouse=True)
def woven() -> Iterator[None]:
    for aspect in (parameters, declared, changes):
        aspect.install()
    yield
    for aspect in (changes, declared, parameters):
        aspect.uninstall()


@pytest.fixture
def robot(woven: None, domain: int) -> Iterator[Node]:
    """A node that spins."""
    with node_in(domain) as node, spinning(node):
        yield node


@pytest.fixture
def table() -> Table:
    return Table(count=5, speed=0.5)


def own(node: Node, table: Table) -> None:
    for hint in ("count", "speed"):
        parameters.own(node, table.location(hint))


# Who owns a location


def test_the_first_publisher_owns_a_location(robot: Node, table: Table, domain: int) -> None:
    location = table.location("count")
    assert location.node is None
    with node_in(domain, "other") as other:
        parameters.own(robot, location)
        parameters.own(other, location)
        assert location.node == "/robot"
        assert parameters.owned(other) == {}


def test_the_next_publisher_owns_what_a_destroyed_node_owned(domain: int, table: Table) -> None:
    location = table.location("count")
    with node_in(domain, "first") as first:
        parameters.own(first, location)
        assert location.node == "/first"
    assert location.node is None
    with node_in(domain, "second", namespace="/a") as second:
        parameters.own(second, location)
        assert location.node == "/a/second"


@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_in_a_forked_process_no_node_owns_it(domain: int, table: Table) -> None:
    location = table.location("count")
    with node_in(domain, "parent") as node:
        parameters.own(node, location)
        process = os.fork()
        if not process:
            os._exit(0 if location.node is None and not parameters.owned(node) else 1)
        assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 0
        assert location.node == "/parent"


def test_a_node_that_is_collected_owns_nothing(domain: int, table: Table) -> None:
    import gc

    with node_in(domain) as keeper:
        node = Node("forgotten", context=keeper.context)
        parameters.own(node, table.location("count"))
        assert table.location("count").node == "/forgotten"
        for subscription in list(node.subscriptions):
            node.destroy_subscription(subscription)
        del node
        gc.collect()
        wait_until(lambda: table.location("count").node is None, "the node to be collected")


def test_a_new_location_is_announced(robot: Node, observer: Observer, table: Table) -> None:
    events = observer.record(ParameterEvent, "/parameter_events")
    publisher = robot._parameter_event_publisher
    wait_until(lambda: publisher.get_subscription_count() > 0, "the observer")
    parameters.own(robot, table.location("speed"))
    event = events.until(lambda event: event.node == "/robot" and event.new_parameters)
    [new] = event.new_parameters
    assert (new.name, new.value.double_value) == (table.name("speed"), 0.5)
    assert event.stamp.sec > 0


# Clients


def test_client_lists_as_rclpy_lists_its_own(robot: Node, observer: Observer, table: Table) -> None:
    plain = observer.list_parameters("/robot")
    own(robot, table)
    ours = [table.name("count"), table.name("speed")]
    assert observer.list_parameters("/robot") == [*plain, *ours]
    assert observer.list_parameters("/robot", "rosslt") == ours
    assert observer.list_parameters("/robot", table.prefix) == ours
    assert observer.list_parameters("/robot", ours[0]) == ours[:1]
    assert observer.list_parameters("/robot", "ross") == []
    assert observer.list_parameters("/robot", "nosuch") == []


def test_prefixes_and_depth(robot: Node, table: Table) -> None:
    from rcl_interfaces.srv import ListParameters

    own(robot, table)
    robot.declare_parameter("a.b.c", 1)
    service = robot._parameter_service

    def listed(prefixes: list[str], depth: int) -> Any:
        request = ListParameters.Request(prefixes=prefixes, depth=depth)
        return service._list_parameters_callback(request, ListParameters.Response()).result

    assert table.name("count") not in listed([], 1).names
    assert "use_sim_time" in listed([], 1).names
    assert listed(["rosslt"], 1).names == []
    assert listed(["rosslt"], 2).names == [table.name("count"), table.name("speed")]
    everything = listed([], 0)
    assert everything.prefixes.count(table.prefix) == 1
    assert "a.b" in everything.prefixes


def test_client_describes(robot: Node, observer: Observer, table: Table) -> None:
    own(robot, table)
    descriptor = observer.describe("/robot", table.name("speed"))
    assert descriptor.name == table.name("speed")
    assert descriptor.type == ParameterType.PARAMETER_DOUBLE
    assert descriptor.description.startswith(f"{table.location('speed').file}:2:4  ")
    assert not descriptor.read_only
    assert not descriptor.dynamic_typing


def test_client_gets_and_sets(robot: Node, observer: Observer, table: Table) -> None:
    own(robot, table)
    assert observer.get("/robot", table.name("count")) == 5
    assert observer.get("/robot", f"{table.prefix}.nosuch") is None
    results = observer.set("/robot", {table.name("count"): 8, table.name("speed"): 2})
    assert all(result.successful for result in results)
    assert (table.read("count"), table.read("speed")) == (8, 2.0)
    assert is_tracked(table.read("count"))
    speed = observer.get("/robot", table.name("speed"))
    assert (type(speed), speed) == (float, 2.0)


@pytest.mark.parametrize(
    "value", ["x", True, 7.5, [7], [b"7"], ["x"], [True], [1.5], float("nan")], ids=repr
)
def test_client_sets_what_is_refused(
    robot: Node, observer: Observer, table: Table, value: Any
) -> None:
    own(robot, table)
    [result] = observer.set("/robot", {table.name("count"): value})
    assert not result.successful
    assert table.name("count") in result.reason
    assert table.read("count") == 5


def test_a_location_cannot_be_undeclared(robot: Node, observer: Observer, table: Table) -> None:
    own(robot, table)
    [result] = observer.set("/robot", {table.name("count"): None})
    assert not result.successful
    assert observer.get("/robot", table.name("count")) == 5


def test_a_location_that_no_message_has_reached_is_not_declared(
    robot: Node, observer: Observer, table: Table
) -> None:
    [result] = observer.set("/robot", {table.name("count"): 7})
    assert not result.successful
    assert table.read("count") == 5


def test_a_change_is_announced(robot: Node, observer: Observer, table: Table) -> None:
    own(robot, table)
    events = observer.record(ParameterEvent, "/parameter_events")
    publisher = robot._parameter_event_publisher
    wait_until(lambda: publisher.get_subscription_count() > 0, "the observer")
    observer.set_atomically("/robot", {table.name("count"): 8, table.name("speed"): 1.5})
    event = events.until(lambda event: event.node == "/robot" and event.changed_parameters)
    assert {one.name for one in event.changed_parameters} == {
        table.name("count"),
        table.name("speed"),
    }


# Together with parameters of the node


class Guarded(Node):
    """Has a parameter and writes down what its callbacks are asked."""

    def __init__(self, context: Any) -> None:
        super().__init__("guarded", context=context)
        self.asked: list[list[str]] = []
        self.declare_parameter("gain", 1.0)
        self.add_on_set_parameters_callback(self.on_set)

    def on_set(self, requested: list[Parameter]) -> SetParametersResult:
        self.asked.append([parameter.name for parameter in requested])
        fits = all(parameter.value < 10 for parameter in requested)
        return SetParametersResult(successful=fits, reason="" if fits else "too much")


@pytest.fixture
def guarded(robot: Node, table: Table) -> Iterator[Guarded]:
    node = Guarded(robot.context)
    own(node, table)
    yield node
    node.destroy_node()


def test_callbacks_are_not_asked_about_literals(guarded: Guarded, table: Table) -> None:
    [result] = guarded.set_parameters([Parameter(table.name("count"), value=100)])
    assert result.successful
    assert guarded.asked == []


@pytest.mark.parametrize(
    ("gain", "count", "successful"), [(2.0, 7, True), (20.0, 7, False), (2.0, "x", False)]
)
def test_all_or_none_of_both(
    guarded: Guarded, table: Table, gain: float, count: Any, successful: bool
) -> None:
    request = [Parameter("gain", value=gain), Parameter(table.name("count"), value=count)]
    result = guarded.set_parameters_atomically(request)
    assert result.successful is successful
    assert guarded.get_parameter("gain").value == (2.0 if successful else 1.0)
    assert table.read("count") == (7 if successful else 5)
    assert guarded.asked in ([["gain"]], [])


def test_unknown_names_raise_as_without_us(guarded: Guarded, table: Table) -> None:
    request = [Parameter("nosuch", value=1), Parameter(table.name("count"), value=7)]
    with pytest.raises(ParameterNotDeclaredException):
        guarded.set_parameters_atomically(request)
    assert table.read("count") == 5


# What the program sees


def test_the_program_finds_a_location_by_name(robot: Node, table: Table) -> None:
    own(robot, table)
    name = table.name("count")
    assert robot.has_parameter(name)
    assert robot.get_parameter(name).value == 5
    assert robot.get_parameters([name, "use_sim_time"])[0].value == 5
    assert robot.get_parameter_or(name).value == 5
    assert robot.get_parameter_type(name) == Parameter.Type.INTEGER.value
    assert robot.describe_parameter(name).type == ParameterType.PARAMETER_INTEGER
    assert robot.set_parameters([Parameter(name, value=table.read("count") + 1)])[0].successful
    assert table.read("count") == 6
    with pytest.raises(ParameterImmutableException):
        robot.undeclare_parameter(name)


def test_what_the_program_lists_is_its_own(robot: Node, table: Table) -> None:
    plain = robot.list_parameters([], 0), robot.get_parameters_by_prefix("")
    own(robot, table)
    assert (robot.list_parameters([], 0), robot.get_parameters_by_prefix("")) == plain
    assert not [name for name in vars(robot) if "rosslt" in name]


def test_a_node_that_allows_undeclared_parameters(domain: int, table: Table) -> None:
    with node_in(domain, allow_undeclared_parameters=True) as node:
        name = table.name("count")
        assert node.get_parameter(name).value is None
        parameters.own(node, table.location("count"))
        assert node.get_parameter(name).value == 5


# Read-only


def test_read_only(
    robot: Node, observer: Observer, table: Table, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parameters, "read_only", True)
    own(robot, table)
    [result] = observer.set("/robot", {table.name("count"): 7})
    assert not result.successful
    assert "read-only" in result.reason
    assert table.read("count") == 5
    assert observer.describe("/robot", table.name("count")).read_only


# Values at start, as far as only rcl knows them


def start_with(domain: int, table: Table, *arguments: str, **options: Any) -> Node:
    with node_in(domain, cli_args=["--ros-args", *arguments], **options) as node:
        return node


@pytest.mark.parametrize("automatic", [False, True], ids=["", "declares from overrides"])
def test_override_for_the_node_by_name(domain: int, table: Table, automatic: bool) -> None:
    rules = ("-p", f"robot:{table.name('count')}:=7", "-p", f"other:{table.name('speed')}:=9.0")
    node = start_with(
        domain, table, *rules, "-p", "gain:=2.0",
        automatically_declare_parameters_from_overrides=automatic,
    )  # fmt: skip
    assert table.read("count") == 7
    assert table.read("speed") == 0.5
    assert node.has_parameter("gain") is automatic
    assert not [name for name in node._parameters if name.startswith("rosslt.")]


def test_override_of_the_wrong_type(
    domain: int, table: Table, capsys: pytest.CaptureFixture[str]
) -> None:
    start_with(domain, table, "-p", f"robot:{table.name('count')}:=many")
    assert table.read("count") == 5
    [line] = capsys.readouterr().err.splitlines()
    assert table.name("count") in line
    assert "many" in line


# Fire and forget


def test_source_change_topic(robot: Node, observer: Observer, table: Table) -> None:
    own(robot, table)
    publisher = observer.publisher(ParameterEvent, "/rosslt/source_change")

    def send(node: str, **values: Any) -> None:
        messages = [
            Parameter(table.name(hint), value=value).to_parameter_msg()
            for hint, value in values.items()
        ]
        publisher.publish(ParameterEvent(node=node, changed_parameters=messages))

    send("/other", count=7)
    send("/robot", nosuch=7)
    send("/robot", count=9, speed="fast")  # all or none
    send("/robot", count=8, speed=1)
    wait_until(lambda: table.read("speed") == 1.0, "the change")
    assert table.read("count") == 8
    observer.destroy(publisher)


# Weaving


def test_install_and_uninstall_leave_nothing_behind(woven: None) -> None:
    declared.uninstall()
    parameters.uninstall()
    plain = {name: value for name, value in vars(Node).items() if callable(value)}
    for _ in range(2):
        parameters.install()
        declared.install()
    assert Node.has_parameter is not plain["has_parameter"]
    assert vars(Node)["has_parameter"].__wrapped__ is plain["has_parameter"]  # woven once
    declared.uninstall()
    parameters.uninstall()
    assert {name: value for name, value in vars(Node).items() if callable(value)} == plain
    assert rclpy.node.Node is Node
