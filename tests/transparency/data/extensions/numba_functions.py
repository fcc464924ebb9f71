"""Functions that numba compiles: literals, constants of the module, closures, generators."""

import numpy as np
from numba import cfunc, guvectorize, njit, stencil, vectorize

SPEED = 0.5
COUNT = 3
TABLE = (0.5, 1.5, 2.5)


@njit
def helper(x):
    return x * SPEED + COUNT + TABLE[1]


@njit(fastmath=True)
def outer(values, gain=2.5):
    def inner(value):
        return value * gain + 0.25

    total = 0.0
    for index in range(values.shape[0]):
        total += inner(helper(values[index]))
    return total


@guvectorize(["void(float64[:], float64, float64[:])"], "(n),()->(n)")
def scaled(values, offset, result):
    for index in range(values.shape[0]):
        result[index] = values[index] + offset * 1.5


@cfunc("float64(float64)")
def callback(x):
    return x * 4.5


@stencil
def smoothed(values):
    return 0.5 * (values[-1] + values[1])


@njit
def steps(count):
    for index in range(count):
        yield index * 0.5


@njit
def text(count):
    made = "a"
    for _ in range(count):
        made += "b"
    return made


doubled = vectorize(["float64(float64)"])(lambda value: value * 2.0)

print(outer(np.arange(3.0)), outer(np.arange(3.0), SPEED), scaled(np.ones(2), SPEED))
print(callback.ctypes(SPEED), smoothed(np.arange(4.0)), list(steps(COUNT)), text(COUNT))
print(doubled(SPEED), njit(lambda x: x * 3.5)(SPEED))
