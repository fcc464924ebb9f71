"""What provenance costs on the wire: ``python -m benchmarks.wire``.

publish   with a subscriber in another process; the header, if there is one, goes there too
receive   taking a message that has arrived, by `Subscription.handle.take_message`
matched   headers that found their message, in another process, at 1 kHz

Plain rclpy does the same beside it in the same run.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

if __name__ == "__main__":
    # Before rclpy is imported: nobody else's ROS, nobody else's messages.
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 98))

import rclpy
from geometry_msgs.msg import Pose
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Image

from benchmarks.common import Timing, machine, measure_together, print_table
from rosslt_auto.provenance import Source
from rosslt_auto.provenance.values import is_tracked, leaf
from rosslt_auto.ros import publishing, subscribing

DEPTH = 100
BATCH = 20
DEADLINE = 30.0


class Sources(Node):
    """Publishes plain and woven side by side."""

    def __init__(self) -> None:
        super().__init__("wire_sources")
        self.pose = self.create_publisher(Pose, "plain/pose", DEPTH)
        self.image = self.create_publisher(Image, "plain/image", DEPTH)
        with woven():
            self.woven_pose = self.create_publisher(Pose, "woven/pose", DEPTH)
            self.woven_image = self.create_publisher(Image, "woven/image", DEPTH)
            self.counted = self.create_publisher(Pose, "woven/counted", 2000)

    @property
    def publishers_made(self) -> list[Any]:
        return [self.pose, self.image, self.woven_pose, self.woven_image, self.counted]

    def wait_for_subscribers(self) -> None:
        """Returns when all topics and header topics have one."""
        handles = [publisher.handle for publisher in self.publishers_made]
        handles += [h.headers._handle for h in handles if getattr(h, "headers", None)]
        wait_until(lambda: all(handle.get_subscription_count() for handle in handles))


@contextmanager
def woven() -> Iterator[None]:
    """Publishers and subscriptions made here have our advice, and keep it."""
    publishing.install()
    subscribing.install()
    try:
        yield
    finally:
        for aspect in (publishing, subscribing):
            connected = set(aspect.woven.connected)
            aspect.woven.connected.clear()
            aspect.uninstall()
            aspect.woven.connected.update(connected)


def wait_until(condition: Callable[[], bool]) -> None:
    """Returns when the condition holds; ends the benchmark if that takes too long."""
    end = time.monotonic() + DEADLINE
    while not condition():
        if time.monotonic() > end:
            sys.exit("the two processes did not find each other")
        time.sleep(0.01)


RADIUS = leaf(Source("/wire_sources", "rosslt.wire.radius", "float", file="wire.py"), 1.5)
OFFSET = leaf(Source("/wire_sources", "rosslt.wire.offset", "float", file="wire.py"), 0.25)


def three_tracked_fields(step: int = 0) -> Pose:
    """A pose as a node computes it: literals, arithmetic, one value that moves."""
    pose = Pose()
    pose.position.x = RADIUS * (step * 0.01) + OFFSET
    pose.position.y = RADIUS * 2.0
    pose.position.z = OFFSET
    return pose


def measure_publishing(node: Sources, seconds: float) -> dict[str, list[Timing]]:
    """Times of [plain, woven] by what is published."""
    plain, tracked = Pose(), three_tracked_fields()
    image = Image(data=bytes(1_000_000))
    own = node.woven_pose.handle.headers
    assert own is not None
    poses = measure_together(
        [
            lambda: node.pose.publish(plain),
            lambda: node.woven_pose.publish(plain),
            lambda: node.woven_pose.publish(tracked),
        ],
        seconds,
    )
    images = measure_together(
        [lambda: node.image.publish(image), lambda: node.woven_image.publish(image)], 2 * seconds
    )
    return {
        "publish Pose, nothing tracked": [poses[0], poses[1]],
        "publish Pose, 3 tracked fields": [poses[0], poses[2]],
        "publish Image of 1 MB, nothing tracked": images,
    }


def measure_receiving(node: Node, seconds: float) -> dict[str, list[Timing]]:
    """Times of [plain, woven] by what is received."""
    plain = Pair(node, "plain/received")
    with woven():
        untracked = Pair(node, "woven/received_plain")
        tracked = Pair(node, "woven/received")
    pairs = [(plain, Pose()), (untracked, Pose()), (tracked, None)]
    samples: list[list[float]] = [[], [], []]
    end = time.perf_counter() + seconds
    step = 0
    while time.perf_counter() < end:
        for found, (pair, message) in zip(samples, pairs, strict=True):
            step += BATCH
            found += pair.take([message or three_tracked_fields(step + i) for i in range(BATCH)])
    times = [Timing(sorted(found)[len(found) // 2], min(found)) for found in samples]
    return {
        "receive Pose, nothing tracked": [times[0], times[1]],
        "receive Pose, 3 tracked fields": [times[0], times[2]],
    }


class Pair:
    """A publisher and a subscription in this process."""

    def __init__(self, node: Node, topic: str) -> None:
        self.publisher = node.create_publisher(Pose, topic, DEPTH)
        self.subscription = node.create_subscription(Pose, topic, lambda _: None, DEPTH)
        wait_until(lambda: bool(self.publisher.get_subscription_count()))
        headers = getattr(self.publisher.handle, "headers", None)
        if headers is not None:
            wait_until(lambda: bool(headers._handle.get_subscription_count()))

    def take(self, messages: list[Pose]) -> list[float]:
        """The seconds that taking each of these messages lasts, which are published first."""
        for message in messages:
            self.publisher.publish(message)
        handle = self.subscription.handle
        times = []
        for message in messages:
            taken = None
            while taken is None:
                start = time.perf_counter()
                taken = handle.take_message(Pose, False)
                end = time.perf_counter()
            times.append(end - start)
            received = taken[0]
            assert received == message
            assert is_tracked(received.position.x) == is_tracked(message.position.x)
        return times


def count_matched(node: Sources, receiver: subprocess.Popen[str], count: int, rate: float) -> int:
    """How many of `count` messages got their header in the other process."""
    due = time.perf_counter()
    for step in range(count):
        node.counted.publish(three_tracked_fields(step))
        due += 1 / rate
        while (left := due - time.perf_counter()) > 0:
            time.sleep(left)
    try:
        output, _ = receiver.communicate(timeout=DEADLINE)
    except subprocess.TimeoutExpired:
        receiver.kill()
        output, _ = receiver.communicate()
    found = json.loads(output.splitlines()[-1])
    return found["matched"]


def receive(count: int) -> None:
    """The other process: takes everything, prints how many of `count` messages had provenance."""
    subscribing.install()
    rclpy.init()
    node = rclpy.create_node("wire_receiver")
    matched: list[bool] = []

    def on_counted(pose: Pose) -> None:
        matched.append(all(map(is_tracked, (pose.position.x, pose.position.y, pose.position.z))))
        if len(matched) == count:
            print(json.dumps({"matched": sum(matched)}), flush=True)
            raise KeyboardInterrupt

    for topic in ("plain/pose", "woven/pose"):
        node.create_subscription(Pose, topic, lambda _: None, DEPTH)
    for topic in ("plain/image", "woven/image"):
        node.create_subscription(Image, topic, lambda _: None, 1, raw=True)
    node.create_subscription(Pose, "woven/counted", on_counted, QoSProfile(depth=count))
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)
    if len(matched) < count:
        print(json.dumps({"matched": sum(matched)}), flush=True)
    rclpy.try_shutdown()


def figures(plain: float, own: float) -> list[str]:
    """Microseconds of both, how much more that is, and how many times as much."""
    more = (own - plain) * 1e6
    return [f"{plain * 1e6:.1f}", f"{own * 1e6:.1f}", f"{more:+.1f}", f"{own / plain:.3f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seconds", type=float, default=3.0, help="for each measurement")
    parser.add_argument("--messages", type=int, default=2000, help="at 1 kHz")
    parser.add_argument("--receive", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.receive:
        receive(options.receive)
        return
    command = [sys.executable, "-m", "benchmarks.wire", "--receive", str(options.messages)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as receiver:
        try:
            rclpy.init()
            node = Sources()
            node.wait_for_subscribers()
            found = measure_publishing(node, options.seconds)
            matched = count_matched(node, receiver, options.messages, 1000.0)
            found |= measure_receiving(node, options.seconds)
        finally:
            receiver.kill()
    print_table(
        f"Wire: microseconds, {machine()}",
        ["", "plain", "woven", "difference", "ratio", "minimum", "woven", "difference", "ratio"],
        [
            [
                what,
                *figures(plain.median, own.median),
                *figures(plain.minimum, own.minimum),
            ]
            for what, (plain, own) in found.items()
        ],
    )
    print(f"headers matched at 1 kHz between two processes: {matched} of {options.messages}")
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
