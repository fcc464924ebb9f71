"""A subscriber whose callback is a lambda, and a publisher in a function beside it."""

import rclpy
from std_msgs.msg import Float64

rclpy.init()
node = rclpy.create_node("lambda_subscriber")
received = []
subscription = node.create_subscription(
    Float64, "numbers", lambda msg: received.append(msg.data), 10
)
publisher = node.create_publisher(Float64, "numbers", 10)
while not publisher.get_subscription_count():
    rclpy.spin_once(node, timeout_sec=0.05)
for number in range(5):
    publisher.publish(Float64(data=number * 0.1))
while len(received) < 5:
    rclpy.spin_once(node)
print(received, sum(received), max(received))
node.destroy_node()
rclpy.shutdown()
