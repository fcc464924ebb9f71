"""The whole table of operators; what a row says stands in `operator_table`."""

from . import math_operators, number_operators, text_operators  # fill the table
from .operator_table import DEFERRED, LEAVES, LITERAL, OPERATORS, SOURCE, Operator

__all__ = [
    "DEFERRED",
    "LEAVES",
    "LITERAL",
    "OPERATORS",
    "SOURCE",
    "Operator",
    "math_operators",
    "number_operators",
    "text_operators",
]
