"""From wanted values back to their sources: the arithmetic of `force_value` (Section IV-A).

One source that occurs once is solved exactly, by the inverses of the operators on the way; one
that occurs several times, or several sources for several values together, numerically
(`solving`). Every answer is checked by re-evaluation.
"""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from .chains import evaluate_chain, invert_chain
from .clamps import in_order
from .expressions import evaluate_many, is_leaf, operands, sources, topological
from .locations import source_of
from .operators import Operator
from .sources import Source, SourceChangeRefused, place_of
from .values import is_tracked, untracked

RELATIVE_TOLERANCE = 1e-9

Target = tuple[Any, Any]
"""A tracked value, and the plain number that it is to become."""

_Step = tuple[Operator, int, tuple[Any, ...]]
"""Operator, index of the operand that leads on, all operands."""

Changes = dict[Source, Any]
"""New plain values by source."""


class NotInvertible(ValueError):
    """No change of a source gives the wanted value; the message says why."""


class NoInverse(NotInvertible):
    """An operator on the way has no inverse for its operand; its slope may lead on."""


@dataclass
class Solution:
    """A checked answer.

    changes  new plain values by source
    values   what re-evaluation with them gives, one for each target
    exact    whether these are the targets; False: the nearest that discrete sources can reach
    """

    changes: Changes = field(default_factory=dict)
    values: list[Any] = field(default_factory=list)
    exact: bool = True

    @property
    def value(self) -> Any:
        """The value of the first target."""
        return self.values[0]


def reached(
    value: Any, target: Any, tolerance: float = RELATIVE_TOLERANCE, finest: float = 1e-15
) -> bool:
    """Whether a float is the target but for rounding; other values have to be equal.

    tolerance  relative to the larger of the two
    finest     the difference that is too small to be asked for, see `rounding`
    """
    if isinstance(value, float) or isinstance(target, float):
        return math.isclose(value, target, rel_tol=tolerance, abs_tol=finest)
    return bool(value == target)


def rounding(value: Any) -> float:
    """What rounding may add to a tracked value: some units in the last place of the largest
    number that it was computed from. Sums that cancel cannot be had more exactly."""
    found = [abs(node._v) for node in topological([value]) if type(node._v) in (float, int)]
    try:
        return 16 * max((math.ulp(size) for size in found if math.isfinite(size)), default=0.0)
    except OverflowError:  # an int beyond all floats
        return 0.0


def _refusing(function: Callable[..., Solution]) -> Callable[..., Solution]:
    """Lets an expression that is nonsense - it may come from the network - be not invertible."""

    @functools.wraps(function)
    def wrapper(*args: Any, **keywords: Any) -> Solution:
        try:
            return function(*args, **keywords)
        except NotInvertible:
            raise
        except (
            ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError,
        ) as error:  # fmt: skip
            raise NotInvertible(f"the expression cannot be solved: {error}") from error

    return wrapper


@_refusing
def invert(value: Any, target: Any, policy: str = "left", source: str | None = None) -> Solution:
    """`invert_many` for one value."""
    if source is None and policy in POLICIES and is_tracked(value):
        check_target(value, target)
        solution = _solve_chain(value, target)
        if solution is not None:
            return solution
    return invert_many([(value, target)], policy, source)


@_refusing
def invert_many(
    targets: Sequence[Target], policy: str = "left", source: str | None = None
) -> Solution:
    """What to change so that all values become their targets together.

    targets  (tracked value, plain number of the same kind; an int for a float is fine)
    policy   "left": as few sources as possible, for each value the first that can (the paper's
             left bias); "least-change": all sources, each as little as possible for its size
    source   parameter name of the only source that may be changed

    Returns a Solution; raises NotInvertible with the reason.
    """
    if policy not in POLICIES:
        raise NotInvertible(f"unknown policy {policy!r}; there are: {', '.join(POLICIES)}")
    for value, target in targets:
        if not is_tracked(value):
            raise NotInvertible("the value has no provenance")
        check_target(value, target)
    candidates = [_candidates(value, source) for value, _ in targets]
    try:
        return POLICIES[policy](targets, candidates)
    except NotInvertible as refusal:
        for apart in filter(None, _taken_apart(targets) if source is None else ()):
            with contextlib.suppress(NotInvertible):
                return checked(targets, invert_many(apart, policy).changes)
        everything = list(dict.fromkeys(s for found in candidates for s in found))
        return _nearest(targets, everything, str(refusal))


