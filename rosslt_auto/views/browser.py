"""The page in the browser: the scene with its drag handles, and the code behind it.

A loop draws what has changed; callbacks of viser only note what people want. Every browser sees the
same.
"""

from __future__ import annotations

import contextlib
import html
import io
import logging
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import viser

from . import panel
from .dragging import Dragger
from .drawing import Drawing, linear, node_name
from .geometry import Quaternion, Vector
from .gizmos import Gizmos
from .handles import Grip, Handle
from .origin import Origin
from .scene import Item
from .session import Session
from .shapes import AXES, LINE_LIST, LINE_STRIP, OF_POINTS

DEFAULT_PORT = 8080

_FRAME = 0.04
_CODE = 0.1
_ORIGIN = 0.25
_NOTE = 1.0
"""Seconds between two drawings of the scene, the code, and the origin; and two looks at sources."""


class Camera(NamedTuple):
    """Where people look from at first: positions in the fixed frame, the vertical angle in rad."""

    position: Vector
    look_at: Vector
    field_of_view: float


CAMERA = Camera((2.6, -5.2, 4.2), (0.6, 1.2, 1.3), 0.85)

_ORANGE = (255, 120, 20)
_MAX_GIZMOS = 40

_DONE = 15.0
"""Seconds that people can read what has been done."""


class CannotServe(Exception):
    """The page cannot be served; the message says why."""


