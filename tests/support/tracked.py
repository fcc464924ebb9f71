"""Tracked values for tests, and comparing what programs can see of them with the plain ones."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any

from rosslt_auto.provenance import Source, untracked
from rosslt_auto.provenance.expressions import leaves
from rosslt_auto.provenance.locations import source_of
from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.provenance.values import leaf, record


def tracked(value: Any, name: str = "x", named: bool = True) -> Any:
    """A leaf of a remote source; anything but a float or an int stays as it is."""
    if type(value) is not float and type(value) is not int:
        return value
    return leaf(Source("/node", name, type(value).__name__, named=named), value)


def sources_by_name(value: Any) -> dict[str, Source]:
    """The sources of a tracked value by parameter name."""
    return {source.parameter: source for source in map(source_of, leaves(value))}


def apply(name: str, *operands: Any) -> Any:
    """A row of the operator table applied as instrumented code applies it."""
    plain = OPERATORS[name].forward(*map(untracked, operands))
    return record(OPERATORS[name], plain, *operands)


def bits(value: Any) -> Any:
    """What makes a value the same bit for bit: -0.0 is not 0.0, and nan is itself."""
    kind = type(value)
    if kind.__module__ == "numpy":
        return (str(value.dtype), value.shape, value.tobytes())
    if isinstance(value, (tuple, list)):
        return [(type(item), bits(item)) for item in value]
    if isinstance(value, complex):
        return (bits(value.real), bits(value.imag))
    if isinstance(value, float):
        return "nan" if math.isnan(value) else struct.pack("d", value)
    return value if value == value else repr(value)


def outcome(action: Callable[..., Any], *operands: Any) -> Any:
    """What a program sees of an operation: type and bits of the result, or the exception."""
    try:
        result = action(*operands)
    except Exception as error:
        return ("raises", type(error), str(error))
    return (type(result), bits(result))
