"""Positions, quaternions (w, x, y, z) and poses, as plain tuples of floats."""

from __future__ import annotations

import math
from typing import NamedTuple

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)
ORIGIN: Vector = (0.0, 0.0, 0.0)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation b, then a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def inverse(q: Quaternion) -> Quaternion:
    """The opposite rotation, of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def turned(q: Quaternion, v: Vector) -> Vector:
    """The vector after the rotation."""
    _, x, y, z = product(product(q, (0.0, *v)), inverse(q))
    return (x, y, z)


def unit(q: Quaternion) -> Quaternion:
    """The quaternion of length one; no rotation if there is no direction in it, as RViz does."""
    length = math.sqrt(sum(part * part for part in q))
    if not math.isfinite(length) or length < 1e-9:
        return UNTURNED
    w, x, y, z = q
    return (w / length, x / length, y / length, z / length)


def about(axis: int, angle: float) -> Quaternion:
    """The rotation about x, y or z (axis 0, 1, 2)."""
    parts = [math.cos(angle / 2), 0.0, 0.0, 0.0]
    parts[1 + axis] = math.sin(angle / 2)
    return (parts[0], parts[1], parts[2], parts[3])


def nearer(q: Quaternion, to: Quaternion) -> Quaternion:
    """q or -q, which are the same rotation, whichever has the numbers closer to those of `to`."""
    if sum(a * b for a, b in zip(q, to, strict=True)) >= 0:
        return q
    w, x, y, z = q
    return (-w, -x, -y, -z)


class Frame(NamedTuple):
    """A pose: where something is, and how it is turned."""

    position: Vector = ORIGIN
    rotation: Quaternion = UNTURNED

    def out(self, local: Vector) -> Vector:
        """A position in this frame, as one in the frame around it."""
        x, y, z = turned(self.rotation, local)
        return (x + self.position[0], y + self.position[1], z + self.position[2])

    def into(self, position: Vector) -> Vector:
        """The other way round."""
        x, y, z = (a - b for a, b in zip(position, self.position, strict=True))
        return turned(inverse(self.rotation), (x, y, z))

    def around(self, inner: Frame) -> Frame:
        """A frame that stands in this one, as one in the frame around it."""
        return Frame(self.out(inner.position), product(self.rotation, inner.rotation))


HERE = Frame()
"""The frame around, itself."""


def is_finite(*numbers: float) -> bool:
    """Whether there is no NaN and no infinity among them."""
    return all(map(math.isfinite, numbers))
