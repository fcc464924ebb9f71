"""Meshes of markers: files of this machine, or what is in the message itself.

An address comes from the network. It may name a file (`file://`), a file in a package that has been
sourced (`package://`, as ament finds it) or what the message carries (`embedded://`); nothing is
fetched. Readers are trimesh's, for the formats named here.
"""

from __future__ import annotations

import functools
import io
import os
from typing import Any
from urllib.parse import unquote, urlparse

import trimesh

FORMATS = ("stl", "dae", "obj", "ply", "glb", "gltf", "off")
"""Endings of names of what can be read."""

_KEPT = 16
_METRE = "meters"


class NoMesh(ValueError):
    """There is no mesh to show; the message says why."""


def load(resource: str, data: tuple[str, bytes] = ("", b"")) -> Any:
    """The mesh at an address, in metres: a `trimesh.Trimesh` of the caller's own. Raises NoMesh.

    data  name and content of the file that the message carries, for ``embedded://``
    """
    try:
        if urlparse(resource).scheme == "embedded":
            name, content = data
            mesh = _read(io.BytesIO(content), name)
        else:
            path = mesh_path(resource)
            mesh = _file(path, os.stat(path).st_mtime_ns).copy()
    except NoMesh:
        raise
    except Exception as reason:  # whatever readers raise at what is no mesh
        raise NoMesh(f"the mesh {resource} cannot be read: {reason}") from None
    if not len(mesh.faces):
        raise NoMesh(f"there is nothing in the mesh {resource}")
    return mesh


@functools.lru_cache(_KEPT)
def _file(path: str, changed: int) -> Any:
    """A marker that changes its size does so without reading the file again."""
    return _read(path, path)


def _read(source: Any, name: str) -> Any:
    ending = name.rpartition(".")[2].lower()
    if ending not in FORMATS:
        raise NoMesh(f"the mesh {name!r} is in none of the formats {', '.join(FORMATS)}")
    mesh = trimesh.load(source, file_type=ending, force="mesh")
    if mesh.units not in (None, _METRE):
        mesh.convert_units(_METRE)
    return mesh


def mesh_path(resource: str) -> str:
    """The file at an address ``file://`` or ``package://``. Raises NoMesh."""
    address = urlparse(resource)
    path = unquote(address.path)
    if address.scheme == "package":
        path = _in_package(address.netloc, path.lstrip("/"))
    elif address.scheme != "file":
        raise NoMesh(f"the mesh {resource!r} is neither file:// nor package:// nor embedded://")
    elif address.netloc not in ("", "localhost"):
        raise NoMesh(f"the mesh {resource} is on another machine")
    if not os.path.isfile(path):
        raise NoMesh(f"the mesh {resource} is not there")
    return path


def _in_package(package: str, path: str) -> str:
    if os.pardir in (package, *path.split("/")):
        raise NoMesh(f"package://{package}/{path} leads out of the package")
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        found = os.path.join(prefix, "share", package, path)
        if prefix and os.path.isfile(found):
            return found
    raise NoMesh(f"no package {package} with {path} has been sourced")
