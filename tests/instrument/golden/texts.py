"""Texts, and names of things that stay as they are."""

import rclpy

FRAME = "map"


def report(node, label, n):
    node.create_publisher(String, "topic", 10)
    node.get_logger().info("started")
    text = f"{label} {n:d} of {10}" + "!"
    if label == "x":
        raise ValueError(f"{label} is bad")
    return "{} metres".format(n), "%d" % n, ", ".join([text, "end"]), f"{n!r:>{width}}"


def project(zone):
    return Proj(FRAME, zone=f"{zone}N", kind="utm")
