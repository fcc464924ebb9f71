"""Histories without end: ``python -m benchmarks.histories [STEPS] [PROGRAM...]``.

Runs the programs of `endless`, instrumented by the import hook (the integrator ten million steps
unless told otherwise, the others a tenth of it), and prints for each tenth of the run what should
stay flat (design 3.4): memory, time per step, nodes of the expression, bytes of its header. Then it
inverts the last value and runs the plain program with the answer.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import importlib.util
import math
import os
import resource
import sys
import time
from collections.abc import Iterator
from typing import Any

from benchmarks.common import machine, print_table
from rosslt_auto.instrument import hook
from rosslt_auto.instrument.selection import Selection
from rosslt_auto.provenance import NotInvertible, Source, provenance, untracked
from rosslt_auto.provenance.expressions import topological
from rosslt_auto.provenance.registry import count_executions
from rosslt_auto.provenance.values import leaf
from rosslt_auto.ros.encoding import Encoder
from rosslt_auto.ros.header import decode

PROGRAMS = {
    "Integrator": ("START", "DT"),
    "Text": ("WORD",),
    "Filter": ("gain", "WEIGHT"),
    "Walk": ("SPEED",),
    "Cells": ("HEAT",),
    "Window": ("START", "DT"),
}
"""The classes of `endless`, and the sources that the end value is inverted for."""

MODULE = "benchmarks.endless"
PARTS = 10
CHUNKS = 20
GAIN = 2.0


class Receiver:
    """Measurements that come in headers, ``gain * i``, or plain ones."""

    def __init__(self, gain: float, tracked: bool) -> None:
        self.gain = leaf(Source("/sensor", "gain", "float", hint="gain"), gain) if tracked else gain
        self.encoder = Encoder(lambda source: None) if tracked else None
        self.count = 0

    def __call__(self) -> Any:
        self.count += 1
        value = self.gain * (self.count % 7)
        if self.encoder is None:
            return value
        payload, _ = self.encoder.encode(0, self.count, [("data", value)])
        return decode(payload).fields()["data"]


@contextlib.contextmanager
def instrumented() -> Iterator[Any]:
    """The module of the programs, instrumented as `run` does it."""
    selection = Selection(patterns=(MODULE,))
    hook.install(selection)
    count_executions()
    try:
        yield importlib.import_module(MODULE)
    finally:
        hook.uninstall()


def plain(**constants: Any) -> Any:
    """A copy of the module that nobody has instrumented, with other values of its constants."""
    spec = importlib.util.find_spec(MODULE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    vars(module).update(constants)
    return module


def memory() -> float:
    """Megabytes in use now."""
    gc.collect()
    try:
        with open("/proc/self/statm", encoding="ascii") as statistics:
            return int(statistics.read().split()[1]) * resource.getpagesize() / 1e6
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def header_size(value: Any) -> int:
    """Of a message with the value in it, if one were published."""
    encoder = Encoder(lambda source: None)
    encoder.fold(value)
    return len(encoder.encode(0, 1, [("data", value)])[0])


def measure(module: Any, name: str, steps: int) -> Any:
    """Runs a program in parts, prints the table of them, and gives the last value."""
    program = getattr(module, name)(Receiver(GAIN, tracked=True))
    rows: list[list[str]] = []
    first_memory = first_time = 0.0
    chunk = steps // (PARTS * CHUNKS)
    value: Any = None
    for part in range(PARTS):
        times, nodes, sizes = [], [], []
        for _ in range(CHUNKS):
            start = time.process_time()
            value = program.run(chunk)
            times.append((time.process_time() - start) / chunk)
            nodes.append(len(topological([value])))
            sizes.append(header_size(value))
        best, used = min(times), memory()
        if not part:
            first_memory, first_time = used, best
        rows.append([
            f"{(part + 1) * chunk * CHUNKS}", f"{used - first_memory:+.2f}",
            f"{best * 1e6:.2f}", f"{best / first_time:.2f}", f"{max(nodes)}", f"{max(sizes)}",
        ])  # fmt: skip
    columns = ["steps", "MB more", "µs/step", "of first", "nodes at most", "bytes at most"]
    print_table(name, columns, rows)
    return value


def answers(name: str, value: Any, steps: int) -> list[str]:
    """What inverting for each source comes to, and whether the program agrees."""
    found = []
    marks = {node._op.name for node in topological([value])}
    kind = "approximate (first order)" if "linear" in marks else "exact"
    for hint in PROGRAMS[name]:
        sources = [s for s in provenance(value).sources if s.parameter.split(".")[-1] == hint]
        if not sources:
            found.append(f"{hint}: no source any more")
            continue
        target = _target(untracked(value))
        try:
            [answer] = (
                provenance(value).invert(target, source=sources[0].parameter).changes.values()
            )
        except NotInvertible as refusal:
            found.append(f"{hint}: {kind}, refused: {str(refusal)[:150]}")
            continue
        if hint == "gain":
            module, receiver = plain(), Receiver(answer, tracked=False)
        else:
            module, receiver = plain(**{hint: answer}), Receiver(GAIN, tracked=False)
        got = _rerun(getattr(module, name)(receiver), steps)
        found.append(f"{hint} = {answer!r} for {target!r}: {kind}, the program gives {got!r}: "
                     f"{'right' if _close(got, target) else 'off'}")  # fmt: skip
    return found


def _target(value: Any) -> Any:
    return value * 1.001 if isinstance(value, float) else value.replace("ab", "xy")


def _close(got: Any, target: Any) -> bool:
    return got == target or (type(got) is float and math.isclose(got, target, rel_tol=1e-6))


def _rerun(program: Any, steps: int) -> Any:
    for _ in range(PARTS * CHUNKS):
        value = program.run(steps // (PARTS * CHUNKS))
    return value


def main(steps: int = 10_000_000, *names: str) -> None:
    """Prints the tables for `steps` steps of the integrator, a tenth of it for the others."""
    print(machine(), f"process {os.getpid()}", flush=True)
    for name in names or PROGRAMS:
        with instrumented() as module:
            count = steps if name == "Integrator" or names else steps // 10
            value = measure(module, name, count)
        start = time.process_time()
        same = repr(_rerun(getattr(plain(), name)(Receiver(GAIN, False)), count))
        seconds = time.process_time() - start
        print(f"plain: {seconds / count * 1e6:.2f} µs/step, same value: "
              f"{repr(untracked(value)) == same}")  # fmt: skip
        print(*answers(name, value, count), sep="\n", flush=True)


if __name__ == "__main__":
    given = sys.argv[1:]
    main(*map(int, given[:1]), *given[1:])
