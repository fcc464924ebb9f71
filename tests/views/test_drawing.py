"""How shapes are drawn, as viser is told."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser")

import trimesh
import viser
from geometry_msgs.msg import Point, Pose, PoseArray, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from rosslt_auto.views.drawing import Drawing
from rosslt_auto.views.scene import Scene
from rosslt_auto.views.shapes import MARKER

RED, GREEN = ColorRGBA(r=1.0, a=1.0), ColorRGBA(g=1.0, a=0.5)
SCALE = Vector3(x=0.5, y=1.0, z=2.0)
SIX = [Point(x=1.0), Point(y=1.0), Point(z=1.0), Point(), Point(x=2.0), Point(y=2.0)]


@dataclass
class Message:
    message: Any
    fields: dict[str, Any] = field(default_factory=dict)


class Drawn:
    """A scene that is drawn; nobody looks at it."""

    def __init__(self, server: viser.ViserServer) -> None:
        self.scene = Scene()
        self.drawing = Drawing(server, lambda key: None)
        self._server = server

    def show(self, marker: Marker) -> Any:
        """What stands for a marker in viser's scene tree."""
        self.scene.receive("/t", MARKER, Message(marker))
        return self.update()

    def update(self) -> Any:
        self.drawing.update(self.scene.items())
        shown = [handles for _, _, handles in self.drawing._drawn.values()]
        return shown[0][0] if shown else None

    @property
    def problems(self) -> list[str]:
        return list(self.drawing.problems.values())


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", verbose=False)
    yield server
    server.stop()


@pytest.fixture
def drawn(server: viser.ViserServer) -> Drawn:
    server.scene.reset()
    return Drawn(server)


def extents(vertices: Any) -> list[float]:
    return list(np.ptp(np.asarray(vertices), axis=0))


def is_mesh(*size: float) -> Callable[[Any], None]:
    def check(node: Any) -> None:
        assert extents(node.vertices) == pytest.approx(size, rel=0.02)
        assert tuple(node.color) == (255, 0, 0)
        assert node.opacity is None

    return check


def is_many(*size: float) -> Callable[[Any], None]:
    def check(node: Any) -> None:
        assert extents(node.vertices) == pytest.approx(size, rel=0.02)
        assert np.asarray(node.batched_positions).tolist() == [[p.x, p.y, p.z] for p in SIX]

    return check


def is_segments(*ends: tuple[int, int]) -> Callable[[Any], None]:
    def check(node: Any) -> None:
        points = [[SIX[a], SIX[b]] for a, b in ends]
        assert np.asarray(node.points).tolist() == [
            [[p.x, p.y, p.z] for p in two] for two in points
        ]

    return check


def is_cloud(node: Any) -> None:
    assert np.asarray(node.points).tolist() == [[p.x, p.y, p.z] for p in SIX]
    assert node.point_size == 0.5


def is_text(node: Any) -> None:
    assert (node.text, node.font_scene_height) == ("hello", 2.0)


def is_glb(node: Any) -> None:
    mesh = trimesh.load(trimesh.util.wrap_as_stream(node.glb_data), file_type="glb", force="mesh")
    assert len(mesh.faces) == 2
    assert mesh.vertices.max(axis=0) == pytest.approx((1.0, 2.0, 2.0))  # scaled as in RViz


TYPES: dict[int, Callable[[Any], None]] = {
    Marker.ARROW: is_mesh(0.5, 2.0, 2.0),  # length, and twice the width across its head
    Marker.CUBE: is_mesh(0.5, 1.0, 2.0),
    Marker.SPHERE: is_mesh(0.5, 1.0, 2.0),
    Marker.CYLINDER: is_mesh(0.5, 1.0, 2.0),
    Marker.LINE_STRIP: is_segments((0, 1), (1, 2), (2, 3), (3, 4), (4, 5)),
    Marker.LINE_LIST: is_segments((0, 1), (2, 3), (4, 5)),
    Marker.CUBE_LIST: is_many(0.5, 1.0, 2.0),
    Marker.SPHERE_LIST: is_many(0.5, 1.0, 2.0),
    Marker.POINTS: is_cloud,
    Marker.TEXT_VIEW_FACING: is_text,
    Marker.MESH_RESOURCE: is_mesh(0.5, 2.0, 6.0),  # a box of 1 by 2 by 3
    Marker.TRIANGLE_LIST: is_glb,
}


