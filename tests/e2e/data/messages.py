"""All kinds of fields: nested, arrays, strings, bytes, times; built in many ways."""

import array
import copy
import math

import numpy as np
import rclpy
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, PoseWithCovarianceStamped, Transform, Vector3
from rclpy.time import Time as Clock
from sensor_msgs.msg import Image, JointState, LaserScan, PointCloud2, PointField
from std_msgs.msg import Bool, ColorRGBA, Float32MultiArray, MultiArrayDimension
from visualization_msgs.msg import Marker

rclpy.init()
node = rclpy.create_node("messages")
received = []


def exchange(message):
    topic = f"topic_{len(received)}"
    count = len(received)
    subscription = node.create_subscription(type(message), topic, received.append, 10)
    publisher = node.create_publisher(type(message), topic, 10)
    while not publisher.get_subscription_count():
        rclpy.spin_once(node, timeout_sec=0.05)
    publisher.publish(message)
    while len(received) == count:
        rclpy.spin_once(node, timeout_sec=0.05)
    print(received[-1], received[-1] == message)
    node.destroy_publisher(publisher)
    node.destroy_subscription(subscription)


angle = 0.5
exchange(JointState(name=["a", "b"], position=[math.sin(angle), 2 * angle], effort=[1.0]))
scan = LaserScan(angle_min=-math.pi / 2, range_max=10.0)
scan.ranges = [1.5 + 0.25 * i for i in range(4)]
scan.intensities = array.array("f", [0.5, 1.5])
scan.header.stamp = Time(sec=3, nanosec=500)
exchange(scan)
pose = PoseWithCovarianceStamped()
pose.pose.covariance[0] = 0.25
pose.pose.covariance[35] = angle
pose.pose.pose.position = Point(x=1.0, y=angle * 2, z=-0.0)
pose.header.stamp = Clock(seconds=1.5).to_msg()
exchange(pose)
marker = Marker(type=Marker.LINE_STRIP, id=3, scale=Vector3(x=0.1), lifetime=Duration(sec=1))
marker.points = [Point(x=float(i), y=i * 0.5) for i in range(3)]
marker.points.append(Point(z=1e-300))
marker.color = ColorRGBA(r=1.0, a=0.5)
marker.colors = [marker.color] * 2
exchange(marker)
image = Image(height=2, width=3, encoding="mono8", step=3, data=bytes(range(6)))
exchange(image)
image.data = np.arange(6, dtype=np.uint8).tobytes()
exchange(image)
cloud = PointCloud2(fields=[PointField(name="x", offset=0, datatype=7, count=1)], point_step=4)
cloud.data = np.array([0.5, 1.5], dtype=np.float32).tobytes()
exchange(cloud)
exchange(Float32MultiArray(data=np.linspace(0, 1, 3, dtype=np.float32).tolist()))
multi = Float32MultiArray(data=[0.1] * 3)
multi.layout.dim.append(MultiArrayDimension(label="x", size=3, stride=1))
exchange(multi)
exchange(Bool(data=1 < 2))
transform = Transform()
transform.rotation.w = math.cos(angle / 2)
copied = copy.deepcopy(transform)
copied.translation.x = transform.rotation.w + 1
exchange(copied)
print(transform != copied, copied.get_fields_and_field_types())

for make in (
    lambda: Point(x="one"),
    lambda: Point(nosuch=1.0),
    lambda: exec("transform.rotation.q = 1.0"),
    lambda: setattr(marker, "id", 2**40),
    lambda: setattr(marker, "id", 1.5),
):
    try:
        print(make())
    except Exception as error:
        print(type(error).__name__, error)
rclpy.shutdown()
