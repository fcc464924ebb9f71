"""Reads a code object: which expressions its instructions evaluate, and what happens to them.

The stack is followed symbolically through the blocks of the code, each block once; what is popped
by a store, a return and the like becomes a statement of `ast`. There are no nested statements:
where control flows only matters for values that come from several places (`Either`), and for what
stands in a loop.
"""

from __future__ import annotations

import ast
import sys
from types import CodeType
from typing import Any

from bytecode import Bytecode, Instr, Label, TryBegin

from .code_nodes import Either, Function, Null, Opaque, Part, definition, put
from .code_opcodes import STEPS
from .code_substitutes import name_of, readable
from .errors import NotInstrumented
from .walk import LOAD

_ENDS = frozenset(
    {"RETURN_VALUE", "RETURN_CONST", "RAISE_VARARGS", "RERAISE", "JUMP_FORWARD", "JUMP_BACKWARD",
     "JUMP_BACKWARD_NO_INTERRUPT", "JUMP", "JUMP_NO_INTERRUPT"}
)  # fmt: skip


_NEVER_FOLLOWED = frozenset({"END_ASYNC_FOR"})
"""Its target is for `sys.monitoring` (since 3.14)."""


class Targets:
    """What an assignment, a loop or a ``with`` binds its value to, as far as it is known."""

    def __init__(self, kind: str, value: Any, count: int) -> None:
        self.kind = kind
        self.value = value
        self.found: list[Any] = [None] * count
        self.missing = count
        self.outer: Part | None = None

    def statement(self) -> ast.stmt | None:
        """The statement, once all targets are known."""
        target: Any = self.found[0]
        if self.kind == "for":
            return ast.For(target, self.value, [], [])
        if self.kind == "with":
            return ast.With([ast.withitem(self.value, target)], [])
        return ast.Assign([ast.Tuple(self.found, LOAD)], self.value)


