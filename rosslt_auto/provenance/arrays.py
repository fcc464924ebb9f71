"""numpy arrays that remember where their elements came from, recorded per array operation.

A `TrackedArray` is a true ndarray with the plain data. Values always come from the plain operation
on plain arrays: same bits, type, memory, warnings and errors. Beside it goes a rule (`array_rules`)
from which the expression of an element is made when somebody asks for it.

An array may also be changed behind our back, through a plain view or by C code: an element whose
value is not the one that was recorded has no provenance any more.

This module imports numpy, so it is imported only when the program has done so.
"""

from __future__ import annotations

import dis
from collections.abc import Callable
from sys import _getframe
from types import CodeType, FunctionType
from typing import Any

import numpy as np

from . import array_calls, array_scalars, array_type, bindings
from .array_calls import ADVICE, FUNCTIONS, REDUCTIONS, _array_function, _array_ufunc, operate
from .array_type import (
    TrackedArray,
    elements,
    has_provenance,
    plain,
    replace_elements,
    trackable,
    with_elements,
)
from .elements import READERS
from .values import FOREIGN, PlainType

_ndarray = np.ndarray
_BINARY_OP = dis.opmap["BINARY_OP"]
_FIRST_IN_PLACE = 13  # NB_INPLACE_ADD
_codes: dict[int, tuple[CodeType, bytes]] = {}


def _in_operator() -> bool:
    """Whether the program is in an operator like ``a * b`` (not ``a *= b``)."""
    frame = _getframe(2)
    code = frame.f_code
    known = _codes.get(id(code))
    if known is None or known[0] is not code:
        if len(_codes) > 10_000:
            _codes.clear()
        known = _codes[id(code)] = (code, code.co_code)
    instructions, at_ = known[1], frame.f_lasti
    return instructions[at_] == _BINARY_OP and instructions[at_ + 1] < _FIRST_IN_PLACE


def _number_array_ufunc(cls: Any) -> Any:
    """``type(tracked number).__array_ufunc__``, which numpy looks up on the type.

    Asked in the middle of an operator whose left operand is an array or a scalar of numpy: None,
    so that numpy leaves the operator to the number's own reflected method (it would compute with
    plain numbers otherwise). Elsewhere a function, for numpy's functions called with the number.
    """
    if cls._plain is str:
        raise AttributeError("__array_ufunc__")
    return None if _in_operator() else _array_ufunc


def _number_array_function(cls: Any) -> Any:
    if cls._plain is str:
        raise AttributeError("__array_function__")
    return _array_function


def _is_numpys(other: Any) -> bool:
    return isinstance(other, (_ndarray, np.generic))


def install(hide: Callable[[FunctionType], Any] | None = None) -> None:
    """Lets tracked numbers work with numpy. Idempotent.

    hide  decorator for functions that stand between the program and numpy, so that tracebacks and
          warnings name the program's line
    """
    from . import array_functions

    array_scalars.install()
    array_functions.install()
    FOREIGN[:] = [_is_numpys, operate]
    PlainType.__array_ufunc__ = property(_number_array_ufunc)  # type: ignore[attr-defined]
    PlainType.__array_function__ = property(_number_array_function)  # type: ignore[attr-defined]
    bindings.CONTAINERS[id(TrackedArray)] = replace_elements
    if hide is not None:
        _hide_all(hide)


_hidden: dict[int, FunctionType] = {}


def uninstall() -> None:
    """Undoes `install`; arrays that exist keep working."""
    for name in ("__array_ufunc__", "__array_function__"):
        if name in vars(PlainType):
            delattr(PlainType, name)
    FOREIGN.clear()
    ADVICE.clear()
    array_scalars.uninstall()
    bindings.CONTAINERS.pop(id(TrackedArray), None)


def _hide_all(hide: Callable[[FunctionType], Any]) -> None:
    from . import (
        array_algebra,
        array_functions,
        array_methods,
        array_moving,
        array_reductions,
        array_ufuncs,
    )

    tables: list[Any] = [vars(TrackedArray), *map(vars, array_scalars.CLASSES.values())]
    modules = (
        array_type, array_calls, array_scalars, array_functions, array_algebra, array_methods,
        array_moving, array_reductions, array_ufuncs,
    )  # fmt: skip
    tables += [vars(module) for module in modules]
    tables += [FUNCTIONS, REDUCTIONS, ADVICE]
    for function in [function for table in tables for function in table.values()]:
        if type(function) is not FunctionType:
            continue
        ours = function.__globals__["__name__"].startswith(__package__)
        if ours and id(function) not in _hidden:
            _hidden[id(function)] = function
            hide(function)


READERS[id(TrackedArray)] = elements

__all__ = [
    "ADVICE",
    "TrackedArray",
    "elements",
    "has_provenance",
    "install",
    "plain",
    "replace_elements",
    "trackable",
    "uninstall",
    "with_elements",
]
