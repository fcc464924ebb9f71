"""Numerical inversion: where a source occurs several times, or several targets share sources.

Newton's method with the derivatives of the operator table, damped; for one unknown safeguarded
by bracketing. What would leave its range stays at the end of it while the others go on, and what
comes out is rounded to what discrete sources can hold. Callers check the result by re-evaluation.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .expressions import computed, evaluate_many, slopes_of, source_values, topological
from .inversion import (
    RELATIVE_TOLERANCE,
    Changes,
    NotInvertible,
    Target,
    as_held,
    reached,
    rounding,
)
from .sources import Source, SourceChangeRefused

MAX_STEPS = 60
MAX_HALVINGS = 30
SMALLEST_SCALE = 1e-3
NEGLIGIBLE = 1e-4
"""Part of the largest change, each for the size of its source, that is not worth making."""

NEIGHBOURS = 16
"""How far from its value a discrete source is tried where no slope leads anywhere."""

_AFFORDABLE = 200
"""Operations in an expression of which so many values are tried."""


def solve(targets: Sequence[Target], chosen: Sequence[Source]) -> Changes:
    """New values of the `chosen` sources with which all values are their targets.

    Among several solutions one with small changes, each weighed by the size of its source.
    Raises NotInvertible if none is found.
    """
    if not chosen:
        raise NotInvertible("the value has no sources that can be changed")
    problem = _Problem(targets, chosen)
    found = problem.inside(problem.start, free=list(range(len(chosen))))
    continuous = [i for i, source in enumerate(chosen) if not is_discrete(source)]
    if found is None and 0 < len(continuous) < len(chosen):
        found = problem.inside(problem.start, free=continuous)
    if found is None and len(chosen) == 1 and len(targets) == 1:
        found = problem.bracket(float(problem.start[0]))
    if found is None:
        names = ", ".join(map(_named, chosen))
        raise NotInvertible(f"no value of {names} gives {_targets_text(targets)}")
    return problem.held(problem.settled(found))


def is_discrete(source: Source) -> bool:
    """Whether only some numbers are values of a source."""
    return source.kind == "int" or (source.limits is not None and source.limits.step is not None)


def _around(source: Source, x: float) -> list[Any]:
    """The values of a discrete source next to x, nearest first."""
    if source.limits is not None:
        return source.limits.around(x)
    return sorted((math.floor(x), math.ceil(x)), key=lambda whole: abs(whole - x))


def _named(source: Source) -> str:
    return source.parameter if source.limits is None else f"{source.parameter} ({source.limits})"


def _targets_text(targets: Sequence[Target]) -> str:
    return ", ".join(repr(target) for _, target in targets)


class _Problem:
    """Targets as a function of the chosen sources."""

    def __init__(self, targets: Sequence[Target], chosen: Sequence[Source]) -> None:
        self.values = [value for value, _ in targets]
        self.order = topological(self.values)
        self.goals = np.array([float(target) for _, target in targets])
        self.finest = [rounding(value) for value in self.values]
        self.sources = list(chosen)
        present = source_values(*self.values)
        self.start = np.array([float(present[source]) for source in self.sources])
        self.scale = np.maximum(np.abs(self.start), SMALLEST_SCALE)
        self._latest: tuple[Any, dict[int, Any]] | None = None

    def changes(self, point: Any) -> Changes:
        """The sources' values at a point; those of discrete sources stay unrounded.

        Whole numbers of int sources are ints, for operators that take nothing else.
        """
        found: Changes = {}
        for source, x in zip(self.sources, point.tolist(), strict=True):
            found[source] = int(x) if source.kind == "int" and x.is_integer() else x
        return found

    def at(self, point: Any) -> Any:
        """The values at a point, None where there are none."""
        try:
            found = self._computed(point)
            values = np.array([float(found[id(value)]) for value in self.values])
        except (ArithmeticError, ValueError, TypeError):
            return None
        return values if np.isfinite(values).all() else None

    def _computed(self, point: Any) -> dict[int, Any]:
        """The results of all nodes at a point; steps ask for the slopes where they have arrived."""
        if self._latest is None or self._latest[0] is not point:
            self._latest = (point, computed(self.order, self.changes(point)))
        return self._latest[1]

    def slopes(self, point: Any) -> Any:
        results = self._computed(point)
        rows = [slopes_of(value, self.order, results) for value in self.values]
        return np.array([[row.get(source, 0.0) for source in self.sources] for row in rows])

    def near(self, values: Any, tolerance: float = 1e-11, roundings: float = 1 / 16) -> bool:
        wanted = zip(values.tolist(), self.goals.tolist(), self.finest, strict=True)
        return all(reached(v, g, tolerance, roundings * finest) for v, g, finest in wanted)

    def inside(self, start: Any, free: list[int]) -> Any:
        """What `newton` finds with all sources in their ranges, None if it finds nothing."""
        point, free = np.array(start), list(free)
        while True:
            found = self.newton(point, free)
            if found is None:
                return None
            beyond = {i: self._beyond(i, float(found[i])) for i in free}
            worst = max(free, key=beyond.__getitem__, default=None)
            if worst is None or not beyond[worst]:
                return found
            limits = self.sources[worst].limits
            assert limits is not None
            point[worst] = limits.clamped(float(found[worst]))
            free.remove(worst)

    def settled(self, found: Any) -> Any:
        """A solution in which sources that hardly matter stay exactly as they are."""
        moved = np.abs(found - self.start) / self.scale
        still = moved < NEGLIGIBLE * moved.max()
        if not (still & (moved > 0.0)).any():
            return found
        point = np.where(still, self.start, found)
        again = self.inside(point, free=[i for i in range(len(point)) if not still[i]])
        return found if again is None else again

    def _beyond(self, index: int, x: float) -> float:
        """How far a number is out of a source's range, for its size."""
        limits = self.sources[index].limits
        if limits is None or limits.low <= x <= limits.high:
            return 0.0
        return float(abs(x - limits.clamped(x)) / self.scale[index])

    def newton(self, start: Any, free: list[int]) -> Any:
        """A solution reached from `start` by moving the `free` sources, None if there is none."""
        point = np.array(start, dtype=float)
        values = self.at(point)
        if values is None:
            return None
        for _ in range(MAX_STEPS):
            if self.near(values):
                return point
            try:
                step = self._step(point, values, free)
            except (ArithmeticError, ValueError, TypeError):
                return None
            moved = self._damped(point, values, step)
            if moved is None:
                break
            point, values = moved
        return point if self._good_enough(values) else None

    def _step(self, point: Any, values: Any, free: list[int]) -> Any:
        """The smallest weighted step that the linear form asks for."""
        weights = self.scale[free]
        slopes = self.slopes(point)[:, free] * weights
        if not np.isfinite(slopes).all():
            raise ArithmeticError("no slope")
        step = np.zeros_like(point)
        step[free] = weights * np.linalg.lstsq(slopes, self.goals - values, rcond=1e-12)[0]
        return step

    def _damped(self, point: Any, values: Any, step: Any) -> Any:
        if not step.any():
            return None
        before = np.abs(self.goals - values).max()
        for halving in range(MAX_HALVINGS):
            moved = point + step * 0.5**halving
            found = self.at(moved)
            if found is not None and np.abs(self.goals - found).max() < before:
                return moved, found
        return None

    def _good_enough(self, values: Any) -> bool:
        return self.near(values, RELATIVE_TOLERANCE, 1.0)

    def bracket(self, start: float) -> Any:
        """A solution for one unknown by bisection, the nearest to `start`, None if none is seen.

        Where there is none, a place at which the values jump over the goal.
        """
        goal = float(self.goals[0])

        def miss(x: float) -> float:
            values = self.at(np.array([x])) if not self._beyond(0, x) else None
            return math.nan if values is None else float(values[0]) - goal

        miss = functools.cache(miss)  # neighbouring intervals share their ends
        found = [
            root
            for low, high in _intervals(start, float(self.scale[0]))
            if (root := _bisect(miss, low, high)) is not None
        ]

        def worth(x: float) -> tuple[bool, float]:
            values = self.at(np.array([x]))
            return values is None or not self._good_enough(values), abs(x - start)

        return np.array([min(found, key=worth)]) if found else None

    def held(self, point: Any) -> Changes:
        """The point as values that the sources can hold; what rounding breaks is solved again."""
        discrete = [i for i, source in enumerate(self.sources) if is_discrete(source)]
        free = [i for i in range(len(self.sources)) if i not in discrete]
        if discrete and free:
            rounded = np.array(point)
            for i in discrete:
                rounded[i] = _around(self.sources[i], float(rounded[i]))[0]
            found = self.inside(rounded, free)
            point = rounded if found is None else found
        return {
            source: as_held(source, _tidy(float(x)))
            for source, x, before in zip(self.sources, point, self.start, strict=True)
            if x != before
        }


