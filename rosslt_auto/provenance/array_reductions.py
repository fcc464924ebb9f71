"""Products, sums, norms: functions of numpy with a rule of their own, or done on objects."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from .array_calls import FUNCTIONS, REDUCTIONS, call_plain, ended, written_to
from .array_moving import add_function, frozen
from .array_rules import (
    Build,
    Contracted,
    Elementwise,
    Lanes,
    Moved,
    Shadow,
    Whole,
    chosen,
    lanes_along,
    length,
    mean,
    multiplied,
    operation,
    scalar_shadow,
    shape_of,
    to_digits,
    total,
)
from .array_type import (
    MAX_SIZE,
    TrackedArray,
    holds_tracked,
    is_known,
    note_assignment,
    operand_of,
    plain,
    plain_deeply,
    with_elements,
    wrap,
)
from .array_ufuncs import limiting
from .elements import adapted
from .values import is_tracked, untracked

# ---------------------------------------------------------------- products


def _product(function: Any, rule: Callable[[Any, Any, Any], Any]) -> Callable[..., Any]:
    """The tracked version of a function of two arrays.

    rule  given the result and the two operands
    """

    def call(*args: Any, **keywords: Any) -> Any:
        if keywords or len(args) != 2:
            return call_plain(function, args, keywords)
        found = function(*map(plain_deeply, args))
        operands = [operand_of(arg) for arg in args]
        if not any(map(is_known, operands)):
            return found
        return wrap(found, rule(found, *operands))

    return call


def _reshaped(operand: Any, change: Callable[[Any], Any]) -> Any:
    """An operand with its elements moved, before it takes part in an operation."""
    if type(operand) is Shadow:
        values = change(operand.values.reshape(operand.shape))
        return Shadow(values, Moved([operand], lambda numbers: change(numbers[0])))
    return change(operand) if type(operand) is np.ndarray else operand


def _dot_rule(found: Any, a: Any, b: Any) -> Any:
    if shape_of(a) == () or shape_of(b) == ():
        return Elementwise(operation("mul"), [a, b], np.shape(found))
    if len(shape_of(b)) > 2:
        return None
    return Contracted(a, b, np.shape(found))


def _inner_rule(found: Any, a: Any, b: Any) -> Any:
    if len(shape_of(b)) == 2:
        b = _reshaped(b, np.transpose)
    return _dot_rule(found, a, b)


def _vdot_rule(found: Any, a: Any, b: Any) -> Any:
    return _dot_rule(found, _reshaped(a, np.ravel), _reshaped(b, np.ravel))


def _outer_rule(found: Any, a: Any, b: Any) -> Any:
    a, b = _reshaped(a, lambda x: np.ravel(x)[:, None]), _reshaped(b, np.ravel)
    return Elementwise(operation("mul"), [a, b], found.shape)


def _whole(function: Any) -> Callable[..., Any]:
    """The tracked version of a function that numpy can do on arrays of objects."""

    def call(*args: Any, **keywords: Any) -> Any:
        if keywords.get("out") is not None:
            return call_plain(function, args, keywords)
        found = function(*map(plain_deeply, args), **plain_deeply(keywords))
        if np.size(found) > MAX_SIZE:
            return found
        operands = [operand_of(arg) if _has_elements(arg) else frozen(arg) for arg in args]
        if not any(map(is_known, operands)):
            return found
        others = {n: frozen(v) for n, v in keywords.items() if n not in ("dtype", "optimize")}
        return wrap(found, Whole(functools.partial(function, **others), operands))

    return call


def _has_elements(arg: Any) -> bool:
    return isinstance(arg, np.ndarray) or holds_tracked(arg)


# ---------------------------------------------------------------- reductions


def _reducing(function: Any, build: Build, allowed: frozenset[str]) -> Callable[..., Any]:
    """The tracked version of a reduction.

    allowed  keywords besides `axis` that do not matter to it
    """

    def call(a: Any, axis: Any = None, *rest: Any, **keywords: Any) -> Any:
        out = keywords.get("out")
        if rest or out is not None or not keywords.keys() <= allowed:
            return call_plain(function, (a, axis, *rest), keywords)
        found = function(plain_deeply(a), axis, **keywords)
        operand = operand_of(a)
        if is_tracked(operand):
            operand = scalar_shadow(operand)
        if type(operand) is not Shadow or not operand.values.size:
            return found
        return wrap(found, Lanes(build, operand, functools.partial(lanes_along, axis)))

    return call


def _reduce_method(ufunc: Any, function: Any) -> Callable[..., Any]:
    """``ufunc.reduce``, which the methods of arrays go through."""
    tracked = FUNCTIONS[function]

    def call(a: Any, axis: Any = 0, dtype: Any = None, out: Any = None, keepdims: bool = False,
             **keywords: Any) -> Any:  # fmt: skip
        if dtype is not None or keywords:
            keywords |= {"dtype": dtype} if dtype is not None else {}
            found = ufunc.reduce(
                plain_deeply(a), axis, keepdims=keepdims, out=plain_deeply(out), **keywords
            )
            return found if out is None else written_to(_tuple(out), found, None)
        if out is not None and _tuple(out) != (None,):
            found = ufunc.reduce(plain_deeply(a), axis, keepdims=keepdims, out=plain_deeply(out))
            return written_to(_tuple(out), found, None)
        return tracked(a, axis, keepdims=keepdims)

    return call


def _tuple(out: Any) -> tuple[Any, ...]:
    return out if type(out) is tuple else (out,)


def _norm(x: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    found = np.linalg.norm(plain_deeply(x), ord, axis, keepdims)
    operand = operand_of(x)
    if type(operand) is not Shadow:
        return found
    one_axis = isinstance(axis, int) or (axis is None and len(operand.shape) == 1)
    if not (ord is None or (ord == 2 and one_axis) or ord == "fro"):
        return ended(np.linalg.norm, found)
    return wrap(found, Lanes(length, operand, functools.partial(lanes_along, axis)))


def _trace(a: Any, *args: Any, **keywords: Any) -> Any:
    found = np.trace(plain_deeply(a), *args, **keywords)
    operand = operand_of(a)
    if type(operand) is not Shadow or args or keywords or len(operand.shape) != 2:
        return found
    return wrap(found, Lanes(total, operand, lambda numbers: np.diagonal(numbers)[None, :]))


def _round(a: Any, decimals: Any = 0, out: Any = None) -> Any:
    if out is not None:
        return call_plain(np.round, (a, decimals), {"out": out})
    digits = untracked(decimals)
    found = np.round(plain_deeply(a), digits)
    operand = operand_of(a)
    if not is_known(operand):
        return found

    def build(value: Any, x: Any) -> Any:
        return adapted(x, value) if type(value) is int else to_digits(value, x, digits)

    return wrap(found, Elementwise(build, [operand], np.shape(found)))


def _clip(a: Any, a_min: Any = None, a_max: Any = None, **keywords: Any) -> Any:
    low, high = keywords.pop("min", a_min), keywords.pop("max", a_max)
    if keywords:
        return call_plain(np.clip, (a, low, high), keywords)
    found = np.clip(*map(plain_deeply, (a, low, high)))
    bounds = {"max": low, "min": high}
    names = [name for name, bound in bounds.items() if bound is not None]
    operands = [operand_of(x) for x in (a, *map(bounds.__getitem__, names))]
    if not any(map(is_known, operands)):
        return wrap(found, None)
    return wrap(found, Elementwise(limiting(*names), operands, np.shape(found)))


def _linspace(start: Any, stop: Any, num: Any = 50, endpoint: Any = True, **keywords: Any) -> Any:
    num = untracked(num)
    found = np.linspace(plain_deeply(start), plain_deeply(stop), num, endpoint, **keywords)
    if keywords or not all(isinstance(untracked(x), (float, int)) for x in (start, stop)):
        return found
    steps = num - 1 if endpoint else num
    a, b = map(operand_of, (start, stop))
    nodes = [a + (b - a) * (i / steps if steps else 0.0) for i in range(num)]
    if endpoint and steps:
        nodes[-1] = b
    return with_elements(found, nodes)


def _copyto(dst: Any, src: Any, *args: Any, **keywords: Any) -> None:
    np.copyto(plain(dst), plain_deeply(src), *args, **plain_deeply(keywords))
    if type(dst) is TrackedArray:
        dst._shadow = dst._cells = None
        if not args and not keywords:
            note_assignment(dst, ..., operand_of(src))


def fill_rules() -> None:
    """Adds the functions of this module to the tables."""
    keeps = frozenset({"keepdims"})
    for names, build in (
        (("sum",), total), (("mean",), mean), (("prod",), multiplied),
        (("min", "max", "amin", "amax"), chosen),
    ):  # fmt: skip
        for name in names:
            add_function(name, functools.partial(_reducing, build=build, allowed=keeps))
    for ufunc, function in (
        (np.add, np.sum), (np.multiply, np.prod), (np.minimum, np.min), (np.maximum, np.max),
    ):  # fmt: skip
        REDUCTIONS[ufunc, "reduce"] = _reduce_method(ufunc, function)
    for name, rule in (
        ("dot", _dot_rule), ("inner", _inner_rule), ("vdot", _vdot_rule), ("outer", _outer_rule),
    ):  # fmt: skip
        add_function(name, functools.partial(_product, rule=rule))
    for name in ("cross", "einsum", "cumsum", "cumprod", "diff", "kron", "tensordot", "ediff1d",
                 "average", "polyval", "trapezoid", "trapz"):  # fmt: skip
        add_function(name, _whole)
    for name in ("round", "around"):
        FUNCTIONS[getattr(np, name)] = _round
    FUNCTIONS.update({np.trace: _trace, np.clip: _clip, np.linspace: _linspace})
    FUNCTIONS[np.linalg.matrix_power] = _whole(np.linalg.matrix_power)
    FUNCTIONS.update({np.linalg.norm: _norm, np.copyto: _copyto})
