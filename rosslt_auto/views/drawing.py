"""Draws shapes with viser."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import trimesh
import viser

from . import meshes
from .geometry import Frame
from .scene import Item
from .shapes import (
    ARROW,
    ARROW_STRIP,
    AXES,
    CUBE,
    CUBE_LIST,
    CYLINDER,
    LINE_LIST,
    LINE_STRIP,
    MESH,
    POINTS,
    SPHERE,
    SPHERE_LIST,
    TEXT,
    TRIANGLE_LIST,
    Shape,
)

_SMALLEST = 1e-4


def node_name(key: str) -> str:
    """A key as a name in viser's scene tree."""
    return "items/" + re.sub(r"[^\w]", lambda found: f"-{ord(found[0]):x}-", key)


class Drawing:
    """The items of a scene in a viser server.

    clicked  called with the key of an item that somebody clicks
    """

    def __init__(self, server: viser.ViserServer, clicked: Callable[[str], None]) -> None:
        self._server = server
        self._clicked = clicked
        self._drawn: dict[str, tuple[int, tuple[Shape, ...], list[Any]]] = {}
        self.problems: dict[str, str] = {}

    def update(self, items: Iterable[Item]) -> None:
        """Shows these items and no others."""
        seen = set()
        for item in items:
            seen.add(item.key)
            self._show(item)
        for key in self._drawn.keys() - seen:
            for handle in self._drawn.pop(key)[2]:
                handle.remove()
            self.problems.pop(key, None)

    def _show(self, item: Item) -> None:
        before = self._drawn.get(item.key)
        if before is not None and before[0] == item.revision:
            return
        shapes = item.picture.shapes
        handles: list[Any] = []
        old = before[1] if before else ()
        old_handles = before[2] if before else []
        for i, shape in enumerate(shapes):
            if i < len(old) and _same_but_frame(old[i], shape):
                handle = old_handles[i]
                _move(handle, old[i].frame, shape.frame)
            else:
                handle = self._draw(item.key, f"{node_name(item.key)}/{i}", shape)
            handles.append(handle)
        for handle in old_handles[len(shapes) :]:
            handle.remove()
        self._drawn[item.key] = (item.revision, shapes, handles)

    def _draw(self, key: str, name: str, shape: Shape) -> Any:
        try:
            handle = _DRAW[shape.kind](self._server.scene, name, shape)
            self.problems.pop(key, None)
        except Exception as reason:  # a mesh that is not there, for example
            self.problems[key] = str(reason)
            handle = _cube(self._server.scene, name, shape)
        handle.position = shape.frame.position
        handle.wxyz = shape.frame.rotation
        if hasattr(handle, "on_click"):
            handle.on_click(lambda event: self._clicked(key))
        return handle


def _same_but_frame(one: Shape, other: Shape) -> bool:
    return replace(one, frame=Frame()) == replace(other, frame=Frame())


def _move(handle: Any, before: Frame, now: Frame) -> None:
    if before.position != now.position:
        handle.position = now.position
    if before.rotation != now.rotation:
        handle.wxyz = now.rotation


# ---------------------------------------------------------------- one function for each type


def _rgb(colour: Iterable[float]) -> tuple[int, int, int]:
    r, g, b = (round(255 * min(max(part, 0.0), 1.0)) for part in list(colour)[:3])
    return (r, g, b)


def linear(colour: Any) -> Any:
    """Colours of batched meshes: viser hands them on as light, not as sRGB like all others."""
    part = np.asarray(colour, dtype=float) / 255.0
    light = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return np.round(255.0 * light).astype(np.uint8)


def _opacity(shape: Shape) -> float | None:
    alpha = min(max(shape.colour[3], 0.0), 1.0)
    return None if alpha == 1.0 else alpha


def _scale(shape: Shape) -> tuple[float, float, float]:
    x, y, z = (max(abs(part), _SMALLEST) for part in shape.scale)
    return (x, y, z)


@functools.cache
def _unit_mesh(kind: int) -> tuple[Any, Any]:
    """Vertices and faces of size one."""
    if kind == CUBE:
        mesh = trimesh.creation.box((1.0, 1.0, 1.0))
    elif kind == SPHERE:
        mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.5)
    elif kind == CYLINDER:
        mesh = trimesh.creation.cylinder(radius=0.5, height=1.0, sections=32)
    else:  # the head of an arrow, from its base along x
        mesh = trimesh.creation.cone(radius=0.5, height=1.0, sections=24)
        mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (0, 1, 0)))
    return np.asarray(mesh.vertices, dtype=np.float32), np.asarray(mesh.faces)


def _solid(kind: int) -> Callable[[Any, str, Shape], Any]:
    def draw(scene: Any, name: str, shape: Shape) -> Any:
        vertices, faces = _unit_mesh(kind)
        return scene.add_mesh_simple(
            name,
            vertices * np.array(_scale(shape), dtype=np.float32),
            faces,
            color=_rgb(shape.colour),
            opacity=_opacity(shape),
        )

    return draw


def _solids(kind: int) -> Callable[[Any, str, Shape], Any]:
    def draw(scene: Any, name: str, shape: Shape) -> Any:
        vertices, faces = _unit_mesh(kind)
        count = len(shape.points)
        return scene.add_batched_meshes_simple(
            name,
            vertices * np.array(_scale(shape), dtype=np.float32),
            faces,
            batched_wxyzs=np.tile((1.0, 0.0, 0.0, 0.0), (count, 1)),
            batched_positions=np.array(shape.points).reshape(count, 3),
            batched_colors=linear(_point_colours(shape)),
            opacity=_opacity(shape),
            lod="off",
        )

    return draw


