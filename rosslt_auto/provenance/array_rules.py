"""How the elements of an array came about: one rule per array operation, expressions on demand.

A `Shadow` is what an array's elements were at one moment, with the rule that made them; it never
changes. The expression of one element is worked out when somebody asks for it, from ordinary
scalar operators, so that texts, inversion and the wire format need to know nothing of numpy.
"""

from __future__ import annotations

import functools
import logging
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .elements import adapted
from .folding import fold
from .operators import LITERAL, OPERATORS, SOURCE
from .values import deferred, is_tracked, record, settle, untracked

MAX_DEPTH = 64
"""Array operations on top of each other; a longer history is folded, element by element."""

FOLDED_SIZE = 1024
"""Larger arrays are not folded: beyond MAX_DEPTH they lose their provenance."""

CHAINED_TERMS = 16
"""A sum of so many terms is shown with ``+``, a longer one as ``sum(...)``."""

_log = logging.getLogger(__name__)
_SAME = OPERATORS["same"]

_tobytes = np.ndarray.tobytes

Build = Callable[..., Any]
"""Given the plain value of an element and its operands, makes the node (or the plain value)."""

Operand = Any
"""A Shadow, a plain array that nobody changes, or a tracked or plain Python number."""


@functools.lru_cache(maxsize=256)
def positions(shape: tuple[int, ...]) -> Any:
    """The flat positions of an array's elements, in its shape; read-only."""
    found = np.arange(math.prod(shape)).reshape(shape)
    found.flags.writeable = False
    return found


def core_of(item: Any) -> Any:
    """A scalar of numpy as Python number, tracked if it was; anything else as it is."""
    if is_tracked(item):
        return getattr(item, "_core", item)
    if isinstance(item, np.generic) and item.dtype.kind in "iuf":
        return item.item()
    return item


class Shadow:
    """The elements of an array at one moment, and where they came from."""

    __slots__ = ("_cores", "_mask", "_values", "data", "depth", "dtype", "rule", "shape")

    def __init__(self, array: Any, rule: Rule) -> None:
        self.data = _tobytes(array)
        self.dtype = array.dtype
        self.shape = array.shape
        self.rule = rule
        self.depth = rule.depth
        self._cores: dict[int, Any] = {}
        self._mask: Any = None
        self._values: Any = None
        if self.depth > MAX_DEPTH:
            self._shorten()

    @property
    def values(self) -> Any:
        """The plain elements, one after the other."""
        if self._values is None:
            self._values = np.frombuffer(self.data, self.dtype)
        return self._values

    @property
    def mask(self) -> Any:
        """For each element whether it has provenance."""
        if self._mask is None:
            self._mask = self.rule.mask()
        return self._mask

    def core(self, position: int) -> Any:
        """The element at a flat position as Python number, tracked if it has provenance."""
        found = self._cores.get(position)
        if found is None:
            found = self.values.item(position)
            if self.mask[position]:
                found = self.rule.core(position, found)
            self._cores[position] = found
        return found

    def _shorten(self) -> None:
        """Lets go of the arrays that this one was computed from (design 3.4)."""
        cells: dict[int, Any] = {}
        if self.mask.size <= FOLDED_SIZE:
            for position in np.flatnonzero(self.mask).tolist():
                cells[position] = found = self.core(position)
                if triple(found)[0] is not _SAME:
                    fold(found)
        else:
            _log.debug("provenance of a large array ends: its history is too long")
        self.rule = Over(cells, None, None, self.mask.size)
        self.depth = 1
        self._mask = None


def scalar_shadow(item: Any) -> Shadow:
    """A tracked number as an array of no dimension."""
    return Shadow(np.asarray(untracked(item)), Over({0: core_of(item)}, None, None, 1))


def triple(made: Any) -> tuple[Any, Any, Any]:
    """Operator and operands of a node as `values.deferred` wants them."""
    if is_tracked(made):
        settle(made)
        if made._op is not LITERAL and made._op is not SOURCE:
            return made._op, made._a, made._b
    return _SAME, made, None


# ---------------------------------------------------------------- operands


def at(operand: Operand, position: int) -> Any:
    """An element of an operand."""
    if type(operand) is Shadow:
        return operand.core(position)
    if type(operand) is np.ndarray:
        return operand.item(position)
    return operand


