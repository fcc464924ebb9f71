"""Arrays of module `array` whose elements remember where they came from.

The setters of generated message classes turn a list that is assigned to a field like ``float64[]``
into an ``array.array``, which holds bare numbers. A `TrackedBuffer` is such an array with the
nodes of its elements beside it: same content, same type code, same buffer for the serialiser.
"""

from __future__ import annotations

import array
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from typing import Any

from . import bindings
from .elements import READERS, adapted, any_tracked
from .values import PlainType, is_tracked, untracked

_array = array.array


class _PlainArrayType(type):
    """Lets the class pass for ``array.array`` where types are compared or printed."""

    def __eq__(cls, other: object) -> bool:
        return other is cls or other is _array

    def __hash__(cls) -> int:
        return hash(_array)

    def __repr__(cls) -> str:
        return repr(_array)


class TrackedBuffer(_array, metaclass=_PlainArrayType):
    """An ``array.array`` with provenance.

    _nodes  for each element a tracked number of its value, or None; empty: none has provenance

    The content may be changed behind our back, through the buffer: an element whose value is not
    the one of its node has no provenance any more.
    """

    __slots__ = ("_nodes",)
    _nodes: list[Any]
    __class__ = property(lambda self: _array)
    __hash__ = None

    # ---- reading

    def __getitem__(self, key: Any) -> Any:
        if not self._nodes:
            return _array.__getitem__(self, untracked(key))
        found = _array.__getitem__(self, untracked(key))
        if type(key) is slice:
            return _made(found, self._current()[key])
        return _checked(self._current()[untracked(key)], found)

    def __iter__(self) -> Iterator[Any]:
        return self._items() if self._nodes else _array.__iter__(self)

    def _items(self) -> Iterator[Any]:
        index = 0
        while index < len(self):
            yield self[index]
            index += 1

    def __reversed__(self) -> Iterator[Any]:
        return (self[index] for index in range(len(self) - 1, -1, -1))

    def tolist(self) -> list[Any]:
        if not self._nodes:
            return _array.tolist(self)
        return list(map(_checked, self._current(), _array.tolist(self)))

    # ---- changing

    def __setitem__(self, key: Any, value: Any) -> None:
        if not self._nodes and type(key) is not slice and not is_tracked(value):
            _array.__setitem__(self, untracked(key), value)
            return
        nodes = self._current()
        if type(key) is slice:
            given = _given(value)
            _array.__setitem__(self, key, _plain(value))
            nodes[key] = given
        else:
            key = untracked(key)
            _array.__setitem__(self, key, untracked(value))
            nodes[key] = _node(value, _array.__getitem__(self, key))

    def __delitem__(self, key: Any) -> None:
        nodes = self._current()
        _array.__delitem__(self, untracked(key))
        del nodes[untracked(key)]

    def append(self, value: Any) -> None:
        if not self._nodes and not is_tracked(value):
            _array.append(self, value)
            return
        nodes = self._current()
        _array.append(self, untracked(value))
        nodes.append(_node(value, _array.__getitem__(self, -1)))

    def extend(self, values: Any) -> None:
        nodes = self._current()
        before = len(self)
        values = values if isinstance(values, (_array, list, tuple)) else list(values)
        _array.extend(self, _plain(values))
        nodes += _nodes_of(values, _array.tolist(self)[before:])

    def insert(self, index: Any, value: Any) -> None:
        index = untracked(index)
        nodes = self._current()
        _array.insert(self, index, untracked(value))
        nodes.insert(index, None)
        place = index if 0 <= index < len(self) else len(self) - 1 if index >= 0 else index - 1
        place = max(place, -len(self))
        nodes[place] = _node(value, _array.__getitem__(self, place))

    def pop(self, index: Any = -1) -> Any:
        index = untracked(index)
        nodes = self._current()
        found = _array.pop(self, index)
        return _checked(nodes.pop(index), found)

    def remove(self, value: Any) -> None:
        nodes = self._current()
        value = untracked(value)
        index = next((i for i, held in enumerate(_array.tolist(self)) if held == value), None)
        _array.remove(self, value)
        del nodes[index]  # type: ignore[arg-type]

    def reverse(self) -> None:
        nodes = self._current()
        _array.reverse(self)
        nodes.reverse()

    def fromlist(self, values: Any) -> None:
        nodes = self._current()
        before = len(self)
        _array.fromlist(self, _plain(values) if type(values) is list else values)
        nodes += _nodes_of(values, _array.tolist(self)[before:])

    # ---- making others

    def __add__(self, other: Any) -> Any:
        return _made(_array.__add__(self, other), self._current() + _given(other))

    def __radd__(self, other: Any) -> Any:  # a plain array has none: asked before its own sum
        if not isinstance(other, _array):
            return NotImplemented
        return _made(_array.__add__(other, self), _given(other) + self._current())

    def __iadd__(self, other: Any) -> Any:
        given = _given(other)
        nodes = self._current()
        _array.__iadd__(self, other)
        nodes += given
        return self

    def __mul__(self, count: Any) -> Any:
        return _made(_array.__mul__(self, untracked(count)), self._current() * untracked(count))

    __rmul__ = __mul__

    def __imul__(self, count: Any) -> Any:
        nodes = self._current()
        _array.__imul__(self, untracked(count))
        nodes *= untracked(count)
        return self

    def __copy__(self) -> Any:
        made = TrackedBuffer(self.typecode, _array.tobytes(self))
        made._nodes = list(self._nodes)
        return made

    def __deepcopy__(self, memo: Any) -> Any:
        return self.__copy__()

    def __reduce_ex__(self, protocol: Any) -> Any:
        return _bare(self).__reduce_ex__(protocol)

    def __repr__(self) -> str:
        return repr(_bare(self))

    def __sizeof__(self) -> int:
        return _array.__sizeof__(self)

    def __dir__(self) -> list[str]:
        return dir(_bare(self))

    def _current(self) -> list[Any]:
        """The nodes; as many as there are elements, whoever has added or removed some."""
        if len(self._nodes) != len(self):
            self._nodes[:] = [None] * len(self)
        return self._nodes


