"""What is read out of a code object: nodes of `ast`, as far as its rules need them, and what has no
node there.

Every node carries two attributes beside its position:

made_by   the instruction after which its value lies on the stack
start     the first instruction of its expression, None where that cannot be seen
"""

from __future__ import annotations

import ast
from types import CodeType
from typing import Any

from bytecode import Instr

from .walk import LOAD

COMPREHENSIONS = frozenset({"<listcomp>", "<setcomp>", "<dictcomp>", "<genexpr>"})
GENERIC = "<generic parameters of "


class Opaque(ast.expr):
    """A value of which nothing is known but that it is there."""

    _fields = ()
    start = made_by = None


class Null(Opaque):
    """The empty place beside a function that is going to be called."""


class Either(ast.expr):
    """A value that comes from one of several places: conditional expressions, ``and``, ``or``."""

    _fields = ("values",)
    values: list[ast.expr]
    start = made_by = None
    lineno = end_lineno = 0
    col_offset = end_col_offset = 0

    def __init__(self, values: list[ast.expr], label: int) -> None:
        super().__init__()
        self.values = values
        self.label = label


class Code(Opaque):
    """A constant that is the code of a function, a class or a comprehension."""

    code: CodeType


class Function(Opaque):
    """A function that has just been made, or the value of a lambda expression.

    maker             the `code_reading.Reader` of the code that made it
    defaults          nodes of its positional defaults
    keyword_defaults  nodes by parameter name
    decorators        what it was given to, in the order of the calls
    """

    maker: Any
    code: CodeType
    code_made_by: Instr
    defaults: list[ast.expr]
    keyword_defaults: dict[str, ast.expr]
    decorators: list[ast.expr]

    def body(self) -> list[ast.stmt]:
        """The statements of its code."""
        return self.maker.child(self).body()

    @property
    def is_definition(self) -> bool:
        """Whether a ``def`` statement made it."""
        return not self.code.co_name.startswith("<")

    @property
    def is_annotation(self) -> bool:
        """Whether it is what Python makes of annotations (PEP 649)."""
        return self.code.co_name == "__annotate__" and self.code.co_posonlyargcount == 1

    def arguments(self) -> ast.arguments:
        """Its parameters, as `walk.Walk.defaults` wants them."""
        code = self.code
        names = [ast.arg(as_written(name, code)) for name in code.co_varnames]
        positional, keyword = names[: code.co_argcount], names[code.co_argcount :]
        keyword = keyword[: code.co_kwonlyargcount]
        defaults = self.defaults if len(self.defaults) <= len(positional) else []
        return ast.arguments(
            posonlyargs=[],
            args=positional,
            defaults=defaults,
            kwonlyargs=keyword,
            kw_defaults=[self.keyword_defaults.get(one.arg) for one in keyword],
        )


class Comprehension(ast.expr):
    """A comprehension that is a function of its own, and what it goes through."""

    _fields = ("iterable",)
    function: Function
    iterable: ast.expr


class Class(Opaque):
    """A class that has just been made: its body's function, bases and keywords."""

    function: Function
    bases: list[ast.expr]
    keywords: list[ast.keyword]
    decorators: list[ast.expr]


class ClassBuilder(Opaque):
    """What Python calls to make a class."""


class AssertionError_(Opaque):
    """What a failing ``assert`` raises, and its message once it has one."""

    message: ast.expr | None = None


class SpecialMethod(Opaque):
    """A method that ``with`` calls (since 3.14), and the manager if it enters that."""

    manager: ast.expr | None


class Module(Opaque):
    """What an import has given."""

    module: str
    level: int
    name: str | None = None
    star: bool = False


class Part(Opaque):
    """One of the values that an assignment, a loop or a ``with`` binds, not yet bound."""

    targets: Any
    index: int


def put(
    node: Any, made_by: Instr | None, start: Instr | None = None, *, unknown: bool = False
) -> Any:
    """`node` at the position of `made_by`, None for what comes from several places.

    unknown  nobody can say where it starts
    """
    where = made_by.location if made_by is not None else None
    node.lineno = where.lineno or 0 if where else 0
    node.end_lineno = where.end_lineno or node.lineno if where else 0
    node.col_offset = where.col_offset if where else None
    node.end_col_offset = where.end_col_offset if where else None
    node.made_by = made_by
    node.start = None if unknown else start or made_by
    return node


def as_written(name: str, code: CodeType) -> str:
    """A name in code as its source has it: in a class ``A``, ``__x`` for the private ``_A__x``."""
    if name.startswith("_") and "__" in name and not name.endswith("__"):
        for outer in code.co_qualname.split("."):
            private = f"_{outer.lstrip('_')}__"
            if name.startswith(private):
                return name[len(private) - 2 :]
    return name


def constant(value: Any, made_by: Instr, reader: Any, element: tuple[int, ...] = ()) -> ast.expr:
    """The node of a constant; of a tuple the node of each of its elements.

    element  where in the constant it is, if it is a part of it
    """
    node: Any
    if isinstance(value, CodeType):
        node = Code()
        node.code = value
    elif type(value) is tuple:
        parts = [constant(one, made_by, reader, (*element, i)) for i, one in enumerate(value)]
        node = ast.Tuple(parts, LOAD)
    else:
        node = ast.Constant(value)
    node.reader, node.element = reader, element
    put(node, made_by)
    if not element and type(value) is tuple:
        _place_elements(node, value)
    return node


def _place_elements(node: Any, value: tuple[Any, ...]) -> None:
    """Finds the columns of the elements of a constant tuple, of which only the whole has a place.

    They are known if the whole is as wide as Python would write it, with brackets or without.
    """
    if node.col_offset is None or node.lineno != node.end_lineno:
        return
    bare = sum(_width(one) for one in value) + 2 * (len(value) - 1) + (len(value) == 1)
    brackets, odd = divmod(node.end_col_offset - node.col_offset - bare, 2)
    if brackets not in (0, 1) or odd:
        return
    column = node.col_offset + brackets
    for part, one in zip(node.elts, value, strict=True):
        part.col_offset, part.end_col_offset = column, column + _width(one)
        if type(one) is tuple:
            _place_elements(part, one)
        column = part.end_col_offset + 2


def _width(value: Any) -> int:
    return len(repr(value).encode())


def definition(target: Any, value: Any) -> ast.stmt | None:
    """The statement that binds a function, a class or a module; None for any other value."""
    if isinstance(value, Function) and value.is_annotation:
        return ast.Pass()
    if isinstance(value, Function) and value.is_definition:
        return ast.FunctionDef(
            value.code.co_name, value.arguments(), value.body(), value.decorators
        )
    if isinstance(value, Class):
        name = value.function.code.co_name
        return ast.ClassDef(
            name, value.bases, value.keywords, value.function.body(), value.decorators
        )
    if isinstance(value, Module) and isinstance(target, ast.Name):
        if value.name is None:
            return ast.Import([ast.alias(value.module, target.id)])
        return ast.ImportFrom(value.module, [ast.alias(value.name, target.id)], value.level)
    return None
