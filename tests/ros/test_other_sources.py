"""Sources that are no literals - of files, of `create_location` - as parameters of a node."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter

from rosslt_auto.instrument.file_calls import call_file
from rosslt_auto.provenance import external, provenance
from rosslt_auto.provenance.external import create_location
from rosslt_auto.provenance.sources import Source
from rosslt_auto.ros import parameters
from support.woven import node_in


@pytest.fixture
def robot(domain: int) -> Iterator[Node]:
    parameters.install()
    with node_in(domain) as node:
        yield node
    parameters.uninstall()


@pytest.fixture(autouse=True)
def _fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(external, "_made", {})


def source_of(value: Any) -> Source:
    found = provenance(value)
    assert found is not None
    return found.sources[0]


def load(path: Path) -> Any:
    with open(path) as file:
        return call_file(json.load, file)


def test_a_value_of_a_file_is_a_parameter(robot: Node, tmp_path: Path) -> None:
    path = tmp_path / "mission.json"
    path.write_text('{"speed": 0.5, "name": "alpha"}')
    data = load(path)
    source = source_of(data["speed"])
    parameters.own(robot, source)
    assert robot.get_parameter(source.parameter).value == 0.5
    description = robot.describe_parameter(source.parameter)
    assert description.description.startswith(f"{path}:1:10  ")
    result = robot.set_parameters([Parameter(source.parameter, value=0.75)])[0]
    assert result.successful, result.reason
    assert path.read_text() == '{"speed": 0.75, "name": "alpha"}'

    name = source_of(data["name"])
    parameters.own(robot, name)
    assert robot.get_parameter(name.parameter).value == "alpha"
    result = robot.set_parameters([Parameter(name.parameter, value=3)])[0]
    assert not result.successful and "str" in result.reason
    result = robot.set_parameters([Parameter(name.parameter, value="beta")])[0]
    assert result.successful, result.reason
    assert json.loads(path.read_text()) == {"speed": 0.75, "name": "beta"}


def test_a_refusal_of_one_changes_none(robot: Node, tmp_path: Path) -> None:
    path = tmp_path / "route.json"
    path.write_text('{"speed": 0.5}')
    in_file = source_of(load(path)["speed"])

    def refuse(value: Any) -> None:
        raise ValueError("too hot")

    device = source_of(create_location(20.0, "heater", setter=refuse))
    for source in (in_file, device):
        parameters.own(robot, source)
    result = robot.set_parameters_atomically(
        [Parameter(in_file.parameter, value=0.75), Parameter(device.parameter, value=30.0)]
    )
    assert not result.successful and "too hot" in result.reason
    assert path.read_text() == '{"speed": 0.5}'
    assert robot.get_parameter(in_file.parameter).value == 0.5
    assert robot.get_parameter(device.parameter).value == 20.0


def test_it_cannot_be_undeclared(robot: Node) -> None:
    source = source_of(create_location(1.5, "speed"))
    parameters.own(robot, source)
    result = robot.set_parameters_atomically([Parameter(source.parameter)])
    assert not result.successful and "literal" not in result.reason
