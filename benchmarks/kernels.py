"""Ten small programs of pure Python, without a literal that would be tracked.

All numbers and texts that they compute with are passed in (`kernel_inputs`), so that one and the
same code runs with tracked and with untracked values.
"""

import math


def nbody(bodies, dt, steps, power):
    """Planets: lists of x, y, z, vx, vy, vz, mass."""
    for _ in range(steps):
        for i, a in enumerate(bodies):
            for b in bodies[i + True :]:
                dx, dy, dz = a[0] - b[0], a[1] - b[1], a[2] - b[2]
                scale = dt * (dx * dx + dy * dy + dz * dz) ** power
                pull, push = b[6] * scale, a[6] * scale
                a[3] -= dx * pull
                a[4] -= dy * pull
                a[5] -= dz * pull
                b[3] += dx * push
                b[4] += dy * push
                b[5] += dz * push
        for a in bodies:
            a[0] += dt * a[3]
            a[1] += dt * a[4]
            a[2] += dt * a[5]
    return bodies


def spectral_norm(n, one, two):
    """Two rounds of the power method with A[i][j] = 1 / ((i + j) (i + j + 1) / 2 + i + 1)."""

    def entry(i, j):
        return one / ((i + j) * (i + j + one) / two + i + one)

    u = [one] * n
    for _ in range(2):
        v = [sum([entry(i, j) * u[j] for j in range(n)]) for i in range(n)]
        u = [sum([entry(j, i) * v[j] for j in range(n)]) for i in range(n)]
    return (sum([a * b for a, b in zip(u, v, strict=True)]) / sum([a * a for a in v])) ** (
        one / two
    )


def fannkuch(n, zero, one):
    """The largest number of flips over all permutations."""
    permutation, counts, most = list(range(n)), list(range(n)), zero
    while True:
        flipped, flips = permutation[:], zero
        while flipped[0]:
            first = flipped[0] + one
            flipped[:first] = flipped[:first][::-1]
            flips += one
        most = flips if flips > most else most
        i = one
        while i < n:
            permutation.insert(i, permutation.pop(0))
            counts[i] -= one
            if counts[i] >= zero:
                break
            counts[i] = i
            i += one
        else:
            return most


def mandelbrot(size, limit, left, step, bound):
    """How many points of a square stay within the bound."""
    inside = []
    for row in range(size):
        for column in range(size):
            cx, cy = left + column * step, left + row * step
            x, y = cx, cy
            for _ in range(limit):
                x, y = x * x - y * y + cx, x * y + x * y + cy
                if x * x + y * y > bound:
                    break
            else:
                inside.append((x, y))
    return len(inside)


def text(words, count, separator, end):
    """A text of many words, with some of them changed."""
    lines = []
    for i in range(count):
        line = separator.join([word.upper() if len(word) > i % 7 else word for word in words])
        lines.append(line + end)
    return separator.join(lines)


def parse(source, zero, one):
    """The numbers of a text like ``[1.5, [2.25, 3]]``, and how deep they stand."""
    found, depth, at = [], zero, zero
    while at < len(source):
        character = source[at]
        if character == "[":
            depth += one
        elif character == "]":
            depth -= one
        elif character not in ", ":
            end = at
            while source[end] not in ",]":
                end += one
            found.append((depth, source[at:end]))
            at = end
            continue
        at += one
    return found


def sort(values, zero, one):
    """Merge sort."""
    if len(values) <= one:
        return values
    half = len(values) // (one + one)
    left, right = sort(values[:half], zero, one), sort(values[half:], zero, one)
    merged, i, j = [], zero, zero
    while i < len(left) and j < len(right):
        if left[i] <= right[j]:
            merged.append(left[i])
            i += one
        else:
            merged.append(right[j])
            j += one
    return merged + left[i:] + right[j:]


def multiply(a, b, zero):
    """The product of two matrices."""
    columns = list(zip(*b, strict=True))
    product = []
    for row in a:
        line = []
        for column in columns:
            entry = zero
            for x, y in zip(row, column, strict=True):
                entry += x * y
            line.append(entry)
        product.append(line)
    return product


def sieve(n, two, one):
    """The sum of the primes below n."""
    prime, total, i = [True] * n, one - one, two
    while i < n:
        if prime[i]:
            total += i
            multiple = i * i
            while multiple < n:
                prime[multiple] = False
                multiple += i
        i += one
    return total


def integrate(low, high, steps, rate):
    """The integral of a damped wave, by the midpoint rule."""
    width = (high - low) / steps
    total, x = width - width, low + width / (rate / rate + rate / rate)
    for _ in range(steps):
        total += math.sin(rate * x) * width
        x += width
    return total
