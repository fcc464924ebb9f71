"""What all measurements share: timing, and tables with or without rich."""

from __future__ import annotations

import platform
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple


class Timing(NamedTuple):
    """Seconds of one call: the median says what to expect, the minimum is what can be compared
    on a machine that has other things to do."""

    median: float
    minimum: float


def measure_together(
    actions: Sequence[Callable[[], object]], seconds: float = 1.0, at_least: int = 15
) -> list[Timing]:
    """Times of several actions, measured in turns so that a busy moment hits all of them.

    seconds  how long to go on for all of them together, `at_least` so many rounds
    """
    inner = [_repetitions(action) for action in actions]
    samples: list[list[float]] = [[] for _ in actions]
    deadline = time.perf_counter() + seconds
    while len(samples[0]) < at_least or time.perf_counter() < deadline:
        for action, count, found in zip(actions, inner, samples, strict=True):
            start = time.perf_counter()
            for _ in range(count):
                action()
            found.append((time.perf_counter() - start) / count)
    return [Timing(statistics.median(found), min(found)) for found in samples]


def _repetitions(action: Callable[[], object], enough: float = 5e-4) -> int:
    """How often to repeat an action so that the clock's own cost does not show."""
    count = 1
    while True:
        start = time.perf_counter()
        for _ in range(count):
            action()
        if time.perf_counter() - start >= enough:
            return count
        count *= 2


def machine() -> str:
    """A line about where this was measured."""
    return f"Python {platform.python_version()}, {platform.machine()}, {_processor()}"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown processor"


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A table for people; the first column is text, the others are numbers."""
    try:
        from rich.console import Console
        from rich.table import Table
    except ImportError:
        _print_plain(title, columns, rows)
        return
    table = Table(title=title, title_justify="left")
    for index, column in enumerate(columns):
        table.add_column(column, justify="right" if index else "left")
    for row in rows:
        table.add_row(*row)
    Console(width=None if sys.stdout.isatty() else 110).print(table)


def _print_plain(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, cells)) for cells in zip(columns, *rows, strict=True)]
    print(title)
    for cells in (columns, ["-" * width for width in widths], *rows):
        first, *others = zip(cells, widths, strict=True)
        print("  ".join([first[0].ljust(first[1]), *(c.rjust(w) for c, w in others)]))
    print()
