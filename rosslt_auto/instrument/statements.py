"""The rewriter's walk over statements: what their expressions are bound to."""

from __future__ import annotations

import ast
from typing import Any

from .call_sites import (
    ARRAY_CALLS,
    ARRAY_MODULES,
    FILE_CALLS,
    FILE_MODULES,
    MATH_CALLS,
    MATH_MODULES,
)
from .naming import Scope
from .plain import RETURNS_PLAIN, RUN_ONCE, is_enum, is_special, target_name
from .walk import Block, Walk

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


SYNTAX_ERRORS = frozenset({"SyntaxError", "IndentationError", "TabError"})
"""Errors whose texts show a line number only if that is exactly an `int`."""


class StatementWalk(Walk):
    """Visits of statements. Those not listed at the end, also later Pythons', stay plain."""

    def module(self, tree: ast.Module) -> None:
        """Walks over a whole module."""
        self._enter_block(tree, tree.body)

    def _enter_block(self, node: Any, body: list[ast.stmt]) -> None:
        outer, self.block = self.block, Block(node)
        self.blocks.append(self.block)
        self.statements(body)
        self.block = outer

    def _loop(self, body: list[ast.stmt]) -> None:
        outer, self.repeated = self.repeated, True
        self.statements(body)
        self.repeated = outer

    def _function(self, node: Any) -> None:
        outer_scope, outer_state = self.scope, (
            self.block, self.repeated, self.function, self.plain_return, self.displays,
            self.parameters,
        )  # fmt: skip
        self.with_plain_texts(node.decorator_list)
        self.scope = Scope(node.name, outer_scope)
        self.defaults(node.args)
        self.block, self.function = None, node.name
        self.repeated = False if node.name in RUN_ONCE else None
        self.plain_return = node.name in RETURNS_PLAIN
        self.displays = 0
        self.parameters = frozenset(
            arg.arg for arg in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)
        )
        self.statements(node.body)
        self.scope = outer_scope
        (
            self.block, self.repeated, self.function, self.plain_return, self.displays,
            self.parameters,
        ) = outer_state  # fmt: skip

    def _class(self, node: ast.ClassDef) -> None:
        self.with_plain_texts(node.decorator_list)
        self.with_plain_texts(node.bases)
        for keyword in node.keywords:
            self.with_plain_texts([keyword.value], (keyword.arg or "value", True))
        body = node.body
        if is_enum(node, self.enums):
            self.enums.add(node.name)
            body = [s for s in body if isinstance(s, (*_FUNCTIONS, ast.ClassDef))]
        outer = self.scope, self.function, self.plain_return
        self.scope = Scope(node.name, self.scope, is_class=True)
        self._enter_block(node, body)
        self.scope, self.function, self.plain_return = outer

    def _assign(self, node: ast.Assign) -> None:
        name = target_name(node.targets[0])
        if is_special(name) and not isinstance(node.targets[0], (ast.Tuple, ast.List)):
            if isinstance(node.value, ast.Lambda) and name in RETURNS_PLAIN:
                node.value.body = self.untracked(node.value.body)
            return
        for target in node.targets:
            self.target(target)
        first = node.targets[0]
        if isinstance(first, ast.Name):
            self.alias(first.id, node.value)
        elif isinstance(first, ast.Attribute) and self.is_text(node.value):
            self.text_names.add(f".{first.attr}")
        self.operations.bound(first, node.value, self.scope)
        if isinstance(first, ast.Tuple) and isinstance(node.value, (ast.Tuple, ast.List)):
            values = node.value.elts
            if len(values) == len(first.elts) and not any(
                isinstance(part, ast.Starred) for part in (*values, *first.elts)
            ):
                for part, value in zip(first.elts, values, strict=True):
                    self.expression(value, (target_name(part) or "value", True))
                return
        self.expression(node.value, (name or "value", True))

    def _annotated(self, node: ast.AnnAssign) -> None:
        name = target_name(node.target)
        if node.value is not None and not is_special(name):
            self.target(node.target)
            self.operations.bound(node.target, node.value, self.scope)
            self.expression(node.value, (name or "value", True))

    def _augmented(self, node: ast.AugAssign) -> None:
        self.target(node.target)
        name = target_name(node.target)
        if is_special(name):
            self.with_plain_texts([node.value], (name or "value", False))
        else:
            self.expression(node.value, (name or "value", False))
            self.operations.augmented(node, self.scope, self.block, self.parameters)

    def _expression_statement(self, node: ast.Expr) -> None:
        self.expression(node.value, None)

    def _return(self, node: ast.Return) -> None:
        if node.value is None:
            return
        if self.plain_return:
            self.expression(node.value, None)
            node.value = self.untracked(node.value)
        else:
            self.expression(node.value, (self.function, False))

    def _if(self, node: ast.If) -> None:
        while True:
            self.expression(node.test, None)
            self.statements(node.body)
            if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
                node = node.orelse[0]  # elif: chains of them are long, recursion is not deep
            else:
                self.statements(node.orelse)
                return

    def _while(self, node: ast.While) -> None:
        self.expression(node.test, None)
        self._loop(node.body)
        self.statements(node.orelse)

    def _for(self, node: ast.For | ast.AsyncFor) -> None:
        self.target(node.target)
        self.expression(node.iter, (target_name(node.target) or "value", True))
        self._loop(node.body)
        self.statements(node.orelse)

    def _with(self, node: ast.With | ast.AsyncWith) -> None:
        for item in node.items:
            self.expression(item.context_expr, (target_name(item.optional_vars) or "with", False))
            if item.optional_vars is not None:
                self.target(item.optional_vars)
        self.statements(node.body)

    def _try(self, node: Any) -> None:
        self.statements(node.body)
        for handler in node.handlers:
            self.expression(handler.type, None)
            self.statements(handler.body)
        self.statements(node.orelse)
        self.statements(node.finalbody)

    def _match(self, node: ast.Match) -> None:
        self.expression(node.subject, None)
        for case in node.cases:  # patterns are compared: they stay
            self.expression(case.guard, None)
            self.statements(case.body)

    def _raise(self, node: ast.Raise) -> None:
        self.with_plain_texts((node.exc, node.cause))
        error = node.exc
        if isinstance(error, ast.Call) and getattr(error.func, "id", "") in SYNTAX_ERRORS:
            self._plain_arguments(error)

    def _plain_arguments(self, error: ast.Call) -> None:
        for index, argument in enumerate(error.args):
            if isinstance(argument, ast.Tuple):
                argument.elts = [self.untracked(element) for element in argument.elts]
            else:
                error.args[index] = self.untracked(argument)

    def _assert(self, node: ast.Assert) -> None:
        self.expression(node.test, None)
        self.with_plain_texts([node.msg])

    def _delete(self, node: ast.Delete) -> None:
        self.expressions(node.targets, None)

    def _import(self, node: ast.Import) -> None:
        for alias in node.names:
            package = alias.name.partition(".")[0]
            if alias.name in MATH_MODULES and alias.asname:
                self.math_modules.add(alias.asname)
            elif package in ARRAY_MODULES:
                self.array_modules.add(alias.asname or package)

    def _import_from(self, node: ast.ImportFrom) -> None:
        if node.module in MATH_MODULES and not node.level:
            for alias in node.names:
                if alias.name == "*":
                    self.called_names.update((name, name) for name in MATH_CALLS)
                elif alias.name in MATH_CALLS:
                    self.called_names[alias.asname or alias.name] = alias.name
        elif node.module and not node.level:
            package = node.module.partition(".")[0]
            for alias in node.names:
                bound = alias.asname or alias.name
                if package in ARRAY_MODULES:
                    self.array_modules.add(bound)  # numpy.linalg, perhaps
                    if alias.name in ARRAY_CALLS:
                        self.array_names[bound] = alias.name
                elif package in FILE_MODULES and alias.name in FILE_CALLS:
                    self.file_names[bound] = alias.name

    STATEMENTS = {
        ast.FunctionDef: _function,
        ast.AsyncFunctionDef: _function,
        ast.ClassDef: _class,
        ast.Return: _return,
        ast.Delete: _delete,
        ast.Assign: _assign,
        ast.AugAssign: _augmented,
        ast.AnnAssign: _annotated,
        ast.For: _for,
        ast.AsyncFor: _for,
        ast.While: _while,
        ast.If: _if,
        ast.With: _with,
        ast.AsyncWith: _with,
        ast.Match: _match,
        ast.Raise: _raise,
        ast.Try: _try,
        ast.TryStar: _try,
        ast.Assert: _assert,
        ast.Import: _import,
        ast.ImportFrom: _import_from,
        ast.Expr: _expression_statement,
    }
