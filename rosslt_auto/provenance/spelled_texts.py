"""How texts are written in Python: prefix, quotes and escapes of an old one, around a new value.

Like the spellings of numbers, these are proposals that are read back before one is taken.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Callable, Iterator

_UNIT = re.compile(
    r"\\(?:\r\n|[0-7]{1,3}|x[0-9a-fA-F]{2}|u[0-9a-fA-F]{4}|U[0-9a-fA-F]{8}|N\{[^}]*\}|.)|\r\n|.",
    re.DOTALL,
)
_RAW_UNIT = re.compile(r"\\.|\r\n|.", re.DOTALL)
_BRACES_UNIT = re.compile(r"\{\{|\}\}|" + _UNIT.pattern, re.DOTALL)
_RAW_BRACES_UNIT = re.compile(r"\{\{|\}\}|" + _RAW_UNIT.pattern, re.DOTALL)
_ESCAPES = frozenset("\\'\"abfnrtvxuUN01234567")
_SIMPLE = {"\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t"}

Unit = tuple[str, str]
"""How a character (or none, or two) is written, and what it is."""


def text_spellings(
    prefix: str, quote: str, body: str, new: str, encoding: str, braces: bool = False
) -> Iterator[str]:
    """Spellings of `new` in place of `body`, whole literals, the one most like it first.

    prefix, quote  what stands around `body`
    encoding       the file's; what it does not have is escaped
    braces         whether it is a piece of an f-string; then only bodies are given
    """
    raw = "r" in prefix.lower()
    units = list(_units(body, raw, braces))
    spell = _Speller(quote, units, raw, encoding, braces)
    around = (
        (lambda spelled: spelled) if braces else (lambda spelled: prefix + quote + spelled + quote)
    )
    if not raw or spell.fits_raw(new):
        yield around(_kept(units, new, spell.text))
        yield around(spell.text(new))
    if raw and not braces:
        plain = _Speller(
            quote, [unit for unit in units if "\\" not in unit[0]], False, encoding, False
        )
        yield re.sub("[rR]", "", prefix) + quote + plain.text(new) + quote


def _units(body: str, raw: bool, braces: bool) -> Iterator[Unit]:
    pattern = (
        (_RAW_BRACES_UNIT if raw else _BRACES_UNIT) if braces else (_RAW_UNIT if raw else _UNIT)
    )
    for found in pattern.finditer(body):
        written = found[0]
        if written in ("\r\n", "\r"):
            yield written, "\n"
        elif written[0] != "\\" or raw:
            yield written, written[0] if braces and written in ("{{", "}}") else written
        elif written[1:] in ("\n", "\r", "\r\n"):
            yield written, ""
        elif written[1] in _ESCAPES:
            yield written, _unescaped(written)
        else:
            yield written, written


def _unescaped(written: str) -> str:
    try:
        return ast.literal_eval(f'"{written}"')
    except (SyntaxError, ValueError):
        return written


def _kept(units: list[Unit], new: str, spell: Callable[[str], str]) -> str:
    """`new` with the beginning and the end written as they were, as far as they are the same."""
    start = used = 0
    for _, value in units:
        if not new.startswith(value, used):
            break
        used += len(value)
        start += 1
    end, left = len(units), len(new)
    while end > start:
        value = units[end - 1][1]
        if left - len(value) < used or not new.endswith(value, used, left):
            break
        left -= len(value)
        end -= 1
    middle = spell(new[used:left]) if used < left else ""
    return "".join(
        itertools.chain((u[0] for u in units[:start]), (middle,), (u[0] for u in units[end:]))
    )


class _Speller:
    """Writes characters as the old text does where it shows how."""

    def __init__(
        self, quote: str, units: list[Unit], raw: bool, encoding: str, braces: bool
    ) -> None:
        self.quote = quote
        self.raw = raw
        self.encoding = encoding
        self.braces = braces
        self.known = {value: written for written, value in units if len(value) == 1}
        self.known.pop(quote[0], None)
        if len(quote) == 1 or "\n" not in self.known:
            self.known["\n"] = "\\n"

    def fits_raw(self, new: str) -> bool:
        """Whether every character can stand in a raw literal as it is."""
        return all(
            (char.isprintable() and self._has(char)) or char in self.known for char in new
        ) and ("\n" not in new or self.known["\n"] != "\\n")

    def text(self, new: str) -> str:
        """The whole of `new`, escaped where needed."""
        return "".join(
            self._char(char, following)
            for char, following in itertools.zip_longest(new, new[1:], fillvalue="")
        )

    def _char(self, char: str, following: str) -> str:
        if char == self.quote[0] and not self.raw:
            alone = len(self.quote) == 3 and following not in ("", char)
            return char if alone else "\\" + char
        if self.braces and char in "{}":
            return char * 2
        if char == "\\":
            return char if self.raw else "\\\\"
        if char in self.known:
            return self.known[char]
        if self.raw or (char.isprintable() and self._has(char)):
            return char
        return _SIMPLE.get(char) or _numbered(char)

    def _has(self, char: str) -> bool:
        try:
            char.encode(self.encoding)
        except UnicodeEncodeError:
            return False
        return True


def _numbered(char: str) -> str:
    code = ord(char)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
