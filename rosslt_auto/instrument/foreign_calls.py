"""What is called with texts, in rewritten code: ``@rosslt.for_texts(Proj)("utm")``.

Extensions may insist on exactly str (Cython does so for arguments that are declared ``str``), and
what wraps them hands on what it gets. A text that goes into modules that are not instrumented is
therefore plain. Not so in those that come with Python, numpy and ROS, which take subclasses.
"""

from __future__ import annotations

import builtins
import functools
import sys
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.values import TrackedStr, untracked
from .wrappers import Function

FOR_TEXTS = "@rosslt.for_texts"
"""The name under which rewritten code finds `for_texts`, in `builtins`."""

KEEPING = frozenset(
    {"add", "append", "appendleft", "extend", "format", "insert", "join", "put", "remove", "update"}
)
"""Methods that are called too often for looking at whose they are: of containers, mostly."""

_TAKING_SUBCLASSES = sys.stdlib_module_names | {"numpy", "rclpy", "rosslt_auto"}
_OF_INTERFACES = frozenset({"action", "msg", "srv"})
_module_of_class: Any = vars(type)["__module__"].__get__

_foreign: dict[str, bool] = {}
"""Whether modules want plain texts, by name."""


@unseen
def for_texts(function: Function, /) -> Function:
    """`function`, or what calls it with plain texts if it is of a module that wants them."""
    module = _module_of(function)
    if type(module) is not str:
        return function
    foreign = _foreign.get(module)
    if foreign is None:
        foreign = _foreign[module] = _is_foreign(module)
    return functools.partial(_with_plain_texts, function) if foreign else function


@unseen
def _with_plain_texts(function: Function, /, *args: Any, **keywords: Any) -> Any:
    return function(*map(_plain, args), **{name: _plain(one) for name, one in keywords.items()})


def note(module: str) -> None:
    """Notes that a module is instrumented."""
    _foreign[module] = False


@unseen
def _plain(value: Any) -> Any:
    return untracked(value) if type(value) is TrackedStr else value


def _is_foreign(module: str) -> bool:
    package, *rest = module.split(".")
    return package not in _TAKING_SUBCLASSES and _OF_INTERFACES.isdisjoint(rest)


@unseen
def _module_of(function: Any) -> Any:
    """The name of the module that a callable belongs to; asks no code of the program for it."""
    kind = type(function)
    if kind is FunctionType or kind is MethodType:
        return function.__module__
    if kind is BuiltinFunctionType:
        owner = function.__self__
        if type(owner) is ModuleType:
            return function.__module__
        return _module_of_class(owner if isinstance(owner, type) else type(owner))
    if kind is functools.partial:
        return _module_of(function.func)
    return _module_of_class(function if issubclass(kind, type) else kind)


def publish() -> None:
    """Lets rewritten code find `for_texts`."""
    setattr(builtins, FOR_TEXTS, for_texts)
