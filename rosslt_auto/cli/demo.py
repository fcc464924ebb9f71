"""``demo``: the paper's quadcopter example on unmodified nodes (Section I-A), with ``view``."""

from __future__ import annotations

import os
import queue
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import Failure, need_ros, options, say
from .terminal_demo import sample_nodes

NODES = ("interactive_script.py", "slt_trajectory.py", "slt_quad.py")
TOPICS = ("/trajectory_marker", "/quad_marker")

START = 60.0
"""Seconds that everything may take to be up."""

_END = 10.0
_LAST_WORDS = 2.0
_FOLLOW = 3.0
_TRIES = 3

# A demo that is killed takes its nodes with it.
_WITH_US = ("setpriv", "--pdeathsig", "TERM") if shutil.which("setpriv") else ()


def main(words: Sequence[str]) -> int:
    """Runs the demo until interrupted, which is how it ends: status 0."""
    from . import view

    parser = options.parser(
        "demo",
        "The quadcopter example on unmodified nodes: drag it, and the mission script changes.",
    )
    view.add_page_options(parser)
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")
    parser.add_argument(
        "--terminal", action="store_true", help="two nodes and the command line, without a browser"
    )
    arguments = parser.parse_args(words)
    if arguments.terminal:
        from . import terminal_demo

        return terminal_demo.run()
    with _interrupts() as interrupts:
        need_ros()
        view.need_viser()
        return _run(arguments, sample_nodes(), interrupts)


def _run(arguments: Any, folder: Path, interrupts: queue.SimpleQueue[int]) -> int:
    # A domain of its own on this machine: no robot nearby shall take part.
    os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(1, 99)))
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with _running(folder) as nodes:
        # Imported while the nodes start.
        from rosslt_auto.ros.observer import Observer
        from rosslt_auto.views.browser import CannotServe, Page
        from rosslt_auto.views.session import Session

        from .view import saver

        with Observer("demo") as observer:
            try:
                with (
                    Session(observer, TOPICS, saver(observer)) as session,
                    Page(session, arguments.host, arguments.port) as page,
                ):
                    watch = _Watch(session, page, nodes, interrupts, arguments.no_browser)
                    threading.Thread(target=watch.run, daemon=True).start()
                    page.run(watch.over)
            except CannotServe as reason:
                raise Failure(str(reason)) from None
    if watch.dead is not None:
        raise Failure(f"{watch.dead.name} has ended with status {watch.dead.process.returncode}")
    return 0


class _Watch:
    """Says where the page is, as soon as there is something to drag, and notices the end.

    over  set when the demo is interrupted, or a node, then `dead`, has ended
    """

    def __init__(
        self,
        session: Any,
        page: Any,
        nodes: Sequence[_Node],
        interrupts: queue.SimpleQueue[int],
        no_browser: bool,
    ) -> None:
        self.over = threading.Event()
        self.dead: _Node | None = None
        self._session = session
        self._page = page
        self._nodes = nodes
        self._interrupts = interrupts
        self._no_browser = no_browser

    def run(self) -> None:
        began = time.monotonic()
        said = False
        while not self._ends():
            if not said and (self._is_up() or time.monotonic() - began > START):
                said = True
                self._greet()
        self.over.set()

    def _ends(self) -> bool:
        """After a moment: whether it is over."""
        self.dead = next((one for one in self._nodes if one.process.poll() is not None), None)
        if self.dead is not None:
            return True
        with suppress(queue.Empty):
            self._interrupts.get(timeout=0.05)
            return True
        return False

    def _is_up(self) -> bool:
        session = self._session
        shown = {item.topic for item in session.scene.items() if session.handles.of(item)}
        return shown.issuperset(TOPICS)

    def _greet(self) -> None:
        print(self._page.address, flush=True)
        say("drag the quadcopter or the curve in the browser; press Ctrl-C to end")
        if _has_screen():
            if not self._no_browser:
                _open(self._page.address)
        elif not sys.stdout.isatty():
            threading.Thread(target=_show, args=(self._session,), daemon=True).start()


