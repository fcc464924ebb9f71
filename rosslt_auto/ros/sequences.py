"""Sequences of numbers in messages: fields that remember where their elements came from.

rosidl's setters make an ``array.array`` or a numpy array of what is assigned, which holds bare
numbers. Join points: `__init__` and the setters of such fields, and of truth values (`flags`), in
all message types that a program imports - as far as instrumented code mentions the field's name
(`mentioned`): all others cost what they did. The plain setter does the work, with its checks and
its errors; what it has made is replaced by the same array with provenance where an element has
some.
"""

from __future__ import annotations

import array
import logging
import re
from collections.abc import Callable, Sequence, Set
from functools import partial
from typing import Any

import numpy as np
from rosidl_parser.definition import AbstractNestedType, Array, BasicType, NamespacedType

from ..provenance import arrays, mentioned, sequences
from ..provenance.elements import READERS, all_exact, any_tracked
from ..provenance.frames import unseen
from ..provenance.imported import AfterImports
from . import fields, flags

_FEW = 64
"""Fixed-size arrays up to this one (covariances, matrices) note what is assigned to elements."""

_BYTES = "bB"
"""Type codes of ``int8[]`` and ``uint8[]``."""

_array = array.array
_trackable = sequences.TrackableBuffer
_log = logging.getLogger(__name__)
_plain: dict[type, dict[str, Any]] = {}
_waiting: dict[str, list[Callable[[], None]]] = {}
"""What weaves the fields of a name that no instrumented code has mentioned yet."""


def install() -> None:
    """Weaves the message types that are imported, and those that will be."""
    _imported.install()


def uninstall() -> None:
    """Makes all message types plain again."""
    _imported.uninstall()
    if _weave_mentioned in mentioned.watchers:
        mentioned.watchers.remove(_weave_mentioned)
    for message_type, replaced in _plain.items():
        for name, plain in replaced.items():
            setattr(message_type, name, plain)
    _plain.clear()
    _waiting.clear()


_GENERATED = re.compile(r"(\w+)\.(msg|srv|action)\._\w+")
_INFRASTRUCTURE = frozenset(
    {"action_msgs", "builtin_interfaces", "lifecycle_msgs", "rcl_interfaces", "rosgraph_msgs",
     "service_msgs", "type_description_interfaces", "unique_identifier_msgs"}
)  # fmt: skip
"""Packages of the client library's own messages, which it makes by the thousand."""


def _is_generated(name: str) -> bool:
    """Whether a module of this name defines messages of programs."""
    match = _GENERATED.fullmatch(name)
    return match is not None and match[1] not in _INFRASTRUCTURE


def _weave_module(module: Any) -> None:
    for thing in list(vars(module).values()):
        if isinstance(thing, type) and thing.__module__ == module.__name__:
            try:
                weave(thing)
            except Exception as error:
                _log.warning("no provenance in sequences of %s: %r", thing.__name__, error)


_imported = AfterImports(_is_generated, _weave_module)


def weave(message_type: type) -> None:
    """Weaves a message type and all that are nested in it, once."""
    if message_type in _plain or not fields.is_message_type(message_type):
        return
    if _weave_mentioned not in mentioned.watchers:
        mentioned.watchers.append(_weave_mentioned)
    replaced = _plain[message_type] = {}
    slots: dict[str, str] = {}
    for member in fields.members(message_type):
        kind = member.type
        below = kind.value_type if isinstance(kind, AbstractNestedType) else kind
        if isinstance(below, NamespacedType):
            try:
                nested = fields.message_class(below)
            except AttributeError:  # its package is being imported: woven when it is there
                continue
            weave(nested)
        elif isinstance(below, BasicType) and isinstance(
            vars(message_type).get(member.name), property
        ):
            is_truth = below is kind and below.typename == fields.TRUTH
            if is_truth or (below is not kind and fields.trackable_type(kind)):
                advise = partial(_advise, message_type, member, replaced, slots)
                _waiting.setdefault(member.name, []).append(advise)
    _weave_mentioned()


def _weave_mentioned() -> None:
    """Weaves the fields of whose names instrumented code knows by now.

    All others stay plain: their messages cost what they did.
    """
    for name in [name for name in _waiting if mentioned.is_mentioned(name)]:
        for advise in _waiting.pop(name):
            advise()


