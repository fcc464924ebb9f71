"""What of `run`'s command line is its own, and what belongs to the program."""

from typing import Any

import pytest

from rosslt_auto.cli.run import Command, parse


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["a.py"], dict(target="a.py")),
        (["a.py", "-m", "--module", "x", "--", "--help"],
         dict(target="a.py", arguments=["-m", "--module", "x", "--", "--help"])),
        (["--module", "a.*", "--exclude=b", "--module=c", "--read-only", "x.py", "--read-only"],
         dict(target="x.py", arguments=["--read-only"], modules=["a.*", "c"], excluded=["b"],
                 read_only=True)),
        (["-m", "pkg.node", "--ros-args", "-p", "x:=1"],
         dict(target="pkg.node", as_module=True, arguments=["--ros-args", "-p", "x:=1"])),
        (["-mpkg"], dict(target="pkg", as_module=True)),
        (["-m", "pkg", "-m", "x"], dict(target="pkg", as_module=True, arguments=["-m", "x"])),
        (["--", "--odd.py", "--", "x"], dict(target="--odd.py", arguments=["--", "x"])),
        (["--module", "--odd", "x.py"], dict(target="x.py", modules=["--odd"])),
        (["-i", "--read-only"], dict(prompt=True, read_only=True)),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)  # fmt: skip
def test_command(words: list[str], expected: dict[str, Any]) -> None:
    assert vars(parse(words)) == vars(Command()) | expected


@pytest.mark.parametrize("words", [["--help"], ["-h"], ["--read-only", "--help", "x.py"]])
def test_help(words: list[str]) -> None:
    assert parse(words) is None


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["--read-only"],
        ["--module"],
        ["-m"],
        ["--nosuch", "x.py"],
        ["-x"],
        ["--"],
        ["-"],
        ["-i", "x.py"],
        ["-i", "--show-rewritten"],
    ],
)
def test_wrong_usage(words: list[str]) -> None:
    with pytest.raises(Exception, match=r"required|expected|unrecognized|standard input|prompt"):
        parse(words)
