"""Fields of messages: which ones are tracked, and giving received ones their provenance.

For every message type a flat walker is generated once, because it looks at every field of every
message that is published. A field's path is what one types in Python after ``msg.``:
``pose.position.x``, ``points[3].x``.
"""

from __future__ import annotations

import array
import importlib
import operator
import re
from collections.abc import Callable, Iterator
from functools import cache, partial
from itertools import groupby
from typing import Any, NamedTuple

from rosidl_parser.definition import (
    AbstractGenericString,
    AbstractNestedType,
    BasicType,
    NamespacedType,
)

from ..provenance.elements import READERS, any_tracked
from ..provenance.operators import DEFERRED, OPERATORS
from ..provenance.truths import TrackedBool
from ..provenance.values import TrackedFloat, TrackedInt, TrackedStr, deferred, is_tracked
from . import flags
from .header import Header, HeaderError, Outline

FLOATS = frozenset({"float", "double", "long double"})
INTEGERS = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
TRUTH = "boolean"
_PLAIN_ELEMENTS = frozenset({TRUTH})
"""Types of which sequences are plain: their elements have no place for it."""

LONG = 4096
"""Longer sequences are data (images, clouds): their elements are plain."""

_FLOAT32 = OPERATORS["float32"]
_TOKEN = re.compile(r"([A-Za-z][A-Za-z0-9_]*)(?:\[([0-9]{1,9})\])?")


class Tracked(NamedTuple):
    """A tracked value in a message.

    path         of the field
    value        the tracked value
    owner, slot  ``getattr(owner, slot)`` is the value; of an element ``owner[slot]``
    """

    path: str
    value: Any
    owner: Any
    slot: Any

    def put(self, value: Any) -> None:
        """Puts another value in its place."""
        if type(self.value) is TrackedBool:
            flags.replace(self.owner, self.slot, value)
        elif type(self.slot) is not int:
            setattr(self.owner, self.slot, value)
        else:
            self.owner[self.slot] = value


class Member(NamedTuple):
    """A field as its message type defines it (REP-2011 calls it a member)."""

    name: str
    type: Any  # of rosidl_parser.definition

    @property
    def slot(self) -> str:
        return "_" + self.name


def is_message_type(cls: Any) -> bool:
    """Whether a class was generated from a message definition."""
    return hasattr(cls, "SLOT_TYPES") and hasattr(cls, "_fields_and_field_types")


def members(message_type: type) -> Iterator[Member]:
    """The fields of a message type, in order."""
    names = message_type._fields_and_field_types  # type: ignore[attr-defined]
    for name, kind in zip(names, message_type.SLOT_TYPES, strict=True):  # type: ignore[attr-defined]
        yield Member(name, kind)


def message_class(definition: NamespacedType) -> type:
    """The Python class of a message type."""
    return getattr(importlib.import_module(".".join(definition.namespaces)), definition.name)


@cache
def trackable(message_type: type) -> bool:
    """Whether messages of this type have fields whose values can be tracked."""
    return any(trackable_type(member.type) for member in members(message_type))


def trackable_type(kind: Any) -> bool:
    """Whether values of a field of this type, or below it, can be tracked."""
    if isinstance(kind, BasicType):
        return kind.typename in FLOATS or kind.typename in INTEGERS or kind.typename == TRUTH
    if isinstance(kind, AbstractGenericString):
        return True
    if isinstance(kind, AbstractNestedType):
        kind = kind.value_type
        if not isinstance(kind, NamespacedType):
            return trackable_type(kind) and getattr(kind, "typename", "") not in _PLAIN_ELEMENTS
    return isinstance(kind, NamespacedType) and trackable(message_class(kind))


# ---------------------------------------------------------------- collecting

Collector = Callable[[Any], list[Tracked]]

_collectors: dict[type, Collector] = {}


def collect(message: Any) -> list[Tracked]:
    """The fields of a message that are tracked."""
    return collector(type(message))(message)


def tracked_fields(message: Any) -> dict[str, Any]:
    """The tracked values of a message by path."""
    return {field.path: field.value for field in collect(message)}


def collector(message_type: type) -> Collector:
    """`collect` for messages of this type; an odd message or type has no tracked fields."""
    found = _collectors.get(message_type)
    if found is None:
        found = _collectors[message_type] = _generate(message_type)
    return found


def _nothing(message: Any) -> list[Tracked]:
    return []


