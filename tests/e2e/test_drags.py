"""Drags through the model that all views share, on real nodes."""

import os
from collections.abc import Iterator

import pytest

from rosslt_auto.ros.observer import Observer
from rosslt_auto.views.handles import Grip, Handle
from rosslt_auto.views.session import Session
from support.process import SAMPLES, Program, start
from support.waiting import wait_until

HEIGHT = "rosslt.beacon.main.height"


@pytest.fixture
def beacon(own_domain: int) -> Iterator[Program]:
    with start(SAMPLES / "beacon.py", domain=own_domain, instrumented=True) as program:
        yield program


@pytest.fixture
def session(own_domain: int, beacon: Program, monkeypatch: pytest.MonkeyPatch) -> Iterator[Session]:
    monkeypatch.setitem(os.environ, "ROS_DOMAIN_ID", str(own_domain))
    with Observer("test") as observer, Session(observer) as session:
        assert session.wait_for_handles(30.0)
        yield session


def handle_of(session: Session) -> Handle:
    [handle] = [one for item in session.scene.items() for one in session.handles.of(item)]
    return handle


def height(session: Session) -> float:
    [item] = session.scene.items()
    return float(item.tracked.message.point.z)


def test_drag_and_undo(session: Session) -> None:
    handle = handle_of(session)
    assert (handle.topic, handle.moves) == ("/beacon", "xyz")
    grip, dragger = Grip(handle, handle.position), session.grab(handle)
    assert dragger is not None
    assert session.grab(handle) is None  # somebody holds it
    for z in (2.0, 2.5, 3.25):
        dragger.to(grip.moved((3.0, -2.0, z)))
    session.let_go(handle)
    wait_until(lambda: height(session) == 3.25, "the messages show it")
    wait_until(session.listing.changed, "the node has been asked for what has changed")
    [literal] = session.listing.changed()
    assert (literal.parameter, literal.first, literal.value) == (HEIGHT, 1.5, 3.0)
    assert session.undo() == "undone: height 3.0 → 1.5"
    wait_until(lambda: height(session) == 1.75, "it is as before")
    assert session.undo() == "there is nothing to undo"


def test_a_node_that_dies_during_a_drag(session: Session, beacon: Program) -> None:
    said: list[str] = []
    session.messages.append(said.append)
    handle = handle_of(session)
    dragger = session.grab(handle)
    assert dragger is not None
    dragger.to({"point.z": 2.0})
    wait_until(lambda: height(session) == 2.0, "the drag works")
    beacon.stop()
    dragger.to({"point.z": 4.0})
    wait_until(lambda: any(said), "somebody says why it does not go on")
    assert "/beacon" in next(filter(None, said))
    session.let_go(handle)
    assert not session.is_held(handle.key)
