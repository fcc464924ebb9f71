"""Small programs whose literals are locations, made without the rewriter."""

from __future__ import annotations

import builtins
import itertools
import re
import sys
import types
from typing import Any

from rosslt_auto.provenance import refresh, registry
from rosslt_auto.provenance.locations import LiteralInfo, Location
from rosslt_auto.provenance.registry import count_executions, register_literals

_MARK = re.compile(r"<(\w+)=(-?[\w.]+)([*?]?)>")
_numbers = itertools.count()


class Program:
    """A module whose source has its literals marked: ``SPEED = <speed=0.5>``.

    ``<name=value>`` is executed once, ``<name=value*>`` stands in a loop, and of ``<name=value?>``
    how often it is executed shows when the program runs. Use it in a ``with`` statement.
    """

    def __init__(self, source: str) -> None:
        self.name = f"tested_program_{next(_numbers)}"
        self.file = f"/tested/{self.name}.py"
        marks = list(_MARK.finditer(source))
        self.names = [mark[1] for mark in marks]
        self.infos = [
            LiteralInfo(f"rosslt.{self.name}.{mark[1]}", mark[1], True, i + 1, 0, i + 1, 1,
                        {"": False, "*": True, "?": None}[mark[3]])
            for i, mark in enumerate(marks)
        ]  # fmt: skip
        self.values = tuple(float(m[2]) if "." in m[2] else int(m[2]) for m in marks)
        count = itertools.count()
        self.code = compile(
            _MARK.sub(lambda mark: f"table_of_{self.name}[{next(count)}]", source),
            self.file, "exec", dont_inherit=True,
        )  # fmt: skip
        self.module: Any = types.ModuleType(self.name)

    def __enter__(self) -> Program:
        count_executions()  # as if a node had been made
        self.literals = register_literals(
            self.name, self.name, self.file, self.values, lambda: self.infos,
            lambda table: setattr(builtins, f"table_of_{self.name}", table),
        )  # fmt: skip
        sys.modules[self.name] = self.module
        exec(self.code, self.module.__dict__)
        return self

    def __exit__(self, *exc: object) -> None:
        del sys.modules[self.name]
        delattr(builtins, f"table_of_{self.name}")
        del registry._tables[self.name]

    def location(self, name: str) -> Location:
        """The location of the literal with this name."""
        return self.literals.location(self.names.index(name))

    def change(self, **values: Any) -> None:
        """A request that changes these literals."""
        refresh.apply({self.location(name): value for name, value in values.items()})
