"""What the demo takes: ``python -m benchmarks.views``.

start    from `demo` to the address of a page in which something can be dragged
literal  from a drag of the curve's end to the node's word that the literal has another value
marker   from the same drag to the marker that shows it
cores    all processes together, without a browser, as a share of one core

The machine's load is printed beside: with others at work the figures are theirs too.
"""

from __future__ import annotations

import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

if __name__ == "__main__":
    # Before rclpy is imported: nobody else's ROS, nobody else's messages.
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 98))

from benchmarks.common import machine
from rosslt_auto.ros.observer import Observer
from rosslt_auto.views.session import Session

DRAGS = 30
SECONDS = 10.0
END = "/trajectory_marker/trajectory/2"


def cpu_seconds(process: int) -> float:
    """What a process and its children have used so far."""
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    total = 0.0
    for one in (process, *map(int, children)):
        fields = Path(f"/proc/{one}/stat").read_text().rpartition(")")[2].split()
        total += (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return total


def seconds_until(condition: Callable[[], bool], deadline: float = 3.0) -> float | None:
    began = time.perf_counter()
    while not condition():
        if time.perf_counter() - began > deadline:
            return None
        time.sleep(0.001)
    return time.perf_counter() - began


def drag(session: Session, by: float) -> tuple[float, float] | None:
    """Seconds to the literal and to the marker; None if the next waypoint came in between."""
    item = session.scene.get(END)
    handle = (
        next((one for one in session.handles.of(item) if "x" in one.moves), None) if item else None
    )
    dragger = session.grab(handle) if handle is not None else None
    if handle is None or dragger is None:
        return None
    wanted = handle.position[0] + by

    def shown() -> bool:
        now = session.scene.get(END)
        return now is not None and abs(now.picture.spots[0].position[0] - wanted) < 1e-6

    dragger.to({f"{handle.spot.path}.x": wanted})
    literal = seconds_until(lambda: bool(dragger.drag.changed))
    marker = seconds_until(shown)
    session.let_go(handle)
    if literal is None or marker is None:
        return None
    return literal, literal + marker


def main() -> None:
    began = time.perf_counter()
    demo = subprocess.Popen(
        [sys.executable, "-m", "rosslt_auto", "demo", "--no-browser"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        assert demo.stdout is not None
        demo.stdout.readline()
        start = time.perf_counter() - began
        before, since = cpu_seconds(demo.pid), time.perf_counter()
        time.sleep(SECONDS)
        cores = (cpu_seconds(demo.pid) - before) / (time.perf_counter() - since)
        with (
            Observer("benchmark") as observer,
            Session(observer, ["/trajectory_marker"]) as session,
        ):
            session.wait_for_handles(10.0)
            time.sleep(1.0)  # so that the clients that change parameters are matched
            found = [drag(session, 0.1 if i % 2 else -0.1) for i in range(DRAGS)]
    finally:
        demo.send_signal(signal.SIGINT)
        demo.wait()
    times = [one for one in found if one is not None]
    print(machine(), f"load {os.getloadavg()[0]:.1f}", sep=", ")
    print(f"start    {start:6.1f} s")
    for name, values in zip(("literal", "marker"), zip(*times, strict=True), strict=True):
        milliseconds = sorted(1000 * value for value in values)
        median, worst = statistics.median(milliseconds), milliseconds[-1]
        print(f"{name:8} {median:6.0f} ms, at most {worst:.0f}, of {len(times)} drags")
    print(f"cores    {cores:6.2f}")


if __name__ == "__main__":
    main()
