"""Plans a curve from where the quadcopter is to target_pose and sends it along the curve."""

import rclpy
from geometry_msgs.msg import Point, Pose
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from visualization_msgs.msg import Marker

BULGE = 1.0


class Bezier:
    """A quadratic curve from b0 to b2; t goes from 0 to 1."""

    def __init__(self, b0, b2):
        self.b0 = b0
        self.b1 = Point(x=(b2.x + b0.x) / 2, y=(b2.y + b0.y) / 2, z=BULGE + (b2.z + b0.z) / 2)
        self.b2 = b2

    def at(self, t):
        if t <= 0:
            return self.b0
        if t >= 1:
            return self.b2
        b0, b1, b2 = self.b0, self.b1, self.b2
        return Point(
            x=t * t * b2.x + 2 * t * (1 - t) * b1.x + (1 - t) * (1 - t) * b0.x,
            y=t * t * b2.y + 2 * t * (1 - t) * b1.y + (1 - t) * (1 - t) * b0.y,
            z=t * t * b2.z + 2 * t * (1 - t) * b1.z + (1 - t) * (1 - t) * b0.z,
        )


class Trajectory(Node):
    def __init__(self):
        super().__init__("slt_trajectory")
        self.flight_time = Duration(seconds=4.0)
        self.started = None
        self.quad = None
        self.start = None
        self.target = None
        self.control = self.create_publisher(Pose, "control_target", 10)
        self.marker = self.create_publisher(Marker, "trajectory_marker", 10)
        self.create_subscription(Pose, "quad_pose", self.on_quad, 10)
        self.create_subscription(Pose, "target_pose", self.on_target, 10)
        self.create_timer(0.02, self.send)
        self.create_timer(0.2, self.show)

    def on_quad(self, pose):
        self.quad = pose

    def on_target(self, target):
        if self.quad is None or target == self.target:
            return
        if self.target is None or self.progress() >= 1:
            self.start = self.quad.position
            self.started = self.get_clock().now()
        self.target = target  # on the way this bends the curve
        self.show()

    def progress(self):
        return (self.get_clock().now() - self.started).nanoseconds / self.flight_time.nanoseconds

    def curve(self):
        return Bezier(self.start, self.target.position)

    def send(self):
        if self.target is None:
            return
        pose = Pose(position=self.curve().at(self.progress()), orientation=self.target.orientation)
        self.control.publish(pose)

    def show(self):
        if self.target is None:
            return
        curve = self.curve()

        line = self.new_marker(0, Marker.LINE_STRIP)
        line.scale.x = 0.04
        line.points = [curve.at(i / 20) for i in range(21)]
        self.marker.publish(line)

        for number, point in ((1, curve.b1), (2, curve.b2)):
            ball = self.new_marker(number, Marker.SPHERE)
            ball.pose.position = point
            ball.scale.x = ball.scale.y = ball.scale.z = 0.2
            self.marker.publish(ball)

    def new_marker(self, number, kind):
        marker = Marker(ns="trajectory", id=number, type=kind, action=Marker.ADD)
        marker.header.frame_id = "map"
        marker.color.r = 1.0
        marker.color.g = 0.3 * number
        marker.color.a = 1.0
        return marker


def main(args=None):
    rclpy.init(args=args)
    node = Trajectory()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
