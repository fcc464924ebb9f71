"""The interactive marker protocol, with a client that takes it at its word.

Of our own server, and where the package interactive_markers is installed, of the one in there.
"""

import threading
from collections.abc import Iterator
from typing import Any

import pytest
from geometry_msgs.msg import Point, Pose
from rclpy.clock import ClockType
from rclpy.parameter import Parameter
from rclpy.time import Time
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

from rosslt_auto.views.marker_server import MarkerServer
from support.domains import reserved_domain
from support.marker_client import StrictClient
from support.observer import Observer
from support.waiting import wait_until

try:
    from rosslt_auto.views.packaged_server import PackagedServer
except ImportError:
    SERVERS: list[Any] = [MarkerServer]
else:
    SERVERS = [MarkerServer, PackagedServer]

POSE_UPDATE = InteractiveMarkerFeedback.POSE_UPDATE


class Served:
    """A server, and clients in other participants."""

    def __init__(self, kind: Any, server: Observer, first: Observer, second: Observer) -> None:
        self._now = 0.0
        self._node = server.node
        self.heard: list[InteractiveMarkerFeedback] = []
        if kind is MarkerServer:
            self.server = MarkerServer(server.node, "/ns", self.heard.append, lambda: self._now)
        else:  # it goes by the node's clock
            server.node.set_parameters([Parameter("use_sim_time", value=True)])
            self.wait(1.0)
            self.server = kind(server.node, "/ns", self.heard.append)
        self.first = StrictClient(first, "/ns", "first")
        self.second = StrictClient(second, "/ns", "second")

    def wait(self, seconds: float) -> None:
        """Time passes for the server."""
        self._now += seconds
        now = Time(seconds=self._now, clock_type=ClockType.ROS_TIME)
        self._node.get_clock().set_ros_time_override(now)

    def hears(self, count: int) -> InteractiveMarkerFeedback:
        wait_until(lambda: len(self.heard) >= count, f"{count} feedback messages")
        return self.heard[count - 1]


@pytest.fixture(params=SERVERS)
def served(request: pytest.FixtureRequest) -> Iterator[Served]:
    with (
        reserved_domain() as domain,
        Observer(domain, "server") as server,
        Observer(domain, "first") as first,
        Observer(domain, "second") as second,
    ):
        yield Served(request.param, server, first, second)


def pose(x: float) -> Pose:
    return Pose(position=Point(x=x))


def test_markers_from_before_and_after_connecting(served: Served) -> None:
    server, client = served.server, served.first
    server.insert(InteractiveMarker(name="a", pose=pose(1.0)))
    server.apply()
    client.connect()
    assert client.position("a") == (1.0, 0.0, 0.0)
    server.insert(InteractiveMarker(name="b", pose=pose(2.0)))
    server.move("a", pose(3.0))
    server.apply()
    server.erase("b")
    server.apply()
    wait_until(lambda: len(client.updates) >= 2 and "b" not in client.markers, "b is erased")
    assert client.position("a") == (3.0, 0.0, 0.0)
    assert client.mistakes == []


def test_sequence_numbers_rise_by_one_and_only_with_changes(served: Served) -> None:
    server, client = served.server, served.first
    client.connect()
    server.insert(InteractiveMarker(name="a"))
    for i in range(50):
        server.move("a", pose(float(i)))
        server.apply()
        server.apply()  # nothing has changed: nothing is sent
    wait_until(lambda: client.position("a") == (49.0, 0.0, 0.0), "the last pose")
    numbers = [update.seq_num for update in client.updates]
    assert numbers == list(range(1, 51))
    assert client.mistakes == []


def test_inserted_moved_and_erased_before_it_is_sent(served: Served) -> None:
    server, client = served.server, served.first
    client.connect()
    server.insert(InteractiveMarker(name="a"))
    server.move("a", pose(1.0))
    server.insert(InteractiveMarker(name="b"))
    server.erase("b")
    server.move("c", pose(1.0))
    server.erase("c")
    server.apply()
    wait_until(lambda: client.position("a"), "a is there")
    [update] = client.updates
    assert [marker.name for marker in update.markers] == ["a"]
    assert (len(update.poses), len(update.erases)) == (0, 0)
    assert client.position("a") == (1.0, 0.0, 0.0)


def test_feedback_of_a_second_client_is_refused_for_a_second(served: Served) -> None:
    server, first, second = served.server, served.first, served.second
    for name in ("a", "b"):
        server.insert(InteractiveMarker(name=name))
    server.apply()
    first.connect()
    second.connect()
    served.wait(1.1)  # the package refuses everything in a marker's first second
    first.feedback("a", POSE_UPDATE, pose(1.0))
    assert served.hears(1).client_id == "first"
    served.wait(0.9)
    second.feedback("a", POSE_UPDATE, pose(2.0))  # refused
    second.feedback("b", POSE_UPDATE, pose(3.0))  # another marker
    assert served.hears(2).marker_name == "b"
    first.feedback("a", POSE_UPDATE, pose(4.0))  # keeps it
    assert served.hears(3).pose.position.x == 4.0
    served.wait(1.1)
    second.feedback("a", POSE_UPDATE, pose(5.0))
    assert served.hears(4).client_id == "second"


def test_feedback_for_markers_that_are_not_there_is_ignored(served: Served) -> None:
    served.server.insert(InteractiveMarker(name="a"))
    served.server.apply()
    served.first.connect()
    served.wait(1.1)
    served.first.feedback("b", POSE_UPDATE, pose(1.0))
    served.first.feedback("a", POSE_UPDATE, pose(2.0))
    assert served.hears(1).marker_name == "a"


def test_closing_erases(served: Served) -> None:
    served.server.insert(InteractiveMarker(name="a"))
    served.server.apply()
    served.first.connect()
    served.server.close()
    wait_until(lambda: not served.first.markers, "a is erased")
    assert served.first.mistakes == []


def test_updates_of_several_threads_are_in_order(served: Served) -> None:
    """Drags come in one, messages in another."""
    server, client = served.server, served.first
    names = [f"marker {i}" for i in range(4)]
    for name in names:
        server.insert(InteractiveMarker(name=name))
    server.apply()
    client.connect()

    def move(name: str) -> None:
        for i in range(20):
            server.move(name, pose(float(i)))
            server.apply()

    threads = [threading.Thread(target=move, args=(name,)) for name in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for name in names:
        wait_until(lambda name=name: client.position(name) == (19.0, 0.0, 0.0), "the last pose")
    assert client.mistakes == []