def _advise(
    message_type: Any, member: fields.Member, replaced: dict[str, Any], slots: dict[str, str]
) -> None:
    """Weaves one field.

    replaced  takes what there was before
    slots     takes the field if it is a sequence of numbers; their constructor reads it
    """
    name, slot, kind = member.name, member.slot, member.type
    plain = vars(message_type)[name]
    if not isinstance(kind, AbstractNestedType):
        setter = flags.setter(message_type, name, plain.fset)
    else:
        quick = None
        if not isinstance(kind, Array):
            slots[name] = slot
            quick = _quick_setter(message_type, plain.fset, slot)
        setter = quick or _setter(plain.fset, slot, isinstance(kind, Array))
    replaced[name] = plain
    setattr(message_type, name, property(plain.fget, setter, plain.fdel, plain.__doc__))
    if slots and "__init__" not in replaced:
        replaced["__init__"] = message_type.__init__
        message_type.__init__ = _init(message_type.__init__, slots)


def _setter(plain: Callable[[Any, Any], None], slot: str, fixed: bool) -> Callable[..., None]:
    after = _after_fixed if fixed else _after

    @unseen
    def setter(message: Any, value: Any) -> None:
        kind = type(value)
        if kind is _array or kind is np.ndarray:
            plain(message, value)
            after(message, slot, value)
            return
        value, original = _readable(value)
        plain(message, value)
        after(message, slot, original)

    return setter


def _quick_setter(
    message_type: type, plain: Callable[[Any, Any], None], slot: str
) -> Callable[..., None] | None:
    """`_setter` for sequences, which makes the array itself where nothing tracked is assigned.

    None where the plain setter is another one than we know: without checks it copies everything.
    """
    thorough = _setter(plain, slot, False)
    store = vars(message_type)[slot].__set__
    try:
        probe: Any = object.__new__(message_type)
        probe._check_fields = False
        plain(probe, [])
        typecode = getattr(probe, slot).typecode
        given = _array(typecode)
        plain(probe, given)
        if type(getattr(probe, slot)) is not _array or getattr(probe, slot) is given:
            return None
    except Exception:
        return None

    @unseen
    def setter(message: Any, value: Any) -> None:
        kind = type(value)
        if (kind is _array or kind is list or kind is tuple) and not message._check_fields:
            data = _is_data(typecode, value)
            if data or kind is _array or all_exact(value) or not any_tracked(value):
                try:
                    made = (_array if data else _trackable)(typecode, value)
                except Exception:
                    made = None  # the plain setter is to say so
                if made is not None:
                    store(message, made)
                    return
        thorough(message, value)

    return setter


def _is_data(typecode: str, items: Any) -> bool:
    """Whether these are the bytes of something, an image or a map: nothing is to be asked of it."""
    return typecode in _BYTES and len(items) > fields.LONG


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
    """Gives a slot's array, which the plain setter or constructor has made, its provenance."""
    held = getattr(message, slot)
    # The program's own array stays that; a constructor's has come through the setter already.
    if (type(held) is not _array and type(held) is not _trackable) or held is original:
        return
    kind = type(original)
    if _is_data(held.typecode, held):
        return
    if kind is list or kind is tuple or id(kind) in READERS:
        shadow = sequences.shadow(held.typecode, held, original)
        if shadow is not held:
            setattr(message, slot, shadow)
            return
    if type(held) is _array and len(held) <= fields.LONG:  # to be filled later
        setattr(message, slot, sequences.trackable(held))


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


def _init(plain: Callable[..., None], slots: dict[str, str]) -> Callable[..., None]:
    """Around a constructor, which makes arrays before their setters see what was given for them.

    slots  of the fields that are sequences of numbers, by name
    """

    names = slots.keys()

    @unseen
    def __init__(message: Any, *args: Any, **keywords: Any) -> None:
        originals = {}
        if keywords and not names.isdisjoint(keywords):
            for name in names & keywords.keys():
                keywords[name], originals[name] = _readable(keywords[name])
        plain(message, *args, **keywords)
        for name, slot in slots.items():
            if name in originals or type(getattr(message, slot)) is _array:
                _after(message, slot, originals.get(name))

    __init__.__doc__ = plain.__doc__
    __init__.__qualname__ = plain.__qualname__
    __init__.__module__ = plain.__module__
    __init__.__wrapped__ = plain  # type: ignore[attr-defined]
    return __init__


__all__ = ["install", "uninstall", "weave"]
