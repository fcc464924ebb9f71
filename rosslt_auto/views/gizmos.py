"""Drag handles in viser: a gizmo for what can be moved and one for each axis of turning.

A gizmo that is being dragged, or has just been let go, is not moved by messages: it waits where the
user has left it until the messages have come there.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, Protocol

import viser

from .drawing import node_name
from .geometry import Quaternion, Vector
from .handles import AXES, Handle

PATIENCE = 3.0
"""Seconds that a released gizmo waits for the messages."""

_NEAR = 1e-2
_RINGS = {"x": (False, True, True), "y": (True, False, True), "z": (True, True, False)}


class Drags(Protocol):
    """What the gizmos report; each is called in viser's event loop and must return at once."""

    def grabbed(self, handle: Handle, position: Vector) -> bool: ...

    def moved(self, handle: Handle, position: Vector) -> None: ...

    def turned(self, handle: Handle, rotation: Quaternion) -> None: ...

    def released(self, handle: Handle) -> None: ...


@dataclass
class _Gizmo:
    handle: Handle
    nodes: list[Any] = field(default_factory=list)
    held: bool = False
    until: float = 0.0
    client: int | None = None
    dragged: Any = None


class Gizmos:
    """All drag handles that are shown."""

    def __init__(self, server: viser.ViserServer, drags: Drags) -> None:
        self._server = server
        self._drags = drags
        self._gizmos: dict[str, _Gizmo] = {}

    def update(self, handles: Iterable[tuple[Handle, float]]) -> None:
        """Shows these handles and no others; each with its size."""
        seen = set()
        for handle, size in handles:
            seen.add(handle.key)
            gizmo = self._gizmos.get(handle.key)
            if gizmo is not None and not gizmo.held and _unlike(gizmo.handle, handle):
                self._remove(handle.key)
                gizmo = None
            if gizmo is None:
                gizmo = self._gizmos[handle.key] = _Gizmo(handle)
                self._make(gizmo, size)
            else:
                if not gizmo.held:
                    gizmo.handle = handle
                self._follow(gizmo, handle)
        for key in self._gizmos.keys() - seen:
            if not self._gizmos[key].held:
                self._remove(key)

    def _remove(self, key: str) -> None:
        for node in self._gizmos.pop(key).nodes:
            node.remove()

    def _make(self, gizmo: _Gizmo, size: float) -> None:
        handle = gizmo.handle
        name = f"handles/{node_name(handle.key)}"
        if handle.moves:
            active = tuple(axis in handle.moves for axis in AXES)
            node = self._server.scene.add_transform_controls(
                f"{name}/move", scale=size, active_axes=active, disable_rotations=True,
                disable_sliders=len(handle.moves) < 2, depth_test=False,
                position=handle.position, wxyz=handle.spot.frame.rotation,
            )  # fmt: skip
            node.on_update(self._callback(gizmo, turn=False))
            gizmo.nodes.append(node)
        for axis in handle.turns:
            node = self._server.scene.add_transform_controls(
                f"{name}/turn-{axis}", scale=0.8 * size, active_axes=_RINGS[axis],
                disable_axes=True, disable_sliders=True, depth_test=False,
                position=handle.position, wxyz=handle.rotation,
            )  # fmt: skip
            node.on_update(self._callback(gizmo, turn=True))
            gizmo.nodes.append(node)

    def _callback(self, gizmo: _Gizmo, turn: bool) -> Callable[[Any], Any]:
        async def on_update(event: Any) -> None:
            if event.phase == "start":
                position = _floats(event.target.position)
                if gizmo.held or not self._drags.grabbed(gizmo.handle, position):
                    return
                gizmo.held, gizmo.client, gizmo.dragged = True, event.client_id, event.target
            elif not gizmo.held or gizmo.client != event.client_id:
                return
            elif event.phase == "update":
                if turn:
                    self._drags.turned(gizmo.handle, _floats(event.target.wxyz))
                else:
                    self._drags.moved(gizmo.handle, _floats(event.target.position))
            else:
                gizmo.until = time.monotonic() + PATIENCE
                gizmo.held = False
                self._drags.released(gizmo.handle)

        return on_update

    def _follow(self, gizmo: _Gizmo, handle: Handle) -> None:
        """Moves it to where the messages are, all but what somebody holds."""
        waiting = time.monotonic() < gizmo.until
        for node in gizmo.nodes:
            turning = "/turn-" in node.name
            rotation = handle.rotation if turning else handle.spot.frame.rotation
            there = math.dist(node.position, handle.position) < _NEAR and (
                abs(sum(a * b for a, b in zip(node.wxyz, rotation, strict=True))) > 1 - 1e-4
            )
            if node is gizmo.dragged:
                if gizmo.held or (waiting and not there):
                    continue
                gizmo.until = 0.0
            if tuple(node.position) != handle.position:
                node.position = handle.position
            if tuple(node.wxyz) != rotation:
                node.wxyz = rotation


def _unlike(one: Handle, other: Handle) -> bool:
    return (one.moves, one.turns) != (other.moves, other.turns)


def _floats(values: Any) -> Any:
    return tuple(float(value) for value in values)