class TrackableBuffer(_array, metaclass=_PlainArrayType):
    """An ``array.array`` that becomes a TrackedBuffer as soon as it gets something tracked.

    What is read, and all that brings in nothing tracked, is array's own.
    """

    __slots__ = ("_nodes",)  # the same layout as that of the other class
    _nodes: list[Any]
    __class__ = property(lambda self: _array)
    __hash__ = None

    def __setitem__(self, key: Any, value: Any) -> None:
        if type(type(value)) is not PlainType and type(value) is not TrackedBuffer:
            _array.__setitem__(self, untracked(key), value)
        else:
            _tracking(self)[key] = value

    def append(self, value: Any) -> None:
        if type(type(value)) is not PlainType:
            _array.append(self, value)
        else:
            _tracking(self).append(value)

    def insert(self, index: Any, value: Any) -> None:
        if type(type(value)) is not PlainType:
            _array.insert(self, untracked(index), value)
        else:
            _tracking(self).insert(index, value)

    def extend(self, values: Any) -> None:
        kind = type(values)
        if kind is _array or kind is bytes or kind is bytearray:
            _array.extend(self, values)
        else:
            _tracking(self).extend(values)

    def fromlist(self, values: Any) -> None:
        _tracking(self).fromlist(values)

    def __iadd__(self, other: Any) -> Any:
        if type(other) is TrackedBuffer:
            return _tracking(self).__iadd__(other)
        _array.__iadd__(self, other)
        return self

    def __add__(self, other: Any) -> Any:
        if type(other) is TrackedBuffer:
            return NotImplemented  # that one adds itself
        return _array.__add__(self, other)

    def __copy__(self) -> Any:
        return trackable(_bare(self))

    def __deepcopy__(self, memo: Any) -> Any:
        return trackable(_bare(self))

    __reduce_ex__ = TrackedBuffer.__reduce_ex__
    __repr__ = TrackedBuffer.__repr__
    __sizeof__ = TrackedBuffer.__sizeof__
    __dir__ = TrackedBuffer.__dir__


for _class in (TrackedBuffer, TrackableBuffer):
    _class.__name__ = _class.__qualname__ = "array"
    _class.__module__ = "array"
    _class.__doc__ = _array.__doc__

_become = vars(object)["__class__"].__set__


def _tracking(buffer: Any) -> Any:
    """A TrackableBuffer as TrackedBuffer, which it is from now on."""
    buffer._nodes = []
    _become(buffer, TrackedBuffer)
    return buffer


def _bare(buffer: Any) -> Any:
    return _array(buffer.typecode, _array.tobytes(buffer))


def _node(item: Any, value: Any) -> Any:
    found = adapted(item, value)
    return found if is_tracked(found) else None


