"""How the server of the package interactive_markers is used, with one that notes how.

It keeps to what the package documents: changes wait for `applyChanges`, a pose is refused for what
has not been sent, and each marker has its callback. `test_marker_server` takes the real one where
it is installed.
"""

import importlib
import sys
import threading
from collections.abc import Callable, Iterator
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from geometry_msgs.msg import Point, Pose
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback

from rosslt_auto.views import marker_server
from support.waiting import DEADLINE

OURS = "rosslt_auto.views.packaged_server"


class Package:
    """Stands in for `interactive_markers.InteractiveMarkerServer`.

    sent  what each update had: names of markers, of poses, of what is erased
    """

    def __init__(
        self, node: Any, namespace: str, *, update_pub_qos: Any, feedback_sub_qos: Any
    ) -> None:
        self.made_with = (node, namespace, update_pub_qos.depth, feedback_sub_qos.depth)
        self.markers: dict[str, InteractiveMarker] = {}
        self.callbacks: dict[str, Any] = {}
        self.pending: dict[str, tuple[str, Any]] = {}
        self.sent: list[tuple[list[str], list[str], list[str]]] = []
        self.acked = self.ended = False
        self.on_erase: Callable[[], None] = lambda: None
        self.on_send: Callable[[], None] = lambda: None
        self.update_pub = SimpleNamespace(wait_for_all_acked=self._wait_for_all_acked)

    def _wait_for_all_acked(self, timeout: Any) -> None:
        assert not self.markers  # all are erased
        self.acked = True

    def insert(self, marker: Any, *, feedback_callback: Any = None) -> None:
        self.pending[marker.name] = ("insert", marker)
        self.callbacks[marker.name] = feedback_callback

    def setPose(self, name: str, pose: Any) -> bool:
        kind, _ = self.pending.get(name, ("", None))
        if kind == "insert":
            return False
        if name not in self.markers:
            raise AttributeError(name)  # as the real one does after `erase`
        self.pending[name] = ("pose", pose)
        return True

    def erase(self, name: str) -> bool:
        if name not in self.pending and name not in self.markers:
            return False
        self.pending[name] = ("erase", None)
        on_erase, self.on_erase = self.on_erase, lambda: None
        on_erase()
        return True

    def clear(self) -> None:
        self.pending = {name: ("erase", None) for name in self.markers}

    def get(self, name: str) -> Any:
        kind, what = self.pending.get(name, ("", None))
        if kind == "insert":
            return what
        return None if kind == "erase" else self.markers.get(name)

    def applyChanges(self) -> None:
        if not self.pending:
            return
        self.on_send()
        sent: dict[str, list[str]] = {"insert": [], "pose": [], "erase": []}
        for name, (kind, what) in self.pending.items():
            if kind == "insert":
                self.markers[name] = what
            elif kind == "pose":
                self.markers[name].pose = what
            elif self.markers.pop(name, None) is None:
                continue
            sent[kind].append(name)
        self.pending = {}
        self.sent.append((sent["insert"], sent["pose"], sent["erase"]))

    def getInteractiveMarkersCallback(self, request: Any, response: Any) -> Any:
        return response

    def feedback(self, name: str, pose: Pose) -> None:
        """As `processFeedback`: the pose counts at once, also of what is about to be erased."""
        self.pending[name] = ("pose", pose)
        self.callbacks[name](InteractiveMarkerFeedback(marker_name=name, pose=pose))

    def shutdown(self) -> None:
        self.ended = True


@pytest.fixture(autouse=True)
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    package = ModuleType("interactive_markers")
    package.InteractiveMarkerServer = Package  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "interactive_markers", package)
    before = sys.modules.pop(OURS, None)
    yield
    sys.modules.pop(OURS, None)
    if before is not None:
        sys.modules[OURS] = before


class Made:
    """Our server, the package's behind it, and what people have done."""

    def __init__(self) -> None:
        self.heard: list[InteractiveMarkerFeedback] = []
        self.ours: Any = marker_server.server_for("node", "/ns", self.heard.append)
        self.package: Package = self.ours._server


