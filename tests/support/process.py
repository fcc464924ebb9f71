"""Programs as real processes: plain, or under `python -m rosslt_auto run`."""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from support.waiting import DEADLINE, DeadlineMissed

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = ROOT / "sample_nodes"
DATA = ROOT / "tests" / "e2e" / "data"

# Nothing beyond this machine, and found soon there.
NETWORK = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(ROOT / "tests" / "support" / "fastdds.xml"),
}

RUN = ("-m", "rosslt_auto", "run")
_FINISHING = 10.0  # seconds that a program has to end by itself once it was interrupted


def environment(domain: int, **changes: str | None) -> dict[str, str]:
    """The environment of a test program: its own ROS domain, nothing beyond this machine.

    A change to None removes the variable.
    """
    variables: dict[str, str | None] = {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        **NETWORK,
        "PYTHONUNBUFFERED": "1",
        "XDG_STATE_HOME": os.path.join(tempfile.gettempdir(), f"rosslt-state-{os.getpid()}"),
        **changes,
    }
    return {name: value for name, value in variables.items() if value is not None}


def _default_interrupt() -> None:
    # A shell that starts a test run in the background makes it, and all below it, ignore SIGINT.
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Lines:
    """The lines that a stream has brought so far, read by a thread of its own."""

    def __init__(self, stream: IO[str]) -> None:
        self._lines: list[str] = []
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._read, args=(stream,), daemon=True)
        self._thread.start()

    def _read(self, stream: IO[str]) -> None:
        for line in stream:
            with self._changed:
                self._lines.append(line.rstrip("\n"))
                self._changed.notify_all()
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def all(self) -> list[str]:
        """The lines up to now."""
        with self._changed:
            return list(self._lines)

    def matching(self, pattern: str, count: int = 1, deadline: float = DEADLINE) -> list[str]:
        """The first `count` lines in which `pattern` is found, as soon as they are there.

        Raises DeadlineMissed, with all that was printed, also when the stream ends before.
        """
        search = re.compile(pattern).search
        found: list[str] = []

        def enough() -> bool:
            found[:] = filter(search, self._lines)
            return len(found) >= count or self._closed

        with self._changed:
            self._changed.wait_for(enough, deadline)
            if len(found) < count:
                raise DeadlineMissed(
                    f"{len(found)} of {count} lines with {pattern!r} in:\n" + "\n".join(self._lines)
                )
        return found[:count]

    def finish(self) -> None:
        """Returns when the stream has ended."""
        self._thread.join(DEADLINE)


class Program:
    """A running program. As a context manager it is over when the block is left."""

    def __init__(self, command: Sequence[str], env: Mapping[str, str], cwd: Path = ROOT) -> None:
        self.command = list(command)
        self._process = subprocess.Popen(
            self.command,
            env=dict(env),
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            preexec_fn=_default_interrupt,
        )
        assert self._process.stdout and self._process.stderr
        self.stdout = Lines(self._process.stdout)
        self.stderr = Lines(self._process.stderr)

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self._process.poll() is None

    def interrupt(self) -> None:
        """Sends what Ctrl-C sends."""
        self._process.send_signal(signal.SIGINT)

    def terminate(self) -> None:
        """Sends what a supervisor sends."""
        self._process.terminate()

    def kill(self) -> None:
        """Ends it without asking."""
        self._process.kill()

    def wait(self, deadline: float = DEADLINE) -> int:
        """Its exit status, once it has ended by itself. Raises DeadlineMissed."""
        try:
            status = self._process.wait(deadline)
        except subprocess.TimeoutExpired:
            raise DeadlineMissed(f"still running: {self}") from None
        self.stdout.finish()
        self.stderr.finish()
        return status

    def stop(self) -> int:
        """Its exit status after an interrupt, or a kill if that does not end it."""
        if self.running:
            self.interrupt()
        try:
            return self.wait(_FINISHING)
        except DeadlineMissed:
            self._process.kill()
            return self.wait()

    def __enter__(self) -> "Program":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def __str__(self) -> str:
        return "\n".join(
            [
                " ".join(self.command),
                "--- stdout",
                *self.stdout.all,
                "--- stderr",
                *self.stderr.all,
            ]
        )


def start(
    script: Path | str,
    *arguments: str,
    domain: int,
    instrumented: bool,
    options: Iterable[str] = (),
    cwd: Path = ROOT,
    **variables: str | None,
) -> Program:
    """Starts `script`, plain or instrumented; `options` go to `run`, `arguments` to the script."""
    prefix = [sys.executable, *(RUN if instrumented else ()), *(options if instrumented else ())]
    return Program([*prefix, str(script), *arguments], environment(domain, **variables), cwd=cwd)


@dataclass(frozen=True)
class Outcome:
    """What a program that has ended left behind."""

    status: int
    stdout: str
    stderr: str

    @property
    def json(self) -> Any:
        """The one JSON document on stdout; fails if there is anything else."""
        return json.loads(self.stdout)

    @property
    def json_lines(self) -> list[Any]:
        """The JSON documents on stdout, one a line; fails if there is anything else."""
        return [json.loads(line) for line in self.stdout.splitlines()]

    def assert_clean_failure(self, *statuses: int, says: str = "") -> None:
        """It failed as a user may expect it: one clear line on stderr, no traceback."""
        assert self.status in (statuses or (1, 2)), self
        assert "Traceback" not in self.stderr, self
        lines = [line for line in self.stderr.splitlines() if line.strip()]
        # argparse puts its usage before the line that says what is wrong.
        message = lines[-1:] if lines and lines[0].startswith("usage:") else lines
        assert len(message) == 1, self
        assert re.search(says, message[0], re.IGNORECASE), self


def finish(program: Program, deadline: float = DEADLINE) -> Outcome:
    """The outcome of a program that ends by itself; it is stopped if it does not."""
    with program:
        status = program.wait(deadline)
    return Outcome(status, _text(program.stdout), _text(program.stderr))


def _text(lines: Lines) -> str:
    return "".join(f"{line}\n" for line in lines.all)


def rosslt_auto(
    *arguments: str, domain: int, deadline: float = DEADLINE, **changes: str | None
) -> Outcome:
    """The outcome of `python -m rosslt_auto ARGUMENTS`."""
    command = [sys.executable, "-m", "rosslt_auto", *arguments]
    return finish(Program(command, environment(domain, **changes)), deadline)
