"""Programs that never end, for `histories`: plain classes whose ``run`` goes on from where it was.

All that may be changed is a constant of the module, so that a plain copy of the module can be run
with a changed one.
"""

import math
import random

START = 10.0
SPEED = 0.25
DT = 0.01
WEIGHT = 0.05
WORD = "ab"
OTHER = "c"
PULL = 0.3
PUSH = 0.7
HEAT = 20.0


class Integrator:
    """``self.x += v * dt``"""

    def __init__(self, receive):
        self.x = START

    def run(self, steps):
        for _ in range(steps):
            self.x += SPEED * DT
        return self.x


class Text:
    """A text that grows and is cut."""

    def __init__(self, receive):
        self.text = ""

    def run(self, steps):
        for i in range(steps):
            self.text += OTHER if i % 3 else WORD
            if len(self.text) > 60:
                self.text = self.text[-40:]
        return self.text


class Filter:
    """A low-pass filter over received numbers."""

    def __init__(self, receive):
        self.receive = receive
        self.y = START

    def run(self, steps):
        for _ in range(steps):
            x = self.receive()
            self.y = WEIGHT * x + (1 - WEIGHT) * self.y
        return self.y


class Walk:
    """Mixed operations on values that depend on each other."""

    def __init__(self, receive):
        self.choose = random.Random(1)
        self.values = [START, SPEED, PULL, PUSH]

    def run(self, steps):
        values = self.values
        for _ in range(steps):
            i, j = self.choose.randrange(4), self.choose.randrange(4)
            kind = self.choose.randrange(6)
            if kind == 0:
                values[i] = values[i] * PULL + values[j] * PUSH
            elif kind == 1:
                values[i] = values[i] - values[j] / 3
            elif kind == 2:
                values[i] = math.sin(values[i]) + SPEED
            elif kind == 3:
                values[i] = (values[i] * values[j]) % 7.0
            elif kind == 4:
                values[i] = max(-abs(values[i]), -9.0)
            else:
                values[i] = min(values[i] + DT, values[j])
        return sum(values)


class Cells:
    """Heat on a ring: a thousand values, every one soon depends on every other."""

    COUNT = 1000

    def __init__(self, receive):
        self.cells = [HEAT + i for i in range(self.COUNT)]

    def run(self, steps):
        count = self.COUNT
        for _ in range(max(steps // count, 1)):
            old = self.cells
            self.cells = [(old[i - 1] + old[i] + old[(i + 1) % count]) / 3.0 for i in range(count)]
        return self.cells[0]


class Window:
    """The mean over the latest thousand of a value that goes on and on."""

    def __init__(self, receive):
        self.x = START
        self.window = []

    def run(self, steps):
        for i in range(steps):
            self.x = self.x + DT
            self.window.append(self.x)
            if len(self.window) > 1000:
                self.window.pop(0)
            if not i % 100:
                self.mean = sum(self.window) / len(self.window)
        return self.mean
