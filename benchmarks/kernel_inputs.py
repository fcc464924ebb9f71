"""What `kernels` compute with. Instrumented, all of it is tracked."""


def nbody():
    sun = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 39.5]
    jupiter = [4.84, -1.16, -0.10, 0.61, 2.81, -0.02, 0.0377]
    saturn = [8.34, 4.12, -0.40, -1.01, 1.82, 0.008, 0.0113]
    uranus = [12.89, -15.11, -0.22, 1.08, 0.87, -0.01, 0.0017]
    return [sun, jupiter, saturn, uranus], 0.01, 100, -1.5


def spectral_norm():
    return 24, 1.0, 2.0


def fannkuch():
    zero = 0
    one = 1
    return 6, zero, one


def mandelbrot():
    return 14, 30, -1.5, 0.2, 4.0


def text():
    words = ["position", "of", "the", "gripper", "above", "table"]
    return words, 300, " ", ".\n"


def parse():
    one = "[1.5, [2.25, 3, [4.125]], -6e3], "
    return one * 30, 0, 1


def sort():
    step = 7919
    return [step * i % 1009 for i in range(600)], 0, 1


def multiply():
    a = [[0.5 * i + j for j in range(16)] for i in range(16)]
    return a, a, 0.0


def sieve():
    return 4000, 2, 1


def integrate():
    return 0.0, 3.0, 3000, 2.5
