"""Questions to the expression graph behind a tracked value.

Tracked values are the nodes; all walks are iterative, for expressions may be deep.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from .chains import chain, evaluate_chain
from .extents import Budget
from .locations import Location, source_of
from .operators import DEFERRED, LITERAL, SOURCE, Operator
from .sources import Source
from .values import PlainType, TrackedInt, is_tracked, settle, untracked

if TYPE_CHECKING:
    from .inversion import Solution


def is_leaf(node: Any) -> bool:
    """Whether an expression begins here."""
    if node._op is DEFERRED:
        settle(node)
    op = node._op
    return op is LITERAL or op is SOURCE


def operands(node: Any) -> tuple[Any, ...]:
    """The operands of a node, tracked or plain; none for a leaf."""
    if type(node) is TrackedInt:
        _, op, a, b, _ = node._n
    else:
        op, a, b = node._op, node._a, node._b
    if op is LITERAL or op is SOURCE:
        return ()
    if op is DEFERRED:
        settle(node)
        return operands(node)
    if b is not None:
        return (a, b)
    return a if type(a) is tuple else (a,)


def topological(values: Iterable[Any], deeper_than: int = -1) -> list[Any]:
    """All nodes below and including `values`, each once, operands before what uses them.

    deeper_than  only nodes of a greater depth
    """
    order: list[Any] = []
    seen: set[int] = set()
    # A node in a tuple of its own is one whose operands are done.
    stack: list[Any] = [value for value in values if is_tracked(value)]
    stack.reverse()
    while stack:
        node = stack.pop()
        if type(node) is tuple:
            order.append(node[0])
            continue
        key = id(node)
        if key in seen:
            continue
        seen.add(key)
        below = operands(node)
        if not below:
            order.append(node)
            continue
        stack.append((node,))
        for operand in below[::-1]:
            if type(type(operand)) is PlainType and operand._depth > deeper_than:
                stack.append(operand)
    return order


def leaves(value: Any) -> list[Any]:
    """The leaves of `value` from left to right, one for each source."""
    found: dict[Any, Any] = {}
    for node in topological([value]):
        if is_leaf(node):
            found.setdefault(source_of(node), node)
    return list(found.values())


def source_values(*values: Any) -> dict[Source, Any]:
    """The sources of `values`, and what each of them was when these were computed."""
    return {source_of(leaf): leaf._v for value in values for leaf in leaves(value)}


def sources(value: Any) -> list[Source]:
    """The sources of `value`, the one that left bias prefers first (Section IV-A).

    From left to right, but what cannot move the value as things are (a factor of a
    multiplication by zero) comes last, and a number that is only an operand - a coefficient, like
    the 2 of ``2 * count`` - comes after those that the program gives a name.
    """
    slopes = gradient(value)
    found = [source_of(leaf) for leaf in leaves(value)]
    return sorted(found, key=lambda s: (slopes.get(s) == 0.0, not s.named))


def evaluate(value: Any, changes: Mapping[Source, Any]) -> Any:
    """The plain value that the expression of `value` has with other values of its sources.

    changes  new plain values by source; all others stay as they were when `value` was computed
    Raises what the operators raise (ArithmeticError, ValueError) where they have no result.
    """
    if not is_tracked(value):
        return value
    found = chain(value)
    if found is not None:
        leaf, steps = found
        try:
            return evaluate_chain(steps, changes.get(source_of(leaf), leaf._v))
        except (TypeError, LookupError, AttributeError) as error:
            raise ValueError(str(error)) from error
    return evaluate_many([value], changes)[0]


def evaluate_many(values: Iterable[Any], changes: Mapping[Source, Any]) -> list[Any]:
    """`evaluate` for several values that may share parts."""
    values = list(values)
    found = computed(topological(values), changes)
    return [found[id(value)] if is_tracked(value) else value for value in values]


def computed(order: list[Any], changes: Mapping[Source, Any]) -> dict[int, Any]:
    """The plain result of every node, by id.

    Raises ArithmeticError or ValueError where there is none: an expression from the network may
    well be nonsense.
    """
    results: dict[int, Any] = {}
    budget = Budget()
    for node in order:
        if is_leaf(node):
            results[id(node)] = changes.get(source_of(node), node._v) if changes else node._v
        elif not changes:
            results[id(node)] = node._v
        else:
            op = node._op
            result = results[id(node)] = _applied(op, _plain_operands(node, results))
            if type(result) is not float:
                budget.take(op.name, result)
    return results


def _applied(op: Operator, plain: list[Any]) -> Any:
    try:
        return op.forward(*plain)
    except (TypeError, LookupError, AttributeError) as error:
        raise ValueError(f"{op.name}: {error}") from error


def _plain_operands(node: Any, results: Mapping[int, Any]) -> list[Any]:
    return [results[id(o)] if is_tracked(o) else o for o in operands(node)]


def gradient(value: Any, changes: Mapping[Source, Any] | None = None) -> dict[Source, float]:
    """How `value` moves with each of its sources: partial derivatives, by the chain rule.

    changes  plain values of sources at which to take them, by default the present ones
    A source is missing where an operator on the way has no derivative.
    """
    order = topological([value])
    return slopes_of(value, order, computed(order, changes or {})) if order else {}


def slopes_of(value: Any, order: list[Any], results: Mapping[int, Any]) -> dict[Source, float]:
    """`gradient` where the results of all nodes are known.

    order  at least all nodes below and including `value`, operands before what uses them
    """
    slopes: dict[int, float] = {id(value): 1.0}
    found: dict[Source, float] = {}
    for node in reversed(order):
        slope = slopes.pop(id(node), None)
        if slope is None:
            continue
        if is_leaf(node):
            source = source_of(node)
            found[source] = found.get(source, 0.0) + slope
            continue
        plain = _plain_operands(node, results)
        for index, operand in enumerate(operands(node)):
            if is_tracked(operand):
                part = slope * slope_by(node._op, index, plain)
                slopes[id(operand)] = slopes.get(id(operand), 0.0) + part
    return {source: slope for source, slope in found.items() if not math.isnan(slope)}


def slope_by(op: Operator, index: int, plain: list[Any]) -> float:
    """The partial derivative of an operator by one of its operands, nan where there is none."""
    partial = op.partial(index)
    try:
        return float(partial(*plain)) if partial else math.nan
    except (ArithmeticError, ValueError, TypeError, LookupError, AttributeError):
        return math.nan


# ---------------------------------------------------------------- the public answer


class Provenance:
    """Where a value comes from.

    expression  text of the computation
    sources     list of `Source`, the one that left bias prefers first
    """

    def __init__(self, value: Any) -> None:
        self._value = value

    @property
    def expression(self) -> str:
        from .texts import text

        return text(self._value)

    @property
    def sources(self) -> list[Source]:
        return sources(self._value)

    def evaluate(self, changes: Mapping[Source | str, Any]) -> Any:
        """The plain value with other values of sources, which may be given by parameter name."""
        return evaluate(self._value, self._by_source(changes))

    def invert(self, target: Any, policy: str = "left", source: str | None = None) -> Solution:
        """What to change so that the value becomes `target`; raises NotInvertible."""
        from .inversion import invert

        return invert(self._value, target, policy=policy, source=source)

    def _by_source(self, changes: Mapping[Source | str, Any]) -> dict[Source, Any]:
        if all(isinstance(key, Source) for key in changes):
            return dict(changes)  # type: ignore[arg-type]
        names = {source.parameter: source for source in self.sources}
        found: dict[Source, Any] = {}
        for key, value in changes.items():
            if isinstance(key, Source):
                found[key] = value
            elif key in names:
                found[names[key]] = value
            else:
                raise KeyError(f"{key} is not a source of this value")
        return found

    def __repr__(self) -> str:
        return f"<provenance of {untracked(self._value)!r}: {self.expression}>"


def provenance(value: Any) -> Provenance | None:
    """The provenance of a tracked value, None for a plain one."""
    return Provenance(getattr(value, "_core", value)) if is_tracked(value) else None


__all__ = [
    "Location",
    "Provenance",
    "evaluate",
    "evaluate_many",
    "gradient",
    "is_leaf",
    "leaves",
    "operands",
    "provenance",
    "sources",
    "topological",
]
