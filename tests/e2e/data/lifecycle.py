"""A lifecycle node that is led through its transitions."""

import rclpy
from geometry_msgs.msg import Point
from rclpy.lifecycle import Node, State, TransitionCallbackReturn


class Managed(Node):
    def __init__(self, name, **kwargs):
        super().__init__(name, **kwargs)
        self.level = 0.5
        self.points = None
        self.timer = None

    def on_configure(self, state: State) -> TransitionCallbackReturn:
        self.points = self.create_lifecycle_publisher(Point, "point", 10)
        self.timer = self.create_timer(0.01, self.publish)
        print("configured from", state.label)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: State) -> TransitionCallbackReturn:
        print("activated from", state.label, state.state_id)
        return super().on_activate(state)

    def on_deactivate(self, state: State) -> TransitionCallbackReturn:
        print("deactivated from", state.label)
        return super().on_deactivate(state)

    def on_cleanup(self, state: State) -> TransitionCallbackReturn:
        self.destroy_timer(self.timer)
        self.destroy_publisher(self.points)
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: State) -> TransitionCallbackReturn:
        print("shut down from", state.label)
        return TransitionCallbackReturn.SUCCESS

    def publish(self):
        if self.points is not None and self.points.is_activated:
            self.level += 0.25
        self.points.publish(Point(x=self.level, y=2.0 * self.level))


rclpy.init()
node = Managed("managed")
listener = rclpy.create_node("listener")
received = []
listener.create_subscription(Point, "point", received.append, 10)
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(node)
executor.add_node(listener)
print(node.trigger_configure())
for _ in range(10):
    executor.spin_once(timeout_sec=0.05)
print("inactive:", received)
while not node.points.get_subscription_count():
    executor.spin_once(timeout_sec=0.05)
print(node.trigger_activate())
while len(received) < 3:
    executor.spin_once(timeout_sec=0.05)
print(*received[:3], sep="\n")
print(node.trigger_deactivate(), node.trigger_cleanup(), node.trigger_shutdown())
executor.shutdown()
rclpy.shutdown()