def _generate(message_type: type) -> Collector:
    if not is_message_type(message_type) or not trackable(message_type):
        return _nothing
    source = _Source(message_type)
    namespace: dict[str, Any] = dict(source.classes)
    namespace |= {
        "TrackedFloat": TrackedFloat,
        "TrackedInt": TrackedInt,
        "TrackedStr": TrackedStr,
        "array": array.array,
        "elements": _elements,
        "scalar": _scalar,
        "strings": _strings,
        "truths": _truths,
        "Flags": flags.Flags,
        "Tracked": tuple.__new__,  # without the detour through NamedTuple's own __new__
        "Cls": Tracked,
        "deviating": _deviating,
    }
    name = f"<fields of {message_type.__name__}>"
    exec(compile("\n".join(source.lines), name, "exec"), namespace)
    return namespace["collect"]


class _Source:
    """Source code of a walker: all nested messages in one function, nothing called."""

    def __init__(self, message_type: type) -> None:
        self.classes: dict[str, type] = {}
        self.variables = 0
        self.lines = ["def collect(m):", " found = []", " try:"]
        self.add(message_type, "m", "", 2)
        self.lines += [" except AttributeError:", "  pass", " return found"]

    def add(self, message_type: type, owner: str, prefix: str, depth: int) -> None:
        """prefix: beginning of the path, as the inside of an f-string."""
        indent = " " * depth
        kinds = [member.type for member in members(message_type)]
        if any(getattr(kind, "typename", "") == TRUTH for kind in kinds):
            self.lines += [
                f"{indent}if type({owner}.{flags.SLOT}) is Flags:",
                f"{indent} truths({_literal(prefix)}, {owner}, found)",
            ]
        for member in members(message_type):
            kind = member.type
            if not trackable_type(kind) or getattr(kind, "typename", "") == TRUTH:
                continue
            self.variables += 1
            value = f"v{self.variables}"
            path = prefix + member.name
            self.lines.append(f"{indent}{value} = {owner}.{member.slot}")
            if isinstance(kind, (BasicType, AbstractGenericString)):
                tracked, plain = _class_names(kind)
                self.lines += [
                    f"{indent}if type({value}) is {tracked}:",
                    f"{indent} found.append("
                    f"Tracked(Cls, ({_literal(path)}, {value}, {owner}, {member.slot!r})))",
                ]
                if plain is not None:
                    self.lines += [
                        f"{indent}elif type({value}) is not {plain}:",
                        f"{indent} scalar({_literal(path)}, {value}, {owner}, {member.slot!r},"
                        f" {tracked}, found)",
                    ]
            elif isinstance(kind, NamespacedType):
                self.message(kind, value, path, depth)
            elif isinstance(kind.value_type, AbstractGenericString):
                self.lines += [
                    f"{indent}if {value}:",
                    f"{indent} strings({_literal(path)}, {value}, {owner}, {member.slot!r}, found)",
                ]
            elif not isinstance(kind.value_type, NamespacedType):
                self.lines += [
                    f"{indent}if type({value}) is not array:",
                    f"{indent} elements({_literal(path)}, {value}, found)",
                ]
            else:
                index, element = f"i{self.variables}", f"e{self.variables}"
                self.lines += [
                    f"{indent}if type({value}) is list or type({value}) is tuple:",
                    f"{indent} for {index}, {element} in enumerate({value}):",
                ]
                self.message(kind.value_type, element, f"{path}[{{{index}}}]", depth + 2)

    def message(self, kind: NamespacedType, value: str, path: str, depth: int) -> None:
        nested = message_class(kind)
        name = f"T{len(self.classes)}"
        self.classes[name] = nested
        indent = " " * depth
        self.lines.append(f"{indent}if type({value}) is {name}:")
        self.add(nested, value, path + ".", depth + 1)
        self.lines += [f"{indent}else:", f"{indent} deviating({value}, {_literal(path)}, found)"]


def _class_names(kind: Any) -> tuple[str, str | None]:
    """Our class for a field, and the plain one if numpy's scalars may stand there too."""
    if isinstance(kind, AbstractGenericString):
        return "TrackedStr", None
    return ("TrackedFloat", "float") if kind.typename in FLOATS else ("TrackedInt", "int")


def _scalar(path: str, value: Any, owner: Any, slot: str, cls: type, found: list[Tracked]) -> None:
    """A scalar of numpy in a field of Python's kind `cls`."""
    if is_tracked(value) and type(getattr(value, "_core", None)) is cls:
        found.append(Tracked(path, value, owner, slot))


