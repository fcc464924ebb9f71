"""Doing something with every module of a kind as soon as the program imports it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import Any

from ..provenance.imported import AfterImport


class AfterImports:
    """Calls `then` with each module whose full name is `wanted`, once it is imported.

    Begins with `install`, with those that are imported already.
    """

    def __init__(self, wanted: Callable[[str], bool], then: Callable[[ModuleType], None]) -> None:
        self.wanted = wanted
        self.then = then
        self._waiting: dict[str, AfterImport] = {}

    def install(self) -> None:
        if self in sys.meta_path:
            return
        for name in list(sys.modules):
            if self.wanted(name):
                self._imported(name)
        sys.meta_path.insert(0, self)

    def uninstall(self) -> None:
        if self in sys.meta_path:
            sys.meta_path.remove(self)
        while self._waiting:
            self._waiting.popitem()[1].cancel()

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        if name in self._waiting or not self.wanted(name):
            return None
        waiting = self._waiting[name] = AfterImport(name, partial(self._imported, name))
        return waiting.find_spec(name, path, target)

    def _imported(self, name: str) -> None:
        self._waiting.pop(name, None)
        module = sys.modules.get(name)
        if module is not None:
            self.then(module)


__all__ = ["AfterImports"]
