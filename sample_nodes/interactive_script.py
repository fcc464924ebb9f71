"""Runs a mission script and publishes its waypoints, one after another, on target_pose."""

import importlib.util
import math
import os
import sys
import traceback

import rclpy
from geometry_msgs.msg import Pose
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

MISSION = os.path.join(os.path.dirname(os.path.abspath(__file__)), "mission.py")
sys.dont_write_bytecode = True  # it would not notice an edit within the same second


class InteractiveScript(Node):
    def __init__(self):
        super().__init__("interactive_script")
        self.path = self.declare_parameter("mission", MISSION).value
        self.stay = Duration(seconds=self.declare_parameter("stay", 6.0).value)
        self.loaded = None
        self.mission = None
        self.waypoints = []
        self.current = 0
        self.since = self.get_clock().now()
        self.publisher = self.create_publisher(Pose, "target_pose", 10)
        self.create_timer(0.05, self.on_timer)

    def on_timer(self):
        try:
            self.load()
            self.run()
        except Exception:
            self.report(traceback.format_exc())
        if not self.waypoints:
            return
        if self.get_clock().now() - self.since >= self.stay:
            self.since = self.get_clock().now()
            self.current += 1
        self.current %= len(self.waypoints)
        self.publisher.publish(self.waypoints[self.current])

    def load(self):
        """Loads the script if it is not the one that was loaded last."""
        changed = os.stat(self.path).st_mtime_ns
        if changed == self.loaded:
            return
        self.loaded = changed
        self.mission = None
        spec = importlib.util.spec_from_file_location("mission", self.path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        self.mission = module.mission

    def run(self):
        """Collects the waypoints. What a broken script has not replaced goes on."""
        if self.mission is None:
            return
        waypoints = []

        def goto(x, y, z, yaw=None):
            pose = Pose()
            pose.position.x = x
            pose.position.y = y
            pose.position.z = z
            if yaw is not None:
                pose.orientation.z = math.sin(yaw / 2)
                pose.orientation.w = math.cos(yaw / 2)
            waypoints.append(pose)

        try:
            self.mission(goto)
        except Exception:
            self.mission = None
            raise
        self.waypoints = waypoints

    def report(self, problem):
        self.get_logger().error(f"the mission cannot be used\n{problem}")


def main(args=None):
    rclpy.init(args=args)
    node = InteractiveScript()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
