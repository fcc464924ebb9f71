"""Universal functions of numpy: the rules of their results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .array_calls import UFUNCS
from .array_rules import (
    Build,
    Contracted,
    Elementwise,
    Moved,
    Over,
    Shadow,
    operation,
    reciprocal,
    rounded,
    scalar_shadow,
    squared,
)
from .elements import adapted
from .operators import OPERATORS
from .values import is_tracked, record, untracked

_OPERATIONS = {
    "add": "add", "subtract": "sub", "multiply": "mul", "divide": "truediv",
    "true_divide": "truediv", "floor_divide": "floordiv", "remainder": "mod", "mod": "mod",
    "power": "pow", "float_power": "pow", "pow": "pow", "fmod": "fmod", "negative": "neg",
    "positive": "pos", "absolute": "abs", "fabs": "fabs", "hypot": "hypot", "arctan2": "atan2",
    "copysign": "copysign", "arcsin": "asin", "arccos": "acos", "arctan": "atan",
    "arcsinh": "asinh", "arccosh": "acosh", "arctanh": "atanh", "deg2rad": "radians",
    "rad2deg": "degrees", "left_shift": "lshift", "right_shift": "rshift", "bitwise_and": "and",
    "bitwise_or": "or", "bitwise_xor": "xor", "invert": "invert",
    **{name: name for name in (
        "sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "exp2", "expm1", "log", "log2",
        "log10", "log1p", "sqrt", "cbrt", "degrees", "radians",
    )},
}  # fmt: skip
_BUILDS: dict[str, Build] = {
    **{name: operation(op) for name, op in _OPERATIONS.items()},
    "square": squared,
    "reciprocal": reciprocal,
    "floor": rounded("floor"),
    "ceil": rounded("ceil"),
    "trunc": rounded("trunc"),
    "rint": rounded("round"),
}


def _elementwise(build: Build) -> Callable[..., Any]:
    def make(found: Any, operands: Sequence[Any]) -> Any:
        return Elementwise(build, operands, found.shape)

    return make


def limiting(*names: str) -> Build:
    """minimum, maximum, clip: an element and its bounds, by the rows "min" and "max"."""
    rows = [OPERATORS[name] for name in names]

    def build(value: Any, x: Any, *bounds: Any) -> Any:
        made = x
        for op, bound in zip(rows, bounds, strict=True):
            if is_tracked(made) or is_tracked(bound):
                made = record(op, op.forward(untracked(made), untracked(bound)), made, bound)
            else:
                made = op.forward(made, bound)
        plain = untracked(made)
        if plain == value and type(plain) is type(value):
            return made
        # NaN, or another precision: the operand that has been chosen, as it was converted.
        chosen = [o for o in (x, *bounds) if is_tracked(o) and untracked(o) == value]
        return adapted(chosen[0], value) if chosen else value

    return build


def _as_shadow(operand: Any) -> Shadow:
    if type(operand) is Shadow:
        return operand
    if is_tracked(operand):
        return scalar_shadow(operand)
    array = np.asarray(operand)
    return Shadow(array, Over({}, None, None, array.size))


def _matmul(found: Any, operands: Sequence[Any]) -> Contracted:
    return Contracted(operands[0], operands[1], np.shape(found))


def fill_ufuncs() -> None:
    """Fills the table of universal functions."""
    for name, build in _BUILDS.items():
        ufunc = getattr(np, name, None)
        if isinstance(ufunc, np.ufunc):
            UFUNCS[ufunc] = _elementwise(build)
    for name in ("minimum", "maximum", "fmin", "fmax"):
        UFUNCS[getattr(np, name)] = _elementwise(limiting(name.removeprefix("f")[:3]))
    core = getattr(np, "_core", None) or np.core  # 1.x
    clip = getattr(core.umath, "clip", None)
    if clip is not None:
        UFUNCS[clip] = _elementwise(limiting("max", "min"))
    UFUNCS[np.matmul] = _matmul
    for name in ("conjugate",):
        UFUNCS[getattr(np, name)] = lambda found, operands: Moved(
            [_as_shadow(operands[0])], lambda numbers: numbers[0]
        )
