"""What rewritten code finds in `builtins`: its table of literals, our functions."""

from __future__ import annotations

import builtins
import functools
import marshal

from ..provenance.locations import LiteralInfo, register_literals
from ..provenance.strings import Interpolation
from . import arithmetic, calls, file_calls
from .cache import INTERPOLATIONS, Entry

PREFIX = "@rosslt."
"""What all our names begin with."""


def publish(entry: Entry, source: bytes) -> None:
    """Makes everything known that the code of a module needs to run, and registers its literals.

    source  the content of the file that the code was made from
    """
    arithmetic.publish()
    calls.publish()
    file_calls.publish()
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
