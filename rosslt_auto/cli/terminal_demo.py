"""The main job in a terminal: two unmodified nodes, one field, the literal it came from.

Starts ``sample_nodes/talker.py`` and ``scaler.py`` under ``run`` in two processes, lets the verbs
of the command line show and change what they publish, and ends both.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from . import Failure, need_ros, show

NODES = ("talker.py", "scaler.py")
COMMANDS = (
    ("What /scaled carries, and where each field comes from:", "echo /scaled --once --timeout 10"),
    ("Its linear.x shall be 6. The arithmetic is inverted, through both nodes:",
     "force /scaled linear.x=6 --timeout 10"),
    ("So the literal in talker.py is another one now, and so are the messages:",
     "echo /scaled --field linear.x --once --timeout 10"),
    ("What can be changed in all nodes:", "locations"),
)  # fmt: skip


def run() -> int:
    """Shows the demo; returns the exit status."""
    need_ros()
    folder = sample_nodes()
    # A domain of its own on this machine: no robot nearby shall take part.
    environment = {
        "ROS_DOMAIN_ID": str(random.randint(1, 99)),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        **os.environ,
    }
    console = show.console()
    console.print("Two ordinary rclpy nodes, nothing imported from rosslt_auto:\n", style="bold")
    for name in NODES:
        console.print(f"  $ python -m rosslt_auto run sample_nodes/{name} &", style="cyan")
    with _running(folder, environment):
        for comment, words in COMMANDS:
            console.print(f"\n{comment}", style="bold")
            console.print(f"\n  $ python -m rosslt_auto {words}", style="cyan")
            status = subprocess.run(
                [sys.executable, "-m", "rosslt_auto", *words.split()], env=environment, check=False
            ).returncode
            if status:
                raise Failure(f"the demo's `{words}` failed with status {status}")
    console.print("\nThe files are as they were: only running nodes have changed.", style="bold")
    return 0


def sample_nodes() -> Path:
    """The folder with the sample nodes; raises Failure where the project is not a checkout."""
    folder = Path(__file__).resolve().parents[2] / "sample_nodes"
    if not folder.is_dir():
        raise Failure("the sample nodes are not installed: run the demo in a clone of the project")
    return folder


@contextmanager
def _running(folder: Path, environment: dict[str, str]) -> Iterator[None]:
    """Both nodes, until the end."""
    nodes = [
        subprocess.Popen(
            [sys.executable, "-m", "rosslt_auto", "run", str(folder / name)], env=environment
        )
        for name in NODES
    ]
    try:
        yield
    finally:
        for node in nodes:
            node.send_signal(signal.SIGINT)
        for node in nodes:
            try:
                node.wait(10)
            except subprocess.TimeoutExpired:
                node.kill()
