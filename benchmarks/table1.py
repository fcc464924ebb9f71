"""Table I of the paper on this machine: ``python -m benchmarks.table1``.

Random binary operations on one value, as in the paper's benchmark: the value starts at 10, the
other operands are random integers from 1 to 10.

tracking  the operations applied to a tracked value, provenance recorded
reapply   the recorded operations applied to another value of the source
reverse   from a wanted result back to the source, and the operations applied to what was found

Plain Python computes the same beside it in the same run.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from benchmarks.common import Timing, machine, measure_together, print_table
from rosslt_auto.provenance import Source, provenance
from rosslt_auto.provenance.values import leaf

LENGTHS = (10, 50, 200, 1000)
PAPER = {"tracking": 90.5, "reapply": 21.5, "reverse": 81.2}
"""Table I: microseconds for 50 operations in C++ (Core i5, 2.3 GHz)."""


def random_program(symbols: str, length: int, seed: int = 1) -> Callable[[Any], Any]:
    """A function of one argument that applies `length` random operations to it."""
    choose = random.Random(seed)
    lines = ["def program(x):"]
    for _ in range(length):
        lines.append(f"    x = x {choose.choice(symbols)} {choose.randint(1, 10)}")
    lines.append("    return x")
    namespace: dict[str, Any] = {}
    exec("\n".join(lines), namespace)
    return namespace["program"]


def measure(symbols: str, start: Any, length: int, seconds: float) -> dict[str, Timing]:
    """Times of a whole program in seconds, by what is done."""
    program = random_program(symbols, length)
    other = start - 1
    source = Source("/node", "start", type(start).__name__)
    value = leaf(source, start)
    found = provenance(program(value))
    assert found is not None
    wanted = program(other)
    assert found.evaluate({source: other}) == wanted
    assert found.invert(wanted).exact
    actions = {
        "plain": lambda: program(start),
        "tracking": lambda: program(value),
        "reapply": lambda: found.evaluate({source: other}),
        "reverse": lambda: found.invert(wanted),
    }
    return dict(zip(actions, measure_together(list(actions.values()), seconds), strict=True))


def rows(symbols: str, start: Any, seconds: float) -> list[list[str]]:
    """The table's rows for one kind of value."""
    found = []
    for length in LENGTHS:
        times = measure(symbols, start, length, seconds)
        for name, timing in times.items():
            paper = PAPER.get(name) if length == 50 else None
            found.append([
                f"{name}, {length} operations",
                f"{timing.median * 1e6:.1f}",
                f"{timing.median * 1e6 / length:.3f}",
                f"{timing.minimum * 1e6 / length:.3f}",
                f"{timing.minimum / times['plain'].minimum:.1f}",
                f"{paper:.1f}" if paper else "",
                f"{paper / length:.2f}" if paper else "",
            ])  # fmt: skip
    return found


COLUMNS = ["", "µs", "µs/op", "best µs/op", "ratio to plain", "paper µs", "paper µs/op"]


def main(seconds: float = 1.0) -> None:
    """Prints the tables; `seconds` for each length."""
    print(machine(), "- medians, and the best of the same run")
    print_table("float, random + - * /", COLUMNS, rows("+-*/", 10.0, seconds))
    print_table("int, random + - *", COLUMNS, rows("+-*", 10, seconds))


if __name__ == "__main__":
    main()
