"""The whole table of operators; what a row says stands in `operator_table`."""

from . import (  # fill the table
    integer_operators,
    math_operators,
    number_operators,
    read_operators,
    statistics_operators,
    text_operators,
)
from .extents import bound
from .operator_table import DEFERRED, LEAVES, LITERAL, OPERATORS, SOURCE, Operator

bound(OPERATORS)

__all__ = [
    "DEFERRED",
    "LEAVES",
    "LITERAL",
    "OPERATORS",
    "SOURCE",
    "Operator",
    "integer_operators",
    "math_operators",
    "number_operators",
    "read_operators",
    "statistics_operators",
    "text_operators",
]
