"""Which meshes are shown, and that an address from the network reaches nothing else."""

import os
from pathlib import Path

import pytest

pytest.importorskip("viser")

import trimesh

from rosslt_auto.views.meshes import FORMATS, NoMesh, load, mesh_path

pytestmark = pytest.mark.filterwarnings("ignore:Setting the shape:DeprecationWarning")  # pycollada

SIZE = (1.0, 2.0, 3.0)


def write(path: Path, unit: str = "") -> str:
    """A box of this size; returns the address."""
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box(SIZE).export(path)
    if unit:
        text = path.read_text()
        path.write_text(text.replace("<asset>", f'<asset><unit meter="{unit}" name="unit"/>'))
    return path.as_uri()


@pytest.mark.parametrize("ending", FORMATS)
def test_files_are_read(ending: str, tmp_path: Path) -> None:
    address = write(tmp_path / f"with space.{ending}")
    assert "%20" in address
    assert load(address).extents == pytest.approx(SIZE)


def test_endings_may_be_in_capitals(tmp_path: Path) -> None:
    write(tmp_path / "box.stl")
    (tmp_path / "box.stl").rename(tmp_path / "BOX.STL")
    assert load((tmp_path / "BOX.STL").as_uri()).extents == pytest.approx(SIZE)


def test_a_file_says_its_unit(tmp_path: Path) -> None:
    centimetres = write(tmp_path / "box.dae", unit="0.01")
    assert load(centimetres).extents == pytest.approx([0.01 * size for size in SIZE])


def test_packages_that_have_been_sourced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "b" / "share" / "robot" / "meshes" / "arm.stl")
    write(tmp_path / "b" / "share" / "secret.stl")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'a'}{os.pathsep}{tmp_path / 'b'}")
    assert load("package://robot/meshes/arm.stl").extents == pytest.approx(SIZE)
    for address in (
        "package://robot/../secret.stl",
        "package://robot/%2e%2e/secret.stl",
        "package://robot/meshes/../../secret.stl",
        "package://../share/secret.stl",
    ):
        with pytest.raises(NoMesh, match="leads out of the package"):
            load(address)
    with pytest.raises(NoMesh, match=r"no package other with arm\.stl has been sourced"):
        load("package://other/arm.stl")
    monkeypatch.delenv("AMENT_PREFIX_PATH")
    with pytest.raises(NoMesh, match="has been sourced"):
        load("package://robot/meshes/arm.stl")


def test_what_the_message_carries(tmp_path: Path) -> None:
    write(tmp_path / "box.ply")
    content = (tmp_path / "box.ply").read_bytes()
    assert load("embedded://box", ("box.ply", content)).extents == pytest.approx(SIZE)
    with pytest.raises(NoMesh):
        load("embedded://box", ("box.ply", b"nothing of the kind"))


@pytest.mark.parametrize(
    "address",
    ["http://127.0.0.1:9/box.stl", "https://example.com/a.dae", "ftp://a/b.stl", "box.stl", ""],
)
def test_nothing_is_fetched(address: str) -> None:
    with pytest.raises(NoMesh, match="neither file:// nor package://"):
        load(address)


def test_what_is_no_mesh(tmp_path: Path) -> None:
    with pytest.raises(NoMesh, match=r"gone\.stl is not there"):
        load((tmp_path / "gone.stl").as_uri())
    with pytest.raises(NoMesh, match="is not there"):
        load(f"file://{tmp_path}")
    with pytest.raises(NoMesh, match="on another machine"):
        mesh_path("file://elsewhere/box.stl")
    (tmp_path / "notes.txt").write_text("no mesh")
    with pytest.raises(NoMesh, match="in none of the formats stl, dae"):
        load((tmp_path / "notes.txt").as_uri())
    (tmp_path / "empty.stl").touch()
    with pytest.raises(NoMesh, match="nothing in the mesh"):
        load((tmp_path / "empty.stl").as_uri())
    (tmp_path / "broken.dae").write_text("<COLLADA")
    with pytest.raises(NoMesh, match="cannot be read"):
        load((tmp_path / "broken.dae").as_uri())


def test_what_is_done_to_a_mesh_stays_there(tmp_path: Path) -> None:
    address = write(tmp_path / "box.stl")
    load(address).apply_scale(10.0)
    assert load(address).extents == pytest.approx(SIZE)


def test_a_file_that_has_changed_is_read_again(tmp_path: Path) -> None:
    address = write(tmp_path / "box.stl")
    load(address)
    trimesh.creation.box((5.0, 5.0, 5.0)).export(tmp_path / "box.stl")
    os.utime(tmp_path / "box.stl", ns=(1, 1))
    assert load(address).extents == pytest.approx((5.0, 5.0, 5.0))
