"""What rewritten code finds in `builtins`: its table of literals, our functions."""

from __future__ import annotations

import builtins
import functools
import gc
import marshal
import sys
from collections.abc import Iterator
from types import (
    AsyncGeneratorType,
    CodeType,
    CoroutineType,
    FrameType,
    FunctionType,
    GeneratorType,
)

from ..provenance import mentioned
from ..provenance.locations import LiteralInfo
from ..provenance.registry import register_literals, registered
from ..provenance.strings import Interpolation
from . import arithmetic, calls, executed, file_calls, foreign_calls, statistics_calls
from .cache import INTERPOLATIONS, Entry

PREFIX = "@rosslt."
"""What all our names begin with."""


def publish(entry: Entry, source: bytes | None) -> None:
    """Makes everything known that the code of a module needs to run, and registers its literals.

    source  the content of the file that the code was made from, None if it is not there
    """
    arithmetic.publish()
    calls.publish()
    executed.publish()
    file_calls.publish()
    foreign_calls.publish()
    foreign_calls.note(entry.module)
    statistics_calls.publish()
    mentioned.read(source)
    if entry.values:
        register_literals(
            entry.table,
            entry.module,
            entry.path,
            entry.values,
            functools.partial(_describe, entry.infos),
            functools.partial(vars(builtins).__setitem__, entry.table),
            source,
        )
    if entry.parts:
        interpolations = [Interpolation(parts) for parts in entry.parts]
        setattr(builtins, entry.table + INTERPOLATIONS, interpolations)


def _describe(infos: bytes) -> list[LiteralInfo]:
    return [LiteralInfo(*info) for info in marshal.loads(infos)]


def withdraw() -> None:
    """Takes out of `builtins` what no code reads any more."""
    from .code_objects import nested  # which needs this module

    used = {
        name
        for code in _codes_in_use()
        for one in nested(code)
        for name in one.co_names
        if name.startswith(PREFIX)
    }
    names = {name for name in vars(builtins) if name.startswith(PREFIX)} - used
    for name in names:
        delattr(builtins, name)
    for literals in registered():
        for name in names:
            literals.publish_no_more(name)


_CODE_OF = {
    FunctionType: "__code__", GeneratorType: "gi_code", CoroutineType: "cr_code",
    AsyncGeneratorType: "ag_code",
}  # fmt: skip


def _codes_in_use() -> Iterator[CodeType]:
    for thing in gc.get_objects():
        attribute = _CODE_OF.get(type(thing))
        if attribute is not None:
            yield getattr(thing, attribute)
    for innermost in sys._current_frames().values():
        frame: FrameType | None = innermost
        while frame is not None:
            yield frame.f_code
            frame = frame.f_back
