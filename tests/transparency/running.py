"""Runs a case plain and instrumented, and says what became of it."""

from __future__ import annotations

import ast
import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path

from transparency.suites import Case

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "transparency"
"""Where everything is kept that is downloaded or made: outside of version control."""

RECORDERS = Path(__file__).parent / "recorders"
_MORE_TIME = 4
_LAST_WORDS = 2000


@dataclass
class Outcome:
    """What a program left behind.

    findings  what was recorded for each test, in order of appearance
    status    its exit status; None if it had to be stopped
    output    what it printed, stdout and stderr
    seconds   processor time it took, with that of the programs it waited for
    """

    findings: dict[str, list[dict]] = field(default_factory=dict)
    status: int | None = None
    output: tuple[str, str] = ("", "")
    seconds: float = 0.0


def run(case: Case, instrumented: bool) -> Outcome:
    """Runs the case's program once, in a folder of its own and with a time limit."""
    with tempfile.TemporaryDirectory(prefix="transparency-") as folder:
        return _run_in(case, instrumented, Path(folder).resolve())


def _run_in(case: Case, instrumented: bool, folder: Path) -> Outcome:
    (folder / "tmp").mkdir()
    (folder / "here").mkdir()
    recorded = folder / "recording"
    command = [sys.executable, "-X", "frozen_modules=off"]
    if instrumented:
        command += ["-m", "rosslt_auto", "run"]
        for option, patterns in (
            ("--module", case.modules),
            ("--exclude", [*case.excluded, "record_*", "recording"]),
        ):
            for pattern in patterns:
                command += [option, pattern]
    if case.recorder:
        command += ["-m", case.recorder, str(recorded), ",".join(case.modules)]
    command += case.arguments
    with open(folder / "stdout", "w+b") as stdout, open(folder / "stderr", "w+b") as stderr:
        process = subprocess.Popen(
            command, cwd=case.folder or folder / "here", env=_environment(case, folder),
            stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, start_new_session=True,
        )  # fmt: skip
        status, seconds = _wait(process, case.timeout * (_MORE_TIME if instrumented else 1))
        texts = []
        for stream in (stdout, stderr):
            stream.seek(0)
            texts.append(normalised(stream.read().decode("utf-8", "replace"), folder))
    output = (texts[0], texts[1]) if case.printed else ("", "")
    return Outcome(_read(recorded, folder), status, output, seconds)


def _wait(process: subprocess.Popen, patience: float) -> tuple[int | None, float]:
    """The exit status, None if the patience had an end, and the processor time it took.

    Ends what the program has started, too; they have a process group of their own.
    """
    impatient = threading.Event()

    def end() -> None:
        impatient.set()
        _end_all(process.pid)

    timer = threading.Timer(patience, end)
    timer.start()
    _, status, usage = os.wait4(process.pid, 0)
    timer.cancel()
    timer.join()
    _end_all(process.pid)
    process.returncode = os.waitstatus_to_exitcode(status)
    seconds = usage.ru_utime + usage.ru_stime
    return (None if impatient.is_set() else process.returncode), seconds


def _end_all(group: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)


def _environment(case: Case, folder: Path) -> dict[str, str]:
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("PYTHON", "PYTEST", "COVERAGE", "ROS_", "RCUTILS"))
    }
    return {
        **kept,
        "HOME": str(folder),
        "TMPDIR": str(folder / "tmp"),
        "LC_ALL": "C.UTF-8",
        "PYTHONHASHSEED": "0",
        # Plain and rewritten code side by side, and nothing in the folders of the interpreter.
        "PYTHONPYCACHEPREFIX": str(BUILD / "bytecode"),
        "PYTHONPATH": os.pathsep.join(map(str, [*case.path, ROOT, RECORDERS])),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        **case.variables,
    }


_VARYING = [
    # That not every pattern has found a module is told on stderr, and as it should be.
    (re.compile(r"^rosslt_auto: --module .*\n", re.MULTILINE), ""),
    (re.compile(r"0x[0-9a-fA-F]{6,}"), "0x..."),
    (re.compile(r"\b\d{10,}\b(?=\.|\))|(?<=ident=)\d+|(?<=Thread-)\d+|(?<=pid )\d+"), "#"),
    (re.compile(r"\b\d+(\.\d+)?(e-\d+)? ?(s|ms|us|seconds)\b"), "# s"),
    (re.compile(r"\b\d\d:\d\d:\d\d(\.\d+)?\b"), "[time]"),
    (re.compile(r"(?<=/|_)tmp[a-z0-9_]{8}"), "tmp..."),
    (re.compile(r"@test_\d+_tmp\w*"), "@test_#_tmp"),
]


def normalised(text: str, folder: Path) -> str:
    """Without what differs between any two runs: addresses, times, names of temporary files."""
    text = text.replace(str(folder), "/run")
    for pattern, instead in _VARYING:
        text = pattern.sub(instead, text)
    return text


def _read(path: Path, folder: Path) -> dict[str, list[dict]]:
    findings: dict[str, list[dict]] = {}
    if path.exists():
        for line in normalised(path.read_text(), folder).splitlines():
            try:
                finding = ast.literal_eval(line)
            except (SyntaxError, ValueError):  # the program died while it wrote
                continue
            findings.setdefault(finding.pop("test"), []).append(finding)
    return findings
