"""Functions of numpy whose results consist of elements of their arguments.

How elements are moved, is found out by moving their numbers the same way.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .array_calls import FUNCTIONS, call_plain
from .array_rules import Moved, Shadow, scalar_shadow
from .array_type import TrackedArray, operand_of, plain_deeply, trackable, wrap
from .values import is_tracked


def _moving(function: Any, data: Sequence[int] | None) -> Callable[..., Any]:
    """The tracked version of a function whose results consist of elements of its arguments.

    data  which positional arguments hold the elements, None for all
    """
    try:
        signature: inspect.Signature | None = inspect.signature(function)
    except (ValueError, TypeError):
        signature = None

    def call(*args: Any, **keywords: Any) -> Any:
        out = keywords.pop("out", None)
        if out is not None:
            return call_plain(function, args, {**keywords, "out": out})
        if keywords and data is not None and len(args) <= max(data) and signature is not None:
            args, keywords = _positional(signature, args, keywords)
        parts: list[Shadow] = []
        recipe = [
            _recipe(arg, parts) if data is None or i in data else _constant(arg)
            for i, arg in enumerate(args)
        ]
        others = {
            name: frozen(value)
            for name, value in keywords.items() if name not in ("dtype", "casting")
        }  # fmt: skip
        found = function(*map(plain_deeply, args), **plain_deeply(keywords))
        if not parts:
            return _blank_views(found, args)

        def arrange(numbers: Sequence[Any]) -> Any:
            return function(*(make(numbers) for make in recipe), **others)

        base = args[0] if len(parts) == 1 and args and type(args[0]) is TrackedArray else None
        return _results(found, parts, arrange, base)

    return call


def _positional(signature: inspect.Signature, args: Any, keywords: Any) -> tuple[Any, Any]:
    try:
        bound = signature.bind(*args, **keywords)
    except TypeError:
        return args, keywords
    return bound.args, bound.kwargs


def _recipe(arg: Any, parts: list[Shadow]) -> Callable[[Sequence[Any]], Any]:
    """What gives the numbers of the elements of an argument; its Shadows are added to `parts`."""
    if type(arg) in (list, tuple) and any(type(a) is TrackedArray or _is_array(a) for a in arg):
        makers = [_recipe(item, parts) for item in arg]
        return lambda numbers: [make(numbers) for make in makers]
    operand = operand_of(arg)
    if is_tracked(operand):
        operand = scalar_shadow(operand)
    if type(operand) is Shadow:
        parts.append(operand)
        index = len(parts) - 1
        return lambda numbers: numbers[index]
    shape = np.shape(operand)
    return lambda numbers: np.zeros(shape, int)


def _is_array(thing: Any) -> bool:
    return isinstance(thing, np.ndarray) or (
        type(thing) in (list, tuple) and any(map(_is_array, thing))
    )


def _constant(arg: Any) -> Callable[[Sequence[Any]], Any]:
    kept = frozen(arg)
    return lambda numbers: kept


def frozen(arg: Any) -> Any:
    """A plain copy of an argument, which may change later."""
    arg = plain_deeply(arg)
    if isinstance(arg, np.ndarray):
        return np.array(arg)
    return list(arg) if type(arg) is list else arg


def _results(found: Any, parts: list[Shadow], arrange: Any, base: Any) -> Any:
    """One array or a list or tuple of them."""
    if type(found) in (list, tuple):
        made = [
            result(item, parts, functools.partial(_pick, arrange, index), base)
            for index, item in enumerate(found)
        ]
        return made if type(found) is list else tuple(made)
    return result(found, parts, arrange, base)


def _pick(arrange: Any, index: int, numbers: Sequence[Any]) -> Any:
    return arrange(numbers)[index]


def result(found: Any, parts: list[Shadow], arrange: Any, base: Any) -> Any:
    """The result with the rule of its elements; what it is a view of hears of changes."""
    made = wrap(found, Moved(parts, arrange))
    if base is not None and type(made) is TrackedArray:
        _note_base(made, base, arrange)
    return made


def _note_base(made: Any, base: Any, arrange: Any) -> None:
    if base._whole is None and np.may_share_memory(made, base):
        made._whole = (base, arrange)


def _blank_views(found: Any, args: Sequence[Any]) -> Any:
    """Results of moving the elements of arrays that have no provenance yet, but may get some."""
    if type(found) is np.ndarray and args and type(args[0]) is TrackedArray:
        return trackable(found)
    return found


_FIRST = (
    "reshape", "ravel", "transpose", "squeeze", "expand_dims", "flip", "fliplr", "flipud", "rot90",
    "roll", "swapaxes", "moveaxis", "rollaxis", "repeat", "tile", "take", "take_along_axis",
    "broadcast_to", "diag", "diagonal", "diagflat", "triu", "tril", "resize", "copy", "array_split",
    "split", "hsplit", "vsplit", "dsplit", "delete", "matrix_transpose", "permute_dims", "unstack",
    "concatenate", "concat", "stack", "hstack", "vstack", "row_stack", "dstack", "column_stack",
    "block", "real", "ascontiguousarray",
)  # fmt: skip
_OTHERS = {
    "append": (0, 1), "insert": (0, 2), "where": (1, 2), "compress": (1,), "extract": (1,),
    "atleast_1d": None, "atleast_2d": None, "atleast_3d": None, "meshgrid": None,
    "broadcast_arrays": None,
}  # fmt: skip


def _sort(a: Any, axis: Any = -1, kind: Any = None, order: Any = None, **keywords: Any) -> Any:
    if keywords or order is not None:
        return call_plain(np.sort, (a, axis, kind, order), keywords)
    found = np.sort(plain_deeply(a), axis, kind)
    shadow = operand_of(a)
    if type(shadow) is not Shadow:
        return found
    order = np.argsort(shadow.values.reshape(shadow.shape), axis, "stable")

    def arrange(numbers: Sequence[Any]) -> Any:
        if axis is None:
            return np.ravel(numbers[0])[order]
        return np.take_along_axis(numbers[0], order, axis)

    return wrap(found, Moved([shadow], arrange))


def fill_moving() -> None:
    """Adds the functions of this module to the table."""
    for name, data in {**dict.fromkeys(_FIRST, (0,)), **_OTHERS}.items():
        add_function(name, functools.partial(_moving, data=data))
    FUNCTIONS[np.sort] = _sort


def add_function(name: str, make: Callable[[Any], Any]) -> None:
    """Adds the tracked version of a function of numpy, if this numpy has it."""
    function = getattr(np, name, None)
    if function is not None:
        FUNCTIONS[function] = make(function)
