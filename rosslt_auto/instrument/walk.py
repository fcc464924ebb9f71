"""What all parts of the rewriter's walk over a tree share.

The walk passes a *binding* down to every expression: the name that its value is bound to and
whether it is bound directly - or None where literals stay as they are.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from typing import Any, ClassVar, NamedTuple

from .call_sites import BUILTIN_CALLS, MATH_CALLS, MATH_MODULES
from .calls import UNTRACKED
from .naming import Scope
from .operations import Operations
from .plain import can_be_tracked, can_evaluate_to_tracked
from .remarks import Remarks

Binding = tuple[str, bool] | None
Parts = tuple[tuple[str | None, str | None, str | None], ...]
"""What an f-string is made of, see `strings.Interpolation`."""

LOAD = ast.Load()
LOOSE = ("value", False)
TEMPLATE: Any = getattr(ast, "TemplateStr", None)
"""The node of t-strings, since 3.14."""


def loosen(binding: Binding) -> Binding:
    """The binding of an operand of what is bound."""
    return (binding[0], False) if binding is not None else None


class Found(NamedTuple):
    line: int
    column: int
    node: ast.expr
    value: Any
    scope: Scope
    hint: str
    named: bool
    repeated: bool | None


class Block:
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


def _is_future(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.ImportFrom) and statement.module == "__future__"


class Walk:
    """State and means of the walk; `StatementWalk` and `ExpressionWalk` know the kinds of nodes."""

    STATEMENTS: ClassVar[dict[type, Callable[[Any, Any], None]]]
    EXPRESSIONS: ClassVar[dict[type, Callable[[Any, Any, Binding], None]]]

    def __init__(self, scope: Scope, table: str, remarks: Remarks | None = None) -> None:
        self.module_scope = self.scope = scope
        self.table = table
        self.remarks = remarks if remarks is not None else Remarks()
        self.found: list[Found] = []
        self.calls: list[tuple[ast.Call, Block | None]] = []
        self.operations = Operations()
        self.parameters: frozenset[str] = frozenset()
        self.blocks: list[Block] = []
        self.block: Block | None = None
        self.repeated: bool | None = False
        self.function = "module"
        self.plain_return = False
        self.enums: set[str] = set()
        self.displays = 0
        self.plain_texts = False
        self.truths: set[int] = set()  # ids of True and False that may get into messages
        self.interpolations: list[Parts] = []
        self.math_modules = set(MATH_MODULES)
        self.called_names = {name: name for name in BUILTIN_CALLS}
        self.array_names: dict[str, str] = {}
        self.file_names: dict[str, str] = {}
        self.array_modules: set[str] = set()
        self.text_names: set[str] = set()  # names and, with a dot before them, attributes of texts
        self.with_texts: set[ast.Call] = set()

    def statements(self, body: list[ast.stmt]) -> None:
        """Walks over the statements of a body."""
        for statement in body:
            visit = self.STATEMENTS.get(statement.__class__)
            if visit is not None:
                visit(self, statement)

    def expression(self, node: ast.expr | None, binding: Binding) -> None:
        """Walks over an expression whose value gets bound as `binding` says."""
        if node is not None:
            visit = self.EXPRESSIONS.get(node.__class__)
            if visit is not None:
                visit(self, node, binding)

    def expressions(self, nodes: Iterable[ast.expr | None], binding: Binding) -> None:
        for node in nodes:
            self.expression(node, binding)

    def target(self, node: ast.expr) -> None:
        if node.__class__ is not ast.Name:
            self.expression(node, None)

    def defaults(self, args: ast.arguments) -> None:
        positional = args.posonlyargs + args.args
        if args.defaults:
            for arg, default in zip(positional[-len(args.defaults) :], args.defaults, strict=True):
                self.expression(default, (arg.arg, True))
                self.alias(arg.arg, default)
        for arg, keyword_default in zip(args.kwonlyargs, args.kw_defaults, strict=True):
            self.expression(keyword_default, (arg.arg, True))

    def alias(self, name: str, value: ast.expr) -> None:
        """Notes ``name = math.sin``: calls of that name may be calls of that function.

        And ``name = "text"``: who is called with that name gets a text.
        """
        if isinstance(value, ast.Attribute) and value.attr in MATH_CALLS:
            self.called_names.setdefault(name, value.attr)
        elif self.is_text(value):
            self.text_names.add(name)

    def is_text(self, node: ast.expr) -> bool:
        """Whether an expression looks like a text that is tracked."""
        if isinstance(node, ast.Constant):
            return type(node.value) is str and can_be_tracked(node.value)
        if isinstance(node, ast.Name):
            return node.id in self.text_names
        if isinstance(node, ast.Attribute):
            return f".{node.attr}" in self.text_names
        if isinstance(node, ast.BinOp):
            return self.is_text(node.left) or self.is_text(node.right)
        return isinstance(node, ast.JoinedStr)

    def literal(self, node: ast.expr, value: Any, binding: tuple[str, bool]) -> None:
        if value.__class__ is str and self.plain_texts:
            return
        self.found.append(
            Found(node.lineno, node.col_offset, node, value, self.scope, *binding, self.repeated)
        )
        if self.block is not None:
            self.block.names.add(self.table)

    def with_plain_texts(self, nodes: Iterable[ast.expr | None], binding: Binding = None) -> None:
        """Walks over expressions whose texts stay as they are."""
        outer, self.plain_texts = self.plain_texts, True
        self.expressions(nodes, binding)
        self.plain_texts = outer

    def untracked(self, value: ast.expr, by: str = UNTRACKED) -> ast.expr:
        """A call, of `by`, that makes the value of an expression plain."""
        if not can_evaluate_to_tracked(value) or self.remarks.is_off(value):
            return value
        if self.block is not None:
            self.block.names.add(by)
        func = ast.copy_location(ast.Name(by, LOAD), value)
        return ast.copy_location(ast.Call(func, [value], []), value)
