"""Tracked strings: how texts keep the pieces that they are made of.

Methods of `TrackedStr`, and what the rewriter puts around f-strings (`Interpolation`).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from .elements import any_tracked
from .operators import OPERATORS, Operator
from .text_operators import format_pieces, formatted, percent_pieces
from .values import (
    PlainType,
    TrackedFloat,
    TrackedInt,
    TrackedStr,
    deferred,
    give_method,
    is_tracked,
    record,
    untracked,
)


def _add(self: Any, other: Any) -> Any:
    if not isinstance(other, str):
        return self._v + other  # another class may know how; else Python's own error
    return record(OPERATORS["concat"], self._v + untracked(other), self, other)


def _radd(self: Any, other: Any) -> Any:
    if not isinstance(other, str):
        return NotImplemented
    return record(OPERATORS["concat"], untracked(other) + self._v, other, self)


def _mul(self: Any, count: Any) -> Any:
    if not isinstance(count, int):
        return self._v * count
    return record(OPERATORS["repeat"], self._v * untracked(count), self, count)


def _getitem(self: Any, key: Any) -> Any:
    value = self._v[untracked(key)]
    if isinstance(key, slice):
        bounds = (untracked(key.start), untracked(key.stop), untracked(key.step))
        return record(OPERATORS["slice"], value, self, *bounds)
    return record(OPERATORS["slice"], value, self, untracked(key))


def _mod(self: Any, args: Any) -> Any:
    plain = tuple(untracked(arg) for arg in args) if type(args) is tuple else untracked(args)
    value = self._v % plain
    operands = args if type(args) is tuple else (args,)
    if (
        type(args) is dict
        or not _are_values(operands)
        or percent_pieces(self._v, tuple(map(untracked, operands))) is None
    ):
        return remembered(value, self, *_tracked_in(operands))
    return record(OPERATORS["percent"], value, self, *operands)


_MANY = 256
"""A text of more parts than this is a document."""


def _join(self: Any, parts: Any) -> Any:
    if not hasattr(type(parts), "__iter__") and not hasattr(type(parts), "__getitem__"):
        return self._v.join(parts)  # Python's own error
    parts = list(parts)
    value = self._v.join([untracked(part) for part in parts])
    if len(parts) > _MANY or not any_tracked(parts):
        return value
    return record(OPERATORS["join"], value, self, *parts)


def _format(self: Any, *args: Any, **names: Any) -> Any:
    plain = [untracked(arg) for arg in args]
    value = self._v.format(*plain, **{name: untracked(arg) for name, arg in names.items()})
    if not _are_values((*args, *names.values())):
        return remembered(value, self, *_tracked_in((*args, *names.values())))
    if not names and format_pieces(self._v, tuple(plain), {}) is not None:
        return record(OPERATORS["format"], value, self, *args)
    pieces = format_pieces(self._v, args, names)
    if pieces is None:
        return remembered(value, self, *_tracked_in((*args, *names.values())))
    return record(OPERATORS["pieces"], value, *(part for piece in pieces for part in piece))


def _tracked_in(values: Any) -> list[Any]:
    return [value for value in values if is_tracked(value)]


def remembered(value: str, *sources: Any) -> Any:
    """`value` with the knowledge of what it was made from, but no way back."""
    cores = [getattr(source, "_core", source) for source in sources]
    return record(OPERATORS["remembered"], value, value, *cores)


def _simple(name: str) -> Callable[..., Any]:
    method = getattr(str, name)

    def wrapper(self: Any, *args: Any) -> Any:
        value = method(self._v, *args)
        return value if args else record(OPERATORS[name], value, self)

    return wrapper


for _name, _function in {
    "__add__": _add,
    "__radd__": _radd,
    "__mul__": _mul,
    "__rmul__": _mul,
    "__getitem__": _getitem,
    "__mod__": _mod,
    "join": _join,
    "format": _format,
    "upper": _simple("upper"),
    "lower": _simple("lower"),
    "strip": _simple("strip"),
}.items():
    give_method(TrackedStr, str, _name, _function)


# ---------------------------------------------------------------- f-strings

_FORGOTTEN = 2000


class Interpolation:
    """One f-string of the program: keeps what it interpolates, if any of it is tracked.

    The f-string itself stays, so that everything is evaluated and formatted by Python in Python's
    order; the rewriter puts ``begin()``, ``value(x)`` and ``end(token, text)`` around it and its
    values, or hands the values to ``text(text, *values)`` afterwards.

    parts  for each part (literal text, None, "") or (None, conversion, format specification);
           the specification is None if it is computed itself
    """

    def __init__(self, parts: tuple[tuple[str | None, str | None, str | None], ...]) -> None:
        self.parts = parts
        self.count = sum(literal is None for literal, _, _ in parts)
        self.running = threading.local()

    def __deepcopy__(self, memo: Any) -> Any:
        """Programs that copy the namespace `builtins` may do so."""
        return self

    def text(self, text: str, *values: Any) -> Any:
        """The f-string's value, tracked if one of the values is that it interpolates."""
        for value in values:
            if type(type(value)) is PlainType:
                return self._recorded(text, values)
        return text

    def begin(self) -> Any:
        """Called before the first part; the answer is given to `end`."""
        try:
            stack = self.running.stack
        except AttributeError:
            stack = self.running.stack = []
        if len(stack) > _FORGOTTEN:  # those that an exception has left behind
            del stack[: _FORGOTTEN // 2]
        values: list[Any] = []
        stack.append(values)
        return values

    def value(self, value: Any) -> Any:
        """Notes the value of the next part that is no literal text, and hands it on."""
        stack = self.running.stack
        if stack:
            stack[-1].append(value)
        return value

    def end(self, token: Any, text: str) -> Any:
        """The f-string's value, tracked if one of its parts is."""
        stack = self.running.stack
        while stack and stack.pop() is not token:
            pass  # one inside of this one, left by an exception
        if len(token) == self.count:  # not so if such a one has taken some of the values
            for value in token:
                if type(type(value)) is PlainType:
                    return self._recorded(text, token)
        return text

    def _recorded(self, text: str, values: Sequence[Any]) -> Any:
        """The text with its pieces: Python's own values are taken apart when somebody asks."""
        depth = 0
        for value in values:
            kind = type(value)
            if kind is TrackedFloat or kind is TrackedInt or kind is TrackedStr:
                if value._depth > depth:
                    depth = value._depth
            elif kind is not float and kind is not int and kind is not str:
                return self._taken_apart(text, values)
        return deferred(text, partial(self._expression, text, tuple(values)), depth + 1)

    def _expression(self, text: str, values: Sequence[Any]) -> tuple[Operator, Any, Any]:
        found = self._taken_apart(text, values)
        return found._op, found._a, found._b

    def _taken_apart(self, text: str, values: Sequence[Any]) -> Any:
        operands: list[Any] = []
        rest = iter(values)
        for literal, conversion, spec in self.parts:
            if literal is not None:
                operands += (literal, None, "")
            elif spec is None:
                return remembered(text, *_tracked_in(values))
            else:
                piece = _piece(next(rest), conversion, spec)
                if piece is None:
                    return remembered(text, *_tracked_in(values))
                operands += piece
        return record(OPERATORS["pieces"], text, *operands)


def _piece(value: Any, conversion: str | None, spec: str) -> Any:
    """A value with how it is formatted, as operands; None for an object that is no value.

    Values that expressions do not have stand there as the text that they give.
    """
    kind = type(value)
    if kind is float or kind is int or kind is str:
        return value, conversion, spec
    if type(kind) is PlainType:
        core = getattr(value, "_core", value)
        if core is value:
            return value, conversion, spec
        shown = formatted(value._v, conversion, spec)  # a scalar of numpy
        if formatted(core._v, conversion, spec) == shown:
            return core, conversion, spec
        return shown, None, ""
    if kind is bool or value is None or kind.__module__ == "numpy":
        return formatted(value, conversion, spec), None, ""
    return None  # asking it for its text once more might do something


def _are_values(operands: Any) -> bool:
    """Whether expressions can have all of these as operands."""
    return all(
        is_tracked(value) or type(value) in (float, int, str) for value in operands
    ) and not any(hasattr(value, "_core") for value in operands)


def tracked_str(value: Any) -> Any:
    """``str(value)`` with provenance."""
    if type(value) is TrackedStr:
        return value
    return record(OPERATORS["str"], str(untracked(value)), value)
