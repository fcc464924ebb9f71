"""Sweeps a pose along a circle and publishes it on sweep."""

import math

import rclpy
from geometry_msgs.msg import Pose
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

RADIUS = 2.0
STEP = 0.05


class Sweeper(Node):
    def __init__(self):
        super().__init__("sweeper")
        self.angle = 0.0
        self.publisher = self.create_publisher(Pose, "sweep", 10)
        self.create_timer(0.05, self.on_timer)

    def on_timer(self):
        self.angle += STEP
        pose = Pose()
        pose.position.x = RADIUS * math.cos(self.angle)
        pose.position.y = RADIUS * math.sin(self.angle)
        pose.position.z = self.angle / math.tau
        pose.orientation.z = math.sin(self.angle / 2)
        pose.orientation.w = math.cos(self.angle / 2)
        self.publisher.publish(pose)


def main(args=None):
    rclpy.init(args=args)
    node = Sweeper()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
