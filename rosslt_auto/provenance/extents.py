"""Operations whose result can be far larger than their operands: computed only where it is not.

An expression may come from the network, and inverting one tries values that nobody has ever
computed with: ``x ** y``, ``text * n`` or a format's width could take all memory, or for ever. The
rows of such operators look at their operands first, and `Budget` at what a whole expression adds
up to.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Sequence
from typing import Any

from .operator_table import AnyOperands, Operator

BITS = 1 << 15
"""An integer has no more bits than this."""

CHARACTERS = 1 << 18
"""A text has no more characters than this."""

BYTES = 1 << 23
"""All intermediate results of one evaluation have about so many bytes at most."""

_DIGITS = 400
_MODULUS_BITS = 1 << 11
_NUMBER = re.compile(r"\d+")
_FIELD = re.compile(r"[{%]")
_COMPUTED_WIDTH = re.compile(r"\*|\{[^{}]*\{")


class TooLarge(OverflowError):
    """A result would be too large to be computed."""

    def __init__(self, name: str) -> None:
        super().__init__(f"the result of {name} would be too large")


class Budget:
    """What the intermediate results of one evaluation may come to."""

    def __init__(self) -> None:
        self.left = BYTES

    def take(self, name: str, result: Any) -> None:
        """Counts a result of the operator called `name`; raises TooLarge."""
        kind = type(result)
        if kind is float:
            return
        if kind is int:
            bits = result.bit_length()
            self.left -= bits >> 3
            if bits > BITS or self.left < 0:
                raise TooLarge(name)
        elif kind is str:
            self.left -= len(result)
            if len(result) > CHARACTERS or self.left < 0:
                raise TooLarge(name)


def _power(a: Any, b: Any) -> bool:
    return type(a) is int and type(b) is int and b > 0 and a.bit_length() * b > BITS


def _shifted(a: Any, b: Any) -> bool:
    return type(a) is int and type(b) is int and a.bit_length() + b > BITS


def _modular(a: Any, b: Any, modulus: Any) -> bool:
    return any(type(x) is int and x.bit_length() > _MODULUS_BITS for x in (a, b, modulus))


def _rounded(a: Any, digits: Any = None) -> bool:
    return type(digits) is int and abs(digits) > _DIGITS


def _repeated(a: Any, b: Any) -> bool:
    text, count = (a, b) if type(a) is str else (b, a)
    return type(text) is str and type(count) is int and len(text) * count > CHARACTERS


def _texts(*operands: Any) -> bool:
    return sum(len(x) for x in operands if type(x) is str) > CHARACTERS


def _joined(separator: Any, *parts: Any) -> bool:
    length = len(separator) * len(parts) if type(separator) is str else 0
    return length > CHARACTERS or _texts(*parts)


def _templated(template: Any, *operands: Any) -> bool:
    """Widths and precisions stand in the template or, where it says so, among the operands."""
    if type(template) is not str:
        return True
    length = _widths(template) + sum(len(x) for x in operands if type(x) is str)
    if _COMPUTED_WIDTH.search(template):
        length += sum(abs(x) for x in operands if type(x) is int)
    return len(template) > CHARACTERS or length * len(_FIELD.findall(template)) > CHARACTERS


def _pieced(*operands: Any) -> bool:
    widths = sum(_widths(spec) for spec in operands[2::3] if type(spec) is str)
    return widths > CHARACTERS or _texts(*operands)


def _widths(spec: str) -> int:
    """The sum of all numbers in it: a width, a precision, or just text."""
    return sum(int(number) if len(number) < 9 else CHARACTERS + 1
               for number in _NUMBER.findall(spec))  # fmt: skip


_TOO_LARGE: dict[str, Callable[..., bool]] = {
    "pow": _power,
    "lshift": _shifted,
    "powmod": _modular,
    "round": _rounded,
    "repeat": _repeated,
    "repr": _texts,
    "join": _joined,
    "percent": _templated,
    "format": _templated,
    "pieces": _pieced,
}
"""Which operands of an operator give too large a result, by its name."""


def check(name: str, operands: Sequence[Any]) -> None:
    """Raises TooLarge if an operator's plain operands give too large a result."""
    too_large = _TOO_LARGE.get(name)
    if too_large is not None and too_large(*operands):
        raise TooLarge(name)


def bound(rows: dict[str, Operator]) -> None:
    """Makes these rows of a table raise TooLarge instead of computing something too large."""
    for name, too_large in _TOO_LARGE.items():
        row = rows[name]
        row.forward = _bounded(name, too_large, row.forward, 0)
        row.inverses = tuple(_bounded_or_none(name, too_large, f, 1) for f in row.inverses)
        row.partials = tuple(_bounded_or_none(name, too_large, f, 0) for f in row.partials)
        if isinstance(row, AnyOperands):
            row.make_inverse = _bounded_maker(name, too_large, row.make_inverse)


def _bounded(
    name: str, too_large: Callable[..., bool], plain: Callable[..., Any], skipped: int
) -> Callable[..., Any]:
    """skipped: how many arguments stand before the operands, an inverse's target."""

    @functools.wraps(plain)  # with its signature: it tells how many operands there are
    def function(*args: Any) -> Any:
        if too_large(*args[skipped:]):
            raise TooLarge(name)
        return plain(*args)

    return function


def _bounded_or_none(name: str, too_large: Any, plain: Any, skipped: int) -> Any:
    return None if plain is None else _bounded(name, too_large, plain, skipped)


def _bounded_maker(name: str, too_large: Any, make: Any) -> Any:
    return lambda index: _bounded_or_none(name, too_large, make(index), 1)


__all__ = ["BITS", "BYTES", "CHARACTERS", "Budget", "TooLarge", "bound", "check"]
