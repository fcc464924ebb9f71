"""A simulated quadcopter: it is where control_target was a moment ago."""

from collections import deque

import rclpy
from geometry_msgs.msg import Point, Pose
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from visualization_msgs.msg import Marker

DELAY = 10  # control targets
ARM = 0.25


class Quad(Node):
    def __init__(self):
        super().__init__("slt_quad")
        self.pose = Pose()
        self.coming = deque()
        self.pose_publisher = self.create_publisher(Pose, "quad_pose", 10)
        self.marker_publisher = self.create_publisher(Marker, "quad_marker", 10)
        self.create_subscription(Pose, "control_target", self.on_control, 10)
        self.create_timer(0.02, self.send)
        self.create_timer(0.05, self.show)

    def on_control(self, pose):
        self.coming.append(pose)
        if len(self.coming) > DELAY:
            self.pose = self.coming.popleft()

    def send(self):
        self.pose_publisher.publish(self.pose)

    def show(self):
        marker = Marker(ns="quad", id=0, type=Marker.SPHERE_LIST, action=Marker.ADD)
        marker.header.frame_id = "map"
        marker.pose = self.pose
        marker.scale.x = marker.scale.y = 0.3
        marker.scale.z = 0.08
        marker.color.r = 0.2
        marker.color.g = 0.6
        marker.color.b = 1.0
        marker.color.a = 1.0
        marker.points = [
            Point(x=ARM, y=ARM), Point(x=-ARM, y=ARM), Point(x=-ARM, y=-ARM), Point(x=ARM, y=-ARM)
        ]  # fmt: skip
        self.marker_publisher.publish(marker)


def main(args=None):
    rclpy.init(args=args)
    node = Quad()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
