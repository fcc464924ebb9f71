"""What a literal and an import cost: ``python -m benchmarks.literals``.

literal  a number in instrumented code is a look-up in a list; beside it the plain constant
operand  an int on the right of an operator, whose left operand has operators written in Python
import   modules of the standard library, copied, imported in new interpreters through a warm
         cache: plainly, and with their literals rewritten
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.common import machine, measure_together, print_table

MODULES = (
    "argparse", "ast", "calendar", "configparser", "csv", "datetime", "decimal", "difflib",
    "fractions", "heapq", "inspect", "optparse", "pickle", "plistlib", "random", "statistics",
    "textwrap", "typing", "uuid", "zipfile",
)  # fmt: skip
"""As a program's own modules would be; those that one file holds are copied."""

LITERALS = 50
_SETTLE = 25_000
"""Executions after which a table no longer counts them."""


LITERAL = "def function():\n" + "    x = 0.5\n" * LITERALS
"""A function that does nothing but use literals."""

OPERAND = """
class Other:
    def __mul__(self, other): return self
def function(x=Other()):
""" + "    y = x * 2\n" * LITERALS  # fmt: skip


def measure_literals(folder: Path, name: str, source: str) -> list[str]:
    """The row that compares a program's `function` with a plain one."""
    from rosslt_auto.instrument import hook

    path = folder / "literals.py"
    path.write_text(source)
    namespaces: list[dict[str, Any]] = [{"__name__": "plain"}, {"__name__": "instrumented"}]
    exec(compile(source, str(path), "exec"), namespaces[0])
    code = hook.instrumented_code("instrumented", str(path), path.read_bytes(), cached=False)
    exec(code, namespaces[1])
    plain, tracked = namespaces[0]["function"], namespaces[1]["function"]
    for _ in range(_SETTLE // LITERALS):
        tracked()
    times = measure_together([plain, tracked])
    best = [timing.minimum / LITERALS * 1e9 for timing in times]
    medians = [timing.median / LITERALS * 1e9 for timing in times]
    return _row(name, medians, best)


def _row(name: str, medians: list[float], best: list[float]) -> list[str]:
    return [
        name, f"{medians[0]:.1f}", f"{medians[1]:.1f}", f"{medians[1] / medians[0]:.2f}",
        f"{best[1] / best[0]:.2f}",
    ]  # fmt: skip


_IMPORT = """
import sys, time
sys.path.insert(0, sys.argv[1])
from rosslt_auto.instrument import hook
from rosslt_auto.instrument.selection import Selection
import rosslt_auto.provenance.refresh  # what instrumented code needs, loaded in both cases
if sys.argv[2] == "instrumented":
    hook.install(Selection(folder=sys.argv[1]))
start = time.perf_counter()
for name in sys.argv[3:]:
    __import__(name)
print(time.perf_counter() - start)
"""


def measure_imports(folder: Path, rounds: int = 11) -> list[str]:
    """The row that compares importing the same modules in new interpreters."""
    names = []
    for name in MODULES:
        origin = Path(os.__file__).with_name(f"{name}.py")
        if origin.exists():
            names.append(f"own_{name}")
            shutil.copy(origin, folder / f"own_{name}.py")

    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    for name in ("PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX"):  # there has to be a cache
        environment.pop(name, None)

    def seconds(how: str) -> float:
        command = [sys.executable, "-c", _IMPORT, str(folder), how, *names]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
        return float(done.stdout)

    found: dict[str, list[float]] = {"plain": [], "instrumented": []}
    for how in found:  # fills the caches
        seconds(how)
    for _ in range(rounds):
        for how, times in found.items():
            times.append(seconds(how) * 1e3)
    return _row(
        f"importing {len(names)} modules, ms",
        [statistics.median(times) for times in found.values()],
        [min(times) for times in found.values()],
    )


def main() -> None:
    """Prints the table."""
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        rows = [
            measure_literals(Path(folder), "a literal, ns", LITERAL),
            measure_literals(Path(folder), "an int operand of something else, ns", OPERAND),
            measure_imports(Path(folder)),
        ]
    print(machine(), "- medians, and the ratio of the best")
    print_table("literals", ["", "plain", "instrumented", "ratio", "ratio of best"], rows)
    print(f"{time.perf_counter() - started:.0f} s")


if __name__ == "__main__":
    main()
