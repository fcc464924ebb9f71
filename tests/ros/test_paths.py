"""Paths of fields, and values for them."""

import math
from typing import Any

import pytest
from geometry_msgs.msg import Point32, Polygon, PoseStamped, PoseWithCovariance, Twist
from std_msgs.msg import Bool, Float32, Int8, Int32, UInt8, UInt64
from trajectory_msgs.msg import JointTrajectory

from rosslt_auto.ros import paths


@pytest.mark.parametrize(
    ("message_type", "path", "kind"),
    [
        (Int32, "data", "int32"),
        (Twist, "linear.x", "double"),
        (Twist, "linear", "geometry_msgs/Vector3"),
        (PoseStamped, "pose.orientation.w", "double"),
        (PoseStamped, "header.stamp.sec", "int32"),
        (PoseStamped, "header.frame_id", "string"),
        (Polygon, "points[3].x", "float"),
        (PoseWithCovariance, "covariance[35]", "double"),
        (JointTrajectory, "points[0].positions[2]", "double"),
    ],
)
def test_type_of_a_field(message_type: Any, path: str, kind: str) -> None:
    assert paths.field_type(message_type, path) == kind
    assert paths.normal(path) == path


@pytest.mark.parametrize(
    ("message_type", "path", "says"),
    [
        (Int32, "nosuch", "nosuch.*has: data"),
        (Int32, "data.deeper", "deeper"),
        (Int32, "data[0]", "no sequence"),
        (Twist, "linear.w", "has: x, y, z"),
        (Polygon, "points.x", "points"),
    ],
)
def test_field_that_there_is_not(message_type: Any, path: str, says: str) -> None:
    with pytest.raises(paths.FieldError, match=says):
        paths.field_type(message_type, path)


@pytest.mark.parametrize("path", ["", ".", "a.", ".a", "a..b", "[0]", "a[", "a[x]", "a[-1]", "a b"])
def test_text_that_is_no_path(path: str) -> None:
    with pytest.raises(paths.FieldError, match="no field path"):
        paths.normal(path)


def test_value_of_a_field() -> None:
    polygon = Polygon()
    polygon.points.append(Point32(x=2.5))
    assert paths.get(polygon, "points[0].x") == 2.5
    with pytest.raises(paths.FieldError, match="in this message"):
        paths.get(polygon, "points[1].x")


@pytest.mark.parametrize(
    ("message_type", "text", "value"),
    [
        (Int32, "14", 14),
        (Int32, "-0x10", -16),
        (Int32, 14.0, 14),
        (Int8, "-128", -128),
        (UInt64, str(2**64 - 1), 2**64 - 1),
        (Float32, "0.1", 0.10000000149011612),
        (Float32, 3, 3.0),
    ],
)
def test_value_for_a_field(message_type: Any, text: Any, value: Any) -> None:
    kind = paths.field_type(message_type, "data")
    parsed = paths.parse(kind, "data", text)
    assert (type(parsed), parsed) == (type(value), value)


@pytest.mark.parametrize(
    ("message_type", "text", "says"),
    [
        (Int32, "many", "many"),
        (Int32, "1.5", "1.5"),
        (Int32, 1.5, "1.5"),
        (Int32, "nan", "nan"),
        (Int32, math.nan, "nan"),
        (Int32, str(2**31), "does not fit"),
        (Int8, "200", "does not fit"),
        (UInt8, "-1", "does not fit"),
        (Float32, "nan", "finite"),
        (Float32, "-inf", "finite"),
        (Float32, "1e400", "finite"),
        (Float32, "1e39", "too large"),
        (Float32, "fast", "fast"),
        (Bool, "maybe", "boolean"),
    ],
)
def test_value_that_a_field_cannot_hold(message_type: Any, text: Any, says: str) -> None:
    kind = paths.field_type(message_type, "data")
    with pytest.raises(paths.FieldError, match=says):
        paths.parse(kind, "data", text)
    with pytest.raises(paths.FieldError, match="name one number"):
        paths.parse("geometry_msgs/Vector3", "linear", "1")
