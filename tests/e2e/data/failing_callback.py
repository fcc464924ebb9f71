"""An exception in a callback ends the program with a traceback."""

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64


class Failing(Node):
    def __init__(self):
        super().__init__("failing")
        self.values = [3.0, 1.5, 0.0]
        self.create_subscription(Float64, "value", self.on_value, 10)
        self.publisher = self.create_publisher(Float64, "value", 10)
        self.create_timer(0.01, self.on_timer)

    def on_timer(self):
        if self.publisher.get_subscription_count() and self.values:
            self.publisher.publish(Float64(data=self.values.pop(0)))

    def on_value(self, msg):
        print(self.inverse(msg.data), flush=True)

    def inverse(self, value):
        return 1.0 / value


def main():
    rclpy.init()
    rclpy.spin(Failing())


main()