class Page:
    """The page. A context manager: it is served from the beginning on, `run` keeps it up to date.

    session  a session that has been entered
    port     None: a free one, the usual if possible
    Raises CannotServe.
    """

    def __init__(self, session: Session, host: str = "127.0.0.1", port: int | None = None) -> None:
        self._session = session
        self._ended = threading.Event()
        self._server = _serve(host, port)
        self.address = f"http://{_in_url(host)}:{self._server.get_port()}"
        self._draggers: dict[str, Dragger] = {}
        self._grips: dict[str, Grip] = {}
        self._handles: dict[str, Handle] = {}
        self._points: dict[str, tuple[Any, list[Handle]]] = {}
        self._point_nodes: dict[str, Any] = {}
        self._noted: dict[str, float] = {}
        self._selected: str | None = None
        self._code_shown: tuple[Any, ...] = ()
        self._problem = self._done = ""
        self._done_until = 0.0
        self._build()
        self._drawing = Drawing(self._server, self._item_clicked)
        self._gizmos = Gizmos(self._server, self)
        session.messages.append(self._tell)

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._session.messages.remove(self._tell)
        with contextlib.redirect_stdout(io.StringIO()):  # it says so
            self._server.stop()

    def run(self, until: threading.Event | None = None) -> None:
        """Keeps the page up to date until the event is set, or for ever."""
        ended = until or self._ended
        code_at = origin_at = 0.0
        while not ended.is_set():
            began = time.monotonic()
            with self._server.atomic():
                self._draw(began)
                if began >= code_at:
                    code_at = began + _CODE
                    self._draw_code()
                if began >= origin_at:
                    origin_at = began + _ORIGIN
                    key = self._selected or ""
                    self._origin.draw(key, self._handles.get(key))
            self._server.flush()
            ended.wait(max(0.005, began + _FRAME - time.monotonic()))

    # The page

    def _build(self) -> None:
        server = self._server
        server.gui.configure_theme(show_share_button=False, show_logo=False, control_width="medium")
        server.gui.set_panel_label("rosslt_auto")
        server.scene.configure_default_lights(False)  # they make colours pale
        server.scene.add_light_ambient("lights/all", intensity=1.3)
        server.scene.add_light_directional("lights/sun", intensity=1.6, position=(-2.0, -3.0, 6.0))
        server.scene.add_grid(
            "grid", width=20.0, height=20.0, cell_size=1.0, cell_color=(225, 228, 232),
            section_size=5.0, section_color=(190, 196, 204),
        )  # fmt: skip
        server.initial_camera.position = CAMERA.position
        server.initial_camera.look_at = CAMERA.look_at
        server.initial_camera.fov = CAMERA.field_of_view
        gui = server.gui
        window = gui.add_panel()
        with window.add_tab("Code"):
            self._message = gui.add_markdown("", visible=False)
            self._code = gui.add_html(panel.code(self._session.listing))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(430)
        window.dock_above(gui.main_panel)
        self._undo = gui.add_button("Undo", disabled=True)
        self._save = gui.add_button("Save …", disabled=True)
        self._origin = Origin(gui, self._session)
        self._undo.on_click(self._undo_last)
        self._save.on_click(self._offer_to_save)

    def _tell(self, problem: str) -> None:
        self._problem = problem and f"⚠ {problem}"
        self._done = ""

    def _tell_done(self, what: str) -> None:
        self._problem = ""
        self._done = f"✓ {what}"
        self._done_until = time.monotonic() + _DONE

    def _undo_last(self, event: Any) -> None:
        said = self._session.undo()
        (self._tell_done if said.startswith("undone") else self._tell)(said)

    def _offer_to_save(self, event: Any) -> None:
        session, gui = self._session, event.client.gui
        try:
            diff = session.diff()
        except Exception as reason:
            self._tell(str(reason))
            return
        with gui.add_modal("Save changes into the source files") as modal:
            gui.add_html(f"<pre style='font-size:12px;overflow:auto'>{html.escape(diff)}</pre>")
            save = gui.add_button("Save")
            cancel = gui.add_button("Cancel")

        @save.on_click
        def _(_: Any) -> None:
            modal.close()
            try:
                self._tell_done(session.save())
            except Exception as reason:
                self._tell(f"not saved: {reason}")

        cancel.on_click(lambda _: modal.close())

    # Drawing

    def _draw(self, began: float) -> None:
        session = self._session
        items = session.scene.items()
        self._drawing.update(items)
        shown: list[tuple[Handle, float]] = []
        found: dict[str, Handle] = {}
        points: dict[str, tuple[Item, list[Handle]]] = {}
        for item in items:
            handles = session.handles.of(item)
            if handles and began >= self._noted.get(item.key, 0.0):
                self._noted[item.key] = began + _NOTE
                session.note_sources(item, [path for one in handles for path in one.paths()])
            for handle in handles:
                found[handle.key] = handle
                if handle.spot.is_point:
                    points.setdefault(item.key, (item, []))[1].append(handle)
                elif len(shown) < _MAX_GIZMOS:
                    shown.append((handle, _size(item)))
        self._handles = found  # all at once: callbacks come in other threads
        selected = found.get(self._selected or "")
        if selected is not None and selected.spot.is_point:
            shown.append((selected, 0.5))
        self._gizmos.update(shown)
        self._draw_points(points)

    def _draw_points(self, points: dict[str, tuple[Item, list[Handle]]]) -> None:
        """A ball on every point that can be dragged; a click gives it a gizmo."""
        for key in self._point_nodes.keys() - points.keys():
            self._point_nodes.pop(key).remove()
            self._points.pop(key, None)
        for key, (item, handles) in points.items():
            places = tuple(handle.spot.position for handle in handles)
            known = self._points.get(key)
            node = self._point_nodes.get(key)
            if node is None or known is None or len(known[0]) != len(places):
                node = self._server.scene.add_batched_meshes_simple(
                    f"points/{node_name(key)}", *_ball(),
                    batched_wxyzs=[(1.0, 0.0, 0.0, 0.0)] * len(places), batched_positions=places,
                    batched_scales=[_ball_size(item)] * len(places),
                    batched_colors=linear(_ORANGE), lod="off", cast_shadow=False,
                )  # fmt: skip
                node.on_click(self._point_clicked(key))
                self._point_nodes[key] = node
            elif known[0] != places:
                node.batched_positions = np.array(places, dtype=np.float32)
            frame = handles[0].spot.frame  # the same for all points of an item
            node.position, node.wxyz = frame.position, frame.rotation
            self._points[key] = (places, handles)

    def _point_clicked(self, key: str) -> Any:
        def on_click(event: Any) -> None:
            known = self._points.get(key)
            index = event.instance_index
            if known is not None and index is not None and index < len(known[1]):
                self._select(known[1][index].key)

        return on_click

    def _item_clicked(self, key: str) -> None:
        for handle in list(self._handles.values()):
            if handle.item == key and not handle.spot.is_point:
                self._select(handle.key)
                return
        self._select(key)

    def _select(self, key: str) -> None:
        self._selected = key

    def _draw_code(self) -> None:
        session = self._session
        live = frozenset(
            (source.node or "", source.parameter)
            for dragger in list(self._draggers.values())
            for source in list(dragger.drag.changed)
        )
        now = (session.listing.revision, live)
        if now != self._code_shown:
            self._code_shown = now
            self._code.content = panel.code(session.listing, live)
        self._undo.disabled = not session.can_undo
        self._save.disabled = session.saver is None or not session.listing.changed()
        unshown = [*session.scene.problems.items(), *self._drawing.problems.items()]
        others = [
            *session.listing.errors(),
            *(f"{node} has ended" for node in sorted(session.listing.ended)),
            *(f"{key}: {why}" for key, why in unshown),
        ]
        if time.monotonic() > self._done_until:
            self._done = ""
        problem = self._problem or next((f"⚠ {one}" for one in others), self._done)
        if self._message.visible != bool(problem):
            self._message.visible = bool(problem)
        if problem and self._message.content != _quoted(problem):
            self._message.content = _quoted(problem)

    # What people do

    def grabbed(self, handle: Handle, position: Vector) -> bool:
        dragger = self._session.grab(handle)
        if dragger is None:
            return False
        self._grips[handle.key] = Grip(handle, position)
        self._draggers[handle.key] = dragger
        self._selected = handle.key
        return True

    def moved(self, handle: Handle, position: Vector) -> None:
        dragger = self._draggers.get(handle.key)
        if dragger is not None:
            dragger.to(self._grips[handle.key].moved(position))

    def turned(self, handle: Handle, rotation: Quaternion) -> None:
        dragger = self._draggers.get(handle.key)
        item = self._session.scene.get(handle.item)
        if dragger is not None and item is not None:
            dragger.to(handle.turned(rotation, item.tracked.fields))

    def released(self, handle: Handle) -> None:
        def let_go() -> None:
            self._session.let_go(handle)
            self._draggers.pop(handle.key, None)

        threading.Thread(target=let_go, name="release", daemon=True).start()


