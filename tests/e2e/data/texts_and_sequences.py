"""Texts, sequences of numbers and fixed-size arrays, assigned in the ways that nodes do it."""

import math
from array import array

import numpy as np
import rclpy
from geometry_msgs.msg import PoseWithCovariance
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String

LABEL = "battery"


class Arm(Node):
    def __init__(self):
        super().__init__("arm")
        self.n = 3
        self.angle = 0.5
        self.names = ["shoulder", "elbow"]
        self.variance = 0.25
        self.ready = True
        self.texts = self.create_publisher(String, "chatter", 10)
        self.joints = self.create_publisher(JointState, "joints", 10)
        self.poses = self.create_publisher(PoseWithCovariance, "pose", 10)
        self.flags = self.create_publisher(Bool, "ready", 10)
        self.create_subscription(String, "chatter", self.heard, 10)
        self.count = 0
        self.create_timer(0.1, self.tick)

    def tick(self):
        message = String()
        message.data = f"{LABEL} {self.n:d} of 10"
        self.texts.publish(message)

        flag = Bool()
        flag.data = self.ready
        self.flags.publish(flag)

        joints = JointState(name=self.names, velocity=(x * self.angle for x in (1, 2)))
        joints.header.frame_id = "base" + "_link"
        joints.position = [self.angle, math.sin(self.angle)]
        joints.position.append(self.angle * 2)
        joints.effort.extend([1.5, 2.5])
        self.joints.publish(joints)

        pose = PoseWithCovariance()
        pose.covariance[0] = self.variance
        pose.covariance[7] = self.variance * 2
        self.poses.publish(pose)

        wrong = (
            lambda: setattr(joints, "position", 3),
            lambda: setattr(joints, "position", ["x"]),
            lambda: setattr(message, "data", None) or self.texts.publish(message),
            lambda: JointState(position=["x"]),
        )
        if self.count == 0:
            print(
                joints,
                joints.position,
                type(joints.position),
                joints.position == array("d", joints.position),
            )
            print(
                pose.covariance.tolist()[:8],
                type(pose.covariance),
                pose.covariance.dtype,
                np.sum(pose.covariance),
            )
            for do in wrong[:2] + wrong[3:]:
                try:
                    do()
                except Exception as error:
                    print(type(error).__name__, str(error)[:60])

    def heard(self, message):
        self.count += 1
        print(message.data, message.data.split(), repr(message), message.data == "battery 3 of 10")
        if self.count == LIMIT:
            raise SystemExit


LIMIT = 3


def main():
    import sys

    global LIMIT
    if "--forever" in sys.argv:
        LIMIT = 0
    rclpy.init()
    node = Arm()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, SystemExit):
        pass
    print("done")


if __name__ == "__main__":
    main()