@pytest.fixture
def made() -> Made:
    return Made()


def pose(x: float) -> Pose:
    return Pose(position=Point(x=x))


def test_it_is_used_where_it_is_installed(made: Made) -> None:
    assert type(made.ours) is importlib.import_module(OURS).PackagedServer
    assert made.package.made_with == ("node", "/ns", 100, 100)


def test_ours_is_used_where_it_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "interactive_markers", None)
    made: list[Any] = []
    monkeypatch.setattr(marker_server, "MarkerServer", lambda *given: made.append(given) or "ours")
    assert marker_server.server_for("node", "/ns", print) == "ours"
    assert made == [("node", "/ns", print)]


def test_changes_are_sent_together(made: Made) -> None:
    made.ours.insert(InteractiveMarker(name="a"))
    made.ours.insert(InteractiveMarker(name="b"))
    assert made.package.sent == []
    made.ours.apply()
    made.ours.move("a", pose(1.0))
    made.ours.erase("b")
    made.ours.apply()
    made.ours.apply()
    assert made.package.sent == [(["a", "b"], [], []), ([], ["a"], ["b"])]
    assert made.package.markers["a"].pose == pose(1.0)


def test_what_has_not_been_sent_is_moved(made: Made) -> None:
    made.ours.insert(InteractiveMarker(name="a"))
    made.ours.move("a", pose(1.0))
    made.ours.apply()
    assert made.package.sent == [(["a"], [], [])]
    assert made.package.markers["a"].pose == pose(1.0)


def test_what_is_not_there_is_neither_moved_nor_erased(made: Made) -> None:
    made.ours.move("a", pose(1.0))
    made.ours.erase("a")
    made.ours.move("a", pose(1.0))
    made.ours.apply()
    assert made.package.sent == []


def test_what_is_erased_does_not_come_back(made: Made) -> None:
    made.ours.insert(InteractiveMarker(name="a"))
    made.ours.apply()
    made.ours.erase("a")
    made.ours.move("a", pose(1.0))
    made.package.on_erase = lambda: made.package.feedback("a", pose(2.0))  # dragged just now
    made.ours.apply()
    assert made.package.markers == {}


def test_what_is_erased_may_be_inserted_again(made: Made) -> None:
    made.ours.insert(InteractiveMarker(name="a"))
    made.ours.apply()
    made.ours.erase("a")
    made.ours.insert(InteractiveMarker(name="a", pose=pose(3.0)))
    made.ours.apply()
    assert made.package.markers["a"].pose == pose(3.0)


def test_feedback_is_heard(made: Made) -> None:
    made.ours.insert(InteractiveMarker(name="a"))
    made.ours.apply()
    made.package.feedback("a", pose(2.0))
    assert [one.marker_name for one in made.heard] == ["a"]


def test_nobody_else_is_served_while_an_update_is_sent(made: Made) -> None:
    """The package's own lock does not cover it."""
    package = made.package
    asked = [
        lambda: package.getInteractiveMarkersCallback(None, None),
        package.applyChanges,
        lambda: made.ours.move("a", pose(1.0)),
    ]
    served = [threading.Event() for _ in asked]

    def serve(ask: Callable[[], Any], done: threading.Event) -> None:
        ask()
        done.set()

    def on_send() -> None:
        package.on_send = lambda: None
        for ask, done in zip(asked, served, strict=True):
            threading.Thread(target=serve, args=(ask, done), daemon=True).start()
        assert not any(done.wait(0.1) for done in served)

    package.on_send = on_send
    made.ours.insert(InteractiveMarker(name="a"))
    made.ours.apply()
    assert all(done.wait(DEADLINE) for done in served)


def test_closing_erases_and_waits_for_the_clients(made: Made) -> None:
    made.ours.insert(InteractiveMarker(name="a"))
    made.ours.apply()
    made.ours.close()
    assert made.package.sent[-1] == ([], [], ["a"])
    assert made.package.acked and made.package.ended
