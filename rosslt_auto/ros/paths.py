"""Fields of messages by path, as one types them in Python after ``msg.``: ``points[3].x``."""

from __future__ import annotations

import math
import re
import struct
from typing import Any


class FieldError(ValueError):
    """A path that a message does not have, or a value that a field cannot hold."""


_STEP = re.compile(r"(?:^|\.)([A-Za-z_]\w*)|\[(\d+)\]")
_SEQUENCE = re.compile(r"sequence<(.+?)(?:, \d+)?>|(.+)\[\d+\]")


def normal(path: str) -> str:
    """The path as contract.md writes it; raises FieldError if it is none."""
    steps = _steps(path)
    return "".join(f"[{step}]" if type(step) is int else f".{step}" for step in steps).lstrip(".")


def _steps(path: str) -> list[str | int]:
    steps: list[str | int] = []
    at = 0
    while at < len(path):
        found = _STEP.match(path, at)
        if found is None:
            break
        steps.append(found[1] if found[1] is not None else int(found[2]))
        at = found.end()
    if at < len(path) or not steps or path[0] in ".[":
        raise FieldError(f"{path!r} is no field path, such as pose.position.x or points[3].x")
    return steps


def field_type(message_type: Any, path: str) -> str:
    """The type of a field as rosidl names it: ``double``, ``int32``, ``geometry_msgs/Point``.

    Raises FieldError, which names the fields that there are, if there is no such field.
    """
    kind = _message_name(message_type)
    cls: Any = message_type
    walked = ""
    for step in _steps(path):
        if type(step) is int:
            found = _SEQUENCE.fullmatch(kind)
            if found is None:
                raise FieldError(f"{walked} is no sequence but {kind}, there is no {path}")
            kind = found[1] or found[2]
            cls = None
            walked += f"[{step}]"
            continue
        cls = cls or _class_of(kind)
        fields = cls.get_fields_and_field_types() if cls is not None else {}
        if step not in fields:
            there = ", ".join(fields) or "none, it is no message"
            raise FieldError(f"no field {path}: {walked or kind} has no {step} (has: {there})")
        kind = fields[step]
        cls = None
        walked += f".{step}" if walked else str(step)
    return kind


def _message_name(cls: Any) -> str:
    return f"{cls.__module__.partition('.')[0]}/{cls.__name__}"


def _class_of(kind: str) -> Any:
    """The class of a nested message, None for anything else."""
    if "/" not in kind or _SEQUENCE.fullmatch(kind):
        return None
    import importlib

    package, _, name = kind.partition("/")
    name = name.rpartition("/")[2]
    return getattr(importlib.import_module(f"{package}.msg"), name, None)


def get(message: Any, path: str) -> Any:
    """The value of a field of this message; raises FieldError if it has none."""
    value = message
    for step in _steps(path):
        try:
            value = value[step] if type(step) is int else getattr(value, str(step))
        except (AttributeError, IndexError, TypeError, KeyError):
            raise FieldError(f"no field {path} in this message") from None
    return value


_INTEGERS = {
    f"{sign}int{bits}": (range(2**bits) if sign else range(-(2 ** (bits - 1)), 2 ** (bits - 1)))
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
} | {"char": range(256), "octet": range(256), "byte": range(256)}


def parse(kind: str, path: str, text: Any) -> Any:
    """A value for a field of this type, from a text or a Python value.

    A value for a float32 field is rounded as the field does. Raises FieldError.
    """
    if kind in ("float", "double"):
        value = _as_float(kind, path, text)
        return as_published(kind, value)
    if kind in _INTEGERS:
        value = _as_int(kind, path, text)
        if value not in _INTEGERS[kind]:
            raise FieldError(f"{path} is {kind}: {text} does not fit")
        return value
    if _STRING.fullmatch(kind):
        return str(text)
    if kind == "boolean":
        return _as_bool(path, text)
    raise FieldError(f"{path} is {kind}: name one number or text in it")


_STRING = re.compile(r"w?string(<\d+>)?")
_TRUTH = {"true": True, "false": False, "1": True, "0": False}


def _as_bool(path: str, text: Any) -> bool:
    value = _TRUTH.get(str(text).lower())
    if value is None:
        raise FieldError(f"{path} is boolean, {text!r} is neither true nor false")
    return value


def _as_float(kind: str, path: str, text: Any) -> float:
    try:
        value = float(text)
    except (ValueError, TypeError, OverflowError):
        raise FieldError(f"{path} is {kind}, {text!r} is no number") from None
    if not math.isfinite(value):
        raise FieldError(f"{path} must be finite, not {value}")
    return value


def _as_int(kind: str, path: str, text: Any) -> int:
    try:
        if isinstance(text, str):
            return int(text, 0)
        if int(text) == text:
            return int(text)
    except (ValueError, TypeError, OverflowError):
        pass
    raise FieldError(f"{path} is {kind}, {text!r} is no integer")


def as_published(kind: str, value: Any) -> Any:
    """What of a value arrives in a field of this type."""
    if kind != "float":
        return value
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        raise FieldError(f"{value} is too large for float32") from None