def alternatives(value: Any, target: Any) -> list[tuple[Source, Solution | NotInvertible]]:
    """For each source, left bias first, what it alone could do."""
    found: list[tuple[Source, Solution | NotInvertible]] = []
    for source in sources(value):
        try:
            found.append((source, solve_for(value, target, source)))
        except NotInvertible as refusal:
            found.append((source, refusal))
    return found


def check_target(value: Any, target: Any) -> None:
    """Raises NotInvertible if `target` cannot be a value of the kind that `value` is."""
    plain = type(untracked(value))  # float64 is a float as well
    fitting = (float, int) if issubclass(plain, float) else (plain,)
    if type(target) not in fitting and not (float in fitting and isinstance(target, float)):
        raise NotInvertible(f"the value is {plain.__name__}, the target {target!r} is not")
    if isinstance(target, float) and not math.isfinite(target):
        raise NotInvertible(f"the target must be finite, not {target}")


def _candidates(value: Any, only: str | None) -> list[Source]:
    """Those of its sources that may be changed, or the only one. Raises NotInvertible."""
    found = [source for source in sources(value) if only in (None, source.parameter)]
    if only is not None and not found:
        names = ", ".join(dict.fromkeys(source.parameter for source in sources(value)))
        raise NotInvertible(f"{only} is not a source of this value; there are: {names}")
    open_ones = [source for source in found if not source.frozen]
    if found and not open_ones:
        raise NotInvertible("; ".join(map(_frozen, found)))
    if only is not None:
        return open_ones
    kept = in_order(value, open_ones)
    if open_ones and not kept:
        idle = (f"{one.parameter} is a bound that is not met{place_of(one)}" for one in open_ones)
        raise NotInvertible("; ".join(idle))
    return kept


def _frozen(source: Source) -> str:
    return f"{source.parameter} is frozen{place_of(source)}"


# ---------------------------------------------------------------- policies


def _leftmost(targets: Sequence[Target], candidates: list[list[Source]]) -> Solution:
    """For one value after the other the first source that can; coupled ones are solved jointly."""
    found = _at_once(targets, candidates)
    if found is not None:
        return found
    changes: Changes = {}
    for count, (value, target) in enumerate(targets, 1):
        earlier = [source for found in candidates[: count - 1] for source in found]
        changes = _extended(changes, targets[:count], value, target, candidates[count - 1], earlier)
    return checked(targets, changes)


def _at_once(targets: Sequence[Target], candidates: list[list[Source]]) -> Solution | None:
    """The first source of each value, solved jointly: what is found one by one, if all of them can.

    None if they cannot, or one does not have to change: then another value may do without it.
    """
    chosen: list[Source] = []
    for found in candidates:
        chosen += [source for source in found if source not in chosen][:1]
    if len(targets) == 1 or len(chosen) < len(targets):
        return None
    if any(_reaches([target], {}) for target in targets):
        return None
    try:
        return checked(targets, _solve_jointly(targets, chosen))
    except NotInvertible:
        return None


def _extended(
    changes: Changes,
    targets: Sequence[Target],
    value: Any,
    target: Any,
    candidates: list[Source],
    earlier: list[Source],
) -> Changes:
    """`changes` with what one more target needs: one of its sources, or else another one of an
    `earlier` target, which lets go of the one that both depend on."""
    if changes and _reaches([(value, target)], changes):
        return changes
    reasons = []
    for source in candidates:
        if source in changes:
            continue
        try:
            found = {**changes, **solve_for(value, target, source).changes}
            if len(targets) > 1 and not _reaches(targets, found):
                found = _solve_jointly(targets, [*changes, source])
            return found
        except NotInvertible as refusal:
            reasons.append(str(refusal))
    for source in earlier:
        if source not in changes and source not in candidates:
            try:
                found = _solve_jointly(targets, [*changes, source])
            except NotInvertible:
                continue
            if _reaches(targets, found):
                return found
    if not reasons:
        raise NotInvertible("two of the targets depend on the same source alone")
    raise NotInvertible("; ".join(dict.fromkeys(reasons)))