def _tidy(x: float) -> float:
    """The rounding errors of the last digits removed where that is the same number for people."""
    short = float(f"{x:.12g}")
    return short if math.isclose(short, x, rel_tol=1e-13, abs_tol=0.0) else x


def _intervals(start: float, scale: float) -> list[tuple[float, float]]:
    """Neighbouring intervals around `start`, growing with the distance."""
    reach = [0.0] + [scale * 2.0 ** (k / 2) for k in range(-12, 60)]
    steps = list(itertools.pairwise(reach))
    return [(start + a, start + b) for a, b in steps] + [(start - b, start - a) for a, b in steps]


def _bisect(miss: Any, low: float, high: float) -> float | None:
    at_low, at_high = miss(low), miss(high)
    if at_low == 0.0:
        return low
    if at_high == 0.0:
        return high
    if math.isnan(at_low) or math.isnan(at_high) or (at_low > 0) == (at_high > 0):
        return None
    for _ in range(200):
        middle = (low + high) / 2
        at_middle = miss(middle)
        if at_middle == 0.0 or middle in (low, high):
            return middle
        if math.isnan(at_middle):
            return None
        if (at_middle > 0) == (at_low > 0):
            low, at_low = middle, at_middle
        else:
            high = middle
    return (low + high) / 2


