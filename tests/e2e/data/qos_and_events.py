"""Latched and best-effort topics, match events, a deadline, waiting for one message."""

import rclpy
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from rclpy.wait_for_message import wait_for_message
from sensor_msgs.msg import Range, Temperature

rclpy.init()
node = rclpy.create_node("qos")
events = []
latched = QoSProfile(
    depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE
)
publisher = node.create_publisher(
    Temperature,
    "temperature",
    latched,
    event_callbacks=PublisherEventCallbacks(
        matched=lambda info: events.append(("publisher", info.current_count))
    ),
)
for degrees in (20.0, 21.0, 22.0):
    publisher.publish(Temperature(temperature=degrees + 0.5))
received = []
late = node.create_subscription(
    Temperature,
    "temperature",
    received.append,
    latched,
    event_callbacks=SubscriptionEventCallbacks(
        matched=lambda info: events.append(("subscriber", info.current_count))
    ),
)
while not received or len(events) < 2:
    rclpy.spin_once(node, timeout_sec=0.05)
print(received, sorted(events))

ranges = []
node.create_subscription(Range, "range", ranges.append, qos_profile_sensor_data)
sensor = node.create_publisher(Range, "range", qos_profile_sensor_data)
while not sensor.get_subscription_count():
    rclpy.spin_once(node, timeout_sec=0.05)
message = Range(radiation_type=Range.INFRARED, field_of_view=0.1, min_range=0.5, max_range=4.0)
message.range = min(message.max_range, 2.0**1.5)
while not ranges:
    sensor.publish(message)
    rclpy.spin_once(node, timeout_sec=0.05)
print(ranges[0])

other = rclpy.create_node("other")
print(wait_for_message(Temperature, other, "temperature", qos_profile=latched, time_to_wait=20))
print(node.get_publishers_info_by_topic("temperature")[0].qos_profile.durability.name)
print(publisher.wait_for_all_acked(Duration(seconds=5.0)), publisher.get_subscription_count())
node.destroy_subscription(late)
print(publisher.get_subscription_count(), node.destroy_publisher(publisher))
rclpy.shutdown()
