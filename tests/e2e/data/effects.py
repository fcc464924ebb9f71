"""Publishes on effects numbers that come from literals executed at different times."""

import rclpy
from geometry_msgs.msg import Inertia
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

MODULE = 1.0
DERIVED = MODULE * 10.0


def make_closure():
    enclosed = 4.0
    return lambda: enclosed


class Effects(Node):
    class_attribute = 2.0

    def __init__(self):
        super().__init__("effects")
        self.attribute = 3.0
        self.closure = make_closure()
        self.table = {"nested": [7.0]}
        self.gain = self.declare_parameter("gain", 9.0).value
        self.total = 0.0
        self.publisher = self.create_publisher(Inertia, "effects", 10)
        self.create_timer(0.05, self.on_timer)

    def default(self, argument=5.0):
        return argument

    def on_timer(self):
        self.total += 0.5
        msg = Inertia()
        msg.m = MODULE
        msg.com.x = self.class_attribute
        msg.com.y = self.attribute
        msg.com.z = self.closure()
        msg.ixx = self.default()
        msg.ixy = 6.0
        msg.ixz = self.table["nested"][0]
        msg.iyy = DERIVED
        msg.iyz = self.gain
        msg.izz = self.total
        self.publisher.publish(msg)


def main(args=None):
    rclpy.init(args=args)
    try:
        rclpy.spin(Effects())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == "__main__":
    main()
