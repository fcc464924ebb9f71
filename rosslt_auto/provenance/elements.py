"""What arrays of numpy and of module `array` have in common: elements with provenance."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from .operators import OPERATORS
from .values import PlainType, is_tracked, node

READERS: dict[int, Callable[[Any], list[Any] | None]] = {}
"""What gives the elements of a container, tracked or plain, by the id of the container's type.

None instead of a list if no element has provenance.
"""


def adapted(item: Any, value: Any) -> Any:
    """`item`, tracked or not, as the element of an array in which it became `value`."""
    if not is_tracked(item):
        return value
    item = getattr(item, "_core", item)
    held = item._v
    if type(held) is type(value):
        if held == value or (held != held and value != value):
            return item
        name = "same"
    elif type(held) not in (float, int):
        return value
    else:
        name = "float" if type(value) is float else "int"
    return node(value, OPERATORS[name], item, None, item._depth + 1)


def any_tracked(items: Iterable[Any]) -> bool:
    """Whether one of the items is a tracked value."""
    return PlainType in set(map(type, map(type, items)))
