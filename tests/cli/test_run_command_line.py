"""What of `run`'s command line is its own, and what belongs to the program."""

import pytest

from rosslt_auto.cli.run import Command, parse


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["a.py"], Command("a.py")),
        (["a.py", "-m", "--module", "x", "--", "--help"],
         Command("a.py", arguments=["-m", "--module", "x", "--", "--help"])),
        (["--module", "a.*", "--exclude=b", "--module=c", "--read-only", "x.py", "--read-only"],
         Command("x.py", arguments=["--read-only"], modules=["a.*", "c"], excluded=["b"],
                 read_only=True)),
        (["-m", "pkg.node", "--ros-args", "-p", "x:=1"],
         Command("pkg.node", as_module=True, arguments=["--ros-args", "-p", "x:=1"])),
        (["-mpkg"], Command("pkg", as_module=True)),
        (["-m", "pkg", "-m", "x"], Command("pkg", as_module=True, arguments=["-m", "x"])),
        (["--", "--odd.py", "--", "x"], Command("--odd.py", arguments=["--", "x"])),
        (["--module", "--odd", "x.py"], Command("x.py", modules=["--odd"])),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)  # fmt: skip
def test_command(words: list[str], expected: Command) -> None:
    assert parse(words) == expected


@pytest.mark.parametrize("words", [["--help"], ["-h"], ["--read-only", "--help", "x.py"]])
def test_help(words: list[str]) -> None:
    assert parse(words) is None


@pytest.mark.parametrize(
    "words", [[], ["--read-only"], ["--module"], ["-m"], ["--nosuch", "x.py"], ["-x"], ["--"]]
)
def test_wrong_usage(words: list[str]) -> None:
    with pytest.raises(Exception, match=r"required|expected|unrecognized"):
        parse(words)
