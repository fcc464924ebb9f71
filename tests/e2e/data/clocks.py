"""Times and durations, simulated time, one-shot timers, a context of its own."""

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMessage

context = Context()
rclpy.init(args=["--ros-args", "-p", "use_sim_time:=true"], context=context)
node = rclpy.create_node("clocks", context=context)
executor = SingleThreadedExecutor(context=context)
executor.add_node(node)
ticks = []
timer = node.create_timer(0.5, lambda: ticks.append(node.get_clock().now().nanoseconds))
publisher = node.create_publisher(ClockMessage, "/clock", 10)
while not publisher.get_subscription_count():
    executor.spin_once(timeout_sec=0.05)
now = Time(seconds=100.0, clock_type=ClockType.ROS_TIME)
while len(ticks) < 3:
    now += Duration(seconds=0.5)
    publisher.publish(ClockMessage(clock=now.to_msg()))
    for _ in range(4):
        executor.spin_once(timeout_sec=0.05)
print([tick % 500000000 for tick in ticks[:3]], all(a < b for a, b in zip(ticks, ticks[1:])))
timer.cancel()
print(timer.is_canceled(), timer.timer_period_ns, node.get_parameter("use_sim_time").value)
print(Time(seconds=1.5) + Duration(nanoseconds=5), Time(seconds=2.5) - Duration(seconds=1))
print(Time(seconds=1, nanoseconds=1.5e8).seconds_nanoseconds(), Duration(seconds=0.1).nanoseconds)
print(Clock(clock_type=ClockType.STEADY_TIME).now() > Time(clock_type=ClockType.STEADY_TIME))
print(node.set_parameters([Parameter("use_sim_time", value=False)])[0].successful)
executor.shutdown()
rclpy.shutdown(context=context)
