"""Which functions belong to a class, a function, or a module: also those behind decorators."""

from __future__ import annotations

import functools
import gc
from collections.abc import Iterable, Iterator
from types import CellType, FunctionType, MethodType, ModuleType
from typing import Any

_FOLLOWED = (
    FunctionType, MethodType, CellType, staticmethod, classmethod, property, functools.partial,
    functools.partialmethod, functools.cached_property, functools.singledispatchmethod,
    type(functools.lru_cache(lambda: None)),
)  # fmt: skip
"""What is looked into wherever it is found: wrappers and descriptors."""


def functions_behind(*things: Any) -> Iterator[FunctionType]:
    """The functions that `things` are, wrap, or hold in their closures; each once, `things` first.

    Nothing of the program's own is called: attributes are not asked for, references are followed.
    """
    seen: set[int] = set()
    queue = [thing for thing in things if not isinstance(thing, (type, ModuleType))]
    for thing in queue:  # grows
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        if type(thing) is FunctionType:
            yield thing
            inner: Iterable[Any] = (*(thing.__closure__ or ()), *vars(thing).values())
        elif isinstance(thing, type) or type(thing) is ModuleType:
            continue
        else:
            inner = _held_by(thing)
        queue += [one for one in inner if isinstance(one, _FOLLOWED)]


def _held_by(thing: Any) -> Iterator[Any]:
    for held in gc.get_referents(thing):
        yield held
        if type(held) is dict:  # the attributes of an object
            yield from held.values()


def classes_within(cls: type) -> Iterator[type]:
    """`cls` and the classes that are nested in it."""
    queue = [cls]
    for one in queue:  # grows
        yield one
        queue += [
            inner
            for name, inner in vars(one).items()
            if isinstance(inner, type)
            and inner.__module__ == one.__module__
            and inner.__qualname__ == f"{one.__qualname__}.{name}"
        ]


def functions_of_class(cls: type) -> list[FunctionType]:
    """The functions that stand in the body of a class (not those of its bases)."""
    prefix = f"{cls.__qualname__}."
    return [
        function
        for function in functions_behind(*vars(cls).values())
        if function.__code__.co_qualname.startswith(prefix)
        and function.__globals__.get("__name__") == cls.__module__
    ]


def functions_of_module(module: ModuleType) -> list[FunctionType]:
    """All functions whose global names are those of a module, wherever they are kept."""
    names = vars(module)
    return [
        thing
        for thing in (*gc.get_objects(), *functions_behind(*names.values()))
        if type(thing) is FunctionType and thing.__globals__ is names
    ]
