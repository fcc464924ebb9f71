"""What messages look like: each is made into shapes, plain data that a view can draw.

Shapes and spots stand in the frame that the message names; `Picture.placed` puts them elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from .geometry import UNTURNED, Frame, Quaternion, Vector, is_finite, unit

ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST = range(6)
CUBE_LIST, SPHERE_LIST, POINTS, TEXT, MESH, TRIANGLE_LIST = range(6, 12)
ARROW_STRIP = 12
AXES = 100
"""Types of shapes: those of visualization_msgs/msg/Marker, and a pose that is no marker."""

OF_POINTS = frozenset(
    {LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TRIANGLE_LIST, ARROW_STRIP}
)
"""Types that are made of points."""

Colour = tuple[float, float, float, float]

_GREY: Colour = (0.75, 0.75, 0.75, 1.0)
_MIN_POINTS = {LINE_STRIP: 2, LINE_LIST: 2, TRIANGLE_LIST: 3, ARROW_STRIP: 2}
_GROUPS = {LINE_LIST: 2, TRIANGLE_LIST: 3}


@dataclass(frozen=True)
class Shape:
    """Something to draw.

    kind     one of the types above
    frame    where it stands
    scale    as in Marker
    points   in `frame`; colours: none, or one for each point
    text     of a text
    resource, data      the mesh's address, and what the message carries, see `meshes.load`
    embedded_materials  whether the mesh has colours of its own
    """

    kind: int
    frame: Frame
    scale: Vector = (1.0, 1.0, 1.0)
    colour: Colour = _GREY
    points: tuple[Vector, ...] = ()
    colours: tuple[Colour, ...] = ()
    text: str = ""
    resource: str = ""
    data: tuple[str, bytes] = ("", b"")
    embedded_materials: bool = False


class Unshown(ValueError):
    """A message that cannot be drawn; says why."""


@dataclass(frozen=True)
class Spot:
    """A place in a message that could be dragged.

    path      of the position, "" for the message itself: its fields are ``x``, ``y`` and ``z``
    turn      path of the orientation, None if there is none
    frame     the frame that the fields are in
    position, rotation   what the fields say
    is_point  one of many points, not where the whole thing stands
    """

    path: str
    turn: str | None
    frame: Frame
    position: Vector
    rotation: Quaternion
    is_point: bool = False


@dataclass(frozen=True)
class Picture:
    """What a message shows: shapes, and the places that its fields determine."""

    shapes: tuple[Shape, ...] = ()
    spots: tuple[Spot, ...] = field(default=())

    def placed(self, place: Frame) -> Picture:
        """The same in the frame around `place`."""
        if place == Frame():
            return self
        return Picture(
            tuple(replace(shape, frame=place.around(shape.frame)) for shape in self.shapes),
            tuple(replace(spot, frame=place.around(spot.frame)) for spot in self.spots),
        )


def joined(path: str, name: str) -> str:
    """The path of a field of what stands at `path`."""
    return f"{path}.{name}" if path else name


# ---------------------------------------------------------------- markers


def picture_of_marker(marker: Any, root: str = "") -> Picture:
    """What a marker that is added shows. Raises Unshown.

    root  path of the marker in its message
    """
    kind = int(marker.type)
    if kind not in range(13):
        raise Unshown(f"unknown marker type {kind}")
    pose = marker.pose
    frame = Frame(_vector(pose.position), _rotation(pose.orientation))
    points = tuple(map(_vector, marker.points))
    _check(kind, frame, points)
    colours = tuple(map(_colour, marker.colors))
    shape = Shape(
        kind,
        frame,
        _vector(marker.scale),
        _colour(marker.color),
        points,
        colours if len(colours) == len(points) else (),
        str(marker.text),
        str(marker.mesh_resource),
        (str(marker.mesh_file.filename), bytes(marker.mesh_file.data)),
        bool(marker.mesh_use_embedded_materials),
    )
    pose_path = joined(root, "pose")
    spots = [_pose_spot(pose, pose_path)]
    if kind in OF_POINTS or (kind == ARROW and points):
        points_path = joined(root, "points")
        spots += [
            Spot(f"{points_path}[{i}]", None, frame, point, UNTURNED, is_point=True)
            for i, point in enumerate(points)
        ]
    return Picture((shape,), tuple(spots))


def _check(kind: int, frame: Frame, points: tuple[Vector, ...]) -> None:
    """What RViz refuses to draw."""
    if not is_finite(*frame.position) or any(not is_finite(*point) for point in points):
        raise Unshown("a position is not finite")
    if len(points) < _MIN_POINTS.get(kind, 0):
        raise Unshown(f"needs at least {_MIN_POINTS[kind]} points")
    if len(points) % _GROUPS.get(kind, 1):
        raise Unshown(f"the number of points is no multiple of {_GROUPS[kind]}")
    if kind == ARROW and len(points) not in (0, 2):
        raise Unshown(f"an arrow has no or two points, not {len(points)}")


# ---------------------------------------------------------------- other messages


def _picture_of_pose(pose: Any, root: str) -> Picture:
    spot = _pose_spot(pose, root)
    return Picture((Shape(AXES, Frame(spot.position, spot.rotation)),), (spot,))


def _picture_of_point(point: Any, root: str) -> Picture:
    position = _finite(_vector(point))
    size = (0.12, 0.12, 0.12)
    return Picture(
        (Shape(SPHERE, Frame(position), size, (0.9, 0.7, 0.2, 1.0)),),
        (Spot(root, None, Frame(), position, UNTURNED),),
    )


def _picture_of_poses(poses: Any, root: str) -> Picture:
    pictures = [_picture_of_pose(pose, f"{root}[{i}]") for i, pose in enumerate(poses)]
    return Picture(
        tuple(shape for one in pictures for shape in one.shapes),
        tuple(spot for one in pictures for spot in one.spots),
    )


def _picture_of_path(path: Any, root: str) -> Picture:
    """A line through the positions, which can be dragged like points of a marker."""
    positions = tuple(_finite(_vector(stamped.pose.position)) for stamped in path.poses)
    spots = tuple(
        Spot(
            f"{joined(root, f'poses[{i}].pose')}.position", None, Frame(), position, UNTURNED,
            is_point=True,
        )
        for i, position in enumerate(positions)
    )  # fmt: skip
    shapes = (
        (Shape(LINE_STRIP, Frame(), (0.03, 0, 0), (0.2, 0.8, 0.2, 1.0), positions),)
        if len(positions) > 1
        else ()
    )
    return Picture(shapes, spots)


def _within(name: str, inner: Callable[[Any, str], Picture]) -> Callable[[Any, str], Picture]:
    def picture(message: Any, root: str) -> Picture:
        return inner(getattr(message, name), joined(root, name))

    return picture


PICTURES: dict[str, Callable[[Any, str], Picture]] = {
    "geometry_msgs/msg/Point": _picture_of_point,
    "geometry_msgs/msg/PointStamped": _within("point", _picture_of_point),
    "geometry_msgs/msg/Pose": _picture_of_pose,
    "geometry_msgs/msg/PoseStamped": _within("pose", _picture_of_pose),
    "geometry_msgs/msg/PoseWithCovariance": _within("pose", _picture_of_pose),
    "geometry_msgs/msg/PoseWithCovarianceStamped": _within(
        "pose", _within("pose", _picture_of_pose)
    ),
    "geometry_msgs/msg/PoseArray": _within("poses", _picture_of_poses),
    "nav_msgs/msg/Odometry": _within("pose", _within("pose", _picture_of_pose)),
    "nav_msgs/msg/Path": _picture_of_path,
}
"""How messages of a type are shown, by its name; raises Unshown."""

MARKER = "visualization_msgs/msg/Marker"
MARKER_ARRAY = "visualization_msgs/msg/MarkerArray"


def types() -> Iterator[str]:
    """The names of all message types that can be shown."""
    yield from PICTURES
    yield from (MARKER, MARKER_ARRAY)


def _pose_spot(pose: Any, path: str) -> Spot:
    return Spot(
        joined(path, "position"),
        joined(path, "orientation"),
        Frame(),
        _finite(_vector(pose.position)),
        _rotation(pose.orientation),
    )


def _finite(vector: Vector) -> Vector:
    if not is_finite(*vector):
        raise Unshown("a position is not finite")
    return vector


def _vector(message: Any) -> Vector:
    return (float(message.x), float(message.y), float(message.z))


def _rotation(message: Any) -> Quaternion:
    return unit((float(message.w), float(message.x), float(message.y), float(message.z)))


def _colour(message: Any) -> Colour:
    return (float(message.r), float(message.g), float(message.b), float(message.a))