def _serve(host: str, port: int | None) -> viser.ViserServer:
    if port is not None:
        _check_port(host, port)
    logging.getLogger("websockets").setLevel(logging.CRITICAL)  # somebody's wrong request
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # it prints its address in a box
            return viser.ViserServer(host=host, port=port or DEFAULT_PORT, verbose=False)
    except OSError as error:
        raise CannotServe(f"cannot listen on {host}:{port or DEFAULT_PORT}: {error}") from None


def _check_port(host: str, port: int) -> None:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        with socket.socket(family) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except OSError as error:
        reason = error.strerror or str(error)
        raise CannotServe(f"cannot listen on {host}:{port}: {reason}") from None


def _in_url(host: str) -> str:
    if host in ("0.0.0.0", "::", ""):
        return "localhost"
    return f"[{host}]" if ":" in host else host


def _quoted(problem: str) -> str:
    return "".join(f"\\{c}" if c in "\\`*_{}[]<>()#+-.!|" else c for c in problem)


def _size(item: Item) -> float:
    """How large the gizmo of an item is drawn."""
    shape = item.picture.shapes[0]
    if shape.kind == AXES:
        return 0.6
    if shape.kind in OF_POINTS:
        return 0.9
    return max(0.5, 1.2 * max(map(abs, shape.scale)))


def _ball_size(item: Item) -> float:
    shape = item.picture.shapes[0]
    factor = 2.0 if shape.kind in (LINE_STRIP, LINE_LIST) else 0.3
    return min(max(factor * abs(shape.scale[0]), 0.06), 0.2)


def _ball() -> Iterator[Any]:
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
    yield ball.vertices
    yield ball.faces
