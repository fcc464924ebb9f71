"""Tracked strings: how texts keep the pieces that they are made of.

Methods of `TrackedStr`, and what the rewriter puts around f-strings (`Interpolation`).
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from .operators import OPERATORS
from .text_operators import format_pieces, percent_pieces
from .values import TrackedStr, _install, is_tracked, record, untracked


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
    if type(args) is dict or percent_pieces(self._v, tuple(map(untracked, operands))) is None:
        return remembered(value, self, *_tracked_in(operands))
    return record(OPERATORS["percent"], value, self, *operands)


def _join(self: Any, parts: Any) -> Any:
    parts = list(parts)
    value = self._v.join([untracked(part) for part in parts])
    return record(OPERATORS["join"], value, self, *parts)


def _format(self: Any, *args: Any, **names: Any) -> Any:
    plain = [untracked(arg) for arg in args]
    value = self._v.format(*plain, **{name: untracked(arg) for name, arg in names.items()})
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
    return record(OPERATORS["remembered"], value, value, *sources)


def _simple(name: str) -> Callable[..., Any]:
    method = getattr(str, name)

    def wrapper(self: Any, *args: Any) -> Any:
        value = method(self._v, *args)
        return value if args else record(OPERATORS[name], value, self)

    wrapper.__name__ = name
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
    _function.__name__ = _name
    _install(TrackedStr, _name, _function)


# ---------------------------------------------------------------- f-strings


class Interpolation:
    """One f-string of the program: keeps what it interpolates, if any of it is tracked.

    The f-string itself stays, so that everything is evaluated and formatted by Python in Python's
    order; the rewriter puts ``begin()``, ``value(x)`` and ``end(token, text)`` around it and its
    values.

    parts  for each part (literal text, None, "") or (None, conversion, format specification);
           the specification is None if it is computed itself
    """

    def __init__(self, parts: tuple[tuple[str | None, str | None, str | None], ...]) -> None:
        self.parts = parts
        self.running = threading.local()

    def begin(self) -> int:
        """Called before the first part; the answer is given to `end`."""
        try:
            stack = self.running.stack
        except AttributeError:
            stack = self.running.stack = []
        stack.append([])
        return len(stack)

    def value(self, value: Any) -> Any:
        """Notes the value of the next part that is no literal text, and hands it on."""
        self.running.stack[-1].append(value)
        return value

    def end(self, token: int, text: str) -> Any:
        """The f-string's value, tracked if one of its parts is."""
        stack = self.running.stack
        values = stack[token - 1]
        del stack[token - 1 :]
        for value in values:
            if is_tracked(value):
                return self._recorded(text, values)
        return text

    def _recorded(self, text: str, values: list[Any]) -> Any:
        operands: list[Any] = []
        rest = iter(values)
        for literal, conversion, spec in self.parts:
            if literal is not None:
                operands += (literal, None, "")
            elif spec is None:
                return remembered(text, *_tracked_in(values))
            else:
                operands += (next(rest), conversion, spec)
        return record(OPERATORS["pieces"], text, *operands)


def tracked_str(value: Any) -> Any:
    """``str(value)`` with provenance."""
    if type(value) is TrackedStr:
        return value
    return record(OPERATORS["str"], str(untracked(value)), value)
