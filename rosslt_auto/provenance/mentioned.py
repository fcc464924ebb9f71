"""Names that instrumented code mentions.

What can only be filled under its name - a field of a message - needs no advice as long as no
instrumented code knows that name. A name counts wherever it stands in a source: as an attribute, a
keyword, in a text. Code whose source is not there, or which sets attributes by computed names, may
mean any.
"""

from __future__ import annotations

import re
from collections.abc import Callable

_NAME = re.compile(rb"[A-Za-z_]\w*")
_ANY = "setattr"

watchers: list[Callable[[], None]] = []
"""Called after more names are known."""

_names: set[str] = set()
_any = False
_unread: list[bytes] = []


def read(source: bytes | None) -> None:
    """Notes what a source mentions; None: code without source."""
    global _any
    if source is None:
        _any = True
    else:
        _unread.append(source)
    for tell in tuple(watchers):
        tell()


def is_mentioned(name: str) -> bool:
    """Whether instrumented code may mean something by this (ASCII) name."""
    global _any
    while _unread:
        _names.update(found.decode() for found in set(_NAME.findall(_unread.pop())))
        _any = _any or _ANY in _names
    return _any or name in _names


__all__ = ["is_mentioned", "read", "watchers"]
