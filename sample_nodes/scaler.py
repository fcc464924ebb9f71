"""Turns the numbers on foo into a velocity on scaled."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Int32

METRES_PER_COUNT = 0.25


class Scaler(Node):
    def __init__(self):
        super().__init__("scaler")
        self.offset = 1.0
        self.publisher = self.create_publisher(Twist, "scaled", 10)
        self.create_subscription(Int32, "foo", self.on_number, 10)

    def on_number(self, msg):
        twist = Twist()
        twist.linear.x = msg.data * METRES_PER_COUNT + self.offset
        twist.angular.z = 0.5
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = Scaler()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
