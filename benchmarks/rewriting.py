"""What it costs to get rewritten code: ``python -m benchmarks.rewriting``.

cold   rewriting a module, beyond parsing and compiling it, which plain Python has to do as well
warm   getting its code from the cache, beyond getting the plain code from Python's own cache

Both in ms per 1 000 lines, over modules of the standard library.
"""

from __future__ import annotations

import ast
import importlib.util
import os
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from pathlib import Path

from benchmarks.common import machine, print_table
from benchmarks.literals import MODULES

_ROUNDS = 3


def _best(action: Callable[[], object]) -> float:
    times = []
    for _ in range(_ROUNDS):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return min(times)


def measure(name: str, path: str, source: bytes) -> list[float]:
    """Lines, and seconds: plain and instrumented, cold and then warm."""
    from rosslt_auto.instrument import hook
    from rosslt_auto.instrument.weaving import weave

    def plainly() -> object:
        return compile(ast.parse(source, path), path, "exec", dont_inherit=True)

    loader = SourceFileLoader(name, path)
    cold = [_best(plainly), _best(lambda: weave(name, path, source))]
    loader.get_code(name)  # fills the caches
    hook.instrumented_code(name, path, source)

    def plain_again() -> object:
        return loader.get_code(name)

    def instrumented_again() -> object:
        return hook.instrumented_code(name, path, loader.get_data(path))

    return [source.count(b"\n"), *cold, _best(plain_again), _best(instrumented_again)]


def main() -> None:
    """Prints the table."""
    started = time.perf_counter()
    totals = [0.0] * 5
    with tempfile.TemporaryDirectory() as folder:
        sys.pycache_prefix, sys.dont_write_bytecode = folder, False
        for module in MODULES:
            spec = importlib.util.find_spec(module)
            assert spec is not None
            if spec.origin is None or os.path.basename(spec.origin) == "__init__.py":
                continue
            found = measure(module, spec.origin, Path(spec.origin).read_bytes())
            totals = [total + value for total, value in zip(totals, found, strict=True)]
    lines, *seconds = totals
    rows = []
    for how, plain, instrumented in (("cold", *seconds[:2]), ("warm", *seconds[2:])):
        costs = [1e6 * value / lines for value in (plain, instrumented, instrumented - plain)]
        rows.append([how, *(f"{cost:.2f}" for cost in costs)])
    print(machine(), f"- best times in ms per 1 000 lines, over {lines:.0f} lines")
    print_table("rewriting", ["", "plain", "instrumented", "more"], rows)
    print(f"{time.perf_counter() - started:.0f} s")


if __name__ == "__main__":
    main()