def _elements(path: str, held: Any, found: list[Tracked]) -> None:
    """The elements of a sequence of numbers."""
    read = READERS.get(id(type(held)))
    if read is None or len(held) > LONG:
        return
    for index, element in enumerate(read(held) or ()):
        if is_tracked(element):
            found.append(Tracked(f"{path}[{index}]", element, held, index))


class _Items:
    """The items of a tuple in a slot of a message; putting one in makes another tuple."""

    def __init__(self, message: Any, slot: str) -> None:
        self.message = message
        self.slot = slot

    def __getitem__(self, index: int) -> Any:
        return getattr(self.message, self.slot)[index]

    def __setitem__(self, index: int, value: Any) -> None:
        items = getattr(self.message, self.slot)
        setattr(self.message, self.slot, (*items[:index], value, *items[index + 1 :]))


def _strings(path: str, held: Any, message: Any, slot: str, found: list[Tracked]) -> None:
    """The elements of a sequence of strings."""
    if (type(held) is list or type(held) is tuple) and len(held) <= LONG and any_tracked(held):
        owner: Any = held if type(held) is list else _Items(message, slot)
        for index, element in enumerate(held):
            if type(element) is TrackedStr:
                found.append(Tracked(f"{path}[{index}]", element, owner, index))


def _truths(prefix: str, message: Any, found: list[Tracked]) -> None:
    """The truth values of a message itself."""
    for slot in message._check_fields.leaves:
        leaf = flags.leaf_of(message, slot)
        if leaf is not None:
            found.append(Tracked(prefix + slot[1:], leaf, message, slot))


def _literal(path: str) -> str:
    return f'f"{path}"' if "{" in path else f'"{path}"'


def _deviating(value: Any, path: str, found: list[Tracked]) -> None:
    """A nested message of another class, a subclass perhaps."""
    for field in collect(value):
        found.append(field._replace(path=f"{path}.{field.path}"))


# ---------------------------------------------------------------- attaching


def attach(message: Any, header: Header) -> None:
    """Gives the fields of a received message the provenance that its header tells.

    A field stays plain if its value is not the one that the header's expression has: what was
    received counts. Expressions are made when somebody looks at them. Raises HeaderError if the
    header is not for such a message.
    """
    message_type = type(message)
    plans = header.outline.plans.get(message_type)
    if plans is None:
        plans = header.outline.plans[message_type] = _plan(header.outline, message_type)
    plan, sequences = plans
    values = header.values
    for reach, slot, leaf, index, number, depth, single in plan:
        try:
            owner = message if reach is None else reach(message)
            received = getattr(owner, slot)
        except (AttributeError, IndexError, TypeError):
            raise HeaderError("a field that the message does not have") from None
        sent = values[index] if leaf is None else leaf._v
        kind = type(received)
        if type(sent) is not kind:
            continue
        if received == sent:
            if not received and str(received) != str(sent):  # the two zeros
                continue
            if leaf is not None:
                if kind is bool:
                    flags.put(owner, slot, leaf)
                else:
                    setattr(owner, slot, leaf)
                continue
            expand = partial(_expanded, header, number)
        elif kind is not float:
            continue
        elif received != received and sent != sent:
            expand = partial(_expanded, header, number)
        elif single and _FLOAT32.forward(sent) == received:
            expand = partial(_rounded, header, number)
            depth += 1
        else:
            continue
        if kind is float:
            made: Any = float.__new__(TrackedFloat, received)
            made._v = received
            made._op = DEFERRED
            made._a = expand
            made._b = None
            made._depth = depth
        elif kind is int:
            made = int.__new__(TrackedInt, received)
            made._n = (received, DEFERRED, expand, None, depth)
        else:
            made = deferred(received, expand, depth)
        setattr(owner, slot, made)
    for reach, slot, elements in sequences:
        try:
            owner = message if reach is None else reach(message)
            held = getattr(owner, slot)
            made = _with_elements(held, elements, header)
        except (AttributeError, IndexError, TypeError):
            raise HeaderError("an element that the message does not have") from None
        if made is not held:
            setattr(owner, slot, made)


