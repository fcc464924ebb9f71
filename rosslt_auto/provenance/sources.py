"""Sources: what values can come from, and how a new value for one is checked."""

from __future__ import annotations

import math
import os
from typing import Any

from .limits import Limits
from .values import is_tracked

INT64 = range(-(2**63), 2**63)
"""What a ROS integer parameter can hold (rcl_interfaces/msg/ParameterValue)."""


class SourceChangeRefused(ValueError):
    """A source cannot take a value; the message says why, nothing was changed."""


class Source:
    """Anything whose value can be asked for and changed by name: a parameter of a node.

    node       fully qualified name of the node that owns it, None while no node does
    parameter  name of the parameter
    kind       "float", "int", "str" or "bool"
    hint       the name by which expressions show it
    named      whether it is bound to a name in the program (see `expressions.sources`)
    file, line, column, text   where it stands, and that line; None for a declared parameter
    """

    leaf: Any = None
    """The current leaf of a source that lives in this process, None for a remote one."""

    repeated = False
    """Whether the program reads it again and again, see `Location.repeated`."""

    limits: Limits | None = None
    """The range that its values are in, None if they are not limited."""

    frozen = False
    """Whether nobody changes it."""

    moves = 0
    """How often its line has been written anew (`saved`): what is known of its place is new."""

    def __init__(
        self,
        node: str | None,
        parameter: str,
        kind: str,
        hint: str | None = None,
        named: bool = True,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        text: str | None = None,
    ) -> None:
        self.node = node
        self.parameter = parameter
        self.kind = kind
        self.hint = hint or parameter.rpartition(".")[2]
        self.named = named
        self.file = file
        self.line = line
        self.column = column
        self.text = text

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Source):
            return NotImplemented
        return self.parameter == other.parameter and self.node == other.node

    def __hash__(self) -> int:
        return hash(self.parameter)

    def __repr__(self) -> str:
        return f"<source {self.node or ''}:{self.parameter}>"

    def check(self, value: Any) -> Any:
        """`value` as this source would hold it.

        An integer for a float is converted. Raises SourceChangeRefused for another type, for NaN,
        an infinity or an integer beyond 64 bits, and for what its remark does not allow.
        """
        if self.kind == "float" and type(value) is int:
            try:
                value = float(value)
            except OverflowError:
                raise SourceChangeRefused(f"{self.parameter}: {value} is too large") from None
        if type(value).__name__ != self.kind or is_tracked(value):
            raise SourceChangeRefused(
                f"{self.parameter} is {_ARTICLE[self.kind]}, not {type(value).__name__} {value!r}"
            )
        if self.kind == "float" and not math.isfinite(value):
            raise SourceChangeRefused(f"{self.parameter} must be finite, not {value}")
        if self.kind == "int" and value not in INT64:
            raise SourceChangeRefused(f"{self.parameter} must fit into 64 bits, not {value}")
        if self.limits is not None and not self.limits.allows(value):
            raise SourceChangeRefused(
                f"{self.parameter} is limited to {self.limits}{place_of(self)},"
                f" it cannot be {value!r}"
            )
        if self.frozen and (self.leaf is None or value != self.leaf._v):
            raise SourceChangeRefused(f"{self.parameter} is frozen{place_of(self)}")
        return value

    def change(self, value: Any) -> None:
        """Takes a value that `check` has passed. Only a source of this process can."""
        raise SourceChangeRefused(f"{self.parameter} belongs to another node, {self.node}")


def place_of(source: Source) -> str:
    """`` at controller.py:41``; nothing for what stands in no file."""
    return "" if source.file is None else f" at {os.path.basename(source.file)}:{source.line}"


_ARTICLE = {"float": "a float", "int": "an int", "str": "a str", "bool": "a bool"}