def mask_of(operand: Operand) -> Any:
    """Flat, for each element whether it has provenance."""
    if type(operand) is Shadow:
        return operand.mask
    if type(operand) is np.ndarray:
        return np.zeros(operand.size, bool)
    return np.array([is_tracked(operand)])


def values_of(operand: Operand) -> Any:
    """Flat, the plain values."""
    if type(operand) is Shadow:
        return operand.values
    return np.ravel(untracked(operand))


def shape_of(operand: Operand) -> tuple[int, ...]:
    return operand.shape if type(operand) in (Shadow, np.ndarray) else ()


def depth_of(operand: Operand) -> int:
    if type(operand) is Shadow:
        return operand.depth
    return 1 if is_tracked(operand) else 0


def spread(operand: Operand, position: int, shape: tuple[int, ...]) -> int:
    """Which element of an operand is broadcast to a position in `shape`."""
    own = shape_of(operand)
    if own == shape:
        return position
    if math.prod(own) == 1:
        return 0
    while len(own) > len(shape):  # an assignment drops leading dimensions of one element
        own = own[1:]
    return int(np.broadcast_to(positions(own), shape).flat[position])


# ---------------------------------------------------------------- rules


class Rule:
    """How the elements of an array come about from those of others."""

    depth = 1

    def mask(self) -> Any:
        """For each element, flat, whether it has provenance."""
        raise NotImplementedError

    def core(self, position: int, value: Any) -> Any:
        """The element at `position`, which has provenance, with that plain value."""
        expand = functools.partial(self._expand, position, value)
        return deferred(value, expand, self.depth)

    def _expand(self, position: int, value: Any) -> tuple[Any, Any, Any]:
        try:
            return triple(self.make(position, value))
        except (ArithmeticError, ValueError, TypeError) as error:
            _log.debug("provenance of an array's element ends: %s", error)
            return _SAME, value, None

    def make(self, position: int, value: Any) -> Any:
        """The element as a new node."""
        raise NotImplementedError


class Over(Rule):
    """Single elements that were given, the others from what was there before.

    cells   by position: a tracked number with the element's value, None for a plain one
    under   what was there before, or None
    valid   which elements of it have not changed since, None for all
    """

    def __init__(self, cells: dict[int, Any], under: Shadow | None, valid: Any, size: int) -> None:
        if under is not None and type(under.rule) is Over:
            below = under.rule
            cells = {p: c for p, c in below.cells.items() if valid is None or valid[p]} | cells
            if valid is None or below.valid is None:
                valid = below.valid if valid is None else valid
            else:
                valid = valid & below.valid
            under = below.under
        self.cells: dict[int, Any] = cells
        self.under: Shadow | None = under
        self.valid: Any = valid
        self.size = size
        self.depth = 1 if under is None else under.depth + 1

    def mask(self) -> Any:
        if self.under is None:
            found = np.zeros(self.size, bool)
        else:
            found = np.array(
                self.under.mask if self.valid is None else self.under.mask & self.valid
            )
        for position, cell in self.cells.items():
            found[position] = cell is not None
        return found

    def core(self, position: int, value: Any) -> Any:
        if position in self.cells:
            return self.cells[position]
        return adapted(self.under.core(position), value)  # type: ignore[union-attr]


class Elementwise(Rule):
    """One operation on corresponding elements, with broadcasting."""

    def __init__(self, build: Build, operands: Sequence[Operand], shape: tuple[int, ...]) -> None:
        self.build = build
        self.operands = operands
        self.shape = shape
        self.depth = 1 + max(map(depth_of, operands))

    def mask(self) -> Any:
        found = np.zeros(self.shape, bool)
        for operand in self.operands:
            found |= mask_of(operand).reshape(shape_of(operand))
        return found.reshape(-1)

    def make(self, position: int, value: Any) -> Any:
        return self.build(value, *(at(o, spread(o, position, self.shape)) for o in self.operands))


class Moved(Rule):
    """Elements that are elements of others, or constants.

    parts    Shadows
    arrange  given for each part an array of numbers in its shape, what the operation makes of
             them; 0 is a constant
    """

    def __init__(self, parts: Sequence[Shadow], arrange: Callable[[Sequence[Any]], Any]) -> None:
        self.parts = parts
        self.arrange = arrange
        self.depth = 1 + max(part.depth for part in parts)

    @functools.cached_property
    def origin(self) -> Any:
        """For each element the number of its origin: 0, or 1 + position over all parts."""
        numbers, first = [], 1
        for part in self.parts:
            found = positions(part.shape)
            numbers.append(found + first)
            first += found.size
        return np.asarray(self.arrange(numbers)).reshape(-1)

    def mask(self) -> Any:
        return np.concatenate([[False], *(part.mask for part in self.parts)])[self.origin]

    def core(self, position: int, value: Any) -> Any:
        place = int(self.origin[position]) - 1
        for part in self.parts:
            size = part.mask.size
            if place < size:
                return adapted(part.core(place), value)
            place -= size
        return value


