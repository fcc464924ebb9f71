"""The rewriter's walk over expressions: which literals are tracked, and by which name."""

from __future__ import annotations

import ast
import builtins
from typing import Any

from .cache import INTERPOLATIONS
from .call_sites import METHOD_CALLS, root_name
from .executed import PLAIN_TREE
from .foreign_calls import KEEPING
from .interpolations import can_be_noted, interpolated
from .naming import Scope
from .plain import (
    ALL,
    LARGE,
    PLAIN_KEYWORDS,
    PLAIN_TEXTS,
    can_be_tracked,
    is_sequence,
    last_name,
    plain_from,
    plain_texts,
    target_name,
)
from .walk import LOOSE, TEMPLATE, Binding, Parts, Walk, loosen


class ExpressionWalk(Walk):
    """Visits of expressions. Those not listed at the end, also later Pythons', stay plain."""

    def _constant(self, node: ast.Constant, binding: Binding) -> None:
        if binding is not None and (can_be_tracked(node.value) or id(node) in self.truths):
            self.literal(node, node.value, binding)

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
                    self.literal(node, value, binding)
                return
        self.expression(operand, loosen(binding))

    def _binary(self, node: ast.BinOp, binding: Binding) -> None:
        while True:  # long sums lean to the left: no recursion there
            left, right = node.left, node.right
            loose = loosen(binding)
            if isinstance(node.op, ast.Mult) and (is_sequence(left) or is_sequence(right)):
                # [0.0] * 36: the elements are literals, the count is plumbing
                # (and a text that is repeated is a line)
                self.expression(left, binding if _is_display(left) else None)
                self.expression(right, binding if _is_display(right) else None)
                return
            if _is_complex(left) or _is_complex(right):
                loose = None
            self.expression(right, loose)
            if loose is not None:
                self.operations.binary(node, self.scope, self.block)
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
                plain = self.untracked(operands[index])
                if index:
                    node.comparators[index - 1] = plain
                else:
                    node.left = plain

    def _call(self, node: ast.Call, binding: Binding) -> None:
        func = node.func
        kind = func.__class__
        if kind is ast.Attribute:
            self._callee(func)  # type: ignore[arg-type]
            if func.attr in METHOD_CALLS:  # type: ignore[attr-defined]
                self.calls.append((node, self.block))
        elif kind is ast.Name:
            self.calls.append((node, self.block))
        elif kind is not ast.Constant:
            self.expression(func, LOOSE)
        name = last_name(func)
        module = root_name(func.value) if isinstance(func, ast.Attribute) else None
        texts = ALL if module in self.array_modules else plain_texts(name, module)
        outer = self.plain_texts
        if node.args:
            argument: Binding = (name or "call", False)
            plain = plain_from(name)
            for index, arg in enumerate(node.args):
                self.plain_texts = outer or index < texts
                self._note_text(node, arg)
                self.expression(arg, argument if index < plain else None)
            if kind is ast.Name and name == "compile" and not isinstance(node.args[0], ast.Starred):
                node.args[0] = self.untracked(node.args[0], by=PLAIN_TREE)
        for keyword in node.keywords:
            self.plain_texts = outer or texts == ALL or keyword.arg in PLAIN_KEYWORDS
            self._note_text(node, keyword.value)
            self.expression(keyword.value, (keyword.arg, True) if keyword.arg else LOOSE)
        self.plain_texts = outer

    def _note_text(self, call: ast.Call, argument: ast.expr) -> None:
        """Notes a call that may hand a tracked text to a module that wants a plain one."""
        if self.plain_texts or call in self.with_texts or not self.is_text(argument):
            return
        func = call.func
        if isinstance(func, ast.Attribute):
            if func.attr in KEEPING or func.attr in PLAIN_TEXTS:
                return
            if func.attr not in METHOD_CALLS:
                self.calls.append((call, self.block))
        elif not isinstance(func, ast.Name) or func.id in _BUILTINS:
            return
        self.with_texts.add(call)

    def _callee(self, func: ast.Attribute) -> None:
        template = func.value
        if isinstance(template, ast.Constant):
            if func.attr in _TEMPLATES and type(template.value) is str:
                self.expression(template, (func.attr, False))
        else:
            self._attribute(func, (func.attr, False))

    def _attribute(self, node: ast.Attribute, binding: Binding) -> None:
        if node.value.__class__ is not ast.Constant:
            self.expression(node.value, loosen(binding))

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
            self.target(generator.target)
            self.repeated = outer if index == 0 else True
            bound = (target_name(generator.target) or "value", True) if binding else None
            self.expression(generator.iter, bound)
            self.repeated = True
            self.expressions(generator.ifs, None)
        self.repeated = outer

    def _lambda(self, node: ast.Lambda, binding: Binding) -> None:
        outer = self.scope, self.block, self.repeated, self.function, self.displays
        self.scope = Scope("lambda", self.scope)
        self.defaults(node.args)
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
        loose = loosen(binding)
        for part in node.values:
            if isinstance(part, ast.FormattedValue):
                self.expression(part.value, loose)
                self.expression(part.format_spec, None)
        if loose is None or self.plain_texts or self.remarks.is_off(node):
            return
        if not self.can_note(node):
            return
        name = self.table + INTERPOLATIONS
        parts, literals = self.note(node, name, len(self.interpolations))
        self.interpolations.append(parts)
        if self.block is not None:
            self.block.names.add(name)
        self.expressions(literals, loose)

    def _template(self, node: Any, binding: Binding) -> None:
        loose = loosen(binding)
        for part in node.values:
            if part.__class__ is not ast.Constant:
                self.expression(part.value, loose)
                self.expression(part.format_spec, None)

    def can_note(self, node: ast.JoinedStr) -> bool:
        """Whether an f-string is to know its pieces."""
        return can_be_noted(node)

    def note(self, node: Any, name: str, index: int) -> tuple[Parts, list[ast.Constant]]:
        """Makes an f-string note its pieces; see `interpolations.interpolated`."""
        return interpolated(node, name, index)

    EXPRESSIONS = {
        ast.Constant: _constant,
        ast.UnaryOp: _unary,
        ast.BinOp: _binary,
        ast.BoolOp: _bool_op,
        ast.Compare: _compare,
        ast.Call: _call,
        ast.Attribute: _attribute,
        ast.Subscript: _subscript,
        ast.Slice: _slice,
        ast.IfExp: _conditional,
        ast.List: _display,
        ast.Tuple: _display,
        ast.Dict: _display,
        ast.Set: _set,
        ast.ListComp: _comprehension,
        ast.SetComp: _comprehension,
        ast.DictComp: _comprehension,
        ast.GeneratorExp: _comprehension,
        ast.Lambda: _lambda,
        ast.Starred: _pass_on,
        ast.Await: _pass_on,
        ast.Yield: _yield,
        ast.YieldFrom: _yield,
        ast.NamedExpr: _named,
        ast.JoinedStr: _joined,
        **({TEMPLATE: _template} if TEMPLATE else {}),
    }


_TEMPLATES = frozenset({"format", "join"})
_BUILTINS = frozenset(dir(builtins))


def _is_display(node: ast.expr) -> bool:
    return is_sequence(node) and not isinstance(node, ast.Constant)


def _is_complex(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, complex)


def _is_range(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range"
    )
