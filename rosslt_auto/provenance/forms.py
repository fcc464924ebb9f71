"""What the values of an expression come to, to first order, worked out in one walk upwards.

A form is a sum of terms. Terms are sources, and short expressions that are not affine, such as
the ``speed * dt`` of ``x += speed * dt``: as long as there are few different ones they are kept
as they are, and the form stays exact.
"""

from __future__ import annotations

import math
from collections.abc import Set
from typing import Any

from .excerpts import fold_text
from .expressions import is_leaf, operands, slope_by, topological
from .locations import source_of
from .operators import OPERATORS
from .values import PlainType, is_tracked, untracked

TERM_DEPTH = 4
"""What is deeper is no term."""

MAX_SHORT = 8
"""Terms of a form that are no sources; where there are more they become first-order."""

MAX_SOURCES = 64
"""Sources that a folded text remembers."""

RELEASED = 4096
"""In expressions of more nodes than this, forms go when their last user is done."""

AFFINE = OPERATORS["affine"]
LINEAR = OPERATORS["linear"]
MUL = OPERATORS["mul"]
TRUEDIV = OPERATORS["truediv"]

KEEPS_AFFINE = frozenset(
    OPERATORS[name]
    for name in ("add", "sub", "neg", "pos", "same", "float", "sum", "affine", "mul", "truediv")
)

_CONSTANT_SLOPES = {OPERATORS["add"]: (1.0, 1.0), OPERATORS["sub"]: (1.0, -1.0)}
"""The commonest operators of a history, whose slopes need no look at the operands."""

Form = tuple[dict[int, float], Set[int], bool]
"""How a value moves with its terms, by their ids; which of them it reaches on several ways;
whether that is the whole truth. Forms are shared."""

_NONE: frozenset[int] = frozenset()

_UNKNOWN: Form = ({}, _NONE, False)

_LARGE = 10**300


