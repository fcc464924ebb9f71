"""Scalars of numpy that remember where they came from: what ``array[i]`` gives.

True subclasses of ``numpy.float64`` and the other real types. The node of the expression graph is
a tracked Python number beside it, the core, so that expressions consist of Python numbers only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .array_rules import core_of
from .expressions import is_leaf
from .operators import OPERATORS, Operator
from .values import (
    MORE_KINDS,
    PlainType,
    as_plain,
    give_method,
    is_tracked,
    node,
    record,
    untracked,
)

_SAME = OPERATORS["same"]
_NUMBERS = (float, int)

CLASSES: dict[int, Any] = {}
"""The tracked class by the id of the plain type."""


def scalar(value: Any, core: Any) -> Any:
    """`value`, a scalar of numpy, with the provenance of `core`; as it is if that is plain."""
    cls = CLASSES.get(id(type(value)))
    if cls is None or not is_tracked(core):
        return value
    made = cls._plain.__new__(cls, value)
    made._v = value
    made._core = core
    return made


def _make(value: Any, op: Operator, a: Any, b: Any, depth: int) -> Any:
    """As `values.node`, for scalars of numpy."""
    return scalar(value, node(value.item(), op, a, b, depth))


def _operator(self: Any) -> Operator:
    return _SAME if is_leaf(self._core) else self._core._op


def _first(self: Any) -> Any:
    return self._core if is_leaf(self._core) else self._core._a


def _second(self: Any) -> Any:
    return None if is_leaf(self._core) else self._core._b


def _item(self: Any, *args: Any) -> Any:
    plain = self._v.item(*args)
    return self._core if type(plain) is type(self._core._v) else plain


def _class(plain: Any) -> Any:
    names = {  # no slots: a class with slots cannot have a metaclass and float64 as base
        "_plain": plain,
        "__class__": property(lambda self: plain),
        "__hash__": plain.__hash__,
        "_op": property(_operator),
        "_a": property(_first),
        "_b": property(_second),
        "_depth": property(lambda self: self._core._depth or 1),
        "_like": lambda self, core: scalar(plain(untracked(core)), core),
        "_set": lambda self, *row: self._core._set(*row),
        "__repr__": lambda self: repr(self._v),
        "__str__": lambda self: str(self._v),
        "__reduce__": lambda self: self._v.__reduce__(),
        "__reduce_ex__": lambda self, protocol: self._v.__reduce_ex__(protocol),
        "__copy__": lambda self: self,
        "__deepcopy__": lambda self, memo: self,
        "__sizeof__": lambda self: self._v.__sizeof__(),
        "__dir__": lambda self: dir(self._v),
        "__doc__": plain.__doc__,
        "__module__": as_plain("__module__"),
        "__dict__": as_plain("__dict__"),
    }
    for name in ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow"):
        op = OPERATORS[name]
        names[f"__{name}__"] = _binary(getattr(plain, f"__{name}__"), op, reflected=False)
        names[f"__r{name}__"] = _binary(getattr(plain, f"__r{name}__"), op, reflected=True)
    for name in ("neg", "pos", "abs"):
        names[f"__{name}__"] = _unary(getattr(plain, f"__{name}__"), OPERATORS[name])
    if hasattr(plain, "__round__"):
        names["__round__"] = _round
    made = PlainType(plain.__name__, (plain,), names)
    for name in ("item", "tolist"):
        give_method(made, plain, name, _item)
    return made


def _binary(method: Callable[..., Any], op: Operator, reflected: bool) -> Callable[..., Any]:
    def call(self: Any, other: Any, *modulus: Any) -> Any:
        if isinstance(other, np.ndarray):
            from .array_calls import operate

            return operate(op, other, self) if reflected else operate(op, self, other)
        value = method(self._v, untracked(other), *modulus)
        if value is NotImplemented and isinstance(other, np.generic):
            # numpy has left the operator to us, see `arrays._number_array_ufunc`
            pair = (untracked(other), self._v) if reflected else (self._v, untracked(other))
            value = op.forward(*pair)
        theirs = core_of(other)
        if modulus or not isinstance(theirs, _NUMBERS):
            return value
        if reflected:
            return record(op, value, theirs, self._core)
        return record(op, value, self._core, theirs)

    return call


def _unary(method: Callable[..., Any], op: Operator) -> Callable[..., Any]:
    return lambda self: record(op, method(self._v), self._core)


def _round(self: Any, digits: Any = None) -> Any:
    if digits is None:
        return record(OPERATORS["round"], round(self._v), self._core)
    return record(OPERATORS["round"], round(self._v, untracked(digits)), self._core, digits)


_TYPES = (
    np.float16, np.float32, np.float64, np.int8, np.int16, np.int32, np.int64, np.longlong,
    np.uint8, np.uint16, np.uint32, np.uint64, np.ulonglong,
)  # fmt: skip


def install() -> None:
    """Lets `values.node` make scalars of numpy."""
    for plain in _TYPES:
        if id(plain) not in CLASSES:
            CLASSES[id(plain)] = _class(plain)
        MORE_KINDS[id(plain)] = _make


def uninstall() -> None:
    for plain in _TYPES:
        MORE_KINDS.pop(id(plain), None)
