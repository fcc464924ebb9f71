"""The quadcopter example under `run`, dragged by a client of the interactive marker protocol."""

import shutil
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from geometry_msgs.msg import Point, Pose
from visualization_msgs.msg import InteractiveMarkerFeedback

from support.marker_client import StrictClient
from support.observer import Observer
from support.process import SAMPLES, Program, environment, start
from support.waiting import wait_until

NODES = ("interactive_script.py", "slt_trajectory.py", "slt_quad.py")
QUAD = "/quad_marker/quad/0:pose.position"
CONTROL = "/trajectory_marker/trajectory/1:pose.position"

MISSION = """\
HEIGHT = 1.5

def mission(goto):
    goto(2.0, 0.5, HEIGHT, yaw=0.8)
"""


class Flight:
    """The three nodes with a mission of their own, and `markers`."""

    def __init__(self, observer: Observer, folder: Path, programs: dict[str, Program]) -> None:
        self.observer = observer
        self.mission = folder / "mission.py"
        self.programs = programs
        self.target = observer.record(Pose, "target_pose")
        self.quad = observer.record(Pose, "quad_pose")


@pytest.fixture
def flight(own_domain: int, tmp_path: Path) -> Iterator[Flight]:
    folder = tmp_path / "nodes"
    folder.mkdir()
    for name in NODES:
        shutil.copy(SAMPLES / name, folder)
    (folder / "mission.py").write_text(MISSION)
    with ExitStack() as stack:
        programs = {
            name: stack.enter_context(start(folder / name, domain=own_domain, instrumented=True))
            for name in NODES
        }
        command = [sys.executable, "-m", "rosslt_auto", "markers", "/quad_marker"]
        command += ["/trajectory_marker", "--namespace", "/rviz"]
        markers = Program(command, environment(own_domain))
        programs["markers"] = stack.enter_context(markers)
        observer = stack.enter_context(Observer(own_domain))
        yield Flight(observer, folder, programs)


def at(x: float, y: float, z: float) -> Pose:
    return Pose(position=Point(x=x, y=y, z=z))


@pytest.mark.slow
def test_the_quadcopter_is_dragged(flight: Flight) -> None:
    client = StrictClient(flight.observer, "/rviz")
    client.connect()

    def hovers() -> bool:
        place = client.position(QUAD)
        return place is not None and place == pytest.approx((2.0, 0.5, 1.5))

    wait_until(hovers, "the quadcopter has come to the waypoint, and its marker with it")
    controls = {control.name for control in client.markers[QUAD].controls}
    assert controls == {"move x", "move y", "move z", "turn z"}

    rotation = client.markers[QUAD].pose.orientation
    for x in (2.25, 2.5, 3.0):
        pose = at(x, 0.5, 1.5)
        pose.orientation = rotation
        client.feedback(QUAD, InteractiveMarkerFeedback.POSE_UPDATE, pose)
    client.feedback(QUAD, InteractiveMarkerFeedback.MOUSE_UP, pose)
    flight.target.until(lambda target: target.position.x == pytest.approx(3.0))
    [last] = flight.target.next()
    assert (last.position.y, last.position.z) == (0.5, 1.5)  # what was not dragged is as before

    # It does not snap back, though the quadcopter is still on its way.
    update = next(u for u in reversed(client.updates) if any(p.name == QUAD for p in u.poses))
    assert next(p for p in update.poses if p.name == QUAD).pose.position.x == pytest.approx(3.0)
    flight.quad.until(lambda quad: quad.position.x == pytest.approx(3.0))
    wait_until(lambda: client.position(QUAD) == pytest.approx((3.0, 0.5, 1.5)), "it is there")

    assert flight.mission.read_text() == MISSION  # nobody has asked for that
    assert client.mistakes == []


@pytest.mark.slow
def test_markers_go_with_what_they_belong_to(flight: Flight) -> None:
    client = StrictClient(flight.observer, "/rviz")
    client.connect()
    wait_until(lambda: CONTROL in client.markers and QUAD in client.markers, "both are there")
    assert flight.programs["markers"].stop() in (0, 130)
    wait_until(lambda: not client.markers, "all are erased at the end")
    assert client.mistakes == []
    assert "Traceback" not in str(flight.programs["markers"])
