"""What functions of numpy do to the provenance of arrays: tables of `array_calls`, filled here.

Three kinds: those that move elements (how, is found out by moving their numbers the same way),
those with a rule of their own (products, sums, norms), and those that numpy can do on arrays of
objects. Any other function gives plain results.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import array_algebra
from .array_calls import (
    ADVICE,
    FUNCTIONS,
    REDUCTIONS,
    UFUNCS,
    call_function,
    call_plain,
    call_ufunc,
    ended,
    written_to,
)
from .array_names import SCALARS
from .array_rules import (
    Build,
    Contracted,
    Elementwise,
    Lanes,
    Moved,
    Over,
    Shadow,
    Whole,
    chosen,
    lanes_along,
    length,
    mean,
    multiplied,
    operation,
    positions,
    reciprocal,
    rounded,
    scalar_shadow,
    shape_of,
    squared,
    to_digits,
    total,
)
from .array_type import (
    MAX_SIZE,
    TrackedArray,
    elements,
    has_provenance,
    holds_tracked,
    is_known,
    is_real,
    make_array,
    new_array,
    note_assignment,
    note_moved,
    operand_of,
    plain,
    plain_deeply,
    trackable,
    with_elements,
    wrap,
)
from .elements import adapted
from .values import is_tracked, untracked

# ---------------------------------------------------------------- universal functions

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


def _select(found: Any, operands: Sequence[Any]) -> Moved:
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


def _fill_ufuncs() -> None:
    for name, build in _BUILDS.items():
        ufunc = getattr(np, name, None)
        if isinstance(ufunc, np.ufunc):
            UFUNCS[ufunc] = _elementwise(build)
    for name in ("minimum", "maximum", "fmin", "fmax"):
        UFUNCS[getattr(np, name)] = _select
    core = getattr(np, "_core", None) or np.core  # 1.x
    clip = getattr(core.umath, "clip", None)
    if clip is not None:
        UFUNCS[clip] = _select
    UFUNCS[np.matmul] = _matmul
    for name in ("conjugate",):
        UFUNCS[getattr(np, name)] = lambda found, operands: Moved(
            [_as_shadow(operands[0])], lambda numbers: numbers[0]
        )


# ---------------------------------------------------------------- functions that move elements


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
            name: _frozen(value)
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
    kept = _frozen(arg)
    return lambda numbers: kept


def _frozen(arg: Any) -> Any:
    arg = plain_deeply(arg)
    if isinstance(arg, np.ndarray):
        return np.array(arg)
    return list(arg) if type(arg) is list else arg


def _results(found: Any, parts: list[Shadow], arrange: Any, base: Any) -> Any:
    """One array or a list or tuple of them."""
    if type(found) in (list, tuple):
        made = [
            _result(item, parts, functools.partial(_pick, arrange, index), base)
            for index, item in enumerate(found)
        ]
        return made if type(found) is list else tuple(made)
    return _result(found, parts, arrange, base)


def _pick(arrange: Any, index: int, numbers: Sequence[Any]) -> Any:
    return arrange(numbers)[index]


def _result(found: Any, parts: list[Shadow], arrange: Any, base: Any) -> Any:
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


def _fill_moving() -> None:
    for name, data in {**dict.fromkeys(_FIRST, (0,)), **_OTHERS}.items():
        _add(name, functools.partial(_moving, data=data))
    FUNCTIONS[np.sort] = _sort


def _add(name: str, make: Callable[[Any], Any]) -> None:
    function = getattr(np, name, None)
    if function is not None:
        FUNCTIONS[function] = make(function)


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
        operands = [operand_of(arg) if _has_elements(arg) else _frozen(arg) for arg in args]
        if not any(map(is_known, operands)):
            return found
        others = {n: _frozen(v) for n, v in keywords.items() if n not in ("dtype", "optimize")}
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
    operands = [operand_of(x) for x in (a, low, high) if x is not None]
    return wrap(found, _select(found, operands) if any(map(is_known, operands)) else None)


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


def _fill_rules() -> None:
    keeps = frozenset({"keepdims"})
    for names, build in (
        (("sum",), total), (("mean",), mean), (("prod",), multiplied),
        (("min", "max", "amin", "amax"), chosen),
    ):  # fmt: skip
        for name in names:
            _add(name, functools.partial(_reducing, build=build, allowed=keeps))
    for ufunc, function in (
        (np.add, np.sum), (np.multiply, np.prod), (np.minimum, np.min), (np.maximum, np.max),
    ):  # fmt: skip
        REDUCTIONS[ufunc, "reduce"] = _reduce_method(ufunc, function)
    for name, rule in (
        ("dot", _dot_rule), ("inner", _inner_rule), ("vdot", _vdot_rule), ("outer", _outer_rule),
    ):  # fmt: skip
        _add(name, functools.partial(_product, rule=rule))
    for name in ("cross", "einsum", "cumsum", "cumprod", "diff", "kron", "tensordot", "ediff1d",
                 "average", "polyval", "trapezoid", "trapz"):  # fmt: skip
        _add(name, _whole)
    for name in ("round", "around"):
        FUNCTIONS[getattr(np, name)] = _round
    FUNCTIONS.update({np.trace: _trace, np.clip: _clip, np.linspace: _linspace})
    FUNCTIONS[np.linalg.matrix_power] = _whole(np.linalg.matrix_power)
    FUNCTIONS.update({np.linalg.norm: _norm, np.copyto: _copyto})


# ---------------------------------------------------------------- methods of arrays


def _method(name: str) -> Callable[..., Any]:
    """A method of arrays by way of the function of that name."""
    function = getattr(np, name)

    def method(self: Any, *args: Any, **keywords: Any) -> Any:
        if not has_provenance(self) and not holds_tracked(args):
            return _blank(getattr(plain(self), name)(*plain_deeply(args), **plain_deeply(keywords)))
        return call_function(function, (self, *args), keywords)

    method.__name__ = name
    method.__doc__ = getattr(np.ndarray, name).__doc__
    return method


def _blank(found: Any) -> Any:
    return trackable(found)


def _shaping(name: str) -> Callable[..., Any]:
    """A method that moves elements, called like the method."""
    plain_method = getattr(np.ndarray, name)

    def method(self: Any, *args: Any, **keywords: Any) -> Any:
        if keywords.get("out") is not None:
            return call_plain(plain_method, (self, *args), keywords)
        found = plain_method(plain(self), *plain_deeply(args), **plain_deeply(keywords))
        if type(found) is not np.ndarray or found.dtype.kind not in "iuf":
            if isinstance(found, np.generic) and has_provenance(self):
                return _result(found, [operand_of(self)], arrange_(args, keywords), None)
            return found
        made = new_array(found)
        note_moved(made, self, arrange_(args, keywords))
        return made

    def arrange_(args: Any, keywords: Any) -> Callable[[Sequence[Any]], Any]:
        kept = [_frozen(arg) for arg in args]
        others = {name: _frozen(arg) for name, arg in keywords.items()}
        return lambda numbers: plain_method(numbers[0], *kept, **others)

    method.__name__ = name
    method.__doc__ = plain_method.__doc__
    return method


def _astype(self: Any, dtype: Any, *args: Any, **keywords: Any) -> Any:
    found = plain(self).astype(dtype, *args, **keywords)
    if not is_real(found):
        return found
    made = new_array(found)
    note_moved(made, self, lambda numbers: numbers[0])
    return made


def _tolist(self: Any) -> Any:
    found = elements(self)
    if found is None:
        return plain(self).tolist()
    items = np.empty(len(found), object)
    items[:] = found
    return items.reshape(self.shape).tolist()


def _item(self: Any, *args: Any) -> Any:
    plain_args = plain_deeply(args)
    found = plain(self).item(*plain_args)
    if not has_provenance(self):
        return found
    position = int(positions(self.shape).item(*plain_args))
    item = elements(self)
    if item is None:
        return found
    return adapted(item[position], found)


def _fill(self: Any, value: Any) -> None:
    plain(self).fill(untracked(value))
    if is_tracked(value) or has_provenance(self):
        note_assignment(self, ..., operand_of(value))


def _transposed(self: Any) -> Any:
    return self.transpose()


def _plain_method(name: str) -> Callable[..., Any]:
    plain_method = getattr(np.ndarray, name)

    def method(self: Any, *args: Any, **keywords: Any) -> Any:
        return call_plain(plain_method, (self, *args), keywords)

    method.__name__ = name
    method.__doc__ = plain_method.__doc__
    return method


def _fill_methods() -> None:
    for name in (
        "reshape", "ravel", "flatten", "transpose", "squeeze", "swapaxes", "repeat", "take",
        "diagonal", "compress", "copy",
    ):  # fmt: skip
        setattr(TrackedArray, name, _shaping(name))
    for name in (
        "sum", "mean", "prod", "min", "max", "clip", "round", "trace", "dot", "cumsum", "cumprod",
        "std", "var",
    ):  # fmt: skip
        setattr(TrackedArray, name, _method(name))
    for name in (
        "all", "any", "argmax", "argmin", "argpartition", "argsort", "choose", "conj", "conjugate",
        "nonzero", "ptp", "searchsorted", "byteswap", "getfield", "partition", "put",
        "sort",
    ):  # fmt: skip
        if hasattr(np.ndarray, name):
            setattr(TrackedArray, name, _plain_method(name))
    for name, method in {
        "astype": _astype,
        "tolist": _tolist,
        "item": _item,
        "fill": _fill,
        "T": property(_transposed),
    }.items():
        setattr(TrackedArray, name, method)


# ---------------------------------------------------------------- calls in instrumented code


def _advised_ufunc(ufunc: Any) -> Callable[..., Any]:
    def call(*args: Any, **keywords: Any) -> Any:
        if any(map(holds_tracked, args)):
            return call_ufunc(ufunc, "__call__", args, keywords)
        return ufunc(*args, **keywords)

    return call


def _advised(function: Any) -> Callable[..., Any]:
    tracked = FUNCTIONS[function]

    def call(*args: Any, **keywords: Any) -> Any:
        if any(map(holds_tracked, args)) or any(map(holds_tracked, keywords.values())):
            return tracked(*args, **keywords)
        return function(*args, **keywords)

    return call


def _making(function: Any) -> Callable[..., Any]:
    def call(*args: Any, **keywords: Any) -> Any:
        return make_array(function, args, keywords)

    return call


def _blank_making(function: Any) -> Callable[..., Any]:
    """zeros, eye, ...: an array into which tracked numbers may be put later."""

    def call(*args: Any, **keywords: Any) -> Any:
        if keywords:
            keywords = plain_deeply(keywords)
        return trackable(function(*map(plain_deeply, args), **keywords))

    return call


def _full(*args: Any, **keywords: Any) -> Any:
    found = trackable(np.full(*map(plain_deeply, args), **plain_deeply(keywords)))
    value = args[1] if len(args) > 1 else keywords.get("fill_value")
    if type(found) is TrackedArray and holds_tracked(value):
        note_assignment(found, ..., operand_of(value))
    return found


def _fill_advice() -> None:
    for ufunc in UFUNCS:
        ADVICE[id(ufunc)] = _advised_ufunc(ufunc)
    for function in FUNCTIONS:
        ADVICE[id(function)] = _advised(function)
    for name in ("array", "asarray", "asanyarray", "ascontiguousarray", "asfortranarray"):
        ADVICE[id(getattr(np, name))] = _making(getattr(np, name))
    for name in (
        "zeros", "ones", "empty", "eye", "identity", "zeros_like", "ones_like", "empty_like",
        "full_like",
    ):  # fmt: skip
        ADVICE[id(getattr(np, name))] = _blank_making(getattr(np, name))
    ADVICE[id(np.full)] = _full
    ADVICE[id(np.arange)] = array_algebra.arange
    for name in SCALARS:
        kind = getattr(np, name, None)  # not all in all versions
        if kind is not None:
            ADVICE[id(kind)] = array_algebra.scalar(kind)


def install() -> None:
    """Fills the tables of `array_calls`. Idempotent."""
    if not UFUNCS:
        _fill_ufuncs()
        _fill_moving()
        _fill_rules()
        array_algebra.install()
        _fill_methods()
    if not ADVICE:
        _fill_advice()