def _least_change(targets: Sequence[Target], candidates: list[list[Source]]) -> Solution:
    """All sources together, each changed as little as possible for its size."""
    everything = list(dict.fromkeys(s for found in candidates for s in found))
    return checked(targets, _solve_jointly(targets, everything))


POLICIES: dict[str, Callable[[Sequence[Target], list[list[Source]]], Solution]] = {
    "left": _leftmost,
    "least-change": _least_change,
}
"""How sources are chosen, by the name of the policy."""


def _reaches(targets: Sequence[Target], changes: Changes) -> bool:
    try:
        values = evaluate_many([value for value, _ in targets], changes)
    except (ArithmeticError, ValueError):
        return False
    return all(_is(v, *wanted) for v, wanted in zip(values, targets, strict=True))


def _is(now: Any, value: Any, target: Any) -> bool:
    return reached(now, target, finest=0.0) or reached(now, target, finest=rounding(value))


def _solve_jointly(targets: Sequence[Target], chosen: list[Source]) -> Changes:
    from .solving import solve  # numpy is loaded only where it is needed

    if any(source.kind not in ("float", "int") for source in chosen):
        raise NotInvertible(f"{chosen[0].parameter} is no number")
    return solve(targets, chosen)


def _taken_apart(targets: Sequence[Target]) -> Iterator[list[Target]]:
    """One text as the pieces that it is made of, where more than one of them differs."""
    from .excerpts import aligned
    from .text_inversion import take_apart

    if len(targets) == 1 and type(targets[0][1]) is str:
        yield take_apart(*targets[0]) or []
        yield aligned(*targets[0]) or []


def _nearest(targets: Sequence[Target], candidates: list[Source], reason: str) -> Solution:
    """The nearest that discrete sources can reach, if that is nearer than now; else refuses."""
    from .solving import is_discrete, nearest

    if any(type(target) is str for _, target in targets):
        raise NotInvertible(reason)
    found = nearest(targets, [s for s in candidates if is_discrete(s)])
    if found is None:
        raise NotInvertible(reason)
    values = evaluate_many([value for value, _ in targets], found)
    return Solution(found, values, exact=_reaches(targets, found))


def checked(targets: Sequence[Target], changes: Changes) -> Solution:
    """A Solution, if re-evaluation shows that all targets are reached; else NotInvertible."""
    try:
        values = evaluate_many([value for value, _ in targets], changes)
    except (ArithmeticError, ValueError) as error:
        raise NotInvertible(f"the expression has no result there: {error}") from None
    for got, (value, target) in zip(values, targets, strict=True):
        if not _is(got, value, target):
            names = ", ".join(source.parameter for source in changes)
            raise NotInvertible(f"no value of {names} gives {target!r}")
    return Solution(changes, values)


# ---------------------------------------------------------------- one source, one value


def solve_for(value: Any, target: Any, source: Source) -> Solution:
    """The change of this one source that makes `value` the target."""
    if source.frozen:
        raise NotInvertible(_frozen(source))
    path, below = _only_path(value, source)
    try:
        wanted = _walk_back(path, target)
    except NotInvertible as refusal:
        # Where floats saturate no value gives it, and one would only seem to.
        if isinstance(refusal, NoInverse) or source.kind == "int":
            return _searched((value, target), (value, target), source, refusal)
        raise
    try:
        if not is_leaf(below):  # it occurs several times: inverses would undo only one of them
            raise NotInvertible("")
        return checked([(value, target)], {source: as_held(source, wanted)})
    except NotInvertible as refusal:
        return _searched((value, target), (below, wanted), source, refusal)


def _searched(whole: Target, part: Target, source: Source, refusal: NotInvertible) -> Solution:
    """A solution where inverses alone give none: there may be one on another side.

    part     what is to be reached below, so that the whole is
    refusal  what the inverses said, raised where there is no solution either
    """
    if type(part[1]) is str:
        return _aligned(whole, source, refusal)
    if not (_is_number(untracked(part[0])) and _is_number(part[1])):
        raise refusal
    try:
        return checked([whole], _solve_jointly([part], [source]))
    except NotInvertible as other:
        tried = _by_trying(part, source)
        if tried is None:
            raise (refusal if str(refusal) else other) from None
        return checked([whole], tried)


