"""What a value remembers: locations, tracked values, operators, expressions, inversion.

Knows nothing of ROS or of how code is rewritten.
"""

import sys
import types
from typing import Any

from . import strings  # gives TrackedStr its methods
from .expressions import Provenance, provenance
from .inversion import NotInvertible, Solution
from .locations import Location, Source, SourceChangeRefused
from .values import TrackedFloat, TrackedInt, TrackedStr, is_tracked, untracked

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


sys.modules[__name__].__class__ = _Callable
