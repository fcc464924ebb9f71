"""Publishes points with provenance, as a process of its own.

sender.py [--topic T] [--name NODE] [--count N] [--rate HZ] [--best-effort] [--latched] [--keep-all]
          [--depth D] [--untracked-too] [--constant] [--early]   ROS arguments

Point i has x = gain * i, y = offset, z = i, or all of them the same (--constant). It begins when
somebody listens, to its headers too (--early: at once), prints "sent" and stays until interrupted.
"""

import argparse
import signal
import sys
import time

import rclpy
from geometry_msgs.msg import Point
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from rosslt_auto.provenance import Source
from rosslt_auto.provenance.values import leaf
from rosslt_auto.ros import publishing

parser = argparse.ArgumentParser()
parser.add_argument("--topic", default="points")
parser.add_argument("--name", default="sender")
parser.add_argument("--count", type=int, default=10)
parser.add_argument("--rate", type=float, default=100.0)
parser.add_argument("--best-effort", action="store_true")
parser.add_argument("--latched", action="store_true")
parser.add_argument("--keep-all", action="store_true")
parser.add_argument("--depth", type=int, default=10)
parser.add_argument("--untracked-too", action="store_true")
parser.add_argument("--constant", action="store_true")
parser.add_argument("--early", action="store_true")
options, ros_arguments = parser.parse_known_args()

qos = QoSProfile(
    depth=options.depth,
    history=HistoryPolicy.KEEP_ALL if options.keep_all else HistoryPolicy.KEEP_LAST,
    reliability=(
        ReliabilityPolicy.BEST_EFFORT if options.best_effort else ReliabilityPolicy.RELIABLE
    ),
    durability=DurabilityPolicy.TRANSIENT_LOCAL if options.latched else DurabilityPolicy.VOLATILE,
)

publishing.install()
rclpy.init(args=[sys.argv[0], *ros_arguments])
node = rclpy.create_node(options.name)
publisher = node.create_publisher(Point, options.topic, qos)
headers = publisher.handle.headers
owner = node.get_fully_qualified_name()
gain = leaf(Source(owner, "rosslt.sender.gain", "float", file="sender.py", line=1, column=7), 0.5)
offset = leaf(Source(owner, "rosslt.sender.offset", "float"), 0.25)

try:
    while not options.early and not (
        publisher.get_subscription_count() and headers._handle.get_subscription_count()
    ):
        time.sleep(0.005)
    due = time.monotonic()
    for i in range(options.count):
        if options.constant:
            point = Point(x=gain * 2.0, y=offset)
        else:
            point = Point(x=gain * i, y=offset, z=float(i))
        if options.untracked_too and i % 2:
            point = Point(x=0.5 * i, z=float(i))
        publisher.publish(point)
        due += 1 / options.rate
        while (left := due - time.monotonic()) > 0:
            time.sleep(left)
    print("sent", flush=True)
    signal.pause()
except KeyboardInterrupt:
    pass
finally:
    rclpy.try_shutdown()
