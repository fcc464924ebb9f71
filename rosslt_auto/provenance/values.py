"""Tracked values: numbers that remember how they were computed.

A tracked value is a true float or int (Section IV-B's wrapper, without the wrapping) and at the
same time a node of a shared expression graph: it keeps its operator and its operands, which may
be tracked values themselves. The *value* always comes from the plain operation on plain operands;
provenance is recorded beside it.

To programs the classes call themselves ``float`` and ``int``; inside of this project
`is_tracked` and ``type(value) is TrackedFloat`` tell.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import FunctionType
from typing import Any

from .frames import unseen
from .operators import DEFERRED, LITERAL, OPERATORS, SOURCE, Operator

DEPTH_LIMIT = 1024
"""The oldest part of an expression deeper than this is folded, see `folding`."""


def _fold(value: Any) -> None:
    from .folding import shorten  # which needs this module

    shorten(value)


new_float = float.__new__
new_int = int.__new__


class PlainType(type):
    """Lets a tracked class pass for the plain one where types are compared or printed."""

    _plain: type

    def __eq__(cls, other: object) -> bool:
        return other is cls or other is cls._plain

    def __hash__(cls) -> int:
        return hash(cls._plain)

    def __repr__(cls) -> str:
        return repr(cls._plain)

    # The classes have none of their own, see `as_plain`. (That of this class itself is lost.)
    __module__ = property(lambda cls: cls._plain.__module__)

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        """What libraries get by ``type(x)(2)``: a plain value. We ourselves use ``new_float``."""
        return cls._plain(*args, **kwargs)


def _reduce(self: Any, protocol: Any) -> Any:
    """Copies and pickles are those of the plain value."""
    return (type(self)._plain, (untracked(self),))


def _same(self: Any, memo: Any = None) -> Any:
    """Numbers are immutable: a copy is the number itself."""
    return self


def as_plain(name: str) -> Any:
    """An attribute that instances of a class written in Python have, and of C's mostly do not.

    It is what the plain value answers, or its AttributeError.
    """

    @unseen
    def answer(self: Any) -> Any:
        return getattr(self._v, name)

    return property(answer)


class TrackedFloat(float, metaclass=PlainType):
    """A float that is a node of an expression graph; see `expressions` for what to ask it."""

    __slots__ = ("_a", "_b", "_depth", "_op", "_v")
    _plain = float
    __class__ = property(lambda self: float)
    __module__ = as_plain("__module__")
    __hash__ = float.__hash__

    def _set(self, op: Operator, a: Any, b: Any, depth: int) -> None:
        self._a = a
        self._b = b
        self._depth = depth
        self._op = op  # last: whoever sees it, in another thread, finds the rest in place


class TrackedInt(int, metaclass=PlainType):
    """An int that is a node; int subclasses have no slots, so one tuple holds everything."""

    _plain = int
    __class__ = property(lambda self: int)
    __module__ = as_plain("__module__")
    __dict__ = as_plain("__dict__")
    __hash__ = int.__hash__

    _v = property(lambda self: self._n[0])
    _op = property(lambda self: self._n[1])
    _a = property(lambda self: self._n[2])
    _b = property(lambda self: self._n[3])
    _depth = property(lambda self: self._n[4])

    def _set(self, op: Operator, a: Any, b: Any, depth: int) -> None:
        self._n = (int(self), op, a, b, depth)


class TrackedStr(str, metaclass=PlainType):
    """A str that is a node; its operators are in `strings`."""

    __slots__ = ("_a", "_b", "_depth", "_op", "_v")
    _plain = str
    __class__ = property(lambda self: str)
    __module__ = as_plain("__module__")
    __hash__ = str.__hash__

    def _set(self, op: Operator, a: Any, b: Any, depth: int) -> None:
        self._a = a
        self._b = b
        self._depth = depth
        self._op = op  # last: whoever sees it, in another thread, finds the rest in place


def is_tracked(value: Any) -> bool:
    """Whether `value` is a tracked value. (Its class equals the plain one: ask the metaclass.)"""
    return type(type(value)) is PlainType


def untracked(value: Any) -> Any:
    """The plain value of a tracked one, anything else as it is (discards it, Section V-A)."""
    return value._v if type(type(value)) is PlainType else value


def node(value: Any, op: Operator, a: Any, b: Any, depth: int) -> Any:
    """A new node with the plain float, int or str `value`; any other type is returned as it is."""
    kind = type(value)
    made: Any
    if kind is float:
        made = new_float(TrackedFloat, value)
        made._v = value
        made._op = op
        made._a = a
        made._b = b
        made._depth = depth
    elif kind is int:
        made = new_int(TrackedInt, value)
        made._n = (value, op, a, b, depth)
    elif kind is str:
        made = str.__new__(TrackedStr, value)
        made._v = value
        made._set(op, a, b, depth)
    else:
        make = MORE_KINDS.get(id(kind))
        return value if make is None else make(value, op, a, b, depth)
    if depth > DEPTH_LIMIT:
        _fold(made)
    return made


MORE_KINDS: dict[int, Callable[..., Any]] = {}
"""What makes nodes of other types (numpy's scalars), by the id of the type; see `arrays`."""

FOREIGN: list[Callable[..., Any]] = []
"""Operators between our values and arrays: ``is_theirs(other)``, ``operate(op, a, b)``."""


def leaf(source: Any, value: Any) -> Any:
    """A leaf: `value` (float, int or str) as it comes from `source` (a `sources.Source`)."""
    return node(value, SOURCE, source, None, 0)


def literal_leaf(literals: Any, index: int, value: Any) -> Any:
    """A leaf for entry `index` of a table of literals; its location is made when asked for."""
    return node(value, LITERAL, literals, index, 0)


def deferred(value: Any, expand: Callable[[], tuple[Operator, Any, Any]], depth: int) -> Any:
    """A node whose expression is not known yet: received in a header, or an array's element.

    expand  gives (operator, first, second) as for `node` when the expression is first looked at
    depth   an estimate of its depth, at least 1
    """
    return node(value, DEFERRED, expand, None, depth)


_settling = threading.RLock()


def settle(value: Any) -> None:
    """Works out what a deferred node stands for, in place."""
    if value._op is DEFERRED:
        with _settling:
            if value._op is DEFERRED:
                op, a, b = value._a()
                value._set(op, a, b, 0 if op is SOURCE or op is LITERAL else value._depth)


def record(op: Operator, value: Any, *operands: Any) -> Any:
    """`value`, computed by `op` from `operands` on plain numbers, with that provenance.

    Returns `value` as it is if no operand is tracked or if it is neither float, int nor str.
    """
    depth = -1
    for operand in operands:
        if type(type(operand)) is PlainType and operand._depth > depth:
            depth = operand._depth
    if depth < 0:
        return value
    if len(operands) == 1:
        return node(value, op, operands[0], None, depth + 1)
    if len(operands) == 2:
        return node(value, op, operands[0], operands[1], depth + 1)
    return node(value, op, operands, None, depth + 1)


# ---------------------------------------------------------------- operator methods
#
# One template for all methods of both classes. The common kinds of operands come first; a
# subclass of float or int that somebody else wrote keeps its own dispatch; everything else gets
# NotImplemented, so that Python asks the other operand next, as for a plain number. (A reflected
# method is called with a subclass only when that has declined already.) An error is
# left to Python too where Python can raise it itself: the traceback is then the plain one.

_BINARY = """
def __{method}__(self, other):
    {prepare}kind = type(other)
    if kind is float or kind is int:
        try:
            value = {with_plain}
        except ArithmeticError:
            if kind is {base}:
                return NotImplemented
            raise
        depth = {depth} + 1
    elif kind is TrackedFloat:
        value = {with_float}
        depth = {depth}
        if other._depth > depth:
            depth = other._depth
        depth += 1
    elif kind is TrackedInt:
        theirs = other._n
        value = {with_int}
        depth = {depth}
        if theirs[4] > depth:
            depth = theirs[4]
        depth += 1
    elif FOREIGN and FOREIGN[0](other):
        return FOREIGN[1](OP, {operands})
    elif isinstance(other, {accepted}):
        value = {with_subclass}
        return value if value is NotImplemented else record(OP, value, {operands})
    else:
        {otherwise}
    {make}
"""

_MAKE_FLOAT = """made = new_float(TrackedFloat, value)
    made._v = value
    made._op = OP
    made._a = {a}
    made._b = {b}
    made._depth = depth
    if depth > DEPTH_LIMIT:
        _fold(made)
    return made"""

_MAKE_INT = """if type(value) is not int:
        return node(value, OP, {a}, {b}, depth)
    made = new_int(TrackedInt, value)
    made._n = (value, OP, {a}, {b}, depth)
    if depth > DEPTH_LIMIT:
        _fold(made)
    return made"""

_MAKE_ANY = "return node(value, OP, {a}, {b}, depth)"

# method: (operator, expression); what `TrackedFloat` has of them gives floats if `always`.
_ARITHMETIC = {
    "add": ("add", "{0} + {1}", True),
    "sub": ("sub", "{0} - {1}", True),
    "mul": ("mul", "{0} * {1}", True),
    "truediv": ("truediv", "{0} / {1}", True),
    "floordiv": ("floordiv", "{0} // {1}", True),
    "mod": ("mod", "{0} % {1}", True),
    "pow": ("pow", "{0} ** {1}", False),
}
_BITWISE = {
    "lshift": ("lshift", "{0} << {1}", False),
    "rshift": ("rshift", "{0} >> {1}", False),
    "and": ("and", "{0} & {1}", False),
    "xor": ("xor", "{0} ^ {1}", False),
    "or": ("or", "{0} | {1}", False),
}


def _binary_method(cls: type, name: str, row: tuple[str, str, bool], prefix: str = "") -> None:
    op, expression, always_float = row
    method = prefix + name
    reflected = prefix == "r"
    mine, depth = ("self._v", "self._depth") if cls is TrackedFloat else ("mine[0]", "mine[4]")

    def value(theirs: str) -> str:
        return expression.format(*((theirs, mine) if reflected else (mine, theirs)))

    a, b = ("other", "self") if reflected else ("self", "other")
    if cls is TrackedInt:
        make = _MAKE_INT
    else:
        make = _MAKE_FLOAT if always_float else _MAKE_ANY
    source = _BINARY.format(
        method=method,
        prepare="" if cls is TrackedFloat else "mine = self._n\n    ",
        with_plain=value("other"),
        with_float=value("other._v"),
        with_int=value("theirs[0]"),
        depth=depth,
        base=cls._plain.__name__,  # type: ignore[attr-defined]
        accepted="(float, int)" if name in _ARITHMETIC else "int",
        with_subclass=f"{mine}.__{method}__(other)" if reflected else value("other"),
        operands=f"{a}, {b}",
        otherwise=(
            f"value = {mine}\n        value *= other\n        return value"
            if prefix == "i"
            else "return NotImplemented"
        ),
        make=make.format(a=a, b=b),
    )
    if name in _BITWISE:  # float has no such operators: neither kind of it gets here
        source = source.replace("kind is float or kind is int", "kind is int")
        source = source.replace("kind is TrackedFloat:", "False:")
    namespace = {**globals(), "OP": OPERATORS[op]}
    exec(compile(source, "<tracked operator>", "exec"), namespace)
    _install(cls, f"__{method}__", namespace[f"__{method}__"])


def _install(cls: Any, name: str, function: Any) -> None:
    give_method(cls, cls._plain, name, function)


def give_method(cls: Any, plain: type, name: str, function: Any) -> None:
    """Makes a function a method that says of itself what that of the plain class says."""
    made: Any = FunctionType(
        function.__code__, function.__globals__, name, function.__defaults__, function.__closure__
    )
    made.__kwdefaults__ = function.__kwdefaults__
    made.__qualname__ = f"{plain.__name__}.{name}"
    made.__module__ = None
    made.__doc__ = getattr(getattr(plain, name, None), "__doc__", None)
    setattr(cls, name, made)


def _unary_method(cls: type, name: str, op: Operator) -> None:
    forward = op.forward

    def method(self: Any) -> Any:
        return node(forward(self._v), op, self, None, self._depth + 1)

    _install(cls, f"__{name}__", method)


def _divmod(self: Any, other: Any) -> Any:
    if not isinstance(other, (float, int)):
        return NotImplemented
    return _divmod_pair(divmod(self._v, untracked(other)), self, other)


def _rdivmod(self: Any, other: Any) -> Any:
    if not isinstance(other, (float, int)):
        return NotImplemented
    return _divmod_pair(self._v.__rdivmod__(untracked(other)), other, self)


def _divmod_pair(value: Any, a: Any, b: Any) -> Any:
    if type(value) is not tuple or len(value) != 2:  # somebody's subclass has its own idea
        return value
    quotient, remainder = value
    return (
        record(OPERATORS["floordiv"], quotient, a, b),
        record(OPERATORS["mod"], remainder, a, b),
    )


def _pow_with_modulus(two: Callable[..., Any]) -> Callable[..., Any]:
    def __pow__(self: Any, other: Any, modulus: Any = None) -> Any:
        if modulus is None:
            return two(self, other)
        value = pow(self._v, untracked(other), untracked(modulus))
        return record(OPERATORS["powmod"], value, self, other, modulus)

    return __pow__


def _rpow_with_modulus(two: Callable[..., Any]) -> Callable[..., Any]:
    def __rpow__(self: Any, other: Any, modulus: Any = None) -> Any:
        if modulus is None:
            return two(self, other)
        value = pow(untracked(other), self._v, untracked(modulus))  # asked for since 3.14
        return record(OPERATORS["powmod"], value, other, self, modulus)

    return __rpow__


def _round(self: Any, digits: Any = None) -> Any:
    op = OPERATORS["round"]
    if digits is None:
        return record(op, self._v.__round__(), self)
    return record(op, self._v.__round__(untracked(digits)), self, digits)


_COMPARISON = """
def __{method}__(self, other):
    kind = type(other)
    if kind is float or kind is int:
        return self._v {symbol} other
    if kind is TrackedFloat or kind is TrackedInt:
        return self._v {symbol} other._v
    if isinstance(other, (float, int)):
        return self._v {symbol} other
    return NotImplemented
"""
_COMPARISONS = {"lt": "<", "le": "<=", "eq": "==", "ne": "!=", "gt": ">", "ge": ">="}


def _comparison_method(cls: type, name: str, symbol: str) -> None:
    """The plain comparison; a subclass of float or int has its say first, as it always has."""
    source = _COMPARISON.format(method=name, symbol=symbol)
    if cls is TrackedInt:
        source = source.replace("self._v", "self._n[0]")
    namespace = dict(globals())
    exec(compile(source, "<tracked comparison>", "exec"), namespace)
    _install(cls, f"__{name}__", namespace[f"__{name}__"])


def _array_ufunc(self: Any, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
    """numpy lets exact floats and ints alone adapt to an array's type (NEP 50): it gets those."""
    return getattr(ufunc, method)(*_plain(inputs), **_plain(options))


def _array_function(self: Any, function: Any, types: Any, inputs: Any, options: Any) -> Any:
    """Likewise for numpy's other functions (NEP 18)."""
    return function(*_plain(inputs), **_plain(options))


def _plain(thing: Any) -> Any:
    """Arguments for numpy, everything in them untracked."""
    if type(thing) is tuple or type(thing) is list:
        return type(thing)(map(_plain, thing))
    if type(thing) is dict:
        return {key: _plain(value) for key, value in thing.items()}
    return untracked(thing)


def _complete(cls: type) -> None:
    """Gives a class all operators of its plain type."""
    rows = _ARITHMETIC if cls is TrackedFloat else {**_ARITHMETIC, **_BITWISE}
    for name, row in rows.items():
        _binary_method(cls, name, row)
        _binary_method(cls, name, row, "r")
    # Python repeats no sequence for `n *= "ab"` where n is of a class written in Python.
    _binary_method(cls, "mul", rows["mul"], "i")
    unary = {"neg": "neg", "pos": "pos", "abs": "abs", "trunc": "trunc", "floor": "floor"}
    unary |= {"ceil": "ceil"} | ({"invert": "invert"} if cls is TrackedInt else {})
    for name, op in unary.items():
        _unary_method(cls, name, OPERATORS[op])
    for name, symbol in _COMPARISONS.items():
        _comparison_method(cls, name, symbol)
    _install(cls, "__pow__", _pow_with_modulus(vars(cls)["__pow__"]))
    _install(cls, "__rpow__", _rpow_with_modulus(vars(cls)["__rpow__"]))
    _install(cls, "__divmod__", _divmod)
    _install(cls, "__rdivmod__", _rdivmod)
    _install(cls, "__round__", _round)
    _install(cls, "__array_ufunc__", _array_ufunc)
    _install(cls, "__array_function__", _array_function)


def disguise(cls: type) -> None:
    """Lets a tracked class behave as its plain type where objects are looked at, not computed."""
    for name, function in {
        "__reduce_ex__": _reduce,
        "__copy__": _same,
        "__deepcopy__": _same,
        "__dir__": lambda self: dir(untracked(self)),
        "__sizeof__": lambda self: untracked(self).__sizeof__(),
    }.items():
        _install(cls, name, function)
    plain = cls._plain  # type: ignore[attr-defined]
    cls.__name__ = cls.__qualname__ = plain.__name__
    cls.__doc__ = plain.__doc__
    if "__slots__" in vars(cls):
        del cls.__slots__  # type: ignore[attr-defined]


_complete(TrackedFloat)
_complete(TrackedInt)
for _cls in (TrackedFloat, TrackedInt, TrackedStr):
    disguise(_cls)