def _has_screen() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _open(address: str) -> None:
    import webbrowser

    with suppress(webbrowser.Error):  # the address has been printed
        webbrowser.open(address)


def _show(session: Any) -> None:
    """For a log that nobody will drag anything in: one drag of the curve's end, taken back."""
    for _ in range(_TRIES):  # the next waypoint may come in between
        said, followed = _drag_once(session)
        undone = session.undo()
        if followed:
            break
    for line in said:
        say(line)
    outcome = "and the curve has followed" if followed else "but the curve has not followed"
    say(f"{outcome}; {undone}")


def _drag_once(session: Any) -> tuple[list[str], bool]:
    """What the drag has changed, for people, and whether a message shows it."""
    item = session.scene.get("/trajectory_marker/trajectory/2")
    handles = session.handles.of(item) if item is not None else []
    handle = next((one for one in handles if "x" in one.moves), None)
    dragger = session.grab(handle) if handle is not None else None
    if handle is None or dragger is None:
        return [], False
    wanted = round(handle.position[0] + 0.5, 3)
    dragger.to({f"{handle.spot.path}.x": wanted})
    session.let_go(handle)
    said = []
    for one in dragger.drag.changed.values():
        place = session.listing.get(one.source) or one.source
        said.append(
            f"for example: the end of the curve dragged to x = {wanted} changes {one.old!r} to"
            f" {one.new:.6g} in {os.path.basename(place.file or '')}:{place.line}"
            f"  {(place.text or '').strip()}"
        )
    deadline = time.monotonic() + _FOLLOW
    while time.monotonic() < deadline:
        session.scene.wait(0.2)
        item = session.scene.get(item.key)
        if item is not None and abs(item.picture.spots[0].position[0] - wanted) < 1e-6:
            return said, True
    return said, False


@contextmanager
def _interrupts() -> Iterator[queue.SimpleQueue[int]]:
    """What has been asked to end comes in a queue and disturbs nothing on its way.

    Whoever terminates this ends the nodes too; a second signal does not hinder that.
    """
    came: queue.SimpleQueue[int] = queue.SimpleQueue()
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {n: signal.signal(n, lambda number, frame: came.put(number)) for n in numbers}
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@dataclass
class _Node:
    """A node of the demo, and the thread that passes on what it complains about."""

    name: str
    process: subprocess.Popen[bytes]
    complaints: threading.Thread


@contextmanager
def _running(folder: Path) -> Iterator[list[_Node]]:
    """The nodes, until the end. Ctrl-C in a terminal is not for them: they are ended here.

    What they complain about is passed on, but not at the end: an interrupted rclpy node that is
    just publishing cannot, and says so.
    """
    ending = threading.Event()
    nodes: list[_Node] = []
    try:
        for name in NODES:
            process = subprocess.Popen(
                [*_WITH_US, sys.executable, "-m", "rosslt_auto", "run", str(folder / name)],
                stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, process_group=0,
            )  # fmt: skip
            complaints = threading.Thread(target=_pass_on, args=(process, ending), daemon=True)
            complaints.start()
            nodes.append(_Node(name, process, complaints))
        yield nodes
    finally:
        for node in nodes:
            if node.process.poll() is not None:  # why it has ended
                node.complaints.join(_LAST_WORDS)
        ending.set()
        for node in nodes:
            node.process.terminate()
        deadline = time.monotonic() + _END
        for node in nodes:
            try:
                node.process.wait(max(0.1, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                node.process.kill()


def _pass_on(process: subprocess.Popen[bytes], ending: threading.Event) -> None:
    assert process.stderr is not None
    for line in process.stderr:
        if not ending.is_set():
            sys.stderr.write(line.decode(errors="replace"))
            sys.stderr.flush()