class Forms:
    """The forms of the nodes of an expression.

    order  all nodes, operands before what uses them
    most   terms that a folded form keeps, those with the greatest influence
    """

    def __init__(self, order: list[Any], most: int) -> None:
        self.order = order
        self.most = most
        self._terms: dict[int, Any] = {}
        self._forms: dict[int, Form] = {}
        self._short: dict[int, Form] = {}  # first-order forms of terms that are no sources
        self._known: dict[tuple[Any, ...], Any] = {}  # nodes by what they are
        self._same: dict[int, Any] = {}  # the first node that is the same, for shallow ones

    def fold(self, chosen: set[int]) -> None:
        """Makes each of the nodes with the ids `chosen` one operator over its terms, in place."""
        forms = self._forms
        last = _last_users(self.order) if len(self.order) > RELEASED else None
        left = len(chosen)
        for node in self.order:
            below = operands(node)
            form = forms[id(node)] = self._form(node, below)
            if last is not None:
                for operand in below:
                    if last.get(id(operand)) is node:
                        forms.pop(id(operand), None)
            if id(node) in chosen:
                if below:
                    self._replace(node, form)
                left -= 1
                if not left:
                    return

    def _form(self, node: Any, below: tuple[Any, ...]) -> Form:
        if not below:
            leaf = self._first(node, (source_of(node), node._v))
            self._terms[id(leaf)] = leaf
            return ({id(leaf): 1.0}, _NONE, True)
        if type(node._v) is str and node._depth > TERM_DEPTH:
            return _UNKNOWN  # a text has no slopes
        form = self._combined(node._op, below)
        if len(form[0]) > MAX_SHORT and self._short:
            form = self._few_short(form)
        if len(form[0]) > 2 * self.most:
            form = self._greatest(form)
        if node._depth <= TERM_DEPTH:
            return self._as_term(node, below, form)
        return form

    def _first(self, node: Any, key: tuple[Any, ...]) -> Any:
        found = self._known.setdefault(key, node)
        self._same[id(node)] = found
        return found

    def _as_term(self, node: Any, below: tuple[Any, ...], form: Form) -> Form:
        """The form of a shallow node: a term of its own if it is not affine."""
        op = node._op
        if op is LINEAR:
            return form
        key: list[Any] = [op]
        for operand in below:
            if type(type(operand)) is not PlainType:
                key += (type(operand), operand)
                continue
            same = self._same.get(id(operand))
            if same is None:  # there is something first-order in it
                return form
            key.append(id(same))
        try:
            first = self._first(node, tuple(key))
        except TypeError:  # a plain operand that cannot be hashed
            return form
        if form[2] or type(node._v) is str:
            return form
        if first is node:
            self._short[id(node)] = form
            self._terms[id(node)] = node
        return ({id(first): 1.0}, _NONE, True)

    def _combined(self, op: Any, below: tuple[Any, ...]) -> Form:
        """The form of an operation, from those of its operands."""
        if op is AFFINE or op is LINEAR:
            return self._unfolded(op, below)
        constant = _CONSTANT_SLOPES.get(op)
        plain = [] if constant else [untracked(operand) for operand in below]
        if op is MUL:
            constant = (_finite(plain[1]), _finite(plain[0]))
        keeps = op in KEEPS_AFFINE and one_tracked(op, below)
        found: Form | None = None
        for index, operand in enumerate(below):
            if type(type(operand)) is PlainType:
                slope = constant[index] if constant else slope_by(op, index, plain)
                form = self._forms[id(operand)]
                if slope != 1.0 or not keeps:
                    scaled = {key: slope * s for key, s in form[0].items()}
                    form = (scaled, form[1], keeps and form[2])
                found = form if found is None else _added(found, form)
        assert found is not None
        return found

    def _unfolded(self, op: Any, below: tuple[Any, ...]) -> Form:
        """The form of what has been folded before, from those of its terms."""
        slopes: dict[int, float] = {}
        repeated: set[int] = set()
        exact = op is AFFINE
        for index in range(1, len(below), 4):
            if type(type(below[index])) is not PlainType:
                continue
            form = self._forms[id(below[index])]
            exact = exact and form[2]
            for key, slope in form[0].items():
                if below[index + 3] > 1 or key in slopes or key in form[1]:
                    repeated.add(key)
                slopes[key] = slopes.get(key, 0.0) + below[index + 2] * slope
        return (slopes, repeated, exact)

    def _few_short(self, form: Form) -> Form:
        """The form over sources alone, if there are too many other terms in it."""
        short = self._short
        if sum(key in short for key in form[0]) <= MAX_SHORT:
            return form
        slopes: dict[int, float] = {}
        repeated = set(form[1])
        stack = list(form[0].items())
        while stack:
            key, slope = stack.pop()
            if key in short:
                repeated |= short[key][1]
                stack += [(k, slope * s) for k, s in short[key][0].items()]
                continue
            if key in slopes:
                repeated.add(key)
            slopes[key] = slopes.get(key, 0.0) + slope
        return (slopes, repeated, False)

    def _greatest(self, form: Form) -> Form:
        """The form without the terms of least influence, if there are too many."""
        if len(form[0]) <= self.most:
            return form
        kept = sorted(form[0], key=lambda key: -abs(form[0][key]))[: self.most]
        return ({key: form[0][key] for key in kept}, form[1], False)

    def _replace(self, node: Any, form: Form) -> None:
        """Makes `node` one operator over its terms."""
        if type(node._v) is str:
            if not fold_text(node, TERM_DEPTH):
                _forget_way_back(node)
            return
        same = self._same.get(id(node))
        if same is not None and id(same) in form[0]:
            return  # it is a term itself
        slopes = {key: slope for key, slope in form[0].items() if slope and math.isfinite(slope)}
        slopes, repeated, exact = self._greatest((slopes, form[1], form[2]))
        flat: list[Any] = [node._v]
        depth = 0
        for key, slope in slopes.items():
            term = self._terms[key]
            depth = max(depth, term._depth)
            times = 2 if key in repeated else 1
            flat += (term, term._v, _whole(slope) if type(node._v) is int else slope, times)
        node._set(AFFINE if exact else LINEAR, tuple(flat), None, depth + 1)


def _last_users(order: list[Any]) -> dict[int, Any]:
    return {id(o): node for node in order for o in operands(node) if type(type(o)) is PlainType}


def _finite(factor: Any) -> Any:
    """A slope by which others can be multiplied: an int may be too large for a float."""
    return factor if type(factor) is not int or -_LARGE < factor < _LARGE else math.nan


def _added(a: Form, b: Form) -> Form:
    slopes = a[0] | b[0]
    repeated = a[1] | b[1] if a[1] or b[1] else _NONE
    both = a[0].keys() & b[0].keys()
    if both:
        repeated = repeated | both
        for key in both:
            slopes[key] = a[0][key] + b[0][key]
    return (slopes, repeated, a[2] and b[2])


def _forget_way_back(value: Any) -> None:
    """A text keeps the knowledge of its sources, but no way back."""
    leaves = {source_of(node): node for node in topological([value]) if is_leaf(node)}
    kept = list(leaves.values())[:MAX_SOURCES]
    value._set(OPERATORS["remembered"], (value._v, *kept), None, 1)


def _whole(slope: float) -> float | int:
    return int(slope) if slope.is_integer() and abs(slope) < 2**53 else slope


def one_tracked(op: Any, below: tuple[Any, ...]) -> bool:
    """Whether a multiplication or division is one by a constant; true of other operators."""
    if op is MUL:
        return not (is_tracked(below[0]) and is_tracked(below[1]))
    return op is not TRUEDIV or not is_tracked(below[1])
