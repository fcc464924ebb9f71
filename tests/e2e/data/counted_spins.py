"""Counts how often it spins: whatever else wakes the executor would be counted too."""

import rclpy
from std_msgs.msg import Float64

rclpy.init()
node = rclpy.create_node("counted_spins")
received, ticks = [], []
publisher = node.create_publisher(Float64, "value", 10)
node.create_subscription(Float64, "value", received.append, 10)
while not publisher.get_subscription_count():
    rclpy.spin_once(node, timeout_sec=0.05)


def on_timer():
    ticks.append(len(ticks) + 1)
    publisher.publish(Float64(data=ticks[-1] * 0.5))


node.create_timer(0.1, on_timer)
rclpy.spin_once(node, timeout_sec=0)  # the timer has just been added
for cycle in range(12):
    rclpy.spin_once(node)
print(len(ticks), [message.data for message in received])
rclpy.shutdown()
