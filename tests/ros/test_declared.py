"""Parameters that a node declares itself, as sources of values."""

from collections.abc import Iterator
from typing import Any

import pytest
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter

from rosslt_auto.provenance import is_tracked, provenance, refresh, untracked
from rosslt_auto.ros import changes, declared, parameters
from support.woven import Table, node_in


@pytest.fixture
def node(domain: int) -> Iterator[Node]:
    for aspect in (parameters, declared, changes):
        aspect.install()
    with node_in(domain) as made:
        yield made
    for aspect in (changes, declared, parameters):
        aspect.uninstall()


def gain(node: Node) -> Any:
    return node.get_parameter("gain").value


@pytest.mark.parametrize("first", [2.5, 3])
def test_every_way_of_reading_gives_the_source(node: Node, first: Any) -> None:
    parameter = node.declare_parameter("gain", first)
    message = parameter.get_parameter_value()
    for value in (
        parameter.value,
        gain(node),
        node.get_parameters(["gain"])[0].value,
        node.get_parameter_or("gain", None).value,
        node.get_parameters_by_prefix("")["gain"].value,
        message.double_value if type(first) is float else message.integer_value,
    ):
        assert is_tracked(value)
        assert (type(untracked(value)), untracked(value)) == (type(first), first)
        [source] = provenance(value).sources
        assert (source.parameter, source.file) == ("gain", None)


def test_values_of_other_types_are_plain(node: Node) -> None:
    for name, value in {"a": True, "c": [1.5], "d": [1], "e": [b"x"]}.items():
        assert not is_tracked(node.declare_parameter(name, value).value)


def test_the_default_is_not_the_source(node: Node) -> None:
    literal = Table(default=0.5)
    node.declare_parameter("gain", literal.read("default"))
    [source] = provenance(gain(node)).sources
    assert source.parameter == "gain"
    assert literal.location("default").node is None


def test_what_was_computed_from_it_follows(node: Node) -> None:
    node.declare_parameter("gain", 2.0)
    doubled = gain(node) * 2
    for value in (3.0, 4.0, 2.0, 5.0):
        [result] = node.set_parameters([Parameter("gain", value=value)])
        assert result.successful
        doubled = refresh.refreshed(doubled)  # as is done for a name or attribute
        assert untracked(doubled) == 2 * value
        client = GetParameters.Request(names=["gain"])
        node._parameter_service._get_parameters_callback(client, GetParameters.Response())
    assert untracked(gain(node)) == 5.0
    assert is_tracked(gain(node))


def test_what_a_callback_keeps_is_tracked(node: Node) -> None:
    kept: list[Any] = []

    def on_set(requested: list[Parameter]) -> SetParametersResult:
        if requested[0].value > 10:
            return SetParametersResult(successful=False, reason="too much")
        kept.append(requested[0].value)
        return SetParametersResult(successful=True)

    node.declare_parameter("gain", 2.0)
    node.add_on_set_parameters_callback(on_set)
    assert node.set_parameters([Parameter("gain", value=3.0)])[0].successful
    assert is_tracked(kept[0])
    assert untracked(refresh.refreshed(kept[0])) == 3.0

    assert not node.set_parameters([Parameter("gain", value=30.0)])[0].successful
    assert untracked(gain(node)) == 3.0
    assert untracked(refresh.refreshed(kept[0])) == 3.0


def test_it_belongs_to_the_node_that_declares_it(node: Node, domain: int) -> None:
    node.declare_parameter("gain", 2.0)
    [source] = provenance(gain(node)).sources
    assert source.node is None
    with node_in(domain, "publishes") as other:
        parameters.own(other, source)
    assert source.node == "/robot"


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_value_that_no_change_could_have(node: Node, value: float) -> None:
    node.declare_parameter("gain", 2.0)
    assert node.set_parameters([Parameter("gain", value=value)])[0].successful
    assert repr(gain(node)) == repr(value)


def test_undeclared_and_declared_again(node: Node) -> None:
    node.declare_parameter("gain", 2.0)
    node.undeclare_parameter("gain")
    node.declare_parameter("gain", 3)
    assert untracked(gain(node)) == 3
    assert provenance(gain(node)).sources[0].kind == "int"


def test_quality_of_service_parameters_stay_plain(node: Node) -> None:
    assert not is_tracked(node.declare_parameter("qos_overrides./x.publisher.depth", 7).value)


def test_what_is_read_again_and_again_does_not_change_what_was_read_before(node: Node) -> None:
    node.declare_parameter("gain", 2.0)
    history = [gain(node) for _ in range(2)]
    node.set_parameters([Parameter("gain", value=3.0)])
    history.append(gain(node))
    assert [untracked(refresh.refreshed(value)) for value in history] == [2.0, 2.0, 3.0]


def test_read_from_several_places_but_once_from_each_it_is_followed(node: Node) -> None:
    node.declare_parameter("gain", 2.0)
    values = [node.get_parameter("gain").value, node.get_parameters(["gain"])[0].value]
    values.append(node.get_parameters_by_prefix("")["gain"].value)
    node.set_parameters([Parameter("gain", value=3.0)])
    assert [untracked(refresh.refreshed(value)) for value in values] == [3.0] * 3


def test_what_callbacks_are_handed_stays_what_it_was(node: Node) -> None:
    handed: list[Any] = []

    def on_set(requested: list[Parameter]) -> SetParametersResult:
        handed.extend(parameter.value for parameter in requested)
        return SetParametersResult(successful=True)

    node.declare_parameter("gain", 1.0)
    node.add_on_set_parameters_callback(on_set)
    for value in (2.0, 3.0, 4.0):
        node.set_parameters([Parameter("gain", value=value)])
    assert [untracked(refresh.refreshed(value)) for value in handed] == [2.0, 3.0, 4.0]
    assert provenance(refresh.refreshed(handed[-1])).sources[0].parameter == "gain"
