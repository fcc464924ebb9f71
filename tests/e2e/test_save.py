"""`save` with real nodes: change, save, start again, and everything is as it was."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Pose
from std_msgs.msg import Int32

from support.observer import Observer
from support.process import SAMPLES, Program, rosslt_auto, start

COUNT = "rosslt.talker.Talker.init.count"


@pytest.fixture
def talker(tmp_path: Path) -> Path:
    """A talker of our own."""
    return Path(shutil.copy(SAMPLES / "talker.py", tmp_path))


@pytest.fixture
def running(talker: Path, own_observer: Observer) -> Iterator[Program]:
    with start(talker, domain=own_observer.domain, instrumented=True) as program:
        own_observer.record(Int32, "foo").first(1)
        own_observer.wait_for_parameter("/talker", COUNT)
        yield program


def change(observer: Observer, value: int) -> None:
    [result] = observer.set("/talker", {COUNT: value})
    assert result.successful, result.reason


def location(domain: int) -> dict[str, Any]:
    found = rosslt_auto("locations", "/talker", "--json", domain=domain).json
    [place] = [place for place in found if place["parameter"] == COUNT]
    return place


def test_change_save_start_again(running: Program, talker: Path, own_observer: Observer) -> None:
    domain = own_observer.domain
    before = talker.read_text()
    change(own_observer, 12345)
    diff = rosslt_auto("save", "--diff", domain=domain)
    assert (diff.status, diff.stderr) == (0, "")
    assert talker.read_text() == before
    changed = [line for line in diff.stdout.splitlines() if line[:1] in "+-"]
    assert [line[:3] for line in changed[:2]] == ["---", "+++"]
    assert len(changed) == 4 and "5" in changed[2] and "12345" in changed[3]

    saved = rosslt_auto("save", domain=domain)
    assert (saved.status, saved.stderr) == (0, "")
    assert f"{talker}:" in saved.stdout and "5 -> 12345" in saved.stdout
    after = talker.read_text()
    assert [
        (a, b) for a, b in zip(before.split("\n"), after.split("\n"), strict=True) if a != b
    ] == [(changed[2][1:], changed[3][1:])]

    # Node and file agree.
    place = location(domain)
    assert place["first"] == place["value"] == 12345
    assert place["text"] == changed[3][1:].strip()
    nothing = rosslt_auto("save", domain=domain)
    assert (nothing.status, nothing.stdout) == (0, "") and "nothing to save" in nothing.stderr

    # The same again.
    change(own_observer, 6)
    again = rosslt_auto("save", "talker", domain=domain)
    assert (again.status, again.stderr) == (0, "")
    assert talker.read_text() == after.replace("12345", "6")

    assert running.stop() == 0 or "KeyboardInterrupt" in str(running)
    messages = own_observer.record(Int32, "foo")
    with start(talker, domain=domain, instrumented=True):
        assert messages.next()[0].data == 12
        own_observer.wait_for_parameter("/talker", COUNT)
        place = location(domain)
        assert place["first"] == place["value"] == 6
    with start(talker, domain=domain, instrumented=False):
        assert messages.next()[0].data == 12


def test_a_mission_that_is_loaded_again_when_it_is_saved(
    own_observer: Observer, tmp_path: Path
) -> None:
    domain = own_observer.domain
    script = Path(shutil.copy(SAMPLES / "interactive_script.py", tmp_path))
    mission = Path(shutil.copy(SAMPLES / "mission.py", tmp_path))
    before = mission.read_text()
    stay = ("--ros-args", "-p", "stay:=600.0")  # at the first waypoint
    with start(script, *stay, domain=domain, instrumented=True):
        poses = own_observer.record(Pose, "target_pose")
        poses.first(3)
        found = rosslt_auto("locations", "/interactive_script", "--json", domain=domain).json
        [place] = [one for one in found if one["text"].startswith("goto(2.0") and one["first"] == 2]
        for value in ("12.25", "3.75"):
            name = place["parameter"]
            assert own_observer.set("/interactive_script", {name: float(value)})[0].successful
            saved = rosslt_auto("save", domain=domain)
            assert (saved.status, saved.stderr) == (0, "")
            assert mission.read_text() == before.replace("goto(2.0,", f"goto({value},")
            since = len(poses)
            poses.first(since + 5)
            assert poses.messages[-1].position.x == float(value)
            found = rosslt_auto("locations", "/interactive_script", "--json", domain=domain).json
            assert all(one["first"] == one["value"] for one in found)
            assert rosslt_auto("save", "--diff", domain=domain).stdout == ""


def test_a_file_that_was_edited_is_left_alone(
    running: Program, talker: Path, own_observer: Observer
) -> None:
    change(own_observer, 7)
    edited = "# mine\n" + talker.read_text()
    talker.write_text(edited)
    for options in ([], ["--diff"]):
        outcome = rosslt_auto("save", *options, domain=own_observer.domain)
        outcome.assert_clean_failure(
            1, says=r"talker\.py is not what /talker has loaded: lines? \d"
        )
        assert outcome.stdout == ""
    assert talker.read_text() == edited


def test_a_file_that_is_gone(running: Program, talker: Path, own_observer: Observer) -> None:
    change(own_observer, 7)
    talker.unlink()
    outcome = rosslt_auto("save", domain=own_observer.domain)
    outcome.assert_clean_failure(1, says="not on this machine")


def test_values_given_at_start(talker: Path, own_observer: Observer, tmp_path: Path) -> None:
    before = talker.read_text()
    domain = own_observer.domain
    file = tmp_path / "values.yaml"
    file.write_text(f"talker:\n  ros__parameters:\n    {COUNT}: 7\n")
    for arguments, where in (
        (("-p", f"{COUNT}:=7"), "by -p"),
        (("--params-file", str(file)), f"by {file}"),
    ):
        with start(talker, "--ros-args", *arguments, domain=domain, instrumented=True):
            own_observer.record(Int32, "foo").first(1)
            own_observer.wait_for_parameter("/talker", COUNT)
            outcome = rosslt_auto("save", domain=domain)
            assert (outcome.status, outcome.stdout) == (0, "")
            assert COUNT in outcome.stderr and where in outcome.stderr
    assert talker.read_text() == before


def test_two_nodes_of_the_same_file(talker: Path, own_observer: Observer) -> None:
    domain = own_observer.domain
    before = talker.read_text()
    with (
        start(talker, domain=domain, instrumented=True),
        start(talker, "--ros-args", "-r", "__node:=other", domain=domain, instrumented=True),
    ):
        for node, value in (("/talker", 7), ("/other", 8)):
            own_observer.wait_for_parameter(node, COUNT)
            own_observer.set(node, {COUNT: value})
        outcome = rosslt_auto("save", domain=domain)
        outcome.assert_clean_failure(1, says="several values: 8 in /other, 7 in /talker")
        assert rosslt_auto("save", "/other", domain=domain).status == 0
        # Both know the file; the one that was not asked has another value than the file.
        found = rosslt_auto("locations", "--json", domain=domain).json
        values = {p["node"]: (p["first"], p["value"]) for p in found if p["parameter"] == COUNT}
        assert values == {"/other": (8, 8), "/talker": (8, 7)}
        assert rosslt_auto("save", "/talker", domain=domain).status == 0
        assert talker.read_text() == before.replace("5", "7", 1), "the first 5 is the count"


def test_no_such_node_and_no_node(own_domain: int) -> None:
    outcome = rosslt_auto("save", "nosuch", "--timeout", "1", domain=own_domain)
    outcome.assert_clean_failure(1, says="/nosuch")
    outcome = rosslt_auto("save", "--timeout", "1", domain=own_domain)
    assert (outcome.status, outcome.stdout) == (0, "")
    assert "nothing to save" in outcome.stderr
