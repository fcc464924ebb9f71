"""An executor of one's own: callbacks of the important node first, the others in a pool."""

from concurrent.futures import ThreadPoolExecutor

import rclpy
from rclpy.executors import Executor, TimeoutException
from rclpy.node import Node
from std_msgs.msg import Float64


class Priority(Executor):
    def __init__(self):
        super().__init__()
        self.important = set()
        self.pool = ThreadPoolExecutor(2)
        self.handled = {True: 0, False: 0}

    def spin_once(self, timeout_sec=None):
        try:
            handler, group, node = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
        except (StopIteration, TimeoutException):
            return
        important = node in self.important
        self.handled[important] += 1
        if important:
            handler()
            if handler.exception() is not None:
                raise handler.exception()
        else:
            self.pool.submit(handler)


class Echo(Node):
    def __init__(self, name, factor):
        super().__init__(name)
        self.factor = factor
        self.received = []
        self.create_subscription(Float64, "value", self.on_value, 10)

    def on_value(self, msg):
        self.received.append(msg.data * self.factor)


rclpy.init()
executor = Priority()
important, other = Echo("important", 2.0), Echo("other", 0.5)
executor.important.add(important)
executor.add_node(important)
executor.add_node(other)
publisher = other.create_publisher(Float64, "value", 10)
while publisher.get_subscription_count() < 2:
    executor.spin_once(timeout_sec=0.05)
for i in range(6):
    publisher.publish(Float64(data=1.5**i))
for _ in range(2000):
    if len(important.received) == len(other.received) == 6:
        break
    executor.spin_once(timeout_sec=0.05)
executor.pool.shutdown()
print(important.received, sorted(other.received), executor.handled[True] >= 6)
executor.shutdown()
rclpy.shutdown()
