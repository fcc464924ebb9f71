"""What a command line says about literals, as rcl reads it."""

from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.ros import overrides

NAME = "rosslt.talker.count"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--ros-args", "-p", f"{NAME}:=7"], {NAME: 7}),
        (["--ros-args", "--param", f"{NAME}:=7.5"], {NAME: 7.5}),
        (["--ros-args", "-p", f"{NAME}:=-1e3"], {NAME: -1000.0}),
        (["--ros-args", "-p", f"{NAME}:=true"], {NAME: True}),
        (["--ros-args", "-p", f"{NAME}:=many"], {NAME: "many"}),
        (["--ros-args", "-p", f"{NAME}:=[1, 2]"], {NAME: [1, 2]}),
        (["--ros-args", "-p", f"{NAME}:={{"], {NAME: "{"}),
        (["--ros-args", "-p", f"{NAME}:=1", "-p", f"{NAME}:=2"], {NAME: 2}),
        (["-v", "--ros-args", "-p", f"{NAME}:=7", "--", "x"], {NAME: 7}),
        # Outside of --ros-args it is the program's own business.
        (["-p", f"{NAME}:=7"], {}),
        (["--ros-args", "--", "-p", f"{NAME}:=7"], {}),
        (["--ros-args", "-p", "speed:=7"], {}),
        (["--ros-args", "-p"], {}),
        # For a node by name: only if remaps name it, else rcl decides when the node is made.
        (["--ros-args", "-p", f"talker:{NAME}:=7"], {}),
        (["--ros-args", "-p", f"talker:{NAME}:=7", "-r", "__node:=talker"], {NAME: 7}),
        (["--ros-args", "-p", f"talker:{NAME}:=7", "-r", "__node:=other"], {}),
        (["--ros-args", "-r", "__ns:=/a", "--remap", "__node:=b", "-p", f"/a/b:{NAME}:=7"],
         {NAME: 7}),
        (["--ros-args", "-r", "__node:=b", "-r", "__ns:=/a/c", "-p", f"/**/b:{NAME}:=7"],
         {NAME: 7}),
        (["--ros-args", "-r", "__node:=b", "-r", "__ns:=/a/c", "-p", f"/*/b:{NAME}:=7"], {}),
        (["--ros-args", "-r", "__node:=b", "-r", "__ns:=/a", "-p", f"/*/b:{NAME}:=7"], {NAME: 7}),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)  # fmt: skip
def test_command_line(arguments: list[str], expected: dict[str, Any]) -> None:
    assert overrides.read(arguments) == expected
    assert [type(value) for value in overrides.read(arguments).values()] == [
        type(value) for value in expected.values()
    ]


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (f"/**:\n  ros__parameters:\n    {NAME}: 7\n", {NAME: 7}),
        ("/**:\n  ros__parameters:\n    rosslt: {talker: {count: 7}}\n", {NAME: 7}),
        ("/**:\n  ros__parameters:\n    rosslt.talker: {count: 1e3, other: 2}\n",
         {NAME: 1000.0, "rosslt.talker.other": 2}),
        (f"talker:\n  ros__parameters:\n    {NAME}: 7\n", {}),
        (f"robot:\n  ros__parameters:\n    {NAME}: 7\n", {NAME: 7}),
        (f"/robot:\n  ros__parameters:\n    {NAME}: 7\n", {NAME: 7}),
        (f"/**:\n  robot:\n    ros__parameters:\n      {NAME}: 7\n", {NAME: 7}),
        ("/**:\n  ros__parameters:\n    speed: 7\n", {}),
        ("# rosslt\n", {}),
        ("- rosslt\n", {}),
        ("rosslt: [\n", {}),
        ("", {}),
    ],
)  # fmt: skip
def test_parameter_file(content: str, expected: dict[str, Any], tmp_path: Path) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text(content)
    arguments = ["--ros-args", "-r", "__node:=robot", "--params-file", str(file)]
    assert overrides.read(arguments) == expected


def test_file_that_cannot_be_read_is_left_to_rcl(tmp_path: Path) -> None:
    (tmp_path / "binary").write_bytes(b"\xff\xfe rosslt")
    for file in (tmp_path / "nosuch.yaml", tmp_path, tmp_path / "binary"):
        assert overrides.read(["--ros-args", "--params-file", str(file)]) == {}


def test_later_wins_over_earlier(tmp_path: Path) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text(f"/**:\n  ros__parameters:\n    {NAME}: 7\n")
    option = ["-p", f"{NAME}:=8"]
    from_file = ["--params-file", str(file)]
    assert overrides.read(["--ros-args", *option, *from_file]) == {NAME: 7}
    assert overrides.read(["--ros-args", *from_file, *option]) == {NAME: 8}
