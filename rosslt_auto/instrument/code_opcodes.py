"""What each instruction does to the stack, in terms of expressions and statements.

A table from the names of instructions (CPython's `dis`, 3.11 to 3.14) to functions; an instruction
that is not listed takes and leaves what `bytecode` says it does, and literals that it takes stay
plain.
"""

# Nodes carry attributes of their own, see `code_nodes`:
# mypy: disable-error-code="attr-defined, union-attr, arg-type"

from __future__ import annotations

import ast
from typing import Any

from .code_calls import NULL_FIRST
from .code_calls import STEPS as CALLS
from .code_displays import STEPS as DISPLAYS
from .code_displays import Step, to_tuple
from .code_nodes import (
    AssertionError_,
    ClassBuilder,
    Module,
    Null,
    Opaque,
    Part,
    SpecialMethod,
    as_written,
    constant,
    put,
)
from .code_substitutes import name_of
from .walk import LOAD


def _name_of(reader: Any, instr: Any) -> str:
    argument = instr.arg
    if isinstance(argument, tuple):
        argument = argument[-1]
    name = argument if isinstance(argument, str) else getattr(argument, "name", "")
    return as_written(name, reader.code)


def _has_flag(argument: Any) -> bool:
    return isinstance(argument, tuple) and bool(argument[0])


# ---------------------------------------------------------------- loads


def _constant(reader: Any, instr: Any) -> None:
    reader.push(constant(instr.arg, instr, reader))


def _name(reader: Any, instr: Any) -> None:
    reader.push(put(ast.Name(_name_of(reader, instr), LOAD), instr))


def _name_in(reader: Any, instr: Any) -> None:
    namespace = reader.pop()
    reader.made(ast.Name(_name_of(reader, instr), LOAD), instr, [namespace])


def _callable(reader: Any, node: Any, with_null: bool) -> None:
    null = put(Null(), node.made_by, node.start, unknown=node.start is None)
    if with_null and NULL_FIRST:
        reader.push(null)
    reader.push(node)
    if with_null and not NULL_FIRST:
        reader.push(null)


def _global(reader: Any, instr: Any) -> None:
    node = put(ast.Name(_name_of(reader, instr), LOAD), instr)
    _callable(reader, node, _has_flag(instr.arg))


def _attribute(reader: Any, instr: Any) -> None:
    value = reader.pop()
    node = put(ast.Attribute(value, _name_of(reader, instr), LOAD), instr, value.start,
               unknown=value.start is None)  # fmt: skip
    _callable(reader, node, instr.name == "LOAD_METHOD" or _has_flag(instr.arg))


def _super_attribute(reader: Any, instr: Any) -> None:
    builtin, _, _ = reader.pop_many(3)
    call = put(ast.Call(builtin, [], []), instr, builtin.start)
    node = put(ast.Attribute(call, _name_of(reader, instr), LOAD), instr, builtin.start)
    _callable(reader, node, _has_flag(instr.arg))


def _null(reader: Any, instr: Any) -> None:
    reader.push(put(Null(), instr))


def _build_class(reader: Any, instr: Any) -> None:
    reader.push(put(ClassBuilder(), instr))


def _assertion_error(reader: Any, instr: Any) -> None:
    reader.push(put(AssertionError_(), instr))


def _common_constant(reader: Any, instr: Any) -> None:
    is_error = instr.arg.name == "ASSERTION_ERROR"
    reader.push(put(AssertionError_() if is_error else Opaque(), instr))


# ---------------------------------------------------------------- operators


def _unary(reader: Any, instr: Any) -> None:
    operand = reader.pop()
    op: Any = ast.Not() if instr.name == "UNARY_NOT" else ast.Invert()
    if instr.name in ("UNARY_NEGATIVE", "UNARY_POSITIVE"):
        op = ast.USub()
    reader.made(ast.UnaryOp(op, operand), instr, [operand])


_OPERATORS: dict[str, type[ast.operator]] = {
    "ADD": ast.Add, "SUBTRACT": ast.Sub, "MULTIPLY": ast.Mult, "TRUE_DIVIDE": ast.Div,
    "FLOOR_DIVIDE": ast.FloorDiv, "REMAINDER": ast.Mod, "POWER": ast.Pow,
}  # fmt: skip
"""Those that the rules tell from others."""


def _binary(reader: Any, instr: Any) -> None:
    left, right = reader.pop_many(2)
    name = getattr(instr.arg, "name", "")
    if name == "SUBSCR":  # since 3.14
        node: Any = ast.Subscript(left, right, LOAD)
    else:
        op = _OPERATORS.get(name.removeprefix("INPLACE_"), ast.BitAnd)
        node = ast.BinOp(left, op(), right)
        node.in_place = name.startswith("INPLACE_")
        node.computed_by = instr
    reader.made(node, instr, [left])


