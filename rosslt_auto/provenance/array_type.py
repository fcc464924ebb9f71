"""The type of arrays that remember where their elements came from.

A true ndarray with the plain data, and beside it what is known of its elements (`array_rules`).
What calls of numpy do to it is in `array_calls`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import array_scalars
from .array_rules import Moved, Over, Rule, Shadow, at, core_of, positions, spread
from .array_scalars import scalar
from .elements import READERS, adapted, any_tracked
from .values import TrackedFloat, TrackedInt, is_tracked, untracked

MAX_SIZE = 1 << 16
"""Larger arrays are data (images, maps, clouds): results of that size are plain."""

_ndarray = np.ndarray
_float64 = np.float64
_view = np.ndarray.view
_tobytes = np.ndarray.tobytes


class _PlainArrayType(type):
    """Lets the class pass for ndarray where types are compared or printed."""

    def __eq__(cls, other: object) -> bool:
        return other is cls or other is _ndarray

    def __hash__(cls) -> int:
        return hash(_ndarray)

    def __repr__(cls) -> str:
        return repr(_ndarray)


class TrackedArray(np.ndarray, metaclass=_PlainArrayType):
    """An ndarray with provenance; `array_functions` adds the methods.

    _shadow  what was known at the last array operation, or unset
    _cells   elements assigned since: node or None for a plain one, by flat position; or unset
    _whole   for a view: the array that it is a view of, and the Moved rule; or unset
    """

    __slots__ = ("_cells", "_shadow", "_whole")
    __class__ = property(lambda self: _ndarray)
    _cells: Any
    _shadow: Any
    _whole: Any

    def __getitem__(self, key: Any) -> Any:
        key = plain_deeply(key)
        found = _ndarray.__getitem__(self, key)
        if type(found) is _float64 and not has_provenance(self):
            return found
        if isinstance(found, np.generic):
            return _element(self, key, found)
        if type(found) is TrackedArray and found.dtype.kind in "iuf":
            _note_view(found, self, key)
        return found

    def __setitem__(self, key: Any, value: Any) -> None:
        key = plain_deeply(key)
        given = operand_of(value)
        _ndarray.__setitem__(self, key, plain_deeply(value))
        tracked = has_provenance(self)
        if self.dtype.kind in "iuf" and (type(given) is Shadow or is_tracked(given) or tracked):
            note_assignment(self, key, given)

    def __reduce__(self) -> Any:
        return plain(self).__reduce__()

    def __reduce_ex__(self, protocol: Any) -> Any:
        return plain(self).__reduce_ex__(protocol)

    def __setstate__(self, state: Any) -> Any:
        plain(self).__setstate__(state)

    def __copy__(self) -> Any:
        return _copied(self)

    def __deepcopy__(self, memo: Any) -> Any:
        return _copied(self)

    def __repr__(self) -> str:
        return repr(plain(self))

    def __str__(self) -> str:
        return str(plain(self))

    def __format__(self, specification: str) -> str:
        return format(plain(self), specification)

    def __dir__(self) -> list[str]:
        return dir(plain(self))

    def __sizeof__(self) -> int:
        return plain(self).__sizeof__()


# ---------------------------------------------------------------- plain and tracked


def plain(array: Any) -> Any:
    """The plain view of a tracked array; a tracked number's plain one; anything else as it is."""
    if type(array) is TrackedArray:
        return _view(array, _ndarray)
    return untracked(array)


def plain_deeply(thing: Any) -> Any:
    """As `plain`, in lists, tuples and dicts too."""
    kind = type(thing)
    if kind is int or kind is float or kind is _ndarray or kind is slice or kind is str:
        return thing
    if kind is TrackedArray:
        return _view(thing, _ndarray)
    if kind is list or kind is tuple:
        items = [plain_deeply(item) for item in thing]
        if all(a is b for a, b in zip(items, thing, strict=True)):
            return thing
        return items if kind is list else tuple(items)
    if kind is dict:
        return {name: plain_deeply(item) for name, item in thing.items()}
    return untracked(thing)


def new_array(array: Any) -> Any:
    """A tracked view of a plain array, without provenance yet."""
    made = _view(array, TrackedArray)
    made._shadow = made._cells = made._whole = None
    return made


def is_real(array: Any) -> bool:
    """Whether the elements of an array are integers or floats that a node can have as value."""
    return array.dtype.kind in "iuf" and array.dtype.itemsize <= 8


def trackable(array: Any) -> Any:
    """A plain array as one that takes provenance when elements are assigned; the same memory.

    Anything that is not a real numerical ndarray of moderate size comes back as it is.
    """
    if type(array) is _ndarray and is_real(array) and array.size <= MAX_SIZE:
        return new_array(array)
    return array


def has_provenance(array: Any) -> bool:
    """Whether any element of an array may have provenance; a cheap test for any object."""
    if type(array) is not TrackedArray:
        return False
    try:
        return array._shadow is not None or bool(array._cells)
    except AttributeError:  # a view that C code has made
        array._shadow = array._cells = array._whole = None
        return False


