"""Histories without end: ``python -m benchmarks.histories [STEPS]`` (10 million by default).

Whether time per step and memory stay flat (design 3.4) for an integrator, a low-pass filter and
a random walk of mixed operations, each beside plain Python.
"""

from __future__ import annotations

import gc
import random
import resource
import sys
import time
from collections.abc import Callable
from typing import Any

from benchmarks.common import machine, print_table
from rosslt_auto.provenance import Source, untracked
from rosslt_auto.provenance.values import leaf

PARTS = 10


def number(name: str, value: float) -> Any:
    return leaf(Source("/node", name, "float"), value)


def integrator(state: list[Any], dt: Any, a: Any, steps: int) -> None:
    x = state[0]
    for _ in range(steps):
        x += dt
    state[0] = x


def low_pass(state: list[Any], dt: Any, a: Any, steps: int) -> None:
    y = state[0]
    for i in range(steps):
        y = a * (i % 7) + (1 - a) * y
    state[0] = y


def walk(state: list[Any], dt: Any, a: Any, steps: int) -> None:
    choose = random.Random(1)
    x, y, z = state
    for _ in range(steps):
        kind = choose.random()
        if kind < 0.4:
            x, y, z = y + dt, z, x * 0.5
        elif kind < 0.7:
            y = (x * a + y) % 9.0
        else:
            z = abs(y - z) / 3
    state[:] = x, y, z


def memory() -> float:
    """Megabytes in use now."""
    try:
        with open("/proc/self/statm", encoding="ascii") as statistics:
            return int(statistics.read().split()[1]) * resource.getpagesize() / 1e6
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def measure(program: Callable[..., None], steps: int) -> list[str]:
    """Runs a program in parts; the first one is the warm-up that the others are compared with."""
    plain, found = [0.5, 1.5, 2.5], [number(f"x{i}", i + 0.5) for i in range(3)]
    part = steps // PARTS
    times, plain_times, sizes = [], [], []
    for _ in range(PARTS):
        start = time.perf_counter()
        program(found, number("dt", 0.01), number("a", 0.1), part)
        middle = time.perf_counter()
        program(plain, 0.01, 0.1, part)
        plain_times.append((time.perf_counter() - middle) / part)
        times.append((middle - start) / part)
        gc.collect()
        sizes.append(memory())
    same = [float.hex(untracked(value)) for value in found] == [float.hex(v) for v in plain]
    return [
        program.__name__,
        f"{min(plain_times) * 1e6:.3f}",
        f"{min(times) * 1e6:.2f}",
        f"{times[0] * 1e6:.2f}",
        f"{times[-1] * 1e6:.2f}",
        f"{sizes[0]:.1f}",
        f"{max(sizes[1:]) - sizes[0]:+.1f}",
        "yes" if same else "NO",
    ]


COLUMNS = ["", "plain µs", "µs/step", "first tenth", "last tenth", "MB", "MB more", "same value"]


def main(steps: int = 10_000_000) -> None:
    """Prints the table for `steps` steps of the integrator, a fifth of it for the others."""
    print(machine())
    rows = [measure(program, steps if program is integrator else steps // 5)
            for program in (integrator, low_pass, walk)]  # fmt: skip
    print_table(f"{steps} steps", COLUMNS, rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
