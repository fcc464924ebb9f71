"""Publishes where it stands on beacon, in a loop of its own: it never spins."""

import time

import rclpy
from geometry_msgs.msg import PointStamped


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("beacon")
    publisher = node.create_publisher(PointStamped, "beacon", 10)

    height = 1.5
    try:
        while rclpy.ok():
            msg = PointStamped()
            msg.header.frame_id = "map"
            msg.point.x = 3.0
            msg.point.y = -2.0
            msg.point.z = height + 0.25
            publisher.publish(msg)
            time.sleep(0.1)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
