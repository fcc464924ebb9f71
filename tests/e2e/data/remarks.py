"""What is in it may be changed as far as its comments allow."""

import rclpy
from geometry_msgs.msg import Vector3
from rclpy.node import Node

OFFSET = 0.25  # rosslt: off


class Remarks(Node):
    def __init__(self):
        super().__init__("remarks")
        self.speed = 0.5  # rosslt: 0.0 to 2.0 step 0.1
        self.gears = 3  # rosslt: 1 to 5
        self.mass = 4.0  # rosslt: frozen
        self.publisher = self.create_publisher(Vector3, "limited", 10)
        self.timer = self.create_timer(0.05, self.tick)

    def tick(self):
        self.publisher.publish(
            Vector3(x=self.speed + OFFSET, y=self.mass * 1.5, z=float(self.gears))
        )


rclpy.init()
rclpy.spin(Remarks())
