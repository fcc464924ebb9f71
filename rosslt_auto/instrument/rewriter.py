"""From a module's syntax tree to one that produces tracked values.

A literal becomes a look-up in the module's table of literals, ``0.5`` -> ``@rosslt.node.1f0c[3]``,
and a call that would lose provenance a call of ours, ``sin(x)`` -> ``@rosslt.call1(sin, x)``. The
names contain a character that no program can write, and are found through `builtins`. Nodes are
replaced in place by nodes at exactly the same position, so that tracebacks, coverage and debuggers
see what they would see without us, and nothing else of the tree changes.

The walk passes a *binding* down to every expression: the name that its value is bound to and
whether it is bound directly - or None where literals stay as they are. One walk serves a module as
well as the tree of a single class or function.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from ..provenance.locations import LiteralInfo
from .call_sites import BUILTIN_CALLS, MATH_CALLS, call_helper
from .calls import UNTRACKED
from .naming import Scope, parameter_names
from .plain import (
    LARGE,
    RETURNS_PLAIN,
    RUN_ONCE,
    can_be_tracked,
    can_evaluate_to_tracked,
    is_enum,
    is_sequence,
    is_special,
    last_name,
    plain_from,
    target_name,
)

Binding = tuple[str, bool] | None

_LOAD = ast.Load()
_LOOSE = ("value", False)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


class Rewritten(NamedTuple):
    """What the rewriter made of a tree: the values of the literals, and what is known of them."""

    values: tuple[Any, ...]
    infos: list[LiteralInfo]


class _Found(NamedTuple):
    line: int
    column: int
    node: ast.expr
    value: Any
    scope: Scope
    hint: str
    named: bool
    repeated: bool | None


class _Block:
    """A module's or a class's own code, where names are looked up in a namespace first."""

    def __init__(self, node: Any) -> None:
        self.node = node
        self.names: set[str] = set()

    def declare(self) -> None:
        """Makes our names global: not even a namespace made by a metaclass is asked for them."""
        if not self.names:
            return
        body = self.node.body
        at = 1 if ast.get_docstring(self.node, clean=False) is not None else 0
        while at < len(body) and _is_future(body[at]):
            at += 1
        first = body[min(at, len(body) - 1)]
        body.insert(at, ast.copy_location(ast.Global(sorted(self.names)), first))


def rewrite(tree: ast.Module, scope: Scope, table: str, reserved: Iterable[str] = ()) -> Rewritten:
    """Rewrites `tree` in place.

    scope     the module's, see `naming.module_scope`
    table     the name under which the code finds its table of literals
    reserved  names that its literals must not use, see `naming.submodules`
    """
    walk = Rewriter(scope, table)
    walk.module(tree)
    return walk.finish(reserved)


class Rewriter:
    """One walk over a tree. Literals are collected first: names can only be given at the end."""

    def __init__(self, scope: Scope, table: str) -> None:
        self.module_scope = self.scope = scope
        self.table = table
        self.found: list[_Found] = []
        self.calls: list[tuple[ast.Call, _Block | None]] = []
        self.blocks: list[_Block] = []
        self.block: _Block | None = None
        self.repeated: bool | None = False
        self.function = "module"
        self.plain_return = False
        self.enums: set[str] = set()
        self.displays = 0
        self.math_modules = {"math"}
        self.called_names = {name: name for name in BUILTIN_CALLS}

    # ------------------------------------------------------------ results

    def finish(self, reserved: Iterable[str] = ()) -> Rewritten:
        """Puts the look-ups and calls in place, in source order."""
        self.found.sort(key=lambda found: (found.line, found.column))
        names = parameter_names(
            self.module_scope, [(f.scope, f.hint) for f in self.found], frozenset(reserved)
        )
        infos = []
        for index, (found, name) in enumerate(zip(self.found, names, strict=True)):
            node = found.node
            infos.append(
                LiteralInfo(name, name.rpartition(".")[2], found.named, node.lineno,
                            node.col_offset, node.end_lineno or node.lineno,
                            node.end_col_offset or node.col_offset, found.repeated)
            )  # fmt: skip
            _become_lookup(node, self.table, index)
        for call, block in self.calls:
            self._rewrite_call(call, block)
        for block in self.blocks:
            block.declare()
        return Rewritten(tuple(found.value for found in self.found), infos)

    def _rewrite_call(self, node: ast.Call, block: _Block | None) -> None:
        func = node.func
        if isinstance(func, ast.Attribute):
            if not (isinstance(func.value, ast.Name) and func.value.id in self.math_modules):
                return
            name: str | None = func.attr
        else:
            name = self.called_names.get(func.id)  # type: ignore[attr-defined]
        helper = call_helper(node, name) if name is not None else None
        if helper is None:
            return
        node.args.insert(0, node.func)
        node.func = ast.copy_location(ast.Name(helper, _LOAD), node.func)
        if block is not None:
            block.names.add(helper)

    def _untracked(self, value: ast.expr) -> ast.expr:
        """A call that makes the value of an expression plain."""
        if not can_evaluate_to_tracked(value):
            return value
        if self.block is not None:
            self.block.names.add(UNTRACKED)
        func = ast.copy_location(ast.Name(UNTRACKED, _LOAD), value)
        return ast.copy_location(ast.Call(func, [value], []), value)

    # ------------------------------------------------------------ blocks and statements

    def module(self, tree: ast.Module) -> None:
        """Walks over a whole module."""
        self._enter_block(tree, tree.body)

    def _enter_block(self, node: Any, body: list[ast.stmt]) -> None:
        outer, self.block = self.block, _Block(node)
        self.blocks.append(self.block)
        self.statements(body)
        self.block = outer

    def statements(self, body: list[ast.stmt]) -> None:
        """Walks over the statements of a body."""
        for statement in body:
            visit = _STATEMENTS.get(statement.__class__)
            if visit is not None:
                visit(self, statement)

    def expression(self, node: ast.expr | None, binding: Binding) -> None:
        """Walks over an expression whose value gets bound as `binding` says."""
        if node is not None:
            visit = _EXPRESSIONS.get(node.__class__)
            if visit is not None:
                visit(self, node, binding)

    def expressions(self, nodes: Iterable[ast.expr | None], binding: Binding) -> None:
        for node in nodes:
            self.expression(node, binding)

    def _loop(self, body: list[ast.stmt]) -> None:
        outer, self.repeated = self.repeated, True
        self.statements(body)
        self.repeated = outer

    def _target(self, node: ast.expr) -> None:
        if node.__class__ is not ast.Name:
            self.expression(node, None)

    def _function(self, node: Any) -> None:
        outer_scope, outer_state = self.scope, (
            self.block, self.repeated, self.function, self.plain_return, self.displays,
        )  # fmt: skip
        self.expressions(node.decorator_list, None)
        self.scope = Scope(node.name, outer_scope)
        self._defaults(node.args)
        self.block, self.function = None, node.name
        self.repeated = False if node.name in RUN_ONCE else None
        self.plain_return = node.name in RETURNS_PLAIN
        self.displays = 0
        self.statements(node.body)
        self.scope = outer_scope
        self.block, self.repeated, self.function, self.plain_return, self.displays = outer_state

    def _defaults(self, args: ast.arguments) -> None:
        positional = args.posonlyargs + args.args
        if args.defaults:
            for arg, default in zip(positional[-len(args.defaults) :], args.defaults, strict=True):
                self.expression(default, (arg.arg, True))
        for arg, keyword_default in zip(args.kwonlyargs, args.kw_defaults, strict=True):
            self.expression(keyword_default, (arg.arg, True))

    def _class(self, node: ast.ClassDef) -> None:
        self.expressions(node.decorator_list, None)
        self.expressions(node.bases, None)
        for keyword in node.keywords:
            self.expression(keyword.value, (keyword.arg or "value", True))
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
                node.value.body = self._untracked(node.value.body)
            return
        for target in node.targets:
            self._target(target)
        first = node.targets[0]
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
            self._target(node.target)
            self.expression(node.value, (name or "value", True))

    def _augmented(self, node: ast.AugAssign) -> None:
        self._target(node.target)
        self.expression(node.value, (target_name(node.target) or "value", False))

    def _expression_statement(self, node: ast.Expr) -> None:
        self.expression(node.value, None)

    def _return(self, node: ast.Return) -> None:
        if node.value is None:
            return
        if self.plain_return:
            self.expression(node.value, None)
            node.value = self._untracked(node.value)
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
        self._target(node.target)
        self.expression(node.iter, (target_name(node.target) or "value", True))
        self._loop(node.body)
        self.statements(node.orelse)

    def _with(self, node: ast.With | ast.AsyncWith) -> None:
        for item in node.items:
            self.expression(item.context_expr, (target_name(item.optional_vars) or "with", False))
            if item.optional_vars is not None:
                self._target(item.optional_vars)
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
        self.expressions((node.exc, node.cause), None)

    def _assert(self, node: ast.Assert) -> None:
        self.expressions((node.test, node.msg), None)

    def _delete(self, node: ast.Delete) -> None:
        self.expressions(node.targets, None)

    def _import(self, node: ast.Import) -> None:
        for alias in node.names:
            if alias.name == "math" and alias.asname:
                self.math_modules.add(alias.asname)

    def _import_from(self, node: ast.ImportFrom) -> None:
        if node.module == "math" and not node.level:
            for alias in node.names:
                if alias.name == "*":
                    self.called_names.update((name, name) for name in MATH_CALLS)
                elif alias.name in MATH_CALLS:
                    self.called_names[alias.asname or alias.name] = alias.name

    # ------------------------------------------------------------ expressions

    def _literal(self, node: ast.expr, value: Any, binding: tuple[str, bool]) -> None:
        self.found.append(
            _Found(node.lineno, node.col_offset, node, value, self.scope, *binding, self.repeated)
        )
        if self.block is not None:
            self.block.names.add(self.table)

    def _constant(self, node: ast.Constant, binding: Binding) -> None:
        if binding is not None and can_be_tracked(node.value):
            self._literal(node, node.value, binding)

    def _unary(self, node: ast.UnaryOp, binding: Binding) -> None:
        operand = node.operand
        if isinstance(node.op, ast.Not):
            self.expression(operand, None)
            return
        if isinstance(node.op, (ast.USub, ast.UAdd)) and isinstance(operand, ast.Constant):
            # The sign belongs to the literal: one location, at the sign.
            value: Any = operand.value
            if type(value) in (int, float):
                value = -value if isinstance(node.op, ast.USub) else value
                if binding is not None and can_be_tracked(value):
                    self._literal(node, value, binding)
                return
        self.expression(operand, _loosen(binding))

    def _binary(self, node: ast.BinOp, binding: Binding) -> None:
        while True:  # long sums lean to the left: no recursion there
            left, right = node.left, node.right
            loose = _loosen(binding)
            if isinstance(node.op, ast.Mult) and (is_sequence(left) or is_sequence(right)):
                # [0.0] * 36: the elements are literals, the count is plumbing
                self.expression(left, binding if is_sequence(left) else None)
                self.expression(right, binding if is_sequence(right) else None)
                return
            if _is_complex(left) or _is_complex(right):
                loose = None
            self.expression(right, loose)
            binding = loose
            if left.__class__ is not ast.BinOp:
                self.expression(left, loose)
                return
            node = left

    def _bool_op(self, node: ast.BoolOp, binding: Binding) -> None:
        self.expressions(node.values, binding)

    def _compare(self, node: ast.Compare, binding: Binding) -> None:
        operands = [node.left, *node.comparators]
        self.expressions(operands, None)
        for index, op in enumerate(node.ops):
            # A subclass of int has to search through a range, one number after another.
            if isinstance(op, (ast.In, ast.NotIn)) and _is_range(operands[index + 1]):
                plain = self._untracked(operands[index])
                if index:
                    node.comparators[index - 1] = plain
                else:
                    node.left = plain

    def _call(self, node: ast.Call, binding: Binding) -> None:
        func = node.func
        kind = func.__class__
        if kind is ast.Attribute:
            self.expression(func.value, (func.attr, False))  # type: ignore[attr-defined]
            if func.attr in MATH_CALLS:  # type: ignore[attr-defined]
                self.calls.append((node, self.block))
        elif kind is ast.Name:
            self.calls.append((node, self.block))
        elif kind is not ast.Constant:
            self.expression(func, _LOOSE)
        name = last_name(func)
        if node.args:
            argument: Binding = (name or "call", False)
            plain = plain_from(name)
            for index, arg in enumerate(node.args):
                self.expression(arg, argument if index < plain else None)
        for keyword in node.keywords:
            self.expression(keyword.value, (keyword.arg, True) if keyword.arg else _LOOSE)

    def _attribute(self, node: ast.Attribute, binding: Binding) -> None:
        if node.value.__class__ is not ast.Constant:
            self.expression(node.value, _loosen(binding))

    def _subscript(self, node: ast.Subscript, binding: Binding) -> None:
        if node.value.__class__ is not ast.Constant:
            self.expression(node.value, binding)
        self.expression(node.slice, None)

    def _slice(self, node: ast.Slice, binding: Binding) -> None:
        self.expressions((node.lower, node.upper, node.step), None)

    def _conditional(self, node: ast.IfExp, binding: Binding) -> None:
        self.expression(node.test, None)
        self.expressions((node.body, node.orelse), binding)

    def _display(self, node: Any, binding: Binding) -> None:
        before = len(self.found)
        self.displays += 1
        if node.__class__ is ast.Dict:
            self._dict(node, binding)
        else:
            self.expressions(node.elts, binding)
        self.displays -= 1
        if not self.displays and len(self.found) - before > LARGE:
            del self.found[before:]

    def _dict(self, node: ast.Dict, binding: Binding) -> None:
        self.expressions(node.keys, None)
        for key, value in zip(node.keys, node.values, strict=True):
            if isinstance(key, ast.Constant) and isinstance(key.value, str) and key.value:
                self.expression(value, (key.value, True) if binding is not None else None)
            else:
                self.expression(value, binding)

    def _set(self, node: ast.Set, binding: Binding) -> None:
        self.expressions(node.elts, None)

    def _comprehension(self, node: Any, binding: Binding) -> None:
        outer, self.repeated = self.repeated, True
        if isinstance(node, ast.DictComp):
            self.expression(node.key, None)
            self.expression(node.value, binding)
        else:
            self.expression(node.elt, binding if not isinstance(node, ast.SetComp) else None)
        for index, generator in enumerate(node.generators):
            self._target(generator.target)
            self.repeated = outer if index == 0 else True
            bound = (target_name(generator.target) or "value", True) if binding else None
            self.expression(generator.iter, bound)
            self.repeated = True
            self.expressions(generator.ifs, None)
        self.repeated = outer

    def _lambda(self, node: ast.Lambda, binding: Binding) -> None:
        outer = self.scope, self.block, self.repeated, self.function, self.displays
        self.scope = Scope("lambda", self.scope)
        self._defaults(node.args)
        self.block, self.repeated, self.function, self.displays = None, None, "lambda", 0
        self.expression(node.body, (binding[0] if binding else "lambda", False))
        self.scope, self.block, self.repeated, self.function, self.displays = outer

    def _pass_on(self, node: Any, binding: Binding) -> None:
        self.expression(node.value, binding)

    def _yield(self, node: ast.Yield | ast.YieldFrom, binding: Binding) -> None:
        self.expression(node.value, (self.function, False))

    def _named(self, node: ast.NamedExpr, binding: Binding) -> None:
        self.expression(node.value, (node.target.id, True))

    def _joined(self, node: ast.JoinedStr, binding: Binding) -> None:
        for part in node.values:
            if isinstance(part, ast.FormattedValue):
                self.expression(part.value, _loosen(binding))
                self.expression(part.format_spec, None)


def _loosen(binding: Binding) -> Binding:
    """The binding of an operand of what is bound."""
    return (binding[0], False) if binding is not None else None


def _is_complex(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, complex)


def _is_range(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range"
    )


def _is_future(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.ImportFrom) and statement.module == "__future__"


def _become_lookup(node: Any, table: str, index: int) -> None:
    """Turns a literal in place into ``table[index]``: nobody needs to know its parent."""
    position = {
        "lineno": node.lineno,
        "col_offset": node.col_offset,
        "end_lineno": node.end_lineno,
        "end_col_offset": node.end_col_offset,
    }
    node.__class__ = ast.Subscript
    node.value = ast.Name(table, _LOAD, **position)
    node.slice = ast.Constant(index, **position)
    node.ctx = _LOAD


_STATEMENTS: dict[type, Callable[[Rewriter, Any], None]] = {
    ast.FunctionDef: Rewriter._function,
    ast.AsyncFunctionDef: Rewriter._function,
    ast.ClassDef: Rewriter._class,
    ast.Return: Rewriter._return,
    ast.Delete: Rewriter._delete,
    ast.Assign: Rewriter._assign,
    ast.AugAssign: Rewriter._augmented,
    ast.AnnAssign: Rewriter._annotated,
    ast.For: Rewriter._for,
    ast.AsyncFor: Rewriter._for,
    ast.While: Rewriter._while,
    ast.If: Rewriter._if,
    ast.With: Rewriter._with,
    ast.AsyncWith: Rewriter._with,
    ast.Match: Rewriter._match,
    ast.Raise: Rewriter._raise,
    ast.Try: Rewriter._try,
    ast.TryStar: Rewriter._try,
    ast.Assert: Rewriter._assert,
    ast.Import: Rewriter._import,
    ast.ImportFrom: Rewriter._import_from,
    ast.Expr: Rewriter._expression_statement,
}
"""Statements that can contain literals; all others, also those of later Pythons, stay plain."""

_EXPRESSIONS: dict[type, Callable[[Rewriter, Any, Binding], None]] = {
    ast.Constant: Rewriter._constant,
    ast.UnaryOp: Rewriter._unary,
    ast.BinOp: Rewriter._binary,
    ast.BoolOp: Rewriter._bool_op,
    ast.Compare: Rewriter._compare,
    ast.Call: Rewriter._call,
    ast.Attribute: Rewriter._attribute,
    ast.Subscript: Rewriter._subscript,
    ast.Slice: Rewriter._slice,
    ast.IfExp: Rewriter._conditional,
    ast.List: Rewriter._display,
    ast.Tuple: Rewriter._display,
    ast.Dict: Rewriter._display,
    ast.Set: Rewriter._set,
    ast.ListComp: Rewriter._comprehension,
    ast.SetComp: Rewriter._comprehension,
    ast.DictComp: Rewriter._comprehension,
    ast.GeneratorExp: Rewriter._comprehension,
    ast.Lambda: Rewriter._lambda,
    ast.Starred: Rewriter._pass_on,
    ast.Await: Rewriter._pass_on,
    ast.Yield: Rewriter._yield,
    ast.YieldFrom: Rewriter._yield,
    ast.NamedExpr: Rewriter._named,
    ast.JoinedStr: Rewriter._joined,
}
