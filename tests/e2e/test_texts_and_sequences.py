"""Texts, sequences of numbers and fixed-size arrays, from the literal to the wire and back."""

from collections.abc import Iterator
from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovariance
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String

from support.observer import Observer
from support.process import DATA, Outcome, rosslt_auto, start

ARM = DATA / "texts_and_sequences.py"


class Arm:
    def __init__(self, observer: Observer) -> None:
        self.observer = observer
        self.texts: Any = observer.record(String, "chatter")
        self.joints: Any = observer.record(JointState, "joints")
        self.poses: Any = observer.record(PoseWithCovariance, "pose")

    def cli(self, *arguments: str) -> Outcome:
        return rosslt_auto(*arguments, domain=self.observer.domain)

    def force(self, *arguments: str) -> dict[str, Any]:
        outcome = self.cli("force", *arguments, "--json")
        assert outcome.status == 0, outcome
        return {change["parameter"]: change["new"] for change in outcome.json["changes"]}


@pytest.fixture(scope="module")
def arm(domain: int, observer: Observer) -> Iterator[Arm]:
    with start(ARM, "--forever", domain=domain, instrumented=True) as program:
        arm = Arm(observer)
        arm.texts.until(lambda message: message.data.startswith("battery"), 0)
        yield arm
        program.stop()
        assert "Traceback" not in str(program), program


PREFIX = "rosslt.texts_and_sequences"


def test_a_text_is_forced_into_its_parts(arm: Arm) -> None:
    changed = arm.force("/chatter", "data=battery 4 of 10")
    assert changed == {f"{PREFIX}.Arm.init.n": 4}
    arm.texts.until(lambda message: message.data == "battery 4 of 10", 0)
    changed = arm.force("/chatter", "data=volts 4 of 10")
    assert changed == {f"{PREFIX}.LABEL": "volts"}
    arm.texts.until(lambda message: message.data == "volts 4 of 10", 0)
    assert arm.observer.get("/arm", f"{PREFIX}.LABEL") == "volts"


def test_sequences_have_provenance_element_by_element(arm: Arm) -> None:
    shown = arm.cli("echo", "/joints", "--once", "--json").json["fields"]
    assert {
        "name[0]", "name[1]", "header.frame_id", "position[0]", "position[1]", "position[2]",
        "velocity[0]", "velocity[1]", "effort[0]", "effort[1]",
    } == shown.keys()  # fmt: skip
    assert shown["position[1]"]["expression"] == "sin(angle)"
    assert shown["name[1]"]["value"] == "elbow"


def test_an_element_is_forced(arm: Arm) -> None:
    assert arm.force("/joints", "position[2]=3.0") == {f"{PREFIX}.Arm.init.angle": 1.5}
    arm.joints.until(lambda message: message.position[0] == 1.5, 0)
    arm.force("/joints", "name[1]=wrist")
    arm.joints.until(lambda message: message.name[1] == "wrist", 0)


def test_an_element_of_a_fixed_array_is_forced(arm: Arm) -> None:
    assert arm.force("/pose", "covariance[7]=1.0") == {f"{PREFIX}.Arm.init.variance": 0.5}
    arm.poses.until(lambda message: message.covariance[0] == 0.5, 0)


def test_a_truth_value_is_forced(arm: Arm) -> None:
    flags: Any = arm.observer.record(Bool, "ready")
    assert arm.force("/ready", "data=false") == {f"{PREFIX}.Arm.init.ready": False}
    flags.until(lambda message: not message.data, 0)
    assert arm.observer.get("/arm", f"{PREFIX}.Arm.init.ready") is False
    diff = arm.cli("save", "--diff").stdout.splitlines()
    assert {"-        self.ready = True", "+        self.ready = False"} <= set(diff)
