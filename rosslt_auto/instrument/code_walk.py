"""The rewriter's walk over code objects: the rules of `statements` and `expressions`, applied to
what `code_reading` finds; what becomes of it are `code_edits`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from types import CodeType
from typing import Any

from bytecode import Instr

from ..provenance.locations import LiteralInfo
from .call_sites import is_spread
from .calls import UNTRACKED
from .code_edits import Edits
from .code_nodes import Comprehension, Either, Function
from .code_reading import Reader
from .expressions import ExpressionWalk
from .foreign_calls import FOR_TEXTS
from .interpolations import can_be_noted, interpolated
from .naming import Scope, parameter_names
from .plain import RETURNS_PLAIN, RUN_ONCE, can_evaluate_to_tracked, target_name
from .rewriter import Rewriter, Rewritten, become_lookup
from .statements import StatementWalk
from .walk import Binding


class CodeRewriter(Rewriter):
    """One walk over a code object and those in it."""

    def __init__(self, scope: Scope, table: str) -> None:
        super().__init__(scope, table)
        self.edits = Edits()
        self.visited: set[Any] = set()
        self.made_plain: list[ast.expr] = []

    def module(self, tree: Any) -> None:
        """Walks over the code of a whole module, given by its reader."""
        self._enter_block(tree, tree.body())

    def enter_function(self, body: list[ast.stmt], name: str) -> None:
        """Walks over the body of a function by itself."""
        self.repeated = False if name in RUN_ONCE else None
        self.plain_return = name in RETURNS_PLAIN
        self.function = name.replace("<lambda>", "lambda")
        self.statements(body)

    def finish(self, reserved: Iterable[str] = ()) -> Rewritten:
        """Notes all edits. Code that the compiler has copied has its literals in common."""
        self.found.sort(key=lambda found: (found.line, found.column))
        indices: dict[Any, int] = {}
        unique: list[Any] = []
        for found in self.found:
            key = _identity(found)
            if key not in indices:
                indices[key] = len(unique)
                unique.append(found)
            elif found.repeated and not unique[indices[key]].repeated:
                unique[indices[key]] = unique[indices[key]]._replace(repeated=True)
            self.edits.look_up(found.node, self.table, indices[key])
        names = parameter_names(
            self.module_scope, [(f.scope, f.hint) for f in unique], frozenset(reserved)
        )
        infos = []
        for found, name in zip(unique, names, strict=True):
            node = found.node
            infos.append(
                LiteralInfo(name, name.rpartition(".")[2], found.named, found.line, found.column,
                            node.end_lineno or found.line, node.end_col_offset or found.column,
                            found.repeated)
            )  # fmt: skip
        for found in self.found:  # for those who look at the operands of operators
            become_lookup(found.node, self.table, indices[_identity(found)])
        values = [found.value for found in unique]
        self._edit_operators(values)
        self._edit_calls()
        return Rewritten(tuple(values), infos, tuple(self.interpolations))

    def _edit_operators(self, values: list[Any]) -> None:
        operators = [(node, node.computed_by) for node in self.operations.nodes]
        self.operations.rewrite(self.table, values, self.module_scope, self.remarks.is_off)
        for node, instr in operators:
            call = node.value if isinstance(node, ast.Assign) else node
            if isinstance(call, ast.Call):
                self.edits.operator(instr, call.func.id)  # type: ignore[attr-defined]

    def _edit_calls(self) -> None:
        known = {call for call, _ in self.calls}
        done: set[Any] = set()
        for call, _ in self.calls:
            function: Any = call.func
            if function in done:
                continue
            done.add(function)
            copies = getattr(function, "calls", ())
            if not copies or function.start is None or not known.issuperset(copies):
                continue
            if any(copy.null is None for copy in copies):
                continue
            helpers = [helper for helper in map(self._helper, copies) if helper is not None]
            for copy in copies:
                if helpers:
                    self.edits.call(copy, helpers[0])
                elif not self.with_texts.isdisjoint(copies) and not is_spread(copy):
                    self.edits.function(copy, FOR_TEXTS)

    # ------------------------------------------------------------ overridden visits

    def expression(self, node: Any, binding: Binding) -> None:
        if node is not None and node not in self.visited:
            self.visited.add(node)
            super().expression(node, binding)

    def literal(self, node: Any, value: Any, binding: tuple[str, bool]) -> None:
        if not node.lineno or _is_shorter_than_its_text(node, value):
            return
        outer = self.repeated
        if node.reader.at[id(node.made_by)] in node.reader.repeated:
            self.repeated = True
        column = node.col_offset
        node.positioned = column is not None
        node.col_offset = column or 0
        super().literal(node, value, binding)
        self.repeated = outer

    def untracked(self, value: ast.expr, by: str = UNTRACKED) -> ast.expr:
        if by == UNTRACKED and can_evaluate_to_tracked(value):
            self.made_plain.append(value)
        return value

    def _to_be_plain(self, visit: Callable[..., None], *args: Any) -> list[Any]:
        """What a visit would make plain, were there a tree to change."""
        before = len(self.made_plain)
        visit(*args)
        found = self.made_plain[before:]
        del self.made_plain[before:]
        return found

    def _compare(self, node: Any, binding: Binding) -> None:
        if self._to_be_plain(super()._compare, node, binding):
            self.edits.plain_operand(node.tested_by)

    def _raise(self, node: Any) -> None:
        for value in self._to_be_plain(super()._raise, node):
            if value.made_by is not None:  # else it comes from several places
                self.edits.plain_argument(value)

    def _return(self, node: Any) -> None:
        if self._to_be_plain(super()._return, node):
            self.edits.plain_result(node.made_by)

    def _assign(self, node: Any) -> None:
        name = target_name(node.targets[0])
        if isinstance(node.value, Function) and name in RETURNS_PLAIN:
            for statement in node.value.body():
                if isinstance(statement, ast.Return) and can_evaluate_to_tracked(statement.value):  # type: ignore[arg-type]
                    self.edits.plain_result(statement.made_by)  # type: ignore[attr-defined]
        super()._assign(node)

    def can_note(self, node: Any) -> bool:
        return can_be_noted(node) and _is_straight(node)

    def note(self, node: Any, name: str, index: int) -> Any:
        values = [part.value for part in node.values if isinstance(part, ast.FormattedValue)]
        parts, literals = interpolated(node, name, index)
        self.edits.interpolation(node, name, index, values)
        for literal in literals:
            self.edits.text_piece(literal, name, index)
        return parts, literals

    # ------------------------------------------------------------ nodes that `ast` has not

    def _either(self, node: Either, binding: Binding) -> None:
        self.expressions(node.values, binding)

    def _function_value(self, node: Function, binding: Binding) -> None:
        if node.is_definition:
            return  # nobody binds it: what it is, cannot be seen
        outer = self.scope, self.block, self.repeated, self.function, self.displays
        outer_return = self.plain_return
        self.scope = Scope("lambda", self.scope)
        self.defaults(node.arguments())
        self.block, self.repeated, self.displays, self.plain_return = None, None, 0, False
        self.function = binding[0] if binding else "lambda"
        self.statements(node.body())
        self.scope, self.block, self.repeated, self.function, self.displays = outer
        self.plain_return = outer_return

    def _comprehension_function(self, node: Comprehension, binding: Binding) -> None:
        body = node.function.body()
        first = next((one for one in body if isinstance(one, ast.For)), None)
        target = target_name(first.target) if first else None
        self.expression(node.iterable, (target or "value", True) if binding else None)
        outer, self.repeated = self.repeated, True
        generator = node.function.code.co_name == "<genexpr>"
        rest = []
        for statement in body:
            value: Any = getattr(statement, "value", None)
            if generator and isinstance(value, ast.Yield):
                self.expression(value.value, binding)
            elif isinstance(statement, ast.Return):
                self.expression(value, binding)
            else:
                rest.append(statement)
        self.statements(rest)
        self.repeated = outer

    STATEMENTS = {
        **StatementWalk.STATEMENTS,
        ast.Assign: _assign,
        ast.Raise: _raise,
        ast.Return: _return,
    }
    EXPRESSIONS = {
        **ExpressionWalk.EXPRESSIONS,
        ast.Compare: _compare,
        Either: _either,
        Function: _function_value,
        Comprehension: _comprehension_function,
    }


def rewrite_code(code: CodeType, scope: Scope, table: str) -> tuple[CodeType, Rewritten]:
    """The counterpart of `rewriter.rewrite` for the code object of a module."""
    reader = Reader(code)
    walk = CodeRewriter(scope, table)
    walk.module(reader)
    rewritten = walk.finish()
    return walk.edits.apply(reader), rewritten


def rewrite_function(code: CodeType, scope: Scope, table: str) -> tuple[CodeType, Rewritten]:
    """The same for the code object of a function in the module of `scope`.

    It is called by its qualified name there.
    """
    walk = CodeRewriter(scope, table)
    for name in code.co_qualname.replace("<lambda>", "lambda").split("."):
        if name != "<locals>":
            walk.scope = Scope(name, walk.scope)
    reader = Reader(code)
    walk.enter_function(reader.body(), code.co_name)
    rewritten = walk.finish()
    return walk.edits.apply(reader), rewritten


def _identity(found: Any) -> Any:
    """Equal for the copies of a literal."""
    node = found.node
    if not node.positioned:
        return id(node)
    return (
        found.line, found.column, node.end_lineno, node.end_col_offset, type(found.value),
        repr(found.value), node.element,
    )  # fmt: skip


def _is_shorter_than_its_text(node: Any, value: Any) -> bool:
    """Whether what stands there is an expression that repeats a text: ``"=" * 78``."""
    if type(value) is not str or node.lineno != node.end_lineno or node.element:
        return False
    if node.col_offset is None or node.end_col_offset is None:
        return False
    return node.end_col_offset - node.col_offset < len(value)


def _is_straight(node: Any) -> bool:
    """Whether an f-string is evaluated from its start to its end without a jump."""
    parts = [node, *(part for part in node.values if isinstance(part, ast.Constant))]
    parts += [part.value for part in node.values if isinstance(part, ast.FormattedValue)]
    items, at = node.reader.items, node.reader.at
    for part in parts:
        if part.start is None or part.made_by is None or part.reader is not node.reader:
            return False
        start, end = at[id(part.start)], at[id(part.made_by)]
        if start > end:
            return False
    start, end = at[id(node.start)], at[id(node.made_by)]
    return all(isinstance(one, Instr) and not one.has_jump() for one in items[start : end + 1])
