"""Says itself what is to be tracked, and is run by plain python."""

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64

from rosslt_auto import tracked_module


@tracked_module
class Pacer(Node):
    gain = 0.5

    def __init__(self, offset=1.25):
        super().__init__("pacer")
        self.offset = offset
        self.publisher = self.create_publisher(Float64, "pace", 10)
        self.plain = self.create_publisher(Float64, "plain", 10)
        self.create_timer(0.05, self.on_timer)

    def on_timer(self):
        self.publisher.publish(Float64(data=self.gain * 4.0 + self.offset))
        self.plain.publish(Float64(data=not_tracked()))


def not_tracked():
    return 7.0


rclpy.init()
try:
    rclpy.spin(Pacer())
except KeyboardInterrupt:
    pass