class Reader:
    """One code object, read.

    statements  in the order of the instructions; those of which the values may be of use to another
                one (`weak`) have to be visited last
    repeated    positions in the list of instructions that are executed again and again
    """

    def __init__(self, code: CodeType) -> None:
        self.code = code
        shown = readable(code)
        self.has_substitutes = shown is not code
        self.bytecode = Bytecode.from_code(shown, conserve_exception_block_stackdepth=True)
        self.items: list[Any] = [one for item in self.bytecode for one in _single(item)]
        self.at = {id(item): index for index, item in enumerate(self.items)}
        self.labels = {id(item): i for i, item in enumerate(self.items) if isinstance(item, Label)}
        self.statements: list[ast.stmt] = []
        self.weak: list[ast.stmt] = []
        self.children: dict[int, Reader] = {}
        self.stack: list[Any] = []
        self.keyword_names: Any = ()
        self.precall: Instr | None = None
        self._entries: dict[int, list[Any]] = {0: []}
        self._read_from: dict[int, list[int]] = {}
        self._read()
        self.repeated = self._loops()

    def body(self) -> list[ast.stmt]:
        """All statements, in the order in which they have to be visited.

        What is tested may be a copy: if a later statement has the value, that one says more of it.
        """
        return self.statements + self.weak[::-1]

    def child(self, function: Function) -> Reader:
        """The code of a function that this code makes, read."""
        key = id(function.code_made_by)
        if key not in self.children:
            self.children[key] = Reader(function.code)
        return self.children[key]

    # ------------------------------------------------------------ control flow

    def _read(self) -> None:
        done: set[int] = set()
        waiting = {0}
        while waiting:
            start = min(waiting)
            waiting.remove(start)
            done.add(start)
            self.stack = list(self._entries[start])
            for successor in self._block(start):
                self._read_from.setdefault(successor, []).append(start)
                if successor not in done:
                    waiting.add(successor)

    def _block(self, start: int) -> list[int]:
        """Reads a block; the positions of those that may come next, their entries being noted."""
        follow: list[int] = []
        for index in range(start, len(self.items)):
            item = self.items[index]
            if isinstance(item, Label):
                if index != start:
                    self._enter(index, self.stack)
                    return [*follow, index]
            elif isinstance(item, TryBegin):
                handler = self.labels[id(item.target)]
                depth = item.stack_depth if isinstance(item.stack_depth, int) else len(self.stack)
                pushed = [Opaque()] * (2 if item.push_lasti else 1)
                self._enter(handler, self.stack[:depth] + pushed)
                follow.append(handler)
            elif isinstance(item, Instr):
                if item.has_jump() and item.name not in _NEVER_FOLLOWED:
                    follow.append(self._jump(item))
                    if item.name not in _ENDS:
                        self._enter(index + 1, self.stack)
                        follow.append(index + 1)
                    return follow
                step = STEPS.get(name_of(item))
                if step is None:
                    self.unknown(item)
                else:
                    step(self, item)
                if item.name in _ENDS:
                    return follow
        return follow

    def _jump(self, instr: Instr) -> int:
        """Follows an instruction that may jump, on both ways; the position that it jumps to."""
        target = self.labels[id(instr.arg)]
        name = instr.name
        if name == "FOR_ITER":
            iterable = self.peek(1)
            self._enter_after(instr, target)
            self.expect("for", iterable, instr)
        elif name == "SEND":
            self.pop()
            receiver = self.peek(1)
            extra = instr.stack_effect(jump=True)
            self._enter(target, [*self.stack[:-1], *[receiver] * (2 + extra)])
            self.push(put(Opaque(), instr))
        elif name.endswith("_OR_POP"):
            self._enter(target, self.stack)
            self.stack.pop()
        elif "IF_" in name:
            self.loose(self.pop())
            self._enter(target, self.stack)
        elif name in _ENDS:
            self._enter(target, self.stack)
        else:
            self._enter_after(instr, target)
            self.unknown(instr)
        return target

    def _enter_after(self, instr: Instr, target: int) -> None:
        effect = instr.stack_effect(jump=True)
        after = self.stack[:effect] if effect < 0 else self.stack + [Opaque()] * effect
        self._enter(target, after)

    def _enter(self, index: int, stack: list[Any]) -> None:
        """Notes what lies on the stack where a block is entered, from one place more."""
        known = self._entries.get(index)
        if known is None:
            self._entries[index] = list(stack)
            return
        if len(known) != len(stack):
            raise NotInstrumented(f"{self.code.co_qualname}: a stack of two depths")
        for i, (one, other) in enumerate(zip(known, stack, strict=True)):
            if one is other or type(one) is type(other) is Opaque:
                continue
            if isinstance(one, Either) and one.label == index:
                one.values.append(other)
            else:
                known[i] = Either([one, other], index)

    def _loops(self) -> set[int]:
        """Positions in loops: from where a jump back leads to, if nothing else leads behind it."""
        inside: set[int] = set()
        handlers = self._moved_handlers()
        for end, before in self._read_from.items():
            for start in before:
                if start < end:
                    continue
                members, open_ends = {end}, [start]
                while open_ends:
                    block = open_ends.pop()
                    if block not in members:
                        members.add(block)
                        open_ends += self._read_from.get(block, [])
                if 0 in members and end != 0:
                    continue
                if start < handlers:  # also what leaves the loop from inside
                    inside.update(range(end, self._end_of(start)))
                for block in members:
                    inside.update(range(block, self._end_of(block)))
        return inside

    def _moved_handlers(self) -> int:
        """Where exception handlers begin, if they stand behind everything else (since 3.12)."""
        if sys.version_info >= (3, 12):
            for index, item in enumerate(self.items):
                if isinstance(item, Instr) and item.name == "PUSH_EXC_INFO":
                    return index
        return len(self.items)

    def _end_of(self, block: int) -> int:
        return min((one for one in self._entries if one > block), default=len(self.items))

    # ------------------------------------------------------------ what instructions do

    def push(self, node: Any) -> None:
        node.reader = self
        self.stack.append(node)

    def made(self, node: Any, instr: Instr, operands: list[Any]) -> None:
        """Pushes what an instruction makes of operands, the first of which it starts with."""
        start = operands[0].start if operands else instr
        self.push(put(node, instr, start, unknown=start is None))

    def pop(self) -> Any:
        return self.stack.pop()

    def pop_many(self, count: Any) -> list[Any]:
        """The uppermost values, the lowest first."""
        if not count:
            return []
        values = self.stack[-count:]
        del self.stack[-count:]
        return values

    def peek(self, depth: Any) -> Any:
        return self.stack[-depth]

    def loose(self, *values: Any) -> None:
        """Values that nobody binds: dropped, tested, or given to something unknown."""
        for value in values:
            if not isinstance(value, (ast.Name, ast.Constant, Null)):
                self.weak.append(ast.Expr(value))

    def unknown(self, instr: Instr) -> None:
        """An instruction that has no step."""
        pops, _ = instr.pre_and_post_stack_effect(jump=False)
        pops = min(pops, 0)
        self.loose(*self.pop_many(-pops))
        for _ in range(instr.stack_effect(jump=False) - pops):
            self.push(put(Opaque(), instr, unknown=pops < 0))

    def add(self, statement: Any, instr: Instr) -> None:
        self.statements.append(put(statement, instr))

    def expect(self, kind: str, value: Any, instr: Instr) -> None:
        """Pushes what is going to be bound by a loop or a ``with``."""
        self._push_parts(Targets(kind, value, 1), instr)

    def unpack(self, value: Any, count: int, instr: Instr) -> None:
        """Pushes the parts of a value, the first one uppermost."""
        targets = Targets("assign", value, count)
        if isinstance(value, Part):
            targets.outer = value
        if not count:
            self.loose(value)
        self._push_parts(targets, instr)

    def _push_parts(self, targets: Targets, instr: Instr) -> None:
        for index in reversed(range(len(targets.found))):
            part = put(Part(), instr)
            part.targets, part.index = targets, index
            self.push(part)

    def bind(self, target: Any, value: Any, instr: Instr) -> None:
        """Binds a value; whoever else has it gets it by the name of the target."""
        if isinstance(value, Part):
            self._bind_part(target, value, instr)
            return
        self._statement(target, value, instr)
        if any(value is other for other in self.stack):
            start = value.start
            name = put(ast.Name("", LOAD), instr, start, unknown=start is None)
            name.reader = self
            self.stack[:] = [name if value is other else other for other in self.stack]

    def _bind_part(self, target: Any, part: Part, instr: Instr) -> None:
        targets = part.targets
        if targets.found[part.index] is None:
            targets.missing -= 1
        targets.found[part.index] = target
        if targets.missing:
            return
        targets.missing = -1  # a copy of this code, elsewhere, binds it once more
        if targets.outer is not None:
            self._bind_part(ast.Tuple(targets.found, LOAD), targets.outer, instr)
        else:
            self.add(targets.statement(), instr)

    def _statement(self, target: Any, value: Any, instr: Instr) -> None:
        made = definition(target, value)
        if made is not None:
            self.add(made, instr)
        elif isinstance(value, ast.BinOp) and getattr(value, "in_place", False):
            left: Any = value.left
            statement: Any = ast.AugAssign(left, value.op, value.right)
            statement.computed_by = value.made_by  # type: ignore[attr-defined]
            self.add(statement, instr)
        else:
            self.add(ast.Assign([target], value), instr)

    def subject(self, value: Any, instr: Instr) -> None:
        """What a ``match`` compares: its literals stay."""
        self.weak.append(ast.Expr(value))
        self.stack[:] = [put(Opaque(), instr) if value is one else one for one in self.stack]


_PAIRS = {
    "LOAD_FAST_LOAD_FAST": ("LOAD_FAST", "LOAD_FAST"),
    "LOAD_FAST_BORROW_LOAD_FAST_BORROW": ("LOAD_FAST_BORROW", "LOAD_FAST_BORROW"),
    "STORE_FAST_LOAD_FAST": ("STORE_FAST", "LOAD_FAST"),
    "STORE_FAST_STORE_FAST": ("STORE_FAST", "STORE_FAST"),
}


def _single(item: Any) -> list[Any]:
    """Two instructions for one that stands for two (since 3.13): something may come in between."""
    pair = _PAIRS.get(item.name) if isinstance(item, Instr) else None
    if pair is None:
        return [item]
    return [
        Instr(name, arg, location=item.location) for name, arg in zip(pair, item.arg, strict=True)
    ]
