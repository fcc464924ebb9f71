"""The table of operators that tracked values can pass through: one row each.

A row says how an operator computes (``forward``), how a wanted result is turned into a wanted
operand (``inverses``, Section IV-A of the paper), how the result moves with each operand
(``partials``) and what results are possible at all (``domain``).  Everything else - evaluation,
inversion, derivatives, texts, the wire format - is read from this table and knows no arithmetic.

Inverses and partial derivatives are called with the operands as they are:
``inverse(target, *operands)`` gives the new value of its operand, all others unchanged;
``partial(*operands)`` gives the slope. An inverse raises ArithmeticError or ValueError where no
operand gives the target.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Inverse = Callable[..., Any]
Partial = Callable[..., float]


class Operator:
    """One row of the table.

    name        how it is called on the wire, stable for ever
    symbol      how people write it: ``+`` between operands, or a function's name before them
    precedence  binding strength of an infix or prefix symbol, None for a function
    forward     the plain operation on plain operands
    inverses    per operand; the last one also serves all further operands
    partials    per operand; the last one also serves all further operands
    domain      which results are possible, in words, for refusals
    """

    __slots__ = ("domain", "forward", "inverses", "name", "partials", "precedence", "symbol")

    def __init__(
        self,
        name: str,
        symbol: str,
        precedence: int | None,
        forward: Callable[..., Any],
        inverses: tuple[Inverse | None, ...] = (None, None),
        partials: tuple[Partial | None, ...] = (None, None),
        domain: str = "",
    ) -> None:
        self.name = name
        self.symbol = symbol
        self.precedence = precedence
        self.forward = forward
        self.inverses = inverses
        self.partials = partials
        self.domain = domain

    def inverse(self, index: int) -> Inverse | None:
        """The inverse for the operand at `index`, None if there is none."""
        return self.inverses[index] if index < len(self.inverses) else self.inverses[-1]

    def partial(self, index: int) -> Partial | None:
        """The partial derivative by the operand at `index`, None if there is none."""
        return self.partials[index] if index < len(self.partials) else self.partials[-1]

    def __repr__(self) -> str:
        return f"<operator {self.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return (_by_name, (self.name,))


def _by_name(name: str) -> Operator:
    return OPERATORS[name] if name in OPERATORS else LEAVES[name]


class AnyOperands(Operator):
    """An operator with any number of operands.

    make_inverse, make_partial  give the function for the operand at an index, or None
    """

    __slots__ = ("make_inverse", "make_partial")

    def __init__(
        self,
        name: str,
        symbol: str,
        forward: Callable[..., Any],
        make_inverse: Callable[[int], Inverse | None],
        make_partial: Callable[[int], Partial | None] = lambda index: None,
        domain: str = "",
    ) -> None:
        inverses = (make_inverse(0), make_inverse(1))
        super().__init__(name, symbol, None, forward, inverses, domain=domain)
        self.make_inverse = make_inverse
        self.make_partial = make_partial

    def inverse(self, index: int) -> Inverse | None:
        return self.make_inverse(index)

    def partial(self, index: int) -> Partial | None:
        return self.make_partial(index)


OPERATORS: dict[str, Operator] = {}
"""Every operator by its wire name."""


def define(*row: Any, **more: Any) -> None:
    """Adds a row: the arguments of `Operator`."""
    add(Operator(*row, **more))


def add(row: Operator) -> None:
    """Adds a row."""
    OPERATORS[row.name] = row


# Leaves: where an expression begins. They compute nothing, so they are not in the table.
LITERAL = Operator("literal", "", None, lambda: None)
SOURCE = Operator("source", "", None, lambda: None)
LEAVES = {"literal": LITERAL, "source": SOURCE}

# A node whose operator and operands are worked out when somebody asks for them.
DEFERRED = Operator("deferred", "", None, lambda: None)