def elements(array: Any) -> list[Any] | None:
    """All elements one after the other (C order) as Python numbers, tracked where they have
    provenance; None if no element of `array` has any, or if it is something else."""
    if not has_provenance(array):
        return None
    shadow = shadow_of(array)
    if shadow is None or not shadow.mask.any():
        return None
    found = shadow.values.tolist()
    for position in np.flatnonzero(shadow.mask).tolist():
        found[position] = shadow.core(position)
    return found


def with_elements(array: Any, nodes: Sequence[Any]) -> Any:
    """`array` (real, plain) with provenance: for each element, C order, a tracked or plain number.

    Shares the memory of `array`. A node whose value is not the element's is adapted to it.
    """
    found = trackable(array)
    if type(found) is TrackedArray:
        cells = {
            p: adapted(item, array.item(p)) for p, item in enumerate(nodes) if is_tracked(item)
        }
        if cells:
            found._shadow = Shadow(array, Over(cells, None, None, array.size))
    return found


def shadow_of(array: Any) -> Shadow | None:
    """What is known of the elements of a tracked array as they are now."""
    if not has_provenance(array):
        return None
    shadow, cells = array._shadow, array._cells
    if not cells and shadow.data == _tobytes(array):
        return shadow
    now = plain(array)
    cells = {
        p: cell for p, cell in (cells or {}).items()
        if p < now.size and (cell is None or is_equal(cell._v, now.item(p)))
    }  # fmt: skip
    valid = None
    if shadow is not None:
        if shadow.values.size != now.size:
            shadow = None
        else:
            valid = shadow.values == now.reshape(-1)
    array._shadow = Shadow(now, Over(cells, shadow, valid, now.size))
    array._cells = None
    return array._shadow


def is_equal(a: Any, b: Any) -> bool:
    return bool(a == b or (a != a and b != b))


def operand_of(thing: Any) -> Any:
    """An operand of a rule: nobody will change it. Lists with tracked numbers are Shadows too."""
    kind = type(thing)
    if kind is float or kind is int or kind is TrackedFloat or kind is TrackedInt:
        return thing
    if kind is TrackedArray:
        shadow = shadow_of(thing)
        return np.array(plain(thing)) if shadow is None else shadow
    if kind is _ndarray:
        return np.array(thing)
    if kind is list or kind is tuple or id(kind) in READERS:
        found = make_array(np.array, (thing,), {}) if holds_tracked(thing) else np.array(thing)
        return operand_of(found) if type(found) is TrackedArray else found
    return core_of(thing)


def holds_tracked(thing: Any) -> bool:
    """Whether something is tracked, or a list or tuple (of lists...) that has such an item."""
    kind = type(thing)
    if kind is list or kind is tuple:
        if any_tracked(thing):
            return True
        for item in thing:
            kind = type(item)
            if kind is not float and kind is not int and holds_tracked(item):
                return True
        return False
    if kind is TrackedArray:
        return has_provenance(thing)
    if is_tracked(thing):
        return True
    read = READERS.get(id(kind))
    return read is not None and read(thing) is not None


def is_known(operand: Any) -> bool:
    """Whether an operand has provenance."""
    return type(operand) is Shadow or is_tracked(operand)


def wrap(found: Any, rule: Rule | None) -> Any:
    """The plain result of an operation with its rule."""
    if rule is None:
        return found
    if type(found) is _ndarray:
        if is_real(found) and 0 < found.size <= MAX_SIZE:
            made = _view(found, TrackedArray)
            made._shadow = Shadow(found, rule)
            made._cells = made._whole = None
            return made
    elif id(type(found)) in array_scalars.CLASSES and rule.mask()[0]:
        return scalar(found, rule.core(0, found.item()))
    return found


def _copied(array: Any) -> Any:
    made = new_array(plain(array).copy())
    shadow = shadow_of(array)
    if shadow is not None:
        made._shadow = shadow
    return made


# ---------------------------------------------------------------- elements and assignments


def _element(array: Any, key: Any, found: Any) -> Any:
    """What ``array[key]`` gives for a single element."""
    if not has_provenance(array):
        return found
    position = int(positions(array.shape)[key])
    value = found.item()
    cells = array._cells
    if cells and position in cells:
        cell = cells[position]
        return scalar(found, cell) if cell is not None and is_equal(cell._v, value) else found
    shadow = array._shadow
    if shadow is None or position >= shadow.mask.size or not shadow.mask[position]:
        return found
    if not is_equal(shadow.values.item(position), value):
        return found
    return scalar(found, shadow.core(position))


def _note_view(view: Any, array: Any, key: Any) -> None:
    """Gives ``array[key]``, a view or a copy, the provenance of its elements."""
    view._shadow = view._cells = view._whole = None
    key = _kept(key)

    def arrange(numbers: Sequence[Any]) -> Any:
        return numbers[0][key]

    note_moved(view, array, arrange)


