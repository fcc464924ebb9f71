"""Three nodes in one executor, one of them a subclass of another, with names given from outside."""

import rclpy
from geometry_msgs.msg import Vector3
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


class Source(Node):
    step = 0.5

    def __init__(self, name="source", **kwargs):
        super().__init__(name, **kwargs)
        self.vector = Vector3(x=1.0, y=-2.0)
        self.publisher = self.create_publisher(Vector3, "vector", 10)
        self.timer = self.create_timer(0.01, self.publish)

    def publish(self):
        if not self.publisher.get_subscription_count():
            return
        self.vector.x += self.step
        self.publisher.publish(self.vector)
        self.vector.y = -self.vector.x / 3


class Faster(Source):
    step = 2 * Source.step

    def publish(self):
        super().publish()
        self.vector.z = 0.125


class Sink(Node):
    def __init__(self, executor):
        super().__init__("sink")
        self.received = {}
        self.executor_to_end = executor
        for topic in ("left/vector", "right/vector"):
            self.create_subscription(
                Vector3, topic, lambda msg, topic=topic: self.on_vector(topic, msg), 10
            )

    def on_vector(self, topic, msg):
        self.received.setdefault(topic, []).append(msg)
        if all(len(self.received.get(t, ())) >= 4 for t in ("left/vector", "right/vector")):
            raise ExternalShutdownException


rclpy.init()
executor = SingleThreadedExecutor()
sink = Sink(executor)
for node in (Source(namespace="left"), Faster("faster", namespace="right"), sink):
    executor.add_node(node)
try:
    executor.spin()
except ExternalShutdownException:
    print("enough")
for topic in sorted(sink.received):
    print(topic, *sink.received[topic][:4], sep="\n  ")
for node in executor.get_nodes():
    node.destroy_node()
rclpy.shutdown()
