"""What a value remembers: locations, tracked values, operators, expressions, inversion.

Knows nothing of ROS or of how code is rewritten.
"""

from __future__ import annotations

import importlib
import sys
import types
from typing import TYPE_CHECKING, Any

from . import strings  # gives TrackedStr its methods
from .expressions import Provenance, provenance
from .locations import Location
from .sources import Source, SourceChangeRefused
from .values import TrackedFloat, TrackedInt, TrackedStr, is_tracked, untracked

if TYPE_CHECKING:
    from .inversion import NotInvertible as NotInvertible
    from .inversion import Solution as Solution

__all__ = [
    "Location",
    "NotInvertible",
    "Provenance",
    "Solution",
    "Source",
    "SourceChangeRefused",
    "TrackedFloat",
    "TrackedInt",
    "TrackedStr",
    "is_tracked",
    "provenance",
    "strings",
    "untracked",
]


class _Callable(types.ModuleType):
    """``from rosslt_auto import provenance`` names a function of the contract and this package."""

    def __call__(self, value: Any) -> Provenance | None:
        return provenance(value)


def __getattr__(name: str) -> Any:
    if name not in ("NotInvertible", "Solution"):  # those need much that a program does not
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(".inversion", __name__), name)


sys.modules[__name__].__class__ = _Callable
