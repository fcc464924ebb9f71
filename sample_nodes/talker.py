"""Publishes a number on foo."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Int32


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.count = 5
        self.publisher = self.create_publisher(Int32, "foo", 10)
        self.timer = self.create_timer(0.1, self.on_timer)

    def on_timer(self):
        msg = Int32()
        msg.data = 2 * self.count
        self.publisher.publish(msg)


def main(args=None):
    rclpy.init(args=args)
    node = Talker()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
