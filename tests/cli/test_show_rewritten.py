"""`run --show-rewritten`: prints, and runs nothing."""

import sys
from pathlib import Path

import pytest

from rosslt_auto import cli

SCRIPT = "import helper\nopen('ran', 'w')\nx = 0.5  # rosslt: 0.0 to 1.0\n"


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """The exit status and what is printed; fails if anything runs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    Path("program.py").write_text(SCRIPT)
    Path("helper.py").write_text("open('ran', 'w')\ny = 1.5\n")
    Path("pkg/sub").mkdir(parents=True)
    for name in ("__init__", "__main__", "node", "sub/__init__", "sub/deep"):
        Path(f"pkg/{name}.py").write_text(f"open('ran', 'w')\n{Path(name).stem} = 2.5\n")
    Path("broken.py").write_text("x = (1")

    def run(*words: str) -> tuple[int, list[str], str]:
        status = cli.main(["run", "--show-rewritten", *words])
        assert not Path("ran").exists()
        stdout, stderr = capsys.readouterr()
        return status, stdout.splitlines(), stderr

    return run


def shown(lines: list[str]) -> list[str]:
    return [line.partition(":")[0] for line in lines if line.startswith("# ")]


def test_a_script(show) -> None:
    status, lines, errors = show("program.py", "--not-ours")
    assert (status, errors) == (0, "")
    assert lines[0] == "# __main__: program.py"
    assert lines[-1] == "x = @program[0]  # x = 0.5 (0.0 to 1.0)"
    assert set(SCRIPT.splitlines()[:2]) < set(lines)


def test_modules_by_pattern(show) -> None:
    _, lines, _ = show(
        "--module", "helper", "--module=pkg.*", "--exclude", "pkg.node", "program.py"
    )
    assert shown(lines) == [
        "# __main__",
        "# helper",
        "# pkg.__main__",
        "# pkg.sub",
        "# pkg.sub.deep",
    ]
    _, lines, _ = show("--module", "help?r", "program.py")
    assert shown(lines) == ["# __main__", "# helper"]


def test_modules_and_packages_as_programs(show) -> None:
    assert shown(show("-m", "pkg")[1]) == ["# pkg.__main__"]
    assert shown(show("-m", "pkg.sub.deep")[1]) == ["# pkg.sub.deep"]
    assert shown(show("pkg")[1]) == ["# __main__"]


def test_a_console_script_and_its_package(show) -> None:
    Path("talker").write_text("from pkg.node import node\nif __name__ == '__main__':\n    node()\n")
    assert shown(show("talker")[1])[:3] == ["# __main__", "# pkg", "# pkg.__main__"]


@pytest.mark.parametrize(
    "words, reason",
    [
        (["missing.py"], "missing.py: No such file"),
        (["broken.py"], "broken.py: '(' was never closed"),
        (["-m", "missing_module"], "no source of missing_module"),
        (["-m", "sys"], "no source of sys"),
        (["-m", "pkg.sub"], "no source of pkg.sub"),
    ],
)
def test_what_cannot_be_shown(show, words: list[str], reason: str) -> None:
    status, lines, errors = show(*words)
    assert (status, lines, len(errors.splitlines())) == (1, [], 1)
    assert reason in errors