def _with_elements(held: Any, elements: Plan, header: Header) -> Any:
    """A sequence of numbers or strings with the provenance of its elements."""
    if len(held) > LONG:
        return held
    nodes = held if type(held) is list else held.tolist()
    for _, slot, leaf, index, number, depth, single in elements:
        at = int(slot)
        received = nodes[at]
        sent = header.values[index] if leaf is None else leaf._v
        if type(sent) is not type(received):
            continue
        if received == sent and (received or str(received) == str(sent)):
            expand = partial(_expanded, header, number)
            nodes[at] = leaf if leaf is not None else deferred(received, expand, depth)
        elif received != received and sent != sent:
            nodes[at] = deferred(received, partial(_expanded, header, number), depth)
        elif single and type(received) is float and _FLOAT32.forward(sent) == received:
            nodes[at] = deferred(received, partial(_rounded, header, number), depth + 1)
    if type(held) is list:
        return held
    if isinstance(held, array.array):
        from ..provenance import sequences

        return sequences.with_elements(held, nodes)
    from ..provenance import arrays  # of numpy, which is there then

    return arrays.with_elements(held, nodes)


def _expanded(header: Header, number: int) -> tuple[Any, Any, Any]:
    """What a deferred field stands for: operator and operands of a slot of its header."""
    found = header.nodes()[number]
    return found._op, found._a, found._b


def _rounded(header: Header, number: int) -> tuple[Any, Any, Any]:
    """The same for a float32 field, whose value was rounded on its way."""
    return _FLOAT32, header.nodes()[number], None


# reach (None: the message itself), slot, leaf (None: an operation), index of its value in the
# header, number of its slot in the outline, depth, whether it is a float32
Plan = list[tuple[Callable[[Any], Any] | None, str, Any, int, int, int, bool]]
Sequences = list[tuple[Callable[[Any], Any] | None, str, Plan]]


def _plan(outline: Outline, message_type: type) -> tuple[Plan, Sequences]:
    """How to reach each field, and where its value and its leaf are in headers of this outline.

    Beside it the same for the elements of each sequence: their slot is their index.
    """
    places = {step[0]: index for index, step in enumerate(outline.steps)}
    plan: Plan = []
    by_sequence: dict[tuple[str | int, ...], Plan] = {}
    for path, number in outline.fields:
        steps, kind = _resolve(message_type, path)
        if isinstance(kind, (AbstractNestedType, NamespacedType)) or not trackable_type(kind):
            continue  # something that later versions track
        is_element = type(steps[-1]) is int
        reach = _getter(steps[:-1]) if len(steps) > 1 and not is_element else None
        leaf = outline.slots[number]
        index = places.get(number, -1)
        depth = outline.steps[index][4] if leaf is None else 1
        single = getattr(kind, "typename", "") == "float"
        row = (reach, str(steps[-1]), leaf, index, number, depth, single)
        (by_sequence.setdefault(tuple(steps[:-1]), []) if is_element else plan).append(row)
    return plan, [
        (_getter(list(way[:-1])) if len(way) > 1 else None, str(way[-1]), rows)
        for way, rows in by_sequence.items()
    ]


def _resolve(message_type: type, path: str) -> tuple[list[str | int], Any]:
    """Attributes and indices on the way to a field, and its type. Raises HeaderError."""
    steps: list[str | int] = []
    kind: Any = None
    cls: type | None = message_type
    for token in path.split("."):
        match = _TOKEN.fullmatch(token)
        if match is None or cls is None:
            raise HeaderError("not a path of a field")
        name, index = match.groups()
        kind = next((member.type for member in members(cls) if member.name == name), None)
        steps.append("_" + name)
        if index is not None and isinstance(kind, AbstractNestedType):
            kind = kind.value_type
            steps.append(int(index))
        elif kind is None or index is not None:
            raise HeaderError(f"{message_type.__name__} has no such field")
        cls = message_class(kind) if isinstance(kind, NamespacedType) else None
    return steps, kind


def _getter(steps: list[str | int]) -> Callable[[Any], Any]:
    getters: list[Callable[[Any], Any]] = []
    for is_index, group in groupby(steps, lambda step: type(step) is int):
        if is_index:
            getters += [operator.itemgetter(index) for index in group]
        else:
            getters.append(operator.attrgetter(".".join(group)))  # type: ignore[arg-type]
    if len(getters) == 1:
        return getters[0]

    def get(message: Any) -> Any:
        for getter in getters:
            message = getter(message)
        return message

    return get


__all__ = [
    "Tracked",
    "attach",
    "collect",
    "collector",
    "is_message_type",
    "trackable",
    "tracked_fields",
]
