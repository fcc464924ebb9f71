"""Compares the programs of the suites, prints a line for each, and writes the report."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatchcase
from pathlib import Path

from transparency import reporting
from transparency.comparing import Result, compare
from transparency.suites import SHORT, SUITES, Case, cases


def main() -> int:
    parser = argparse.ArgumentParser(prog="transparency", description=__doc__)
    parser.add_argument(
        "programs", nargs="*", metavar="SUITE[:PROGRAM]",
        help=f"patterns; of the suites {', '.join(SUITES)}; all; default: {', '.join(SHORT)}",
    )  # fmt: skip
    parser.add_argument("-j", "--jobs", type=int, default=2, help="how many at a time")
    parser.add_argument("--tries", type=int, default=3, help="how often a difference must show")
    parser.add_argument("--report", type=Path, help="the Markdown file to write")
    parser.add_argument("--checkout", type=Path, help="the folder with ROS's examples and demos")
    parser.add_argument("--details", action="store_true", help="what differs, not only how often")
    arguments = parser.parse_args()
    asked = patterns(arguments.programs)
    results: list[Result] = []

    def add(result: Result) -> None:
        results.append(result)
        print(*reporting.lines(result, arguments.details), sep="\n", flush=True)

    with ThreadPoolExecutor(arguments.jobs) as pool:
        for result in pool.map(lambda case: compare(case, arguments.tries), chosen(asked)):
            add(result)
    if "ros" in asked:
        from transparency import ros

        for result in ros.results(arguments.checkout, arguments.jobs):
            add(result)
    print(reporting.summary(results))
    if arguments.report and not any(":" in pattern for pattern in asked):
        reporting.write(arguments.report, results)  # which is about whole suites
    return 1 if any(result.failed for result in results) else 0


def patterns(words: list[str]) -> list[str]:
    """What the words of the command line ask for: without any, `SHORT`; "all" is every suite."""
    return list(SUITES) if "all" in words else words or list(SHORT)


def chosen(asked: list[str]) -> list[Case]:
    """The cases whose title matches one of the patterns."""
    return [
        case
        for suite in SUITES
        if any(fnmatchcase(suite, pattern.partition(":")[0]) for pattern in asked)
        for case in cases(suite)
        if any(fnmatchcase(case.title, p if ":" in p else f"{p}:*") for p in asked)
    ]


if __name__ == "__main__":
    sys.exit(main())
