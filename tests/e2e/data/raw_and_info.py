"""A subscriber of raw bytes, one that gets MessageInfo, one of both; several on one topic."""

import functools

import rclpy
from geometry_msgs.msg import Quaternion
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Header

rclpy.init()
node = rclpy.create_node("raw_and_info")
seen = {"raw": [], "info": [], "both": [], "partial": [], "callable": []}


def on_info(msg, info):
    seen["info"].append((msg, type(info).__name__, sorted(info)))


def on_both(data, info):
    msg = deserialize_message(data, Quaternion)
    seen["both"].append((type(data).__name__, len(data), msg, sorted(info)))


class Callable:
    def __call__(self, msg):
        seen["callable"].append(msg)


def on_partial(name, msg):
    seen[name].append(msg)


node.create_subscription(Quaternion, "q", lambda data: seen["raw"].append(data), 10, raw=True)
node.create_subscription(Quaternion, "q", on_info, 10)
node.create_subscription(Quaternion, "q", on_both, 10, raw=True)
node.create_subscription(Quaternion, "q", functools.partial(on_partial, "partial"), 10)
node.create_subscription(Quaternion, "q", Callable(), 10)
publisher = node.create_publisher(Quaternion, "q", 10)
while publisher.get_subscription_count() < 5:
    rclpy.spin_once(node, timeout_sec=0.05)
for i in range(3):
    message = Quaternion(x=0.5 * i, w=1 / (i + 1))
    # Bytes may be published too.
    publisher.publish(serialize_message(message) if i == 1 else message)
while not all(len(messages) == 3 for messages in seen.values()):
    rclpy.spin_once(node, timeout_sec=0.05)
print([(type(data).__name__, len(data)) for data in seen["raw"]])
print([deserialize_message(data, Quaternion) for data in seen["raw"]])
for name in ("info", "both", "partial", "callable"):
    print(name, *seen[name], sep="\n  ")

try:
    publisher.publish(Header())
except TypeError as error:
    print(type(error).__name__, "Header" in str(error) or str(error))
print(publisher.topic_name, publisher.msg_type.__name__, publisher.qos_profile.depth)
rclpy.shutdown()
