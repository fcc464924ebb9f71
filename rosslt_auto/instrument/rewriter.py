"""From a module's syntax tree to one that produces tracked values.

A literal becomes a look-up in the module's table of literals, ``0.5`` -> ``@rosslt.node.1f0c[3]``,
and a call that would lose provenance a call of ours, ``sin(x)`` -> ``@rosslt.call1(sin, x)``. The
names contain a character that no program can write, and are found through `builtins`. Nodes are
replaced in place by nodes at exactly the same position, so that tracebacks, coverage and debuggers
see what they would see without us, and nothing else of the tree changes.

Literals are collected first (`statements`, `expressions`): names can only be given when all are
known. One walk serves a module as well as the tree of a single class or function.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from ..provenance.locations import LiteralInfo
from ..provenance.truth_sites import TruthSites
from .call_sites import (
    EXECUTION_CALLS,
    MATH_CALLS,
    array_helper,
    call_helper,
    execution_helper,
    file_helper,
    is_spread,
    root_name,
)
from .expressions import ExpressionWalk
from .foreign_calls import FOR_TEXTS
from .naming import Scope, parameter_names
from .remarks import Remarks
from .statements import StatementWalk
from .walk import LOAD, Block, Parts


class Rewritten(NamedTuple):
    """What the rewriter made of a tree: the values of the literals, what is known of them, what
    its f-strings are made of, and what is wrong with its remarks."""

    values: tuple[Any, ...] = ()
    infos: Sequence[LiteralInfo] = ()
    interpolations: tuple[Parts, ...] = ()
    warnings: tuple[str, ...] = ()


def rewrite(
    tree: ast.Module,
    scope: Scope,
    table: str,
    reserved: Iterable[str] = (),
    remarks: Remarks | None = None,
    executing: bool = True,
) -> Rewritten:
    """Rewrites `tree` in place.

    scope     the module's, see `naming.module_scope`
    table     the name under which the code finds its table of literals
    reserved  names that its literals must not use, see `naming.submodules`
    remarks   what its comments say, see `remarks.read`
    executing whether what it executes (`exec`, `eval`) is tracked, too
    """
    if remarks is not None and remarks.everything:
        return Rewritten(warnings=tuple(remarks.warnings))
    walk = Rewriter(scope, table, remarks)
    walk.executing = executing
    walk.truths.update(map(id, TruthSites(tree).literals))
    walk.module(tree)
    return walk.finish(reserved)


class Rewriter(StatementWalk, ExpressionWalk):
    """One walk over a tree, and what is made of its findings."""

    executing = True

    def finish(self, reserved: Iterable[str] = ()) -> Rewritten:
        """Puts the look-ups and calls in place, in source order."""
        self.found.sort(key=lambda found: (found.line, found.column))
        names = parameter_names(
            self.module_scope, [(f.scope, f.hint) for f in self.found], frozenset(reserved)
        )
        remarks = self.remarks
        limits = remarks.limits(self.found)
        infos: list[LiteralInfo] = []
        values: list[Any] = []
        for found, name in zip(self.found, names, strict=True):
            node = found.node
            if remarks.is_off(node):  # others keep their names
                continue
            infos.append(
                LiteralInfo(name, name.rpartition(".")[2], found.named, node.lineno,
                            node.col_offset, node.end_lineno or node.lineno,
                            node.end_col_offset or node.col_offset, found.repeated,
                            limits.get(node), node.lineno in remarks.frozen)
            )  # fmt: skip
            become_lookup(node, self.table, len(values))
            values.append(found.value)
        self.operations.rewrite(self.table, values, self.module_scope, remarks.is_off)
        for call, block in self.calls:
            if not remarks.is_off(call):
                self._rewrite_call(call, block)
        for block in self.blocks:
            block.declare()
        return Rewritten(tuple(values), infos, tuple(self.interpolations), tuple(remarks.warnings))

    def _rewrite_call(self, node: ast.Call, block: Block | None) -> None:
        helper = self._helper(node)
        if helper is not None:
            node.args.insert(0, node.func)
            node.func = ast.copy_location(ast.Name(helper, LOAD), node.func)
        elif node in self.with_texts and not is_spread(node):
            helper = FOR_TEXTS
            name = ast.copy_location(ast.Name(helper, LOAD), node.func)
            node.func = ast.copy_location(ast.Call(name, [node.func], []), node.func)
        if helper is not None and block is not None:
            block.names.add(helper)

    def _helper(self, node: ast.Call) -> str | None:
        """The name of our function that is to make a call, None if it stays as it is."""
        func = node.func
        if isinstance(func, ast.Attribute):
            if isinstance(func.value, ast.Name) and func.value.id in self.math_modules:
                return call_helper(node, func.attr) if func.attr in MATH_CALLS else None
            if root_name(func.value) in self.array_modules:
                return array_helper(node, func.attr)
            return file_helper(node, func.attr)
        assert isinstance(func, ast.Name)
        if func.id in self.array_names:
            return array_helper(node, self.array_names[func.id])
        if func.id in self.file_names:
            return file_helper(node, self.file_names[func.id])
        if func.id in EXECUTION_CALLS:
            return execution_helper(node) if self.executing else None
        name = self.called_names.get(func.id)
        return call_helper(node, name) if name is not None else None


def become_lookup(node: Any, table: str, index: int) -> None:
    """Turns a literal in place into ``table[index]``: nobody needs to know its parent."""
    position = {
        "lineno": node.lineno,
        "col_offset": node.col_offset,
        "end_lineno": node.end_lineno,
        "end_col_offset": node.end_col_offset,
    }
    node.__class__ = ast.Subscript
    node.value = ast.Name(table, LOAD, **position)
    node.slice = ast.Constant(index, **position)
    node.ctx = LOAD
