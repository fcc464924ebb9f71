"""Join point: functions that numba compiles to machine code get plain code.

It reads their byte code, and what the literals of rewritten code have become cannot be compiled.
Where values have been through such a function, they are plain. Numba is not imported here for a
program that does without.
"""

from __future__ import annotations

import functools
from types import FunctionType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints

_points = JoinPoints()


def install() -> None:
    """Wraps what reads functions as soon as numba is imported. Idempotent."""
    if not _points:
        _points.replace_when_imported(
            "numba.core.bytecode", "FunctionIdentity.from_function", _advised
        )


def uninstall() -> None:
    """Functions are read as they are. Those that have got plain code keep it."""
    _points.restore()


def _advised(method: Any) -> Any:
    original = method.__func__

    @functools.wraps(original)
    def from_function(cls: Any, function: Any, *args: Any, **kwargs: Any) -> Any:
        if type(function) is FunctionType:
            from .live import make_plain

            make_plain(function)
        return original(cls, function, *args, **kwargs)

    return classmethod(unseen(from_function))
