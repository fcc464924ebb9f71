"""Arrays with provenance on this machine: ``python -m benchmarks.arrays``.

The main case is a 4x4 transform of a 3-vector of tracked numbers, making of the vector included,
as instrumented code does it; the other rows are its parts and neighbours. "plain" is the same line
in plain numpy, measured in turns with it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.common import machine, measure_together, print_table
from rosslt_auto.provenance import Source, arrays, sequences
from rosslt_auto.provenance.values import leaf

GOAL = 25.0
"""Microseconds above plain for the transform."""


def tracked_version(function: Any) -> Callable[..., Any]:
    """What instrumented code calls in place of a function of numpy."""
    return arrays.ADVICE[id(function)]


def cases() -> list[tuple[str, Callable[[], object], Callable[[], object]]]:
    """What is measured: a text, the plain and the tracked version."""
    named = zip("xyz", (1.5, 2.5, -0.5), strict=True)
    x, y, z = (leaf(Source("/node", name, "float"), value) for name, value in named)
    make, plain = tracked_version(np.array), [1.5, 2.5, -0.5]
    transform = np.eye(4)
    transform[:3, 3] = 1.0, 2.0, 3.0
    vector, plain_vector = make([x, y, z]), np.array(plain)
    position, plain_position = make([x, y, z, 1.0]), np.array([*plain, 1.0])
    norm = tracked_version(np.linalg.norm)
    buffer = sequences.array.array("d", plain)
    return [
        (
            "4x4 transform of a 3-vector, vector made",
            lambda: transform @ np.array([1.5, 2.5, -0.5, 1.0]),
            lambda: transform @ make([x, y, z, 1.0]),
        ),
        ("making the vector", lambda: np.array(plain), lambda: make([x, y, z])),
        ("transform @ vector", lambda: transform @ plain_position, lambda: transform @ position),
        ("vector * 2.0 + vector", lambda: plain_vector * 2.0 + plain_vector,
         lambda: vector * 2.0 + vector),
        ("vector[1]", lambda: plain_vector[1], lambda: vector[1]),
        ("vector[:2]", lambda: plain_vector[:2], lambda: vector[:2]),
        ("norm(vector)", lambda: np.linalg.norm(plain_vector), lambda: norm(vector)),
        ("np.cross", lambda: np.cross(plain_vector, plain_vector),
         lambda: np.cross(vector, vector)),
        ("transform, all four expressions asked for", lambda: (transform @ plain_position).tolist(),
         lambda: arrays.elements(transform @ position)),
        ("nothing tracked: array of 3", lambda: np.array(plain), lambda: make(plain)),
        ("float64[] field, 3 elements", lambda: sequences.shadow("d", buffer, plain),
         lambda: sequences.shadow("d", buffer, [x, y, z])),
    ]  # fmt: skip


def main(seconds: float = 1.0) -> None:
    """Prints the table; `seconds` for each row."""
    arrays.install()
    print(f"{machine()}, numpy {np.__version__} - medians, and the best of the same run")
    rows = []
    for text, plain, tracked in cases():
        a, b = measure_together([plain, tracked], seconds)
        above = (b.median - a.median) * 1e6
        rows.append([
            text, f"{a.median * 1e6:.2f}", f"{b.median * 1e6:.2f}", f"{above:.2f}",
            f"{(b.minimum - a.minimum) * 1e6:.2f}", "" if rows else f"{GOAL:.0f}",
        ])  # fmt: skip
    print_table(
        "numpy", ["", "plain µs", "tracked µs", "above plain µs", "best above µs", "goal µs"], rows
    )


if __name__ == "__main__":
    main()
