"""What messages look like."""

import math

import pytest

pytest.importorskip("visualization_msgs")

from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from rosslt_auto.views import shapes
from rosslt_auto.views.geometry import UNTURNED, Frame, about
from rosslt_auto.views.shapes import PICTURES, Unshown, picture_of_marker


@pytest.mark.parametrize("kind", range(13))
def test_every_type_of_marker_is_shown(kind: int) -> None:
    points = [Point(x=1.0), Point(y=1.0), Point(z=1.0), Point(), Point(), Point()]
    marker = Marker(type=kind, points=points if kind in shapes.OF_POINTS else [], text="hello")
    marker.pose.position.x = 2.0
    [shape] = picture_of_marker(marker).shapes
    assert shape.kind == kind
    assert shape.frame.position == (2.0, 0.0, 0.0)
    assert shape.text == "hello"


@pytest.mark.parametrize(
    ("marker", "reason"),
    [
        (Marker(type=13), "unknown marker type 13"),
        (Marker(type=-1), "unknown marker type -1"),
        (Marker(type=Marker.LINE_STRIP, points=[Point()]), "at least 2 points"),
        (Marker(type=Marker.LINE_LIST, points=[Point()] * 3), "multiple of 2"),
        (Marker(type=Marker.TRIANGLE_LIST, points=[Point()] * 4), "multiple of 3"),
        (Marker(type=Marker.ARROW, points=[Point()]), "two points"),
        (Marker(type=Marker.POINTS, points=[Point(x=math.nan)]), "not finite"),
        (Marker(pose=Pose(position=Point(z=math.inf))), "not finite"),
    ],
)
def test_what_rviz_refuses_is_refused(marker: Marker, reason: str) -> None:
    with pytest.raises(Unshown, match=reason):
        picture_of_marker(marker)


def test_a_marker_without_orientation_is_not_turned() -> None:
    marker = Marker()
    marker.pose.orientation.w = 0.0
    assert picture_of_marker(marker).shapes[0].frame.rotation == UNTURNED


def test_orientations_are_normalised() -> None:
    marker = Marker()
    marker.pose.orientation.w = marker.pose.orientation.z = 5.0
    [shape] = picture_of_marker(marker).shapes
    assert shape.frame.rotation == pytest.approx(about(2, math.pi / 2))


def test_colours_need_one_for_each_point() -> None:
    red, two = ColorRGBA(r=1.0, a=1.0), [Point(), Point(x=1.0)]
    marker = Marker(type=Marker.LINE_STRIP, points=two, colors=[red, red])
    assert picture_of_marker(marker).shapes[0].colours == ((1.0, 0.0, 0.0, 1.0),) * 2
    marker.colors = [red]
    assert picture_of_marker(marker).shapes[0].colours == ()


def test_points_of_a_marker_are_spots_in_its_frame() -> None:
    marker = Marker(type=Marker.POINTS, points=[Point(x=1.0)])
    marker.pose.position.y = 2.0
    marker.pose.orientation.z = marker.pose.orientation.w = math.sqrt(0.5)
    pose, point = picture_of_marker(marker, "markers[3]").spots
    assert (pose.path, pose.turn) == ("markers[3].pose.position", "markers[3].pose.orientation")
    assert (point.path, point.turn, point.is_point) == ("markers[3].points[0]", None, True)
    assert point.position == (1.0, 0.0, 0.0)
    assert point.frame.out(point.position) == pytest.approx((0.0, 3.0, 0.0))
    assert point.frame.into((0.0, 3.0, 0.0)) == pytest.approx((1.0, 0.0, 0.0))


def test_poses_and_points_have_the_paths_that_one_would_type() -> None:
    def paths(type_name: str, message: object) -> list[str]:
        return [spot.path for spot in PICTURES[type_name](message, "").spots]

    assert paths("geometry_msgs/msg/Pose", Pose()) == ["position"]
    assert paths("geometry_msgs/msg/Point", Point()) == [""]
    assert paths("geometry_msgs/msg/PoseStamped", PoseStamped()) == ["pose.position"]
    assert paths("nav_msgs/msg/Odometry", Odometry()) == ["pose.pose.position"]
    assert paths("geometry_msgs/msg/PoseArray", PoseArray(poses=[Pose()] * 2)) == [
        "poses[0].position",
        "poses[1].position",
    ]
    assert paths("nav_msgs/msg/Path", Path(poses=[PoseStamped()] * 2)) == [
        "poses[0].pose.position",
        "poses[1].pose.position",
    ]


def test_a_path_is_a_line() -> None:
    poses = [PoseStamped(pose=Pose(position=Point(x=float(i)))) for i in range(3)]
    [shape] = PICTURES["nav_msgs/msg/Path"](Path(poses=poses), "").shapes
    assert shape.kind == shapes.LINE_STRIP
    assert shape.points == ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0))
    assert PICTURES["nav_msgs/msg/Path"](Path(), "").shapes == ()


def test_frames_are_inverse() -> None:
    frame = Frame((1.0, -2.0, 3.0), about(0, 0.7))
    assert frame.into(frame.out((0.3, 0.4, 0.5))) == pytest.approx((0.3, 0.4, 0.5))
