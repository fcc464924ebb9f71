"""Rows of the operator table: numbers read from texts, ``int("42")``.

The way back is a text in the manner of the old one: ``int("0x2A", 0)`` forced to 43 asks for
``0x2B``, ``float(" 0.50")`` forced to 0.75 for `` 0.75``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from .operator_table import define

_DIGITS = "0123456789abcdefghijklmnopqrstuvwxyz"


def _unread(read: Callable[..., Any], spellings: Callable[..., Iterator[str]]) -> Any:
    def inverse(target: Any, text: str, *base: int) -> str:
        if type(target) is not int and (read is int or type(target) is not float):
            if type(target) is not float or target != int(target):
                raise ValueError("only whole numbers can be written there")
            target = int(target)
        bare = text.strip()
        before, after = text[: text.index(bare)], text[text.index(bare) + len(bare) :]
        for spelled in spellings(bare, target, *base):
            candidate = before + spelled + after
            try:
                if read(candidate, *base) == target:
                    return candidate
            except ValueError:
                continue
        raise ValueError(f"{target!r} cannot be written as {bare!r} is")

    return inverse


def _floats(text: str, new: float) -> Iterator[str]:
    from .spelled_numbers import float_spellings, int_spellings  # takes long, and is for later

    if new == int(new) and text.lstrip("+-").replace("_", "").isdecimal():
        yield from int_spellings(text, int(text), int(new))
    yield from float_spellings(text, float(new))


def _ints(text: str, new: int, base: int = 10) -> Iterator[str]:
    from .spelled_numbers import int_spellings

    padded = base == 10 and text.lstrip("+-").startswith("0") and "_" not in text
    if padded or base not in (0, 10):
        yield _in_base(text, new, base)
    yield from int_spellings(text, int(text, base), new)


def _in_base(text: str, new: int, base: int) -> str:
    """Digits of another base: as many, and as large, as there were; with its prefix."""
    body = text.lstrip("+-")
    prefix = body[:2] if body[:2].lower() == {16: "0x", 8: "0o", 2: "0b"}.get(base) else ""
    digits, rest = "", abs(new)
    while rest or not digits:
        rest, digit = divmod(rest, base)
        digits = _DIGITS[digit] + digits
    sign = "-" if new < 0 else "+" if text[:1] == "+" else ""
    width = len(body) - len(prefix) if base in (2, 8, 16) or body[:1] == "0" else 0
    found = digits.zfill(width)
    return sign + prefix + (found.upper() if body != body.lower() else found)


def _int(text: str, *base: int) -> int:
    return int(text, *base)


define("read_int", "int", None, _int, (_unread(int, _ints), None))
define("read_float", "float", None, lambda text: float(text), (_unread(float, _floats),))
