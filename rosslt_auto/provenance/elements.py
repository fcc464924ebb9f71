"""What arrays of numpy and of module `array` have in common: elements with provenance."""

from __future__ import annotations

import marshal
from collections.abc import Callable, Iterable
from typing import Any

from .number_operators import float32
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
        name = "float32" if type(value) is float and float32(held) == value else "same"
    elif type(held) not in (float, int):
        return value
    else:
        name = "float" if type(value) is float else "int"
    return node(value, OPERATORS[name], item, None, item._depth + 1)


_SHORT = 16


def all_exact(items: Any) -> bool:
    """Whether the items of a list or tuple are found, quickly, to be nothing but plain floats.

    marshal writes nothing but exact floats with the letter g (`Python/marshal.c`), in 8 more bytes
    each from version 2 on: reading what it writes takes a fraction of the time of asking each item.
    """
    if len(items) <= _SHORT:
        for item in items:  # noqa: SIM110  (a generator costs more than it asks)
            if type(item) is not float:
                return False
        return True
    if type(items[0]) is not float:
        return False
    try:
        written = marshal.dumps(items, 2)
    except ValueError:  # something else, a tracked number perhaps
        return False
    return len(written) == 5 + 9 * len(items) and written[5::9] == b"g" * len(items)


def any_tracked(items: Iterable[Any]) -> bool:
    """Whether one of the items is a tracked value."""
    return PlainType in set(map(type, map(type, items)))
