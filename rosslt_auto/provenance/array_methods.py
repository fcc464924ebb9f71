"""Methods of tracked arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .array_calls import call_function, call_plain
from .array_moving import frozen, result
from .array_rules import positions
from .array_type import (
    TrackedArray,
    elements,
    has_provenance,
    holds_tracked,
    is_real,
    new_array,
    note_assignment,
    note_moved,
    operand_of,
    plain,
    plain_deeply,
    trackable,
)
from .elements import adapted
from .values import give_method, is_tracked, untracked


def _method(name: str) -> Callable[..., Any]:
    """A method of arrays by way of the function of that name."""
    function = getattr(np, name)

    def method(self: Any, *args: Any, **keywords: Any) -> Any:
        if not has_provenance(self) and not holds_tracked(args):
            return _blank(getattr(plain(self), name)(*plain_deeply(args), **plain_deeply(keywords)))
        return call_function(function, (self, *args), keywords)

    return method


def _blank(found: Any) -> Any:
    return trackable(found)


def _shaping(name: str) -> Callable[..., Any]:
    """A method that moves elements, called like the method."""
    plain_method = getattr(np.ndarray, name)

    def method(self: Any, *args: Any, **keywords: Any) -> Any:
        if keywords.get("out") is not None:
            return call_plain(plain_method, (self, *args), keywords)
        found = plain_method(plain(self), *plain_deeply(args), **plain_deeply(keywords))
        if type(found) is not np.ndarray or found.dtype.kind not in "iuf":
            if isinstance(found, np.generic) and has_provenance(self):
                return result(found, [operand_of(self)], arrange_(args, keywords), None)
            return found
        made = new_array(found)
        note_moved(made, self, arrange_(args, keywords))
        return made

    def arrange_(args: Any, keywords: Any) -> Callable[[Sequence[Any]], Any]:
        kept = [frozen(arg) for arg in args]
        others = {name: frozen(arg) for name, arg in keywords.items()}
        return lambda numbers: plain_method(numbers[0], *kept, **others)

    return method


def _astype(self: Any, dtype: Any, *args: Any, **keywords: Any) -> Any:
    found = plain(self).astype(dtype, *args, **keywords)
    if not is_real(found):
        return found
    made = new_array(found)
    note_moved(made, self, lambda numbers: numbers[0])
    return made


def _tolist(self: Any) -> Any:
    found = elements(self)
    if found is None:
        return plain(self).tolist()
    items = np.empty(len(found), object)
    items[:] = found
    return items.reshape(self.shape).tolist()


def _item(self: Any, *args: Any) -> Any:
    plain_args = plain_deeply(args)
    found = plain(self).item(*plain_args)
    if not has_provenance(self):
        return found
    position = int(positions(self.shape).item(*plain_args))
    item = elements(self)
    if item is None:
        return found
    return adapted(item[position], found)


def _fill(self: Any, value: Any) -> None:
    plain(self).fill(untracked(value))
    if is_tracked(value) or has_provenance(self):
        note_assignment(self, ..., operand_of(value))


def _transposed(self: Any) -> Any:
    return self.transpose()


def _plain_method(name: str) -> Callable[..., Any]:
    plain_method = getattr(np.ndarray, name)

    def method(self: Any, *args: Any, **keywords: Any) -> Any:
        return call_plain(plain_method, (self, *args), keywords)

    return method


def fill_methods() -> None:
    """Gives tracked arrays their methods."""
    for name in (
        "reshape", "ravel", "flatten", "transpose", "squeeze", "swapaxes", "repeat", "take",
        "diagonal", "compress", "copy",
    ):  # fmt: skip
        give_method(TrackedArray, np.ndarray, name, _shaping(name))
    for name in (
        "sum", "mean", "prod", "min", "max", "clip", "round", "trace", "dot", "cumsum", "cumprod",
        "std", "var",
    ):  # fmt: skip
        give_method(TrackedArray, np.ndarray, name, _method(name))
    for name in (
        "all", "any", "argmax", "argmin", "argpartition", "argsort", "choose", "conj", "conjugate",
        "nonzero", "ptp", "searchsorted", "byteswap", "getfield", "partition", "put",
        "sort",
    ):  # fmt: skip
        if hasattr(np.ndarray, name):
            give_method(TrackedArray, np.ndarray, name, _plain_method(name))
    for name, method in {
        "astype": _astype,
        "tolist": _tolist,
        "item": _item,
        "fill": _fill,
    }.items():
        give_method(TrackedArray, np.ndarray, name, method)
    TrackedArray.T = property(_transposed)  # type: ignore[method-assign, assignment]
