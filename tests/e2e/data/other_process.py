"""A node in a process that the program starts."""

import multiprocessing
import sys

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64

GAIN = 0.5


class Child(Node):
    def __init__(self):
        super().__init__("child")
        self.publisher = self.create_publisher(Float64, "from_child", 10)
        self.timer = self.create_timer(0.05, self.tick)

    def tick(self):
        self.publisher.publish(Float64(data=GAIN * 3.0))


def work():
    rclpy.init()
    rclpy.spin(Child())


if __name__ == "__main__":
    context = multiprocessing.get_context(sys.argv[1])
    process = context.Process(target=work, daemon=True)
    process.start()
    process.join()
