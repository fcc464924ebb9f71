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
from .values import is_tracked

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


def select(found: Any, operands: Sequence[Any]) -> Moved:
    """minimum, maximum, clip: every element is one of the operands' elements."""
    parts = [_as_shadow(o) for o in operands]
    values = [part.values.reshape(part.shape) for part in parts]
    result = np.array(found)

    def arrange(numbers: Sequence[Any]) -> Any:
        chosen_numbers = np.zeros(result.shape, int)
        for value, number in reversed(list(zip(values, numbers, strict=True))):
            chosen_numbers = np.where(result == value, number, chosen_numbers)
        return chosen_numbers

    return Moved(parts, arrange)


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
        UFUNCS[getattr(np, name)] = select
    core = getattr(np, "_core", None) or np.core  # 1.x
    clip = getattr(core.umath, "clip", None)
    if clip is not None:
        UFUNCS[clip] = select
    UFUNCS[np.matmul] = _matmul
    for name in ("conjugate",):
        UFUNCS[getattr(np, name)] = lambda found, operands: Moved(
            [_as_shadow(operands[0])], lambda numbers: numbers[0]
        )