# ---------------------------------------------------------------- discrete sources


def nearest(targets: Sequence[Target], discrete: Sequence[Source]) -> Changes | None:
    """The values of one discrete source that come nearest to the targets; None if it is now.

    Sources are tried in their order; the first that comes as near as any wins.
    """
    best: Changes | None = None
    smallest = _miss(targets, {})
    for source in discrete:
        for candidate in _candidates(targets, source):
            miss = _miss(targets, {source: candidate})
            if miss < smallest * (1 - 1e-12):
                best, smallest = {source: candidate}, miss
    return best


def _miss(targets: Sequence[Target], changes: Changes) -> float:
    try:
        values = evaluate_many([value for value, _ in targets], changes)
        return max(abs(v - t) for v, (_, t) in zip(values, targets, strict=True))
    except (ArithmeticError, ValueError, TypeError):
        return math.inf


def _neighbours(source: Source, now: float) -> list[Any]:
    """The values of a discrete source around the present one, nearest first."""
    step = 1.0 if source.limits is None or source.limits.step is None else source.limits.step
    distances = [sign * step * n for n in range(1, NEIGHBOURS + 1) for sign in (-1, 1)]
    return [_around(source, now + distance)[0] for distance in distances]


def _candidates(targets: Sequence[Target], source: Source) -> list[int]:
    """Values on both sides of the unrounded solution, and what is near the present one."""
    problem = _Problem(targets, [source])
    found = problem.newton(problem.start, [0])
    if found is None and len(targets) == 1:
        found = problem.bracket(float(problem.start[0]))
    tried = [] if found is None else _around(source, float(found[0]))
    if len(problem.order) <= _AFFORDABLE:
        tried += _neighbours(source, float(problem.start[0]))
    candidates = []
    for near in dict.fromkeys(tried):
        try:
            candidates.append(source.check(near))
        except SourceChangeRefused:
            continue
    return candidates
