"""``demo``: the paper's quadcopter example on unmodified nodes (Section I-A), with ``view``."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from . import Failure, need_ros, options, say
from .terminal_demo import sample_nodes

NODES = ("interactive_script.py", "slt_trajectory.py", "slt_quad.py")
TOPICS = ("/trajectory_marker", "/quad_marker")

START = 60.0
"""Seconds that everything may take to be up."""

_END = 10.0


def main(words: Sequence[str]) -> int:
    """Runs the demo until interrupted."""
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
    need_ros()
    view.need_viser()
    return _run(arguments, sample_nodes())


def _run(arguments: Any, folder: Path) -> int:
    # A domain of its own on this machine: no robot nearby shall take part.
    os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(1, 99)))
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with _ending_like_interrupted(), _running(folder) as nodes:
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
                    dead = threading.Event()
                    threading.Thread(
                        target=_greet, args=(session, page, nodes, dead, arguments), daemon=True
                    ).start()
                    page.run(dead)
            except CannotServe as reason:
                raise Failure(str(reason)) from None
    raise Failure("a node of the demo has ended")


def _greet(
    session: Any, page: Any, nodes: list[Any], dead: threading.Event, arguments: Any
) -> None:
    """Says where the page is, as soon as there is something to drag in it."""
    began = time.monotonic()
    said = False
    while not dead.wait(0.05):
        if any(node.poll() is not None for node in nodes):
            dead.set()
        elif not said:
            shown = {item.topic for item in session.scene.items() if session.handles.of(item)}
            if shown.issuperset(TOPICS) or time.monotonic() - began > START:
                said = True
                print(page.address, flush=True)
                say("drag the quadcopter or the curve in the browser; press Ctrl-C to end")
                if not arguments.no_browser:
                    _open(page.address)


def _open(address: str) -> None:
    """Opens a browser where there is a screen."""
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return
    import webbrowser

    with suppress(webbrowser.Error):  # the address has been printed
        webbrowser.open(address)


@contextmanager
def _ending_like_interrupted() -> Iterator[None]:
    """Terminated is interrupted: whoever ends this ends the nodes too."""

    def interrupt(number: int, frame: Any) -> None:
        raise KeyboardInterrupt

    before = {which: signal.signal(which, interrupt) for which in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for which, handler in before.items():
            signal.signal(which, handler)


@contextmanager
def _running(folder: Path) -> Iterator[list[Any]]:
    """The nodes, until the end. Ctrl-C in a terminal is not for them: they are ended here.

    What they complain about is passed on, but not at the end: an interrupted rclpy node that is
    just publishing cannot, and says so.
    """
    ending = threading.Event()
    nodes = []
    for name in NODES:
        command = [sys.executable, "-m", "rosslt_auto", "run", str(folder / name)]
        node = subprocess.Popen(command, stderr=subprocess.PIPE, process_group=0)
        nodes.append(node)
        threading.Thread(target=_pass_on, args=(node.stderr, ending), daemon=True).start()
    try:
        yield nodes
    finally:
        ending.set()
        for node in nodes:
            node.terminate()
        deadline = time.monotonic() + _END
        for node in nodes:
            try:
                node.wait(max(0.1, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                node.kill()


def _pass_on(stream: IO[bytes], ending: threading.Event) -> None:
    for line in stream:
        if not ending.is_set():
            sys.stderr.write(line.decode(errors="replace"))
            sys.stderr.flush()
