"""Parameters with descriptors, ranges and callbacks, and an on-set callback that refuses."""

import rclpy
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterNotDeclaredException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Float64


class Tuned(Node):
    def __init__(self):
        super().__init__("tuned", parameter_overrides=[Parameter("overridden", value=7)])
        self.asked = []
        speed = FloatingPointRange(from_value=0.0, to_value=2.0, step=0.5)
        self.declare_parameter(
            "speed", 1.5, ParameterDescriptor(description="m/s", floating_point_range=[speed])
        )
        even = IntegerRange(to_value=8, step=2)
        self.declare_parameters(
            "robot",
            [
                ("wheels", 4, ParameterDescriptor(integer_range=[even])),
                ("name", "r2"),
                ("gains", [0.5, 1.0, 2.0]),
                ("fixed", 3, ParameterDescriptor(read_only=True)),
                ("free", None, ParameterDescriptor(dynamic_typing=True)),
            ],
        )
        self.declare_parameter("overridden", 1)
        self.add_on_set_parameters_callback(self.on_set)
        self.add_post_set_parameters_callback(self.after_set)
        self.publisher = self.create_publisher(Float64, "speed", 10)

    def on_set(self, parameters):
        self.asked.append([(p.name, p.type_.name, p.value) for p in parameters])
        for p in parameters:
            if p.name == "speed" and p.value == 1.0:
                return SetParametersResult(successful=False, reason="not that one")
        return SetParametersResult(successful=True)

    def after_set(self, parameters):
        print("now", [(p.name, p.value) for p in parameters])

    def show(self):
        speed = self.get_parameter("speed").value
        self.publisher.publish(Float64(data=speed * 3.6))
        print(speed, self.get_parameter("robot.wheels").get_parameter_value().integer_value)
        print({k: v.value for k, v in sorted(self.get_parameters_by_prefix("robot").items())})


rclpy.init()
node = Tuned()
node.show()
for name, value in [
    ("speed", 0.5),
    ("speed", 1.0),
    ("speed", 3.0),
    ("speed", 1.2),
    ("speed", 1),
    ("speed", "fast"),
    ("robot.wheels", 6),
    ("robot.wheels", 3),
    ("robot.fixed", 4),
    ("robot.free", 1.25),
    ("robot.free", "x"),
    ("robot.gains", [3.0]),
]:
    try:
        [result] = node.set_parameters([Parameter(name, value=value)])
        print(name, value, result.successful, result.reason)
    except Exception as error:
        print(name, value, type(error).__name__, error)
both = [Parameter("speed", value=2.0), Parameter("robot.wheels", value=8)]
print(node.set_parameters_atomically(both))
node.show()
narrow = FloatingPointRange(from_value=0.0, to_value=1.0)
for action in (
    lambda: node.set_parameters([Parameter("nosuch", value=1)]),
    lambda: node.get_parameter("nosuch"),
    lambda: node.declare_parameter("speed", 1.0),
    lambda: node.declare_parameter("untyped", descriptor=ParameterDescriptor(type=3)),
    lambda: node.declare_parameter("out", 2.5, ParameterDescriptor(floating_point_range=[narrow])),
    lambda: node.undeclare_parameter("nosuch"),
):
    try:
        print(action())
    except (
        InvalidParameterTypeException,
        InvalidParameterValueException,
        ParameterAlreadyDeclaredException,
        ParameterNotDeclaredException,
        TypeError,
        ValueError,
    ) as error:
        print(type(error).__name__, error)
print(node.get_parameter_or("nosuch", Parameter("nosuch", value=0.25)).value)
print(node.describe_parameter("speed"), node.get_parameter_type("robot.gains"))
print(node.get_parameter("overridden").value, node.has_parameter("speed"), *node.asked, sep="\n")
node.undeclare_parameter("overridden")
print(node.has_parameter("overridden"))
rclpy.shutdown()