def _point_colours(shape: Shape) -> Any:
    colours = shape.colours or (shape.colour,) * len(shape.points)
    return np.array([_rgb(colour) for colour in colours], dtype=np.uint8).reshape(-1, 3)


def _line_strip(scene: Any, name: str, shape: Shape) -> Any:
    points, colours = np.array(shape.points), _point_colours(shape)
    return _segments(scene, name, shape, np.stack([points[:-1], points[1:]], 1),
                     np.stack([colours[:-1], colours[1:]], 1))  # fmt: skip


def _line_list(scene: Any, name: str, shape: Shape) -> Any:
    points, colours = np.array(shape.points), _point_colours(shape)
    return _segments(scene, name, shape, points.reshape(-1, 2, 3), colours.reshape(-1, 2, 3))


def _segments(scene: Any, name: str, shape: Shape, points: Any, colours: Any) -> Any:
    return scene.add_line_segments(name, points, colours, thickness=_scale(shape)[0])


def _points(scene: Any, name: str, shape: Shape) -> Any:
    return scene.add_point_cloud(
        name,
        np.array(shape.points, dtype=np.float32).reshape(-1, 3),
        _point_colours(shape),
        point_size=_scale(shape)[0],
        precision="float32",
    )


def _text(scene: Any, name: str, shape: Shape) -> Any:
    height = max(shape.scale[2], _SMALLEST)
    return scene.add_label(
        name, shape.text, font_size_mode="scene", font_scene_height=height, anchor="center-center"
    )


def _triangles(scene: Any, name: str, shape: Shape) -> Any:
    vertices = np.array(shape.points) * np.array(_scale(shape))
    mesh = trimesh.Trimesh(
        vertices,
        np.arange(len(vertices)).reshape(-1, 3),
        vertex_colors=_point_colours(shape),
        process=False,
    )
    return scene.add_mesh_trimesh(name, mesh)


def _mesh(scene: Any, name: str, shape: Shape) -> Any:
    mesh = meshes.load(shape.resource, shape.data)
    mesh.apply_scale(_scale(shape))
    if shape.embedded_materials:
        return scene.add_mesh_trimesh(name, mesh)
    return scene.add_mesh_simple(
        name, np.asarray(mesh.vertices), np.asarray(mesh.faces), color=_rgb(shape.colour),
        opacity=_opacity(shape),
    )  # fmt: skip


def _cube(scene: Any, name: str, shape: Shape) -> Any:
    return _solid(CUBE)(scene, name, shape)


def _arrow(scene: Any, name: str, shape: Shape) -> Any:
    """From the origin along x, or between two points."""
    if shape.points:
        start, end = np.array(shape.points[0]), np.array(shape.points[1])
        shaft, head, head_length = shape.scale
        return _arrows(scene, name, shape, [(start, end)], shaft, head, head_length)
    length, width, _ = _scale(shape)
    ends = [(np.zeros(3), np.array([length, 0, 0]))]
    return _arrows(scene, name, shape, ends, width, 2 * width, 0.23 * length)


def _arrow_strip(scene: Any, name: str, shape: Shape) -> Any:
    points = [np.array(point) for point in shape.points]
    return _arrows(scene, name, shape, itertools.pairwise(points), *shape.scale)


def _arrows(
    scene: Any, name: str, shape: Shape, ends: Any, shaft: float, head: float, head_length: float
) -> Any:
    vertices: list[Any] = []
    faces: list[Any] = []
    for start, end in ends:
        length = float(np.linalg.norm(end - start))
        if length < _SMALLEST:
            continue
        tip = min(head_length or 0.23 * length, length)
        turn = trimesh.geometry.align_vectors((1.0, 0.0, 0.0), (end - start) / length)[:3, :3]
        rod, rod_faces = _unit_mesh(CYLINDER)
        rod = rod[:, [2, 1, 0]] * (length - tip, shaft or _SMALLEST, shaft or _SMALLEST)
        cone, cone_faces = _unit_mesh(ARROW)
        cone = cone * (tip, head or _SMALLEST, head or _SMALLEST)
        for part, part_faces, along in (
            (rod, rod_faces[:, ::-1], (length - tip) / 2),
            (cone, cone_faces, length - tip),
        ):
            faces.append(part_faces + sum(map(len, vertices)))
            vertices.append((part + (along, 0, 0)) @ turn.T + start)
    if not vertices:
        return _cube(scene, name, replace(shape, scale=(_SMALLEST,) * 3))
    return scene.add_mesh_simple(
        name, np.concatenate(vertices), np.concatenate(faces), color=_rgb(shape.colour),
        opacity=_opacity(shape), side="double",
    )  # fmt: skip


def _axes(scene: Any, name: str, shape: Shape) -> Any:
    return scene.add_frame(name, axes_length=0.3, axes_radius=0.012)


_DRAW: dict[int, Callable[[Any, str, Shape], Any]] = {
    ARROW: _arrow,
    CUBE: _cube,
    SPHERE: _solid(SPHERE),
    CYLINDER: _solid(CYLINDER),
    LINE_STRIP: _line_strip,
    LINE_LIST: _line_list,
    CUBE_LIST: _solids(CUBE),
    SPHERE_LIST: _solids(SPHERE),
    POINTS: _points,
    TEXT: _text,
    MESH: _mesh,
    TRIANGLE_LIST: _triangles,
    ARROW_STRIP: _arrow_strip,
    AXES: _axes,
}