@pytest.mark.parametrize("kind", TYPES)
def test_every_type_of_marker_is_drawn(kind: int, drawn: Drawn, tmp_path: Path) -> None:
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / "box.stl")
    marker = Marker(
        ns="a", type=kind, scale=SCALE, color=RED, text="hello",
        points=SIX if 4 <= kind <= 8 or kind == Marker.TRIANGLE_LIST else [],
        mesh_resource=(tmp_path / "box.stl").as_uri(),
    )  # fmt: skip
    marker.pose.position.x = 3.0
    node = drawn.show(marker)
    assert drawn.problems == []
    assert tuple(node.position) == (3.0, 0.0, 0.0)
    TYPES[kind](node)


def test_all_types_of_rviz_are_tested() -> None:
    assert list(TYPES) == list(range(12))


def test_an_arrow_between_two_points(drawn: Drawn) -> None:
    ends = [Point(x=1.0), Point(x=1.0, y=3.0)]
    scale = Vector3(x=0.1, y=0.4)
    node = drawn.show(Marker(type=Marker.ARROW, points=ends, scale=scale, color=RED))
    assert extents(node.vertices) == pytest.approx((0.4, 3.0, 0.4), rel=0.02)


def test_what_shines_through(drawn: Drawn) -> None:
    assert drawn.show(Marker(type=Marker.CUBE, scale=SCALE, color=GREEN)).opacity == 0.5


def test_a_mesh_with_colours_of_its_own(drawn: Drawn, tmp_path: Path) -> None:
    box = trimesh.creation.box()
    box.visual.vertex_colors = (0, 0, 255, 255)
    box.export(tmp_path / "box.ply")
    marker = Marker(type=Marker.MESH_RESOURCE, mesh_resource=(tmp_path / "box.ply").as_uri())
    marker.scale.x = marker.scale.y = marker.scale.z = 2.0
    marker.mesh_use_embedded_materials = True
    data = drawn.show(marker).glb_data
    mesh = trimesh.load(trimesh.util.wrap_as_stream(data), file_type="glb", force="mesh")
    assert mesh.extents == pytest.approx((2.0, 2.0, 2.0))
    assert mesh.visual.vertex_colors[0].tolist() == [0, 0, 255, 255]


def test_a_mesh_in_the_message(drawn: Drawn) -> None:
    marker = Marker(type=Marker.MESH_RESOURCE, scale=SCALE, color=RED)
    marker.mesh_resource, marker.mesh_file.filename = "embedded://box", "box.stl"
    marker.mesh_file.data = trimesh.creation.box((1.0, 2.0, 3.0)).export(file_type="stl")
    is_mesh(0.5, 2.0, 6.0)(drawn.show(marker))


def test_a_mesh_that_is_not_there_is_a_box_until_it_is(drawn: Drawn, tmp_path: Path) -> None:
    there = tmp_path / "there.stl"
    trimesh.creation.box((3.0, 3.0, 3.0)).export(there)
    marker = Marker(type=Marker.MESH_RESOURCE, scale=SCALE, color=RED)
    marker.mesh_resource = "package://robot/arm.dae"
    for _ in range(3):  # it is said once, however often it is published
        box = drawn.show(marker)
        is_mesh(0.5, 1.0, 2.0)(box)
        assert drawn.problems == ["no package robot with arm.dae has been sourced"]
    marker.mesh_resource = there.as_uri()
    is_mesh(1.5, 3.0, 6.0)(drawn.show(marker))
    assert drawn.problems == []
    marker.mesh_resource = "http://127.0.0.1:9/arm.dae"
    drawn.show(marker)
    assert "neither file:// nor package://" in drawn.problems[0]
    drawn.show(Marker(action=Marker.DELETE))
    assert drawn.problems == []


def test_what_only_moves_is_not_drawn_anew(drawn: Drawn) -> None:
    marker = Marker(type=Marker.SPHERE, scale=SCALE, color=RED)
    before = drawn.show(marker)
    marker.pose.position.y = 2.0
    assert drawn.show(marker) is before
    assert tuple(before.position) == (0.0, 2.0, 0.0)
    marker.color = GREEN
    assert drawn.show(marker) is not before


def test_what_is_gone_is_taken_away(drawn: Drawn) -> None:
    drawn.show(Marker(type=Marker.CUBE, scale=SCALE))
    assert drawn.show(Marker(action=Marker.DELETE)) is None


def test_poses_are_axes(drawn: Drawn) -> None:
    poses = [Pose(position=Point(x=float(i))) for i in range(3)]
    drawn.scene.receive("/p", "geometry_msgs/msg/PoseArray", Message(PoseArray(poses=poses)))
    drawn.update()
    [(_, _, nodes)] = drawn.drawing._drawn.values()
    assert [tuple(node.position) for node in nodes] == [(float(i), 0.0, 0.0) for i in range(3)]
    assert {type(node) for node in nodes} == {viser.FrameHandle}
