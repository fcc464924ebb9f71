"""Functions and globals, no class; a rate kept by a second thread that spins."""

import threading

import rclpy
from geometry_msgs.msg import Pose2D
from std_msgs.msg import Int64

g_node = None
g_seen = []


def on_number(msg):
    global g_seen
    g_seen = g_seen + [msg.data]
    g_node.get_logger().info("number: %d, total %s" % (msg.data, sum(g_seen)))


def main():
    global g_node
    rclpy.init()
    g_node = rclpy.create_node("old_school")
    publisher = g_node.create_publisher(Int64, "number", 10)
    poses = g_node.create_publisher(Pose2D, "pose", 10)
    g_node.create_subscription(Int64, "number", on_number, 10)
    spinner = threading.Thread(target=rclpy.spin, args=(g_node,), daemon=True)
    spinner.start()
    rate = g_node.create_rate(50)
    while publisher.get_subscription_count() < 1:
        rate.sleep()
    number = 1
    pose = Pose2D()
    while number < 200:
        publisher.publish(Int64(data=number))
        pose.theta += 0.25
        pose.x = pose.theta * 2
        poses.publish(pose)
        number *= 3
        rate.sleep()
    while len(g_seen) < 5:
        rate.sleep()
    print(g_seen, pose)
    rclpy.shutdown()
    spinner.join()


if __name__ == "__main__":
    main()