def _aligned(whole: Target, source: Source, refusal: NotInvertible) -> Solution:
    """A text that stands in the whole several times, or parts of it."""
    from .excerpts import aligned

    apart = aligned(*whole) or []
    if len(apart) != 1 or not is_leaf(apart[0][0]) or source_of(apart[0][0]) != source:
        raise refusal
    return checked([whole], {source: as_held(source, apart[0][1])})


def _is_number(value: Any) -> bool:
    return isinstance(value, (float, int)) and type(value) is not bool


def _by_trying(wanted: Target, source: Source) -> Changes | None:
    """A value of a discrete source next to a solution between its values, if it is one too."""
    from .solving import is_discrete, nearest

    found = nearest([wanted], [source]) if is_discrete(source) else None
    return found if found is not None and _reaches([wanted], found) else None


def _solve_chain(value: Any, target: Any) -> Solution | None:
    """The answer for a chain, None where it takes more than the inverses."""
    try:
        found = invert_chain(value, target)
        if found is None:
            return None
        leaf, steps, wanted = found
        if any(forward is min or forward is max for forward, _, _ in steps):
            return None  # a bound perhaps
        source = source_of(leaf)
        candidate = as_held(source, wanted)
        result = evaluate_chain(steps, candidate)
    except (ArithmeticError, ValueError, TypeError):
        return None
    return Solution({source: candidate}, [result]) if reached(result, target, finest=0.0) else None


def as_held(source: Source, wanted: Any) -> Any:
    """`wanted` as a value that the source can hold; raises NotInvertible if there is none."""
    if source.kind == "int" and type(wanted) is float:
        if not math.isfinite(wanted):
            raise NotInvertible(f"{source.parameter} would have to be {wanted}")
        nearest = round(wanted)
        if not math.isclose(nearest, wanted, rel_tol=1e-9, abs_tol=1e-9):
            raise NotInvertible(f"{source.parameter} is an int and would have to be {wanted:g}")
        wanted = nearest
    if source.limits is not None and type(wanted) in (float, int):
        end = source.limits.clamped(wanted)
        if math.isclose(end, wanted, rel_tol=1e-9, abs_tol=1e-12):
            wanted = end  # rounding has led beyond it
    try:
        return source.check(wanted)
    except SourceChangeRefused as refusal:
        raise NotInvertible(str(refusal)) from None


def _only_path(value: Any, source: Source) -> tuple[list[_Step], Any]:
    """The way from `value` down to the source, as far as there is only one; and where it ends.

    The end is the source's leaf or the first node below which the source occurs several times.
    """
    step: dict[int, int] = {}
    for node in topological([value]):
        if is_leaf(node):
            if source_of(node) == source:
                step[id(node)] = 0
            continue
        below = [i for i, o in enumerate(operands(node)) if is_tracked(o) and id(o) in step]
        if below:
            step[id(node)] = below[0] if len(below) == 1 else -1
    path = []
    node = value
    while not is_leaf(node) and step[id(node)] >= 0:
        index = step[id(node)]
        held = operands(node)
        path.append((node._op, index, held))
        node = held[index]
    return path, node


def _walk_back(path: list[_Step], target: Any) -> Any:
    """The paper's inverse: from the target through each operator to the source."""
    for op, index, held in path:
        inverse = op.inverse(index)
        if inverse is None:
            known = op.domain if not any(op.inverses) else ""
            raise NoInverse(known or f"{op.symbol} cannot be inverted")
        try:
            target = inverse(target, *map(untracked, held))
        except (ArithmeticError, ValueError, TypeError) as error:
            raise NotInvertible(_refusal(op, index, held, target, error)) from None
    return target


def _refusal(op: Operator, index: int, held: Sequence[Any], target: Any, error: Exception) -> str:
    if op.name in ("min", "max"):
        others = [operand for i, operand in enumerate(held) if i != index]
        limit = op.forward(*others, key=untracked) if len(others) > 1 else others[0]
        return f"limited to {untracked(limit)!r}{_place(limit)}"
    return f"{op.symbol} cannot give {target!r}: {op.domain or error}"


def _place(value: Any) -> str:
    """`` at controller.py:41`` for what comes from there."""
    for source in sources(value) if is_tracked(value) else ():
        return place_of(source) or f" by {source.parameter}"
    return ""
