"""What instructions do that build displays - lists, tuples, sets, dicts - and f-strings.

A part of the table in `code_opcodes`.
"""

# Nodes carry attributes of their own, see `code_nodes`:
# mypy: disable-error-code="attr-defined, union-attr, arg-type"

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from .code_nodes import Opaque, put
from .code_substitutes import has_specification
from .walk import LOAD, TEMPLATE

Step = Callable[[Any, Any], None]


def _build(kind: Any) -> Step:
    def build(reader: Any, instr: Any) -> None:
        elements = reader.pop_many(instr.arg)
        node = kind(elements) if kind is ast.Set else kind(elements, LOAD)
        reader.made(node, instr, elements)

    return build


def _build_map(reader: Any, instr: Any) -> None:
    parts = reader.pop_many(2 * instr.arg)
    reader.made(ast.Dict(parts[::2], parts[1::2]), instr, parts)


def _build_const_key_map(reader: Any, instr: Any) -> None:
    *values, keys = reader.pop_many(instr.arg + 1)
    known = keys.elts if isinstance(keys, ast.Tuple) else [None] * len(values)
    reader.made(ast.Dict(known, values), instr, values)


def _append(reader: Any, instr: Any) -> None:
    element = reader.pop()
    display = _display(reader, instr, _SEQUENCES, element)
    if display is not None:
        display.elts.append(element)


def _extend(reader: Any, instr: Any) -> None:
    more = reader.pop()
    display = _display(reader, instr, _SEQUENCES, more)
    if display is None:
        return
    if isinstance(more, ast.Tuple) and more.start is more.made_by:  # a constant
        display.elts += more.elts
    else:
        display.elts.append(put(ast.Starred(more, LOAD), instr, more.start))


def _map_add(reader: Any, instr: Any) -> None:
    key, value = reader.pop_many(2)
    display = _display(reader, instr, ast.Dict, key, value)
    if display is not None:
        display.keys.append(key)
        display.values.append(value)


def _map_update(reader: Any, instr: Any) -> None:
    more = reader.pop()
    display = _display(reader, instr, ast.Dict, more)
    if display is not None:
        display.keys.append(None)
        display.values.append(more)


_SEQUENCES = (ast.List, ast.Set)


def _display(reader: Any, instr: Any, kind: Any, *more: Any) -> Any:
    """The display that lies there to take more; None if it is something else, `more` loose then."""
    display = reader.peek(instr.arg)
    if isinstance(display, kind):
        display.made_by = instr
        return display
    reader.loose(*more)
    return None


def to_tuple(reader: Any, instr: Any) -> None:
    """What lies there as a list becomes a tuple."""
    elements = reader.pop()
    if isinstance(elements, ast.List):
        reader.made(ast.Tuple(elements.elts, LOAD), instr, [elements])
    else:
        reader.loose(elements)
        reader.push(put(Opaque(), instr, unknown=True))


# ---------------------------------------------------------------- f-strings

_CONVERSIONS = (-1, ord("s"), ord("r"), ord("a"))


def _format_value(reader: Any, instr: Any) -> None:
    flags = int(instr.arg)
    specification = reader.pop() if flags & 4 else None
    _formatted(reader, instr, reader.pop(), _CONVERSIONS[flags & 3], specification)


def _convert_value(reader: Any, instr: Any) -> None:
    value = reader.peek(1)
    value.conversion = _CONVERSIONS[int(instr.arg)]
    value.converted_by = instr


def _format_simple(reader: Any, instr: Any) -> None:
    value = reader.pop()
    _formatted(reader, instr, value, getattr(value, "conversion", -1), None)


def _format_with_spec(reader: Any, instr: Any) -> None:
    value, specification = reader.pop_many(2)
    _formatted(reader, instr, value, getattr(value, "conversion", -1), specification)


def _formatted(reader: Any, instr: Any, value: Any, conversion: int, specification: Any) -> None:
    if specification is not None and not isinstance(specification, ast.JoinedStr):
        specification = put(ast.JoinedStr([specification]), specification.made_by)
    part = put(ast.FormattedValue(value, conversion, specification), instr, value.start)
    node: Any = ast.JoinedStr([part])
    node.single = True
    reader.made(node, instr, [value])


def _build_string(reader: Any, instr: Any) -> None:
    parts = reader.pop_many(instr.arg)
    values = [part.values[0] if getattr(part, "single", False) else part for part in parts]
    node: Any = ast.JoinedStr(values)
    node.single = False
    reader.made(node, instr, parts)


# ---------------------------------------------------------------- t-strings

_INTERPOLATION: Any = getattr(ast, "Interpolation", None)  # since 3.14


def _build_interpolation(reader: Any, instr: Any) -> None:
    specification = reader.pop() if has_specification(instr) else None
    value, text = reader.pop_many(2)
    reader.made(_INTERPOLATION(value, text.value, -1, specification), instr, [value])


def _build_template(reader: Any, instr: Any) -> None:
    texts, interpolations = reader.pop_many(2)
    if isinstance(interpolations, ast.Tuple):
        reader.made(TEMPLATE(interpolations.elts), instr, [texts])
    else:
        reader.loose(interpolations)
        reader.push(put(Opaque(), instr))


STEPS: dict[str, Step] = {
    "BUILD_LIST": _build(ast.List), "BUILD_TUPLE": _build(ast.Tuple), "BUILD_SET": _build(ast.Set),
    "BUILD_MAP": _build_map, "BUILD_CONST_KEY_MAP": _build_const_key_map,
    "LIST_APPEND": _append, "SET_ADD": _append, "LIST_EXTEND": _extend, "SET_UPDATE": _extend,
    "MAP_ADD": _map_add, "DICT_UPDATE": _map_update, "DICT_MERGE": _map_update,
    "LIST_TO_TUPLE": to_tuple, "FORMAT_VALUE": _format_value, "CONVERT_VALUE": _convert_value,
    "FORMAT_SIMPLE": _format_simple, "FORMAT_WITH_SPEC": _format_with_spec,
    "BUILD_STRING": _build_string, "BUILD_INTERPOLATION": _build_interpolation,
    "BUILD_TEMPLATE": _build_template,
}  # fmt: skip
"""See `code_opcodes.STEPS`."""
