"""What becomes of drag handles while messages and people move them."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("viser")

from rosslt_auto.views.geometry import UNTURNED, Frame, Quaternion, Vector, about
from rosslt_auto.views.gizmos import Gizmos
from rosslt_auto.views.handles import Handle
from rosslt_auto.views.shapes import Spot

HERE, THERE = (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)


class Control:
    """What viser gives for a gizmo's part."""

    def __init__(self, name: str, position: Vector, wxyz: Quaternion) -> None:
        self.name = name
        self.position = position
        self.wxyz = wxyz
        self.callback: Any = None

    def on_update(self, callback: Any) -> None:
        self.callback = callback

    def drag(self, phase: str, client: int = 1) -> None:
        event = SimpleNamespace(phase=phase, client_id=client, target=self)
        asyncio.run(self.callback(event))


class Scene:
    """Keeps the parts by the last part of their names."""

    def __init__(self) -> None:
        self.parts: dict[str, Control] = {}

    def add_transform_controls(
        self, name: str, position: Vector, wxyz: Quaternion, **others: Any
    ) -> Control:
        part = self.parts[name.rpartition("/")[2]] = Control(name, position, wxyz)
        return part


class Drags:
    """Lets everybody have everything, and notes what for."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, Any]] = []

    def grabbed(self, handle: Handle, position: Vector) -> bool:
        self.heard.append(("grabbed", position))
        return True

    def moved(self, handle: Handle, position: Vector) -> None:
        self.heard.append(("moved", position))

    def turned(self, handle: Handle, rotation: Quaternion) -> None:
        self.heard.append(("turned", rotation))

    def released(self, handle: Handle) -> None:
        self.heard.append(("released", handle.position))


def handle(position: Vector, rotation: Quaternion = UNTURNED) -> tuple[Handle, float]:
    spot = Spot("pose.position", "pose.orientation", Frame(), position, rotation)
    return Handle("key", "item", "/topic", spot, "xyz", "z"), 1.0


def shown() -> tuple[Gizmos, dict[str, Control], Drags]:
    scene, drags = Scene(), Drags()
    gizmos = Gizmos(SimpleNamespace(scene=scene), drags)  # type: ignore[arg-type]
    gizmos.update([handle(HERE)])
    return gizmos, scene.parts, drags


def test_all_parts_follow_the_messages() -> None:
    gizmos, parts, _ = shown()
    gizmos.update([handle(THERE, about(2, 0.5))])
    assert parts["move"].position == parts["turn-z"].position == THERE
    assert parts["move"].wxyz == UNTURNED
    assert parts["turn-z"].wxyz == about(2, 0.5)


def test_what_is_held_stays_in_the_hand_and_the_rest_follows() -> None:
    gizmos, parts, drags = shown()
    parts["move"].drag("start")
    parts["move"].position = (5.0, 0.0, 0.0)
    parts["move"].drag("update")
    gizmos.update([handle(THERE)])  # on its way
    assert parts["move"].position == (5.0, 0.0, 0.0)
    assert parts["turn-z"].position == THERE
    parts["move"].drag("end")
    gizmos.update([handle((3.0, 0.0, 0.0))])
    assert parts["move"].position == (5.0, 0.0, 0.0)  # does not snap back
    gizmos.update([handle((5.0, 0.0, 0.0))])
    gizmos.update([handle(HERE)])
    assert parts["move"].position == parts["turn-z"].position == HERE
    assert [what for what, _ in drags.heard] == ["grabbed", "moved", "released"]


def test_what_one_holds_another_cannot_drag() -> None:
    _, parts, drags = shown()
    parts["move"].drag("start", client=1)
    parts["turn-z"].drag("start", client=2)
    parts["turn-z"].drag("update", client=2)
    parts["turn-z"].drag("end", client=2)
    assert [what for what, _ in drags.heard] == ["grabbed"]
