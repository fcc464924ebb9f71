"""Numbers: what is tracked, by which name, and what stays as it is."""

from __future__ import annotations

import enum

RATE = 50
LIMITS = [-1.5, +2, 1e3, 0.1 + 0.2j, True, None, 10**400]
GAINS = {"slow": 0.5, 3: (0.1, 0.2)}
x = y = 0.25
a, b = 1, 2.0
__version__ = 3


class Mode(enum.IntEnum):
    OFF = 0
    ON = 1

    def next(self, step=1):
        return Mode(self.value + step)


def step(state: int, gain=0.5, *, limit: float = 3.0) -> float:
    if state > 10 or state in (1, 2):
        return -1.0
    while state:
        state -= 1
        total = [0.0] * 36
        total[2] = sum(v * 2.0 for v in total[1:5] if v < 3)
    match state:
        case 0:
            gain *= 1.5
    key = lambda v: v + 0.5
    assert limit == 3.0, 1.0
    return round(key(gain), 2) + (yield 4)
