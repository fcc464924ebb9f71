"""A MultiThreadedExecutor, one group of callbacks at a time and one of many at once."""

import threading
import time

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Int32


class Throttled(MutuallyExclusiveCallbackGroup):
    """A group of one's own."""

    def __init__(self):
        super().__init__()
        self.asked = 0

    def can_execute(self, entity):
        self.asked += 1
        return super().can_execute(entity)


class Groups(Node):
    def __init__(self):
        super().__init__("groups")
        self.one = Throttled()
        self.many = ReentrantCallbackGroup()
        self.running = self.most = 0
        self.lock = threading.Lock()
        self.ones, self.manys = [], []
        self.create_subscription(Int32, "n", self.on_one, 10, callback_group=self.one)
        self.create_subscription(Int32, "n", self.on_many, 10, callback_group=self.many)
        self.publisher = self.create_publisher(Int32, "n", 10)
        self.number = 0
        self.timer = self.create_timer(0.01, self.on_timer, callback_group=self.many)

    def on_timer(self):
        if self.publisher.get_subscription_count() == 2 and self.number < 10:
            self.number += 1
            self.publisher.publish(Int32(data=self.number * self.number))
        if self.number == 10:
            self.timer.cancel()

    def on_one(self, msg):
        with self.lock:
            self.running += 1
            self.most = max(self.most, self.running)
        time.sleep(0.002)
        self.ones.append(msg.data)
        with self.lock:
            self.running -= 1

    def on_many(self, msg):
        with self.lock:
            self.manys.append(msg.data)


rclpy.init()
node = Groups()
executor = MultiThreadedExecutor(num_threads=3)
executor.add_node(node)
spinner = threading.Thread(target=executor.spin)
spinner.start()
end = time.monotonic() + 20
while (len(node.ones) < 10 or len(node.manys) < 10) and time.monotonic() < end:
    time.sleep(0.01)
print(node.ones, sorted(node.manys), node.most, node.one.asked > 0)
executor.shutdown()
spinner.join()
rclpy.shutdown()
