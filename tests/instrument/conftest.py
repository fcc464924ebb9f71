"""Helpers for tests of instrumentation: small programs, plain and instrumented."""

import os
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.instrument import hook
from rosslt_auto.instrument.selection import Selection
from support.modules import write_modules

ROOT = Path(__file__).parents[2]

_RUN = """
import sys
from rosslt_auto.instrument.runner import run
from rosslt_auto.instrument.selection import Selection
as_module = sys.argv[1] == "-m"
words = sys.argv[1 + as_module:]
sys.exit(run(words[0], words[1:], as_module=as_module, selection=Selection()))
"""


@pytest.fixture
def instrumented(tmp_path: Path) -> Callable[..., dict[str, Any]]:
    """Executes a source text as an instrumented module and gives its namespace."""

    def execute(source: str, name: str = "sample") -> dict[str, Any]:
        path = tmp_path / f"{name}.py"
        text = textwrap.dedent(source)
        path.write_text(text)
        code = hook.instrumented_code(name, str(path), text.encode(), cached=False)
        namespace = {"__name__": name, "__file__": str(path)}
        exec(code, namespace)
        return namespace

    return execute


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Path]]:
    """Writes modules into a folder on the path, selected by the pattern ``under_test*``."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", None)
    hook.install(Selection(patterns=["under_test*"]))

    def write(**files: str) -> Path:
        write_modules(tmp_path, files)
        return tmp_path

    yield write
    hook.uninstall()
    for name in [name for name in sys.modules if name.startswith("under_test")]:
        del sys.modules[name]


@dataclass
class Outcome:
    """What a process leaves."""

    status: int
    stdout: str
    stderr: str


@pytest.fixture
def both(tmp_path: Path) -> Callable[..., tuple[Outcome, Outcome]]:
    """Runs a program plain and instrumented, in processes of their own.

    python   options of the interpreter
    path     folders that are on its path as well
    options  for `run`, which is then the command
    input    what the program reads
    """

    def run(
        *words: str,
        python: tuple[str, ...] = (),
        path: tuple[Path, ...] = (),
        options: tuple[str, ...] | None = None,
        input: str | None = None,
    ) -> tuple[Outcome, Outcome]:
        how = ["-c", _RUN] if options is None else ["-m", "rosslt_auto", "run", *options]
        plain = _start([sys.executable, *python, *words], tmp_path, path)
        ours = _start([sys.executable, *python, *how, *words], tmp_path, path)
        return _outcome(plain, input), _outcome(ours, input)

    return run


def _start(command: list[str], folder: Path, path: tuple[Path, ...]) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        command,
        cwd=folder,
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join(map(str, (ROOT, *path))),
            "PYTHONHASHSEED": "0",
        },
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def _outcome(process: "subprocess.Popen[str]", input: str | None) -> Outcome:
    stdout, stderr = process.communicate(input, timeout=60)
    return Outcome(process.returncode, stdout, stderr)