def _checked(node: Any, value: Any) -> Any:
    """An element: the node if it still has that value."""
    if node is None or not (node._v == value or (value != value and node._v != node._v)):
        return value
    return node


def _nodes_of(items: Any, values: Sequence[Any]) -> list[Any]:
    """The nodes of elements that `items` became."""
    read = READERS.get(id(type(items)))
    if read is not None:
        items = read(items)
        if items is None:
            return [None] * len(values)
    return [_node(item, value) for item, value in zip(items, values, strict=True)]


def _given(other: Any) -> list[Any]:
    """The nodes of another array, to be put into one of the same type code."""
    if type(other) is TrackedBuffer:
        return list(other._current())
    return [None] * (len(other) if isinstance(other, _array) else 0)


def _plain(values: Any) -> Any:
    return [untracked(value) for value in values] if type(values) in (list, tuple) else values


def _made(found: Any, nodes: list[Any]) -> Any:
    """A plain array with nodes as TrackedBuffer; as it is if there are none."""
    if not any(node is not None for node in nodes):
        return found
    made = TrackedBuffer(found.typecode, _array.tobytes(found))
    made._nodes = nodes
    return made


# ---------------------------------------------------------------- what others use


def shadow(typecode: str, plain_array: Any, original: Any) -> Any:
    """What a message's field holds after something with tracked elements was assigned.

    plain_array  the ``array.array`` of type code `typecode` that the setter has made of it
    original     what was assigned

    Gives `plain_array` itself if no element of `original` is tracked, else a TrackedBuffer.
    """
    kind = type(original)
    if kind is list or kind is tuple:
        if not any_tracked(original):
            return plain_array
        items = original
    elif kind is TrackedBuffer:
        return (
            original if original is plain_array else _made(plain_array, list(original._current()))
        )
    elif id(kind) in READERS:
        items = READERS[id(kind)](original)
        if items is None:
            return plain_array
    elif isinstance(original, (_array, str, bytes)) or not isinstance(original, (Sequence, Set)):
        return plain_array
    else:
        items = list(original)
        if not any_tracked(items):
            return plain_array
    if len(items) != len(plain_array) or typecode != plain_array.typecode:
        return plain_array
    return _made(plain_array, _nodes_of(items, _array.tolist(plain_array)))


def trackable(plain_array: Any) -> Any:
    """A copy of a plain array that takes provenance when elements are assigned or appended."""
    if type(plain_array) is not _array or plain_array.typecode not in _NUMBERS:
        return plain_array
    return TrackableBuffer(plain_array.typecode, plain_array)


def with_elements(plain_array: Any, nodes: Sequence[Any]) -> Any:
    """`plain_array` with provenance: for each element a tracked or plain number."""
    return _made(plain_array, _nodes_of(nodes, plain_array.tolist()))


def elements(buffer: Any) -> list[Any] | None:
    """All elements, tracked where they have provenance; None if none has any."""
    if type(buffer) is not TrackedBuffer or not buffer._nodes:
        return None
    found = buffer.tolist()
    return found if any_tracked(found) else None


def replace_elements(buffer: Any, replace: Callable[[Any], Any]) -> bool:
    """Puts ``replace(element)`` in place of every tracked element; whether one was another."""
    changed = False
    if not buffer._nodes:
        return changed
    for index, element in enumerate(buffer.tolist()):
        if is_tracked(element):
            new = replace(element)
            if new is not element:
                buffer[index] = new
                changed = True
    return changed


def make(*args: Any, **keywords: Any) -> Any:
    """``array.array(typecode, items)`` in instrumented code."""
    if len(args) != 2 or keywords or type(args[0]) is not str:
        found = _array(*args, **keywords)
        return found if len(found) else trackable(found)  # to be filled
    typecode, items = args
    if isinstance(items, (str, bytes, bytearray, _array)) or not isinstance(items, Iterable):
        return shadow(typecode, _array(typecode, items), items)
    if type(items) not in (list, tuple) and id(type(items)) not in READERS:
        items = list(items)
    return shadow(typecode, _array(typecode, _plain(items)), items)


_NUMBERS = "fdbBhHiIlLqQ"

ADVICE: dict[int, Callable[..., Any]] = {id(_array): make}
"""By the id of a function: its tracked version, for calls in instrumented code."""

READERS[id(TrackedBuffer)] = elements
bindings.CONTAINERS[id(TrackedBuffer)] = replace_elements
