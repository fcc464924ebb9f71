"""What it takes to invert several targets at once: ``python -m benchmarks.solving``.

Three fields of a pose, computed from six sources that they share, as ``force TOPIC x=1 y=2 z=3``
has to solve them. The expressions have come over the wire, as they do for `force`.
"""

from __future__ import annotations

import math
import time
from typing import Any

from benchmarks.common import machine, print_table
from rosslt_auto.instrument import calls
from rosslt_auto.provenance.inversion import POLICIES, invert_many
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.values import leaf
from rosslt_auto.ros.encoding import Encoder
from rosslt_auto.ros.header import decode

GOAL = 2.0
"""Milliseconds."""

NAMES = {"x": 1.5, "y": -0.5, "z": 0.8, "scale": 1.2, "angle": 0.3, "height": 2.0}


def affine(x: Any, y: Any, z: Any, scale: Any, angle: Any, height: Any) -> list[Any]:
    """Offsets and a scale."""
    return [x * scale + angle, y * scale - x / 2.0, z + height * 0.5]


def rotated(x: Any, y: Any, z: Any, scale: Any, angle: Any, height: Any) -> list[Any]:
    """A turned and scaled point."""
    cos, sin = calls.call_1(math.cos, angle), calls.call_1(math.sin, angle)
    return [scale * (x * cos - y * sin), scale * (x * sin + y * cos), z * scale + height]


def aliased(x: Any, y: Any, z: Any, scale: Any, angle: Any, height: Any) -> list[Any]:
    """Squares and products, for which one step of Newton is not enough."""
    return [x * x * scale, y * y * x + angle, z * z * height + y]


def received(compute: Any) -> list[Any]:
    """The three fields as another process knows them."""
    sources = [
        leaf(Source("/node", name, "float", hint=name), value) for name, value in NAMES.items()
    ]
    fields = list(zip("abc", compute(*sources), strict=True))
    payload, _ = Encoder(lambda source: None).encode(0, 1, fields)
    return list(decode(payload).fields().values())


def measure(compute: Any, policy: str, runs: int = 200) -> list[str]:
    """A row: the kind of expressions, the policy, median and best time in milliseconds."""
    times = []
    for i in range(runs):
        values = received(compute)
        targets = [(value, float(value) + 0.01 + 0.001 * i) for value in values]
        start = time.perf_counter()
        invert_many(targets, policy)
        times.append((time.perf_counter() - start) * 1e3)
    times.sort()
    return [compute.__name__, policy, f"{times[runs // 2]:.2f}", f"{times[0]:.2f}", f"{GOAL:g}"]


def main() -> None:
    """Prints the table."""
    print(machine())
    rows = [
        measure(compute, policy) for compute in (affine, rotated, aliased) for policy in POLICIES
    ]
    print_table("three targets, six sources", ["fields", "policy", "ms", "best ms", "goal"], rows)


if __name__ == "__main__":
    main()
