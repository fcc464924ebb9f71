"""A guard condition that is triggered by hand."""

import rclpy

rclpy.init()
node = rclpy.create_node("guarded")
triggered = []


async def on_trigger():
    triggered.append(len(triggered) * 0.5)


guard = node.create_guard_condition(on_trigger)
for _ in range(3):
    guard.trigger()
    rclpy.spin_once(node, timeout_sec=1.0)
print(triggered)
rclpy.spin_once(node, timeout_sec=0.01)
print(len(triggered), node.destroy_guard_condition(guard))
rclpy.shutdown()