class Contracted(Rule):
    """``@``: sums of products of rows and columns."""

    def __init__(self, left: Operand, right: Operand, shape: tuple[int, ...]) -> None:
        self.left = left
        self.right = right
        self.shape = shape
        self.depth = 2 + max(depth_of(left), depth_of(right))

    @functools.cached_property
    def lanes(self) -> tuple[Any, Any]:
        """Positions in the operands: (n, 1, k) of the rows, (1, m, k) of the columns; stacked."""
        a, b = positions(shape_of(self.left)), positions(shape_of(self.right))
        a = a[None, :] if a.ndim == 1 else a
        b = b[:, None] if b.ndim == 1 else b
        rows = a[..., :, None, :]
        columns = np.swapaxes(b, -1, -2)[..., None, :, :]
        rows, columns = np.broadcast_arrays(rows, columns)
        length = rows.shape[-1]
        return rows.reshape(-1, length), columns.reshape(-1, length)

    def mask(self) -> Any:
        rows, columns = self.lanes
        left, right = mask_of(self.left)[rows], mask_of(self.right)[columns]
        nonzero_left = values_of(self.left)[rows] != 0
        nonzero_right = values_of(self.right)[columns] != 0
        return ((left & (right | nonzero_right)) | (right & nonzero_left)).any(axis=-1)

    def make(self, position: int, value: Any) -> Any:
        rows, columns = self.lanes
        terms = [
            product(at(self.left, a), at(self.right, b))
            for a, b in zip(rows[position].tolist(), columns[position].tolist(), strict=True)
        ]
        return total(value, *terms)


class Lanes(Rule):
    """A reduction: each element is made of several elements of one operand."""

    def __init__(self, build: Build, operand: Shadow, lanes: Callable[[Any], Any]) -> None:
        self.build = build
        self.operand = operand
        self.arrange = lanes
        self.depth = 2 + operand.depth

    @functools.cached_property
    def lanes(self) -> Any:
        """A row of positions for each element."""
        return self.arrange(positions(self.operand.shape))

    def mask(self) -> Any:
        return self.operand.mask[self.lanes].any(axis=-1)

    def make(self, position: int, value: Any) -> Any:
        return self.build(value, *map(self.operand.core, self.lanes[position].tolist()))


def lanes_along(axis: Any, numbers: Any) -> Any:
    """For `Lanes`: the numbers of an array's elements, a row for each element of a result."""
    if axis is None:
        return numbers.reshape(1, -1)
    axes = axis if isinstance(axis, tuple) else (axis,)
    axes = tuple(sorted(int(axis) % numbers.ndim for axis in axes))
    last = np.moveaxis(numbers, axes, range(-len(axes), 0))
    lengths = [numbers.shape[axis] for axis in axes]
    return last.reshape(-1, int(np.prod(lengths)))


class Whole(Rule):
    """An operation that numpy can do on arrays of objects: it makes all expressions at once."""

    def __init__(self, function: Callable[..., Any], operands: Sequence[Operand]) -> None:
        self.function = function
        self.operands = operands
        self.depth = 3 + max(map(depth_of, operands))

    @functools.cached_property
    def nodes(self) -> list[Any]:
        found = self.function(*map(_objects, self.operands))
        return [node_of(item) for item in np.ravel(np.asarray(found, dtype=object)).tolist()]

    def mask(self) -> Any:
        try:
            return np.array([is_tracked(found) for found in self.nodes], bool)
        except (ArithmeticError, ValueError, TypeError) as error:
            _log.debug("provenance of an array ends: %s", error)
            self.nodes = []
            return np.zeros(1, bool)

    def make(self, position: int, value: Any) -> Any:
        return self.nodes[position]


def _objects(operand: Operand) -> Any:
    if type(operand) is not Shadow:
        return operand
    found = np.empty(operand.mask.size, object)
    for position in range(found.size):
        found[position] = _Term(operand.core(position))
    return found.reshape(operand.shape)