def _compare(reader: Any, instr: Any) -> None:
    left, right = reader.pop_many(2)
    op = ast.In() if instr.name == "CONTAINS_OP" else ast.Eq()
    node = ast.Compare(left, [op], [right])
    node.tested_by = instr
    reader.made(node, instr, [left])


def _subscript(reader: Any, instr: Any) -> None:
    value, index = reader.pop_many(2)
    reader.made(ast.Subscript(value, index, LOAD), instr, [value])


def _sliced(reader: Any, instr: Any) -> None:
    value, lower, upper = reader.pop_many(3)
    cut = put(ast.Slice(lower, upper), instr)
    reader.made(ast.Subscript(value, cut, LOAD), instr, [value])


def _slice(reader: Any, instr: Any) -> None:
    parts = reader.pop_many(instr.arg)
    reader.made(ast.Slice(*parts), instr, parts)


def _intrinsic(reader: Any, instr: Any) -> None:
    name = getattr(instr.arg, "name", "")
    if name == "INTRINSIC_LIST_TO_TUPLE":
        to_tuple(reader, instr)
    elif name == "INTRINSIC_UNARY_POSITIVE":
        operand = reader.pop()
        reader.made(ast.UnaryOp(ast.UAdd(), operand), instr, [operand])
    elif name == "INTRINSIC_IMPORT_STAR":
        _import_star(reader, instr)
    elif name in ("INTRINSIC_ASYNC_GEN_WRAP", "INTRINSIC_STOPITERATION_ERROR"):
        pass
    elif name == "INTRINSIC_SET_FUNCTION_TYPE_PARAMS":
        reader.pop()
    else:  # of types, but for one that prints what is typed: literals stay
        reader.loose(*reader.pop_many(int(name_of(instr)[-1])))
        reader.push(put(Opaque(), instr, unknown=True))


# ---------------------------------------------------------------- imports


def _import_name(reader: Any, instr: Any) -> None:
    level, _ = reader.pop_many(2)
    node = put(Module(), instr)
    node.module = _name_of(reader, instr)
    node.level = level.value if isinstance(level, ast.Constant) else 1
    reader.push(node)


def _import_from(reader: Any, instr: Any) -> None:
    package = reader.peek(1)
    node = put(Module(), instr)
    node.module, node.level = package.module, package.level
    node.name = _name_of(reader, instr)
    reader.push(node)


def _import_star(reader: Any, instr: Any) -> None:
    module = reader.pop()
    if isinstance(module, Module):
        names = [ast.alias("*")]
        reader.add(ast.ImportFrom(module.module, names, module.level), instr)
    if instr.name == "CALL_INTRINSIC_1":
        reader.push(put(Opaque(), instr))


# ---------------------------------------------------------------- what statements end with


def _store(reader: Any, instr: Any) -> None:
    reader.bind(ast.Name(_name_of(reader, instr), LOAD), reader.pop(), instr)


def _store_attribute(reader: Any, instr: Any) -> None:
    value, owner = reader.pop_many(2)
    reader.bind(ast.Attribute(owner, _name_of(reader, instr), LOAD), value, instr)


def _store_subscript(reader: Any, instr: Any) -> None:
    value, container, key = reader.pop_many(3)
    if isinstance(container, ast.Name) and container.id == "__annotations__":
        return  # the annotation of a variable
    reader.bind(ast.Subscript(container, key, LOAD), value, instr)


def _store_slice(reader: Any, instr: Any) -> None:
    value, container, lower, upper = reader.pop_many(4)
    cut = put(ast.Slice(lower, upper), instr)
    reader.bind(ast.Subscript(container, cut, LOAD), value, instr)


def _return(reader: Any, instr: Any) -> None:
    reader.add(ast.Return(reader.pop()), instr)


def _return_const(reader: Any, instr: Any) -> None:
    reader.add(ast.Return(constant(instr.arg, instr, reader)), instr)


def _yield(reader: Any, instr: Any) -> None:
    value = reader.pop()
    reader.add(ast.Expr(put(ast.Yield(value), instr)), instr)
    reader.push(put(Opaque(), instr, unknown=True))


def _raise(reader: Any, instr: Any) -> None:
    parts = reader.pop_many(instr.arg)
    if parts and isinstance(parts[0], AssertionError_):
        reader.add(ast.Assert(put(ast.Constant(True), instr), parts[0].message), instr)
    else:
        reader.add(ast.Raise(*parts), instr)


def _pop(reader: Any, instr: Any) -> None:
    value = reader.pop()
    if isinstance(value, Part):
        reader.bind(None, value, instr)
    else:
        reader.loose(value)


# ---------------------------------------------------------------- moves


def _copy(reader: Any, instr: Any) -> None:
    reader.push(reader.peek(instr.arg))


def _swap(reader: Any, instr: Any) -> None:
    stack, at = reader.stack, -instr.arg
    stack[at], stack[-1] = stack[-1], stack[at]
    if isinstance(stack[at], (ast.List, ast.Set, ast.Dict)):
        stack[at].start = None  # of a comprehension: what it goes through was there before


