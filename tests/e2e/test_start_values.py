"""Literals set when the node is started, as any ROS parameter, and what cannot be set at all."""

from pathlib import Path

import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Int32

from support.observer import Observer
from support.process import SAMPLES, rosslt_auto, start

TALKER = SAMPLES / "talker.py"
COUNT = "rosslt.talker.Talker.init.count"
METRES = "rosslt.scaler.METRES_PER_COUNT"


def numbers_of_talker(observer: Observer, *arguments: str) -> list[int]:
    with start(TALKER, *arguments, domain=observer.domain, instrumented=True):
        messages = observer.record(Int32, "foo").first(5)
        observer.wait_for_parameter("/talker", COUNT)
        assert 2 * observer.get("/talker", COUNT) == messages[0].data
        return [message.data for message in messages]


def test_on_the_command_line(own_observer: Observer) -> None:
    numbers = numbers_of_talker(own_observer, "--ros-args", "-p", f"{COUNT}:=7")
    assert set(numbers) == {14}


@pytest.mark.parametrize(
    "content",
    [
        f"talker:\n  ros__parameters:\n    {COUNT}: 7\n",
        "/**:\n  ros__parameters:\n    rosslt:\n      talker:\n        Talker:\n"
        "          init:\n            count: 7\n",
    ],
    ids=["of the node", "of all nodes, nested"],
)
def test_from_a_parameter_file(content: str, own_observer: Observer, tmp_path: Path) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text(content)
    numbers = numbers_of_talker(own_observer, "--ros-args", "--params-file", str(file))
    assert set(numbers) == {14}


def test_a_module_constant_and_an_integer_for_a_float(own_observer: Observer) -> None:
    arguments = ("--ros-args", "-p", f"{METRES}:=2")
    domain = own_observer.domain
    with (
        start(TALKER, domain=domain, instrumented=False),
        start(SAMPLES / "scaler.py", *arguments, domain=domain, instrumented=True),
    ):
        messages = own_observer.record(Twist, "scaled").first(3)
        assert {message.linear.x for message in messages} == {21.0}


def test_a_value_of_the_wrong_type_is_refused_and_the_node_goes_on(own_observer: Observer) -> None:
    arguments = ("--ros-args", "-p", f"{COUNT}:=many")
    with start(TALKER, *arguments, domain=own_observer.domain, instrumented=True) as talker:
        messages = own_observer.record(Int32, "foo").first(3)
        assert {message.data for message in messages} == {10}
        [warning] = [line for line in talker.stderr.all if COUNT in line]
        assert "many" in warning or "string" in warning.lower()
        assert "Traceback" not in str(talker)


def test_other_arguments_of_ros_pass_through(own_observer: Observer) -> None:
    arguments = ("--ros-args", "-r", "__node:=speaker", "-r", "foo:=/numbers", "-r", "__ns:=/a")
    with start(TALKER, *arguments, domain=own_observer.domain, instrumented=True):
        own_observer.record(Int32, "/numbers").first(2)
        own_observer.wait_for_parameter("/a/speaker", COUNT)
        echo = rosslt_auto("echo", "/numbers", "--once", "--json", domain=own_observer.domain)
        assert echo.json["fields"]["data"]["sources"][0]["node"] == "/a/speaker"
        topics = own_observer.topics()
        # The header topic is remapped together with its topic.
        assert topics["/numbers/_provenance"] == ["std_msgs/msg/UInt8MultiArray"]
        assert not [topic for topic in topics if topic.startswith("/a/foo")]


def test_read_only_shows_provenance_and_refuses_changes(own_observer: Observer) -> None:
    domain = own_observer.domain
    with start(TALKER, domain=domain, instrumented=True, options=["--read-only"]):
        messages = own_observer.record(Int32, "foo")
        messages.first(2)
        echo = rosslt_auto("echo", "/foo", "--once", "--json", domain=domain)
        assert echo.json["fields"]["data"]["sources"][0]["parameter"] == COUNT

        if COUNT in own_observer.list_parameters("/talker"):
            [result] = own_observer.set("/talker", {COUNT: 7})
            assert not result.successful
            assert result.reason
        force = rosslt_auto("force", "/foo", "data=14", "--timeout", "3", "--json", domain=domain)
        assert force.status == 1
        assert force.json["reached"] is False
        assert force.json["reason"]
        assert {message.data for message in messages.next(3)} == {10}
