"""Uses the public functions on what the talker publishes."""

import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import Int32

from rosslt_auto import create_location, force_value, provenance, reevaluate, untracked


class Listener(Node):
    def __init__(self):
        super().__init__("operator")
        self.messages = []
        self.create_subscription(Int32, "foo", self.messages.append, 10)

    def until(self, condition):
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline:
            rclpy.spin_once(self, timeout_sec=0.1)
            found = [message for message in self.messages if condition(message)]
            if found:
                return found[-1]
        raise TimeoutError


def main():
    rclpy.init()
    node = Listener()
    first = node.until(lambda message: provenance(message.data))
    print("expression", provenance(first.data).expression, type(untracked(first.data)) is int)
    changes = force_value(first, {"data": 14}).result(20)
    print("changed", [(c.node, c.parameter, c.old, c.new) for c in changes])
    print("shown", node.until(lambda message: message.data == 14).data)
    print("reevaluated", first.data, reevaluate(first.data), reevaluate(first).data)
    changes = force_value(first.data, 20).result(20)
    print("changed again", [c.new for c in changes])
    gain = create_location(2.5, name="gain")
    print("location", provenance(gain * 2).sources[0].parameter, gain * 2)
    try:
        force_value(first, {"data": 1.5})
    except ValueError as error:
        print("refused", type(error).__name__)
    rclpy.shutdown()


main()