class _Term:
    """An element in an array of objects: expressions without terms and factors of plain zero."""

    __slots__ = ("node",)

    def __init__(self, node: Any) -> None:
        self.node = node

    def __add__(self, other: Any) -> _Term:
        return _Term(_added(self.node, node_of(other)))

    def __radd__(self, other: Any) -> _Term:
        return _Term(_added(node_of(other), self.node))

    def __sub__(self, other: Any) -> _Term:
        other = node_of(other)
        return self if _is_zero(other) else _Term(self.node - other)

    def __rsub__(self, other: Any) -> _Term:
        other = node_of(other)
        return _Term(-self.node if _is_zero(other) else other - self.node)

    def __mul__(self, other: Any) -> _Term:
        return _Term(product(self.node, node_of(other)))

    def __rmul__(self, other: Any) -> _Term:
        return _Term(product(node_of(other), self.node))

    def __truediv__(self, other: Any) -> _Term:
        return self if _is_zero(self.node) else _Term(self.node / node_of(other))

    def __rtruediv__(self, other: Any) -> _Term:
        return _Term(node_of(other) / self.node)

    def __neg__(self) -> _Term:
        return _Term(-self.node)


def node_of(item: Any) -> Any:
    """The expression of an element of an array of objects."""
    return item.node if type(item) is _Term else core_of(item)


def _is_zero(item: Any) -> bool:
    return not is_tracked(item) and item == 0


def _added(a: Any, b: Any) -> Any:
    return b if _is_zero(a) else a if _is_zero(b) else a + b


# ---------------------------------------------------------------- what builds nodes


def operation(name: str) -> Build:
    """One operator of the table."""
    op = OPERATORS[name]

    def build(value: Any, *operands: Any) -> Any:
        return record(op, value, *operands)

    return build


def product(a: Any, b: Any) -> Any:
    """a * b, simpler where a factor is a plain zero or one."""
    for constant, other in ((a, b), (b, a)):
        if not is_tracked(constant):
            if constant == 0:
                return constant
            if constant == 1 and type(untracked(other)) is type(constant):
                return other
    return a * b


def total(value: Any, *terms: Any) -> Any:
    """A sum; the plain terms in one."""
    tracked = [term for term in terms if is_tracked(term)]
    rest = sum(term for term in terms if not is_tracked(term))
    if rest:
        tracked.append(rest)
    if len(tracked) > CHAINED_TERMS:
        return record(OPERATORS["sum"], value, *tracked)
    found = tracked[0]
    for term in tracked[1:-1]:
        found = found + term
    if len(tracked) > 1:
        return record(OPERATORS["add"], value, found, tracked[-1])
    return adapted(found, value)


def mean(value: Any, *terms: Any) -> Any:
    return record(
        OPERATORS["truediv"], value, total(sum(map(untracked, terms)), *terms), len(terms)
    )


def multiplied(value: Any, *factors: Any) -> Any:
    found = factors[0]
    for factor in factors[1:-1]:
        found = product(found, factor)
    if len(factors) > 1:
        return record(OPERATORS["mul"], value, found, factors[-1])
    return adapted(found, value)


def chosen(value: Any, *candidates: Any) -> Any:
    """The candidate that has the value: what a minimum or maximum took."""
    for candidate in candidates:
        if untracked(candidate) == value:
            return adapted(candidate, value)
    return value


def length(value: Any, *sides: Any) -> Any:
    """A Euclidean norm."""
    sides = tuple(side for side in sides if is_tracked(side) or side)
    return record(OPERATORS["hypot"], value, *sides)


def squared(value: Any, x: Any) -> Any:
    return record(OPERATORS["mul"], value, x, x)


def reciprocal(value: Any, x: Any) -> Any:
    return record(OPERATORS["truediv"], value, 1, x)


def rounded(name: str) -> Build:
    """A rounding that gives whole floats, of an operator that gives ints."""
    op, to_float = OPERATORS[name], OPERATORS["float"]

    def build(value: Any, x: Any) -> Any:
        if type(value) is int:
            return adapted(x, value)
        return record(to_float, value, record(op, int(value), x))

    return build


def to_digits(value: Any, x: Any, digits: Any) -> Any:
    """numpy's round: a float stays a float."""
    return record(OPERATORS["round"], value, x, digits)
