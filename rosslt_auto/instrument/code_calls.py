"""What instructions do that make functions and call them; also classes and comprehensions, which
are made by calls.

A part of the table in `code_opcodes`.
"""

# Nodes carry attributes of their own, see `code_nodes`:
# mypy: disable-error-code="attr-defined, union-attr, arg-type"

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from typing import Any

from .code_nodes import (
    COMPREHENSIONS,
    GENERIC,
    AssertionError_,
    Class,
    ClassBuilder,
    Comprehension,
    Function,
    Null,
    Opaque,
    SpecialMethod,
    as_written,
    put,
)
from .walk import LOAD

NULL_FIRST = sys.version_info < (3, 13)
"""Whether the empty place lies below the function that is called, or above."""


def _make_function(reader: Any, instr: Any) -> None:
    code = reader.pop()
    node: Any = Function()
    node.maker, node.code, node.code_made_by = reader, code.code, code.made_by
    node.defaults, node.keyword_defaults, node.decorators = [], {}, []
    flags = int(instr.arg) if instr.require_arg() else 0
    first = code
    for flag in (8, 4, 2, 1):
        if flags & flag:
            first = reader.pop()
            _set_attribute(node, flag, first)
    reader.made(node, instr, [first])


def _set_function_attribute(reader: Any, instr: Any) -> None:
    value, function = reader.pop_many(2)
    _set_attribute(function, int(instr.arg), value)
    function.made_by, function.start = instr, value.start
    reader.push(function)


def _set_attribute(function: Any, flag: int, value: Any) -> None:
    if flag == 1 and isinstance(value, ast.Tuple):
        function.defaults = value.elts
    elif flag == 2 and isinstance(value, ast.Dict):
        function.keyword_defaults = {
            as_written(key.value, function.code): default
            for key, default in zip(value.keys, value.values, strict=True)
            if isinstance(key, ast.Constant)
        }


def _kw_names(reader: Any, instr: Any) -> None:
    reader.keyword_names = instr.arg


def _precall(reader: Any, instr: Any) -> None:
    reader.precall = instr


def _call(reader: Any, instr: Any) -> None:
    names, reader.keyword_names = reader.keyword_names, ()
    values = reader.pop_many(instr.arg)
    method = reader.peek(2)
    if isinstance(method, SpecialMethod):
        _call_special(reader, instr, method)
    else:
        reader.push(_called(reader, instr, values, names))


def _call_special(reader: Any, instr: Any, method: SpecialMethod) -> None:
    reader.pop_many(2)
    if method.manager is None:
        reader.push(put(Opaque(), instr))
    else:
        reader.expect("with", method.manager, instr)


def _call_kw(reader: Any, instr: Any) -> None:
    names = reader.pop()
    values = [name.value for name in names.elts] if isinstance(names, ast.Tuple) else ()
    reader.push(_called(reader, instr, reader.pop_many(instr.arg), values))


def _called(reader: Any, instr: Any, values: list[Any], names: Any) -> Any:
    below, above = reader.pop_many(2)
    function: Any
    null: Any = None
    if isinstance(below, Null):
        function, null = above, below
    elif isinstance(above, Null):
        function, null = below, above
    else:  # a function and its first argument
        function, values = below, [above, *values]
    count = len(values) - len(names)
    keywords = [
        put(ast.keyword(as_written(name, reader.code), value), instr)
        for name, value in zip(names, values[count:], strict=True)
    ]
    node: Any = _result(instr, function, values[:count], keywords)
    if isinstance(node, ast.Call) and node.func is function:
        node.null, node.precall = null, reader.precall
        function.calls = [*getattr(function, "calls", ()), node]
        if null is not None and NULL_FIRST and function.start is not None:
            node.start = null.start
    return node


def _result(instr: Any, function: Any, args: list[Any], keywords: list[Any]) -> Any:
    """The node of a call: of a comprehension, a class, a decorator, or of anything else."""
    node: Any
    if isinstance(function, Function) and args and function.code.co_name in COMPREHENSIONS:
        node = put(Comprehension(), instr, function.start, unknown=function.start is None)
        node.function, node.iterable = function, args[0]
        return node
    if isinstance(function, Function) and function.code.co_name.startswith(GENERIC):
        return _generic(function, args) or put(Opaque(), instr, unknown=True)
    if isinstance(function, ClassBuilder) and args and isinstance(args[0], Function):
        node = put(Class(), instr)
        node.function, node.bases, node.keywords, node.decorators = args[0], args[2:], keywords, []
        return node
    if isinstance(function, AssertionError_):
        function.message = args[0] if args else None
        return function
    made = args[0] if len(args) == 1 and not keywords else None
    if isinstance(made, Class) or (isinstance(made, Function) and made.is_definition):
        made.decorators.append(function)
        return made
    node = ast.Call(function, args, keywords)
    node.null = node.precall = None
    return put(node, instr, function.start, unknown=function.start is None)


def _generic(function: Function, args: list[Any]) -> Any:
    """The function or class that has parameters of type (PEP 695): the code of these returns it."""
    for statement in function.body():
        made = getattr(statement, "value", None)
        if isinstance(statement, ast.Return) and isinstance(made, (Function, Class)):
            if isinstance(made, Function):
                for defaults in args:
                    _set_attribute(made, 1 if isinstance(defaults, ast.Tuple) else 2, defaults)
            return made
    return None


def _call_function_ex(reader: Any, instr: Any) -> None:
    keywords = []
    if sys.version_info >= (3, 14) or int(instr.arg) & 1:
        mapping = reader.pop()
        if not isinstance(mapping, Null):
            keywords = _spread(mapping)
    values = reader.pop()
    below, above = reader.pop_many(2)
    function = above if isinstance(below, Null) else below
    if isinstance(values, ast.Tuple):
        args = list(values.elts)
    else:
        args = [put(ast.Starred(values, LOAD), instr, values.start)]
    if isinstance(function, ClassBuilder) and args and isinstance(args[0], Function):
        reader.push(_result(instr, function, args, keywords))
        return
    node: Any = ast.Call(function, args, keywords)
    node.null = node.precall = None  # such a call stays as it is
    reader.push(put(node, instr, unknown=True))


def _spread(mapping: Any) -> list[Any]:
    if not isinstance(mapping, ast.Dict):
        return [put(ast.keyword(None, mapping), mapping.made_by)]
    keywords = []
    key: Any
    value: Any
    for key, value in zip(mapping.keys, mapping.values, strict=True):
        name = key.value if isinstance(key, ast.Constant) else None
        keywords.append(put(ast.keyword(name, value), value.made_by))
    return keywords


STEPS: dict[str, Callable[[Any, Any], None]] = {
    "MAKE_FUNCTION": _make_function, "SET_FUNCTION_ATTRIBUTE": _set_function_attribute,
    "KW_NAMES": _kw_names, "PRECALL": _precall, "CALL": _call, "CALL_KW": _call_kw,
    "CALL_FUNCTION_EX": _call_function_ex,
}  # fmt: skip
"""See `code_opcodes.STEPS`."""
