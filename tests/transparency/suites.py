"""The tables: programs, what is instrumented in them, which differences are expected."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

TABLES = Path(__file__).parent
SUITES = ("programs", "numbers", "packages", "extensions", "ros", "library")
SHORT = ("programs", "numbers", "packages")
"""What takes minutes."""


@dataclass(frozen=True)
class Expected:
    """Differences that are expected, and why they are not mended.

    test     fnmatch pattern of names of tests
    reason   what a reader of the report is told
    always   whether it is as wrong if it is not found: false where it depends on the environment
    """

    test: str
    reason: str
    always: bool = True


@dataclass
class Case:
    """A program that is run both ways.

    suite, name  how it is called in reports and on the command line
    recorder     the module in `recorders` that runs its tests; none for a program that has no tests
    arguments    what the recorder is told, or the program itself (``["-m", "calendar"]``)
    modules      fnmatch patterns of the modules that are instrumented
    excluded     and of those that are not
    folder       where it is run, None: in an empty one
    path         folders for PYTHONPATH
    timeout      seconds for the plain program; the instrumented one gets four times as much
    expected     differences that are known
    printed      whether what the program prints is compared
    prepare      fetches what the program needs, if it is not there yet
    """

    suite: str
    name: str
    recorder: str = ""
    arguments: list[str] = field(default_factory=list)
    modules: list[str] = field(default_factory=list)
    excluded: list[str] = field(default_factory=list)
    folder: Path | None = None
    path: list[Path] = field(default_factory=list)
    timeout: float = 120.0
    expected: list[Expected] = field(default_factory=list)
    printed: bool = True
    variables: dict[str, str] = field(default_factory=dict)
    prepare: Callable[[], None] | None = None

    @property
    def title(self) -> str:
        return f"{self.suite}:{self.name}"


def table(suite: str) -> dict:
    """The content of a suite's table."""
    with open(TABLES / f"{suite}.toml", "rb") as file:
        return tomllib.load(file)


def expected(rows: dict, program: str, always: bool = True) -> list[Expected]:
    """What the table expects of a program with this Python.

    rows    the table's ``expected`` (or, not `always`, ``sometimes``): a reason for each
            "program: test" or, for some versions of Python only, "3.12 program: test"; both parts
            are patterns
    always  see `Expected`
    """
    found = []
    for reason, tests in rows.items():
        for entry in tests:
            pattern, _, test = entry.partition(": ")
            version, _, name = pattern.rpartition(" ")
            if version and version != "{}.{}".format(*sys.version_info):
                continue
            if fnmatchcase(program, name):
                found.append(Expected(test, reason, always))
    return found


def cases(suite: str) -> Iterator[Case]:
    """The cases of one of `SUITES` (but "ros", which has programs of its own kind)."""
    if suite == "ros":
        return
    if suite == "packages":
        from transparency import packages

        yield from packages.cases()
    elif suite == "extensions":
        from transparency import packages

        yield from packages.callers()
    else:
        from transparency import cpython

        yield from cpython.cases(suite)
