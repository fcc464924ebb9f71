"""What instrumentation costs where nothing is tracked: ``python -m benchmarks.untracked``.

Ten programs (`kernels`) run plain, instrumented with inputs from a plain module, and instrumented
with inputs that are tracked, all of them. In the second case nothing is to be paid, save where a
function is called that could get a tracked value (`math.sin`, `sum`).
"""

from __future__ import annotations

import copy
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.common import machine, measure_together, print_table

HERE = Path(__file__).parent
KERNELS = (
    "nbody", "spectral_norm", "fannkuch", "mandelbrot", "text", "parse", "sort", "multiply",
    "sieve", "integrate",
)  # fmt: skip
_SECONDS = 1.0


def load(name: str, instrumented: bool) -> dict[str, Any]:
    """The namespace of a module of this folder."""
    from rosslt_auto.instrument import hook

    path = HERE / f"{name}.py"
    if instrumented:
        code = hook.instrumented_code(name, str(path), path.read_bytes(), cached=False)
    else:
        code = compile(path.read_bytes(), str(path), "exec", dont_inherit=True)
    namespace = {"__name__": name}
    exec(code, namespace)
    return namespace


def actions(kernel: str, modules: list[tuple[dict, dict]]) -> list[Callable[[], object]]:
    """Calls of a kernel, for each pair of modules with kernels and inputs; some change inputs."""

    def action(kernels: dict, inputs: dict) -> Callable[[], object]:
        function, arguments = kernels[kernel], inputs[kernel]()
        if kernel == "nbody":
            return lambda: function(copy.deepcopy(arguments[0]), *arguments[1:])
        return lambda: function(*arguments)

    return [action(*pair) for pair in modules]


def measure(kernel: str, modules: list[tuple[dict, dict]]) -> list[float]:
    """Seconds of a kernel for each pair of modules, the best of many in turns."""
    calls = actions(kernel, modules)
    first = calls[0]()
    if not all(call() == first for call in calls[1:]):
        raise AssertionError(f"{kernel} does not compute the same")
    untracked = [timing.minimum for timing in measure_together(calls[:2], _SECONDS)]
    return [*untracked, measure_together(calls[2:], 0.5, 5)[0].minimum]


def main() -> None:
    """Prints the table."""
    started = time.perf_counter()
    plain, tracked = load("kernels", False), load("kernels", True)
    inputs, tracked_inputs = load("kernel_inputs", False), load("kernel_inputs", True)
    modules = [(plain, inputs), (tracked, inputs), (tracked, tracked_inputs)]
    rows, ratios = [], []
    for kernel in KERNELS:
        times = measure(kernel, modules)
        ratios.append([times[1] / times[0], times[2] / times[0]])
        rows.append([kernel, f"{times[0] * 1e3:.2f}", *(f"{ratio:.2f}" for ratio in ratios[-1])])
    means = [statistics.geometric_mean(column) for column in zip(*ratios, strict=True)]
    rows.append(["geometric mean", "", *(f"{mean:.2f}" for mean in means)])
    print(machine(), "- best times in ms, and ratios to plain")
    print_table("programs", ["", "plain", "untracked inputs", "tracked inputs"], rows)
    print(f"{time.perf_counter() - started:.0f} s")


if __name__ == "__main__":
    main()
