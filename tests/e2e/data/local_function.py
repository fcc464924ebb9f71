"""A timer callback that is a local function with variables of the function around it."""

import rclpy
from std_msgs.msg import Float32, String


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("local_function")
    strings = node.create_publisher(String, "strings", 10)
    floats = node.create_publisher(Float32, "floats", 10)
    done = rclpy.Future()
    i = 0
    height = 1.5

    def on_timer():
        nonlocal i, height
        i += 1
        height *= 1.1
        strings.publish(String(data="Hello World: %d" % i))
        node.get_logger().info(f"Publishing: {i} {height:.3f}")
        floats.publish(Float32(data=height))
        if i == 6:
            done.set_result((i, height))

    timer = node.create_timer(0.02, on_timer)
    rclpy.spin_until_future_complete(node, done)
    print(done.result(), timer.timer_period_ns)
    node.destroy_timer(timer)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
