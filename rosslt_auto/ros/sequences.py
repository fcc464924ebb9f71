"""Sequences of numbers in messages: fields that remember where their elements came from.

rosidl's setters make an ``array.array`` or a numpy array of what is assigned, which holds bare
numbers. Join points: `__init__` and the setters of such fields, of the message types that a node
publishes or subscribes. The plain setter does the work, with its checks and its errors; what it has
made is replaced by the same array with provenance where an element has some.
"""

from __future__ import annotations

import array
from collections.abc import Callable, Sequence, Set
from typing import Any

import numpy as np
from rosidl_parser.definition import AbstractNestedType, Array, BasicType, NamespacedType

from ..provenance import arrays, sequences
from ..provenance.elements import READERS, any_tracked
from ..provenance.frames import unseen
from . import fields, flags

_FEW = 64
"""Fixed-size arrays up to this one (covariances, matrices) note what is assigned to elements."""

_array = array.array
_plain: dict[type, dict[str, Any]] = {}


def weave(message_type: type) -> None:
    """Weaves a message type and all that are nested in it, once."""
    if message_type in _plain or not fields.is_message_type(message_type):
        return
    replaced = _plain[message_type] = {}
    names = []
    truths = []
    for member in fields.members(message_type):
        kind = member.type
        below = kind.value_type if isinstance(kind, AbstractNestedType) else kind
        if isinstance(below, NamespacedType):
            weave(fields.message_class(below))
        elif (
            isinstance(kind, AbstractNestedType)
            and isinstance(below, BasicType)
            and fields.trackable_type(kind)
            and isinstance(vars(message_type).get(member.name), property)
        ):
            names.append((member.name, isinstance(kind, Array)))
        elif getattr(kind, "typename", "") == fields.TRUTH:
            truths.append(member.name)
    for name in truths:
        plain = replaced[name] = vars(message_type)[name]
        setter = flags.setter(message_type, name, plain.fset)
        setattr(message_type, name, property(plain.fget, setter, plain.fdel, plain.__doc__))
    for name, fixed in names:
        plain = replaced[name] = vars(message_type)[name]
        setter = _setter(plain.fset, "_" + name, fixed)
        setattr(message_type, name, property(plain.fget, setter, plain.fdel, plain.__doc__))
    given = frozenset(name for name, fixed in names if not fixed)
    if given:
        replaced["__init__"] = message_type.__init__  # type: ignore[misc]
        message_type.__init__ = _init(message_type.__init__, given)  # type: ignore[misc]


def uninstall() -> None:
    """Makes all message types plain again."""
    for message_type, replaced in _plain.items():
        for name, plain in replaced.items():
            setattr(message_type, name, plain)
    _plain.clear()


def _setter(plain: Callable[[Any, Any], None], slot: str, fixed: bool) -> Callable[..., None]:
    after = _after_fixed if fixed else _after

    @unseen
    def setter(message: Any, value: Any) -> None:
        kind = type(value)
        if kind is _array or kind is np.ndarray:
            plain(message, value)
            if fixed or not len(value):
                after(message, slot, value)
            return
        value, original = _readable(value)
        plain(message, value)
        after(message, slot, original)

    return setter


def _readable(value: Any) -> tuple[Any, Any]:
    """What to give the plain setter, and what its elements are to be read from afterwards."""
    kind = type(value)
    if kind is list or kind is tuple or id(kind) in READERS:
        return value, value
    if isinstance(value, (Sequence, Set, str, bytes, bytearray)) or not hasattr(kind, "__iter__"):
        return value, value
    seen: list[Any] = []  # read once: a generator
    add = seen.append

    @unseen
    def note(item: Any) -> Any:
        add(item)
        return item

    return map(note, value), seen


def _after(message: Any, slot: str, original: Any) -> None:
    held = getattr(message, slot)
    if type(held) is _array:
        if len(held):
            shadow = sequences.shadow(held.typecode, held, original)
            if shadow is not held:
                setattr(message, slot, shadow)
        else:
            setattr(message, slot, sequences.trackable(held))  # to be appended to


def _after_fixed(message: Any, slot: str, original: Any) -> None:
    held = getattr(message, slot)
    if type(held) is not np.ndarray or held.ndim != 1:
        return
    kind = type(original)
    read = READERS.get(id(kind))
    items: Any = read(original) if read is not None else original
    if type(items) in (list, tuple) and len(items) == len(held) and any_tracked(items):
        setattr(message, slot, arrays.with_elements(held, items))
    elif len(held) <= _FEW:
        setattr(message, slot, arrays.trackable(held))


def _init(plain: Callable[..., None], names: frozenset[str]) -> Callable[..., None]:
    """Around a constructor, which makes an array of a keyword before its setter sees it."""

    @unseen
    def __init__(message: Any, *args: Any, **keywords: Any) -> None:
        given = names.intersection(keywords)
        if not given:
            plain(message, *args, **keywords)
            return
        originals = {}
        for name in given:
            keywords[name], originals[name] = _readable(keywords[name])
        plain(message, *args, **keywords)
        for name, original in originals.items():
            _after(message, "_" + name, original)

    __init__.__doc__ = plain.__doc__
    __init__.__qualname__ = plain.__qualname__
    __init__.__module__ = plain.__module__
    __init__.__wrapped__ = plain  # type: ignore[attr-defined]
    return __init__


__all__ = ["uninstall", "weave"]
