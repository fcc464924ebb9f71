"""Changes of instructions: what is put before, after or in the place of them.

The counterpart for code objects of what `rewriter` does to a tree: look-ups for constants, our
functions for calls, and what goes around f-strings.
"""

from __future__ import annotations

import sys
from types import CodeType
from typing import Any

from bytecode import BinaryOp, Instr, TryBegin
from bytecode.instr import InstrLocation

from .calls import UNTRACKED
from .code_calls import NULL_FIRST
from .code_reading import Reader
from .code_substitutes import executable

Where = InstrLocation | None

_OUTER, _INNER = 0, 1
_UNKNOWN = 24
"""From so many places more on the stack, `bytecode` has to compute how many it needs."""


class Edits:
    """What is to be done to the instructions of a code object and of those in it."""

    def __init__(self) -> None:
        self._before: dict[int, list[tuple[int, int, list[Instr]]]] = {}
        self._after: dict[int, list[tuple[int, list[Instr]]]] = {}
        self._instead: dict[int, list[Instr]] = {}
        self._elements: dict[int, dict[tuple[int, ...], tuple[str, int]]] = {}
        self._deeper: dict[int, int] = {}
        self._widest: dict[int, int] = {}

    # ------------------------------------------------------------ what can be changed

    def look_up(self, node: Any, table: str, index: int) -> None:
        """A literal, or an element of a constant, comes from a table."""
        self._elements.setdefault(id(node.made_by), {})[node.element] = (table, index)

    def call(self, node: Any, helper: str) -> None:
        """A call is made by one of our functions, which gets what was to be called."""
        function, instr, null = node.func, node.made_by, node.null.made_by
        if id(null) not in self._instead:  # the compiler may have copied the call alone
            load = Instr("LOAD_GLOBAL", (True, helper), location=_where(function.start))
            self._put_before(function, instr, _INNER, [load])
            self._instead[id(null)] = _without_null(null, function.lineno)
        self._note_depth(node.reader, function.start, instr, 1)
        for one in (instr, node.precall):
            if one is not None:
                self._instead[id(one)] = [Instr(one.name, one.arg + 1, location=one.location)]

    def function(self, node: Any, helper: str) -> None:
        """What is called is what one of our functions gives for it."""
        function, instr, null = node.func, node.made_by, node.null.made_by
        if id(null) in self._instead:  # done, for a copy of the call
            return
        at = _where(function.start if NULL_FIRST else function.made_by)
        push = [Instr("PUSH_NULL", location=at)]
        before, after = (push, []) if NULL_FIRST else ([], push)
        self._put_before(function, instr, _INNER, before)
        self._instead[id(null)] = _without_null(null, function.lineno)
        given = _given_to(helper, _where(function.made_by))
        self._put_after(function.made_by, _OUTER, [*given, *after])
        self._note_depth(node.reader, function.start, instr, 3)

    def operator(self, instr: Instr, helper: str) -> None:
        """Two operands are given to one of our functions."""
        at = instr.location
        null, swap = Instr("PUSH_NULL", location=at), Instr("SWAP", 3, location=at)
        load = Instr("LOAD_GLOBAL", (False, helper), location=at)
        first, second = (null, load) if NULL_FIRST else (load, null)
        self._instead[id(instr)] = [first, swap, second, swap, *_calling(2, at)]

    def interpolation(self, node: Any, name: str, index: int, values: list[Any]) -> None:
        """Puts ``begin``, ``value`` and ``end`` of `strings.Interpolation` around an f-string."""
        where = _where(node.made_by)
        self._note_depth(node.reader, node.start, node.made_by, 6)
        begin = [*_method(name, index, "end", where), *_method(name, index, "begin", where)]
        self._put_before(node, node.made_by, _INNER, [*begin, *_calling(0, where)])
        for value in values:
            at = _where(value.made_by)
            load = _method(name, index, "value", at)
            self._put_before(value, value.made_by, _OUTER, load)
            self._put_after(value.made_by, _INNER, _calling(1, at))
        self._put_after(node.made_by, _OUTER, _calling(2, where))

    def text_piece(self, node: Any, name: str, index: int) -> None:
        """A literal in an f-string becomes a value of it."""
        at = _where(node.made_by)
        self._put_before(node, node.made_by, _OUTER, _method(name, index, "value", at))
        self._put_after(node.made_by, _INNER, [*_calling(1, at), *_formatting(at)])

    def plain_result(self, instr: Instr) -> None:
        """What is returned is made plain."""
        self._put(self._before, instr, (0, _OUTER, _untracked(_where(instr))))

    def plain_operand(self, instr: Instr) -> None:
        """The left operand is made plain."""
        at = _where(instr)
        swap = [Instr("SWAP", 2, location=at)]
        self._put(self._before, instr, (0, _OUTER, [*swap, *_untracked(at), *swap]))

    def plain_argument(self, value: Any) -> None:
        """The value of an expression is made plain where it is made."""
        self._put_after(value.made_by, _OUTER, _untracked(_where(value.made_by)))

    def _note_depth(self, reader: Reader, start: Instr, end: Instr, depth: int) -> None:
        """Notes by how much the stack of a code object gets deeper, at most."""
        between = reader.items[reader.at[id(start)] : reader.at[id(end)]]
        if any(isinstance(item, TryBegin) for item in between):
            depth = _UNKNOWN  # handlers inside of an expression, which have depths of their own
        self._deeper[id(reader)] = self._deeper.get(id(reader), 2) + depth

    def _put_before(self, node: Any, end: Instr, kind: int, instrs: list[Instr]) -> None:
        # The one that ends last goes around the others.
        self._put(self._before, node.start, (-node.reader.at[id(end)], kind, instrs))

    def _put_after(self, instr: Instr, kind: int, instrs: list[Instr]) -> None:
        self._put(self._after, instr, (kind, instrs))

    @staticmethod
    def _put(edits: Any, instr: Instr, edit: Any) -> None:
        edits.setdefault(id(instr), []).append(edit)

    # ------------------------------------------------------------ the result

    def apply(self, reader: Reader) -> CodeType:
        """The code of `reader`, changed; the same one if nothing of it is."""
        changed = False
        items: list[Any] = []
        for item in reader.items:
            key = id(item)
            done = len(items)
            for _, _, instrs in sorted(self._before.get(key, ()), key=lambda edit: edit[:2]):
                items += instrs
            items += self._replaced(item, reader)
            for _, instrs in sorted(self._after.get(key, ()), key=lambda edit: edit[0]):
                items += instrs
            changed = changed or len(items) != done + 1 or items[-1] is not item
        if not changed:
            return reader.code
        reader.bytecode[:] = items
        reader.bytecode.argnames = list(reader.code.co_varnames)  # all: `locals()` is in this order
        deeper = self._deeper.get(id(reader), 2)
        if deeper > _UNKNOWN:  # takes twice as long
            made = reader.bytecode.to_code()
        else:
            made = reader.bytecode.to_code(
                stacksize=reader.code.co_stacksize + deeper + self._widest.get(id(reader), 0),
                compute_exception_stack_depths=False,
            )
        return executable(made) if reader.has_substitutes else made

    def _replaced(self, item: Any, reader: Reader) -> list[Any]:
        key = id(item)
        if key in self._elements:
            made = _from_table(item.arg, self._elements[key], (), _where(item))
            leaves = sum(instr.name == "LOAD_CONST" for instr in made)  # that lie there together
            self._widest[id(reader)] = max(leaves, self._widest.get(id(reader), 0))
            if item.name == "RETURN_CONST":
                made.append(Instr("RETURN_VALUE", location=item.location))
            return made
        if key in reader.children:
            code: Any = self.apply(reader.children[key])
            if code is not item.arg:
                return [Instr(item.name, code, location=item.location)]
        return self._instead.get(key, [item])


