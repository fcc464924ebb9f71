"""Results for people: lines while it runs, and the report in Markdown."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from transparency.comparing import Result
from transparency.running import ROOT
from transparency.suites import SUITES, table

PACKAGE = "rosslt_auto"
_WIDE = 300


def lines(result: Result, details: bool) -> Iterator[str]:
    """What is printed of one case."""
    found = len(result.expected) + len(result.surprises)
    how = result.note or f"{found} differences, {len(result.surprises)} unexpected"
    seconds = "{:.0f}/{:.0f} s".format(*result.seconds) if any(result.seconds) else ""
    yield f"{result.case.title:<44}{result.tests:>6} tests  {how}  {seconds}"
    for difference in (*result.surprises, *(result.expected if details else ())):
        yield f"    {difference.test}  {f'[{difference.reason}]' if difference.reason else ''}"
        yield f"        plain:        {difference.plain[:_WIDE]}"
        yield f"        instrumented: {difference.instrumented[:_WIDE]}"
    for expected in result.vanished:
        yield f"    {expected.test}: a difference was expected ({expected.reason}), there is none"


def summary(results: Iterable[Result]) -> str:
    """The last line."""
    results = list(results)
    tests = sum(result.tests for result in results)
    found = sum(len(result.expected) + len(result.surprises) for result in results)
    surprises = sum(len(result.surprises) for result in results)
    vanished = sum(len(result.vanished) for result in results)
    return (
        f"{len(results)} programs, {tests} tests, {found} differences, "
        f"{surprises} unexpected, {vanished} expected but not found"
    )


# ---------------------------------------------------------------- the report


MARK = "<!-- What follows is written by `make test-transparency`. -->"

_HEADING = re.compile(r"^### (.*) \(Python (\d+\.\d+).*\)$", re.MULTILINE)


def write(path: Path, results: list[Result]) -> None:
    """Puts a section for each suite into a Markdown file, behind the line `MARK`.

    It replaces the section of that suite and version of Python; others stay. Raises ValueError if
    the file has no such line.
    """
    head, mark, rest = path.read_text().partition(MARK)
    if not mark:
        raise ValueError(f"{path} has no line {MARK!r}")
    pieces = _HEADING.split(rest)
    sections = {
        (title, version): (full, body.strip())
        for title, version, full, body in _existing(rest, pieces)
    }
    version = "{}.{}".format(*sys.version_info)
    for suite in SUITES:
        rows = [result for result in results if result.case.suite == suite]
        if rows:
            heading = f"### {TITLES[suite]} (Python {'{}.{}.{}'.format(*sys.version_info)})"
            sections[TITLES[suite], version] = (heading, "\n".join(_section(suite, rows)).strip())
    order = list(TITLES.values())
    texts = [
        f"{heading}\n\n{body}\n"
        for (title, _), (heading, body) in sorted(
            sections.items(), key=lambda item: (order.index(item[0][0]), item[0][1])
        )
    ]
    path.write_text("\n".join([head + mark + "\n", *texts]))


def _existing(text: str, pieces: list[str]) -> Iterator[tuple[str, str, str, str]]:
    """Title, version, heading and text of each section that a report has."""
    headings = [found.group() for found in _HEADING.finditer(text)]
    for index, heading in enumerate(headings):
        title, version, body = pieces[3 * index + 1 : 3 * index + 4]
        if title in TITLES.values():
            yield title, version, heading, body


def _section(suite: str, results: list[Result]) -> Iterator[str]:
    run = [result for result in results if result.tests]
    tests = sum(result.tests for result in run)
    found = sum(len(result.expected) + len(result.surprises) for result in run)
    yield f"{len(run)} programs, {tests} tests, **{found} differences**{_tree()}.\n"
    yield "| program | tests | differences | reason |"
    yield "|---|---:|---:|---|"
    same = []
    for result in results:
        reasons = Counter([difference.reason for difference in result.expected])
        reasons.update(["not expected"] * len(result.surprises))
        if suite == "library" and result.tests and not reasons and not result.note:
            same.append(f"{result.case.name} ({result.tests})")
            continue
        why = [f"{reason} ({count})" if count > 1 else reason for reason, count in reasons.items()]
        why += [result.note] if result.note not in ("", "same") else []
        numbers = (result.tests, sum(reasons.values())) if result.tests else ("", "")
        yield f"| {result.case.name} | {numbers[0]} | {numbers[1]} | {'; '.join(why)} |"
    if same:
        yield f"\nWithout a difference: {', '.join(same)}."
    for reason, names in table(suite).get("left_out", {}).items():
        yield f"\nLeft out, as {reason}: {', '.join(names)}."


def _tree() -> str:
    """Which commit of the package was compared, as far as anybody knows."""
    command = ["git", "-C", str(ROOT), "log", "-1", "--format=%h", "--abbrev=7", "--", PACKAGE]
    try:
        commit = subprocess.run(command, capture_output=True, text=True).stdout.strip()
    except OSError:
        commit = ""
    return f" (`{PACKAGE}` of commit {commit})" if commit else ""


TITLES = {
    "programs": "Programs of the standard library, all of which is instrumented",
    "library": "CPython's tests, the whole standard library instrumented",
    "numbers": "CPython's numeric tests, themselves instrumented",
    "extensions": "Programs that call extensions with literals",
    "packages": "Packages from PyPI, each instrumented as a whole, and their own tests",
    "ros": "The ROS 2 examples and demos",
}