def _nothing(reader: Any, instr: Any) -> None:
    pass


def _unpack(reader: Any, instr: Any) -> None:
    argument = instr.arg
    if instr.name == "UNPACK_EX":
        count = int(argument) & 0xFF
        count += 1 + (int(argument) >> 8)
    else:
        count = int(argument)
    reader.unpack(reader.pop(), count, instr)


def _opaque(reader: Any, instr: Any) -> None:
    reader.push(put(Opaque(), instr))


def _with(reader: Any, instr: Any) -> None:
    manager = reader.pop()
    reader.push(put(Opaque(), instr))
    reader.expect("with", manager, instr)


def _special_method(reader: Any, instr: Any) -> None:
    manager = reader.pop()
    method = put(SpecialMethod(), instr, manager.start, unknown=manager.start is None)
    method.manager = manager if instr.arg.name in ("ENTER", "AENTER") else None
    reader.push(method)
    reader.push(put(Null(), instr))


def _awaited(reader: Any, instr: Any) -> None:
    value = reader.pop()
    if isinstance(value, Part):  # of ``async with``
        reader.push(value)
        return
    if instr.name == "GET_YIELD_FROM_ITER":
        node: Any = ast.YieldFrom(value)
    else:
        node = ast.Await(value)
    reader.made(node, instr, [value])


def _end_send(reader: Any, instr: Any) -> None:
    receiver, _ = reader.pop_many(2)
    reader.push(receiver)


def _matched(reader: Any, instr: Any) -> None:
    reader.subject(reader.peek(1), instr)
    reader.push(put(Opaque(), instr))


STEPS: dict[str, Step] = {
    **CALLS, **DISPLAYS,
    "LOAD_CONST": _constant, "LOAD_SMALL_INT": _constant, "RETURN_CONST": _return_const,
    "LOAD_CONST_IMMORTAL": _constant, "LOAD_CONST_MORTAL": _constant,
    **dict.fromkeys(
        ("LOAD_FAST", "LOAD_FAST_CHECK", "LOAD_FAST_BORROW", "LOAD_FAST_AND_CLEAR", "LOAD_NAME",
         "LOAD_DEREF", "LOAD_CLASSDEREF", "LOAD_CLOSURE"), _name),
    **dict.fromkeys(("LOAD_FROM_DICT_OR_GLOBALS", "LOAD_FROM_DICT_OR_DEREF"), _name_in),
    "LOAD_GLOBAL": _global, "LOAD_ATTR": _attribute, "LOAD_METHOD": _attribute,
    "LOAD_SUPER_ATTR": _super_attribute, "PUSH_NULL": _null, "LOAD_BUILD_CLASS": _build_class,
    "LOAD_ASSERTION_ERROR": _assertion_error, "LOAD_COMMON_CONSTANT": _common_constant,
    **dict.fromkeys(
        ("UNARY_NEGATIVE", "UNARY_POSITIVE", "UNARY_NOT", "UNARY_INVERT"), _unary),
    "BINARY_OP": _binary, "BINARY_SUBSCR": _subscript, "BINARY_SLICE": _sliced,
    "BUILD_SLICE": _slice,
    **dict.fromkeys(("COMPARE_OP", "IS_OP", "CONTAINS_OP"), _compare),
    "CALL_INTRINSIC_1": _intrinsic, "CALL_INTRINSIC_2": _intrinsic, "IMPORT_NAME": _import_name,
    "IMPORT_FROM": _import_from, "IMPORT_STAR": _import_star,
    **dict.fromkeys(("STORE_FAST", "STORE_NAME", "STORE_GLOBAL", "STORE_DEREF"), _store),
    "STORE_ATTR": _store_attribute, "STORE_SUBSCR": _store_subscript, "STORE_SLICE": _store_slice,
    "RETURN_VALUE": _return, "YIELD_VALUE": _yield, "RAISE_VARARGS": _raise, "POP_TOP": _pop,
    "COPY": _copy, "SWAP": _swap,
    **dict.fromkeys(("GET_ITER", "NOP", "RESUME", "CACHE", "TO_BOOL", "ASYNC_GEN_WRAP",
                     "NOT_TAKEN"), _nothing),
    **dict.fromkeys(("UNPACK_SEQUENCE", "UNPACK_EX"), _unpack),
    **dict.fromkeys(("BEFORE_WITH", "BEFORE_ASYNC_WITH"), _with), "LOAD_SPECIAL": _special_method,
    **dict.fromkeys(("GET_AWAITABLE", "GET_YIELD_FROM_ITER"), _awaited),
    "END_SEND": _end_send, "RETURN_GENERATOR": _opaque, "LOAD_LOCALS": _opaque,
    **dict.fromkeys(("MATCH_SEQUENCE", "MATCH_MAPPING"), _matched),
}  # fmt: skip
"""By the name of an instruction: what it does, given the `code_reading.Reader` and itself."""