def _where(instr: Instr) -> Where:
    return instr.location


def _from_table(
    value: Any,
    elements: dict[tuple[int, ...], tuple[str, int]],
    path: tuple[int, ...],
    where: Where,
) -> list[Instr]:
    """Instructions for a constant of which some elements come from a table."""
    if path in elements:
        return _look_up(*elements[path], where)
    if not any(one[: len(path)] == path for one in elements):
        return [Instr("LOAD_CONST", value, location=where)]
    made = []
    for index, one in enumerate(value):
        made += _from_table(one, elements, (*path, index), where)
    return [*made, Instr("BUILD_TUPLE", len(value), location=where)]


def _look_up(name: str, index: int, where: Where) -> list[Instr]:
    if sys.version_info >= (3, 14):
        subscript = Instr("BINARY_OP", BinaryOp.SUBSCR, location=where)
    else:
        subscript = Instr("BINARY_SUBSCR", location=where)
    return [
        Instr("LOAD_GLOBAL", (False, name), location=where),
        Instr("LOAD_CONST", index, location=where),
        subscript,
    ]


def _method(name: str, index: int, method: str, where: Where) -> list[Instr]:
    if sys.version_info >= (3, 12):
        load = Instr("LOAD_ATTR", (True, method), location=where)
    else:
        load = Instr("LOAD_METHOD", method, location=where)
    return [*_look_up(name, index, where), load]


def _calling(count: int, where: Where) -> list[Instr]:
    call = [Instr("CALL", count, location=where)]
    if sys.version_info < (3, 12):
        call.insert(0, Instr("PRECALL", count, location=where))
    return call


def _formatting(where: Where) -> list[Instr]:
    if sys.version_info >= (3, 13):
        return [Instr("FORMAT_SIMPLE", location=where)]
    return [Instr("FORMAT_VALUE", 0, location=where)]


def _untracked(where: Where) -> list[Instr]:
    """Makes the uppermost value plain."""
    return _given_to(UNTRACKED, where)


def _given_to(helper: str, where: Where) -> list[Instr]:
    """Puts what one of our functions gives for the uppermost value in its place."""
    null = Instr("PUSH_NULL", location=where)
    load = Instr("LOAD_GLOBAL", (False, helper), location=where)
    first, second = (null, load) if NULL_FIRST else (load, null)
    swap = Instr("SWAP", 2, location=where)
    return [first, swap, second, swap, *_calling(1, where)]


def _without_null(instr: Instr, line: int) -> list[Instr]:
    """An instruction that prepares a call, without the empty place beside the function.

    line  of the function: if it is another one, tracers see both
    """
    if instr.name == "PUSH_NULL":
        seen = not NULL_FIRST and instr.lineno != line
        return [Instr("NOP", location=instr.location)] if seen else []
    if instr.name == "LOAD_METHOD":
        return [Instr("LOAD_ATTR", instr.arg, location=instr.location)]
    argument: Any = instr.arg
    return [Instr(instr.name, (False, *argument[1:]), location=instr.location)]
