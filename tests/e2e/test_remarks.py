"""Ranges and frozen literals of a real node: whoever asks, they keep to what the file says."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from geometry_msgs.msg import Vector3
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter

from support.observer import Observer, Recording
from support.process import DATA, Program, rosslt_auto, start

NAME = "rosslt.node.Remarks.init."
SPEED, GEARS, MASS = f"{NAME}speed", f"{NAME}gears", f"{NAME}mass"
LIMITED = "is limited to 0.0 to 2.0 step 0.1 at node.py:13"


@pytest.fixture
def node(tmp_path: Path) -> Path:
    return Path(shutil.copy(DATA / "remarks.py", tmp_path / "node.py"))


@pytest.fixture
def running(
    node: Path, own_observer: Observer, request: pytest.FixtureRequest
) -> Iterator[tuple[Program, Recording]]:
    arguments = ("--ros-args", "-p", f"{SPEED}:=7.0", "-p", f"{MASS}:=1.0", "-p", f"{GEARS}:=2")
    recording = own_observer.record(Vector3, "limited")
    with start(node, *arguments, domain=own_observer.domain, instrumented=True) as program:
        recording.first(1)
        own_observer.wait_for_parameter("/remarks", SPEED)
        yield program, recording


@pytest.mark.slow
def test_every_way_keeps_to_the_remarks(
    running: tuple[Program, Recording], node: Path, own_observer: Observer
) -> None:
    program, recording = running
    domain, observer = own_observer.domain, own_observer

    # At start: refused where it does not fit, and said.
    assert recording.messages[0] == Vector3(x=0.75, y=6.0, z=2.0)
    said = "\n".join(program.stderr.all)
    assert f"{SPEED} {LIMITED}" in said and f"{MASS} is frozen at node.py:15" in said
    assert "OFFSET" not in " ".join(observer.list_parameters("/remarks"))

    # As parameters.
    speed, gears = observer.describe("/remarks", SPEED), observer.describe("/remarks", GEARS)
    [floats], [integers] = speed.floating_point_range, gears.integer_range
    assert (floats.from_value, floats.to_value, floats.step) == (0.0, 2.0, 0.1)
    assert (integers.from_value, integers.to_value, integers.step) == (1, 5, 0)
    assert observer.describe("/remarks", MASS).read_only and not speed.read_only
    [beyond] = observer.set("/remarks", {SPEED: 2.5})
    [between] = observer.set("/remarks", {SPEED: 0.55})
    [heavy] = observer.set("/remarks", {MASS: 5.0})
    assert not beyond.successful and LIMITED in beyond.reason
    assert not between.successful and LIMITED in between.reason
    assert not heavy.successful and "is frozen" in heavy.reason
    [fine] = observer.set("/remarks", {SPEED: 1})
    assert fine.successful
    recording.until(lambda message: message.x == 1.25)

    # As a source change.
    publisher = observer.publisher(ParameterEvent, "/rosslt/source_change")
    changed = [Parameter(SPEED, value=3.0).to_parameter_msg()]
    publisher.publish(ParameterEvent(node="/remarks", changed_parameters=changed))
    program.stderr.matching(f"source change refused: {SPEED} {LIMITED}")

    # Listed.
    places = {p["parameter"]: p for p in rosslt_auto("locations", "--json", domain=domain).json}
    assert places[SPEED]["range"] == [0.0, 2.0, 0.1] and not places[SPEED]["frozen"]
    assert places[GEARS]["range"] == [1, 5, None]
    assert places[MASS]["frozen"] and places[MASS]["read_only"] and places[MASS]["range"] is None
    listed = rosslt_auto("locations", domain=domain).stdout
    assert "(0.0 to 2.0 step 0.1)" in listed and "frozen" in listed

    # Forced.
    echoed = rosslt_auto("echo", "/limited", "--once", "--json", domain=domain).json
    assert echoed["fields"]["x"]["sources"][0]["range"] == [0.0, 2.0, 0.1]
    assert echoed["fields"]["y"]["sources"][0]["frozen"]
    refused = rosslt_auto("force", "/limited", "x=2.5", domain=domain)
    refused.assert_clean_failure(1, says="nearest that can be reached is 2.25")
    other = rosslt_auto("force", "/limited", "y=8.0", "--dry-run", "--json", domain=domain).json
    [(_, alternatives)] = other["alternatives"].items()
    assert [change["parameter"] for change in other["changes"]] != [MASS]
    assert any("is frozen" in one.get("reason", "") for one in alternatives)
    named = rosslt_auto("force", "/limited", "y=8.0", "--source", MASS, domain=domain)
    named.assert_clean_failure(1, says="frozen")
    assert rosslt_auto("force", "/limited", "x=1.75", domain=domain).status == 0

    # Saved: the remark stays where it is.
    saved = rosslt_auto("save", domain=domain)
    assert (saved.status, node.read_text().split("\n")[12].strip()) == (
        0, "self.speed = 1.5  # rosslt: 0.0 to 2.0 step 0.1"), saved  # fmt: skip
    [again] = observer.set("/remarks", {SPEED: 2.5})
    assert not again.successful and LIMITED in again.reason