def note_moved(view: Any, array: Any, arrange: Callable[[Sequence[Any]], Any]) -> None:
    """Gives `view`, made of elements of `array`, their provenance, and remembers the relation."""
    if view.size > MAX_SIZE or array.size > MAX_SIZE or not view.size:
        return
    shadow = shadow_of(array)
    if shadow is not None:
        view._shadow = Shadow(plain(view), Moved([shadow], arrange))
    if array._whole is None and np.may_share_memory(view, array):
        view._whole = (array, arrange)


def _kept(key: Any) -> Any:
    """A key that nobody changes."""
    if type(key) is tuple:
        return tuple(map(_kept, key))
    if type(key) is list:
        return list(key)
    return np.array(key) if type(key) is _ndarray else key


def note_assignment(array: Any, key: Any, given: Any) -> None:
    if array.size > MAX_SIZE:
        array._shadow = array._cells = None
        return
    place = positions(array.shape)[key]
    shape = np.shape(place)
    now = plain(array)
    cells = {}
    for index, position in enumerate(np.ravel(place).tolist()):
        cell = adapted(at(given, spread(given, index, shape)), now.item(position))
        cells[position] = cell if is_tracked(cell) else None
    note_cells(array, cells)


def note_cells(array: Any, cells: dict[int, Any]) -> None:
    has_provenance(array)  # sets what a view made by C code lacks
    before = array._cells
    if before is None:
        array._cells = cells
    else:
        before.update(cells)
    whole = array._whole
    if whole is not None:
        base, arrange = whole
        origin = np.asarray(arrange([positions(base.shape)])).reshape(-1)
        if np.may_share_memory(array, base) and origin.size == array.size:
            note_cells(base, {int(origin[p]): cell for p, cell in cells.items()})


def replace_elements(array: Any, replace: Callable[[Any], Any]) -> bool:
    """Puts ``replace(element)`` in place of every tracked element; whether one was another.

    For sources that have changed, see `refresh.refreshed`. Read-only arrays stay as they are.
    """
    found = elements(array)
    if found is None or not array.flags.writeable:
        return False
    now = plain(array)
    cells: dict[int, Any] = {}
    for position, element in enumerate(found):
        if is_tracked(element):
            new = replace(element)
            if new is not element:
                now[np.unravel_index(position, now.shape)] = untracked(new)
                cell = adapted(new, now.item(position))
                cells[position] = cell if is_tracked(cell) else None
    if cells:
        note_cells(array, cells)
    return bool(cells)


# ---------------------------------------------------------------- making arrays


def make_array(function: Any, args: Sequence[Any], keywords: dict[str, Any]) -> Any:
    """`numpy.array` and its like, called with tracked numbers or arrays."""
    if len(args) == 1 and not keywords and type(args[0]) is list:
        found = _array_of_floats(function, args[0])
        if found is not None:
            return found
    if not args or not holds_tracked(args[0]):
        return trackable(function(*map(plain_deeply, args), **plain_deeply(keywords)))
    given = args[0]
    if type(given) is TrackedArray:
        return _array_of_array(function, args, keywords)
    found = function(*map(plain_deeply, args), **plain_deeply(keywords))
    if type(found) is not _ndarray or found.dtype.kind not in "iuf":
        return found
    nodes: list[Any] = []
    _flatten(given if type(given) in (list, tuple) else (given,), nodes)
    return with_elements(found, nodes) if len(nodes) == found.size else found


def _array_of_floats(function: Any, given: list[Any]) -> Any:
    """The commonest way to make an array, fast; None if `given` is something else."""
    cells: dict[int, Any] = {}
    items: list[Any] = []
    for item in given:
        kind = type(item)
        if kind is TrackedFloat:
            cells[len(items)] = item
            items.append(item._v)
        elif kind is float:
            items.append(item)
        else:
            return None
    made = function(items)
    if 0 < len(items) <= MAX_SIZE:
        made = new_array(made)
        if cells:
            made._shadow = Shadow(made, Over(cells, None, None, len(items)))
    return made


def _array_of_array(function: Any, args: Sequence[Any], keywords: dict[str, Any]) -> Any:
    given = args[0]
    found = function(plain(given), *args[1:], **plain_deeply(keywords))
    if not isinstance(found, _ndarray) or found.dtype.kind not in "iuf":
        return found
    if found.shape != given.shape:  # ndmin
        return found
    made = new_array(found)
    note_moved(made, given, lambda numbers: numbers[0])
    return made


def _flatten(thing: Any, nodes: list[Any]) -> None:
    for item in thing:
        kind = type(item)
        if kind is list or kind is tuple:
            _flatten(item, nodes)
        elif kind is _ndarray or kind is TrackedArray:
            nodes += elements(item) or plain(item).reshape(-1).tolist()
        elif id(kind) in READERS:
            nodes += READERS[id(kind)](item) or list(item)
        else:
            nodes.append(core_of(item))


TrackedArray.__name__ = TrackedArray.__qualname__ = "ndarray"
TrackedArray.__module__ = "numpy"
TrackedArray.__doc__ = np.ndarray.__doc__
