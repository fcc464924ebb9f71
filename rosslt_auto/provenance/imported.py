"""Doing something as soon as the program has imported a module, and not importing it otherwise.

Knows nothing of provenance; it stands here because both `instrument` and `ros` import this package.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

from .frames import unseen


class AfterImport:
    """Calls `then` once a module is imported; at once if it has been imported before.

    Lets everybody else find the module, and sees its import through (PEP 451): as often as
    somebody looks for it, until it has been imported without an error. The loader stays its own.
    """

    def __init__(self, name: str, then: Callable[[], None]) -> None:
        self.name = name
        self.then = then
        module = sys.modules.get(name)
        if module is not None and not _is_initialising(module):
            then()
        else:
            sys.meta_path.insert(0, self)

    def cancel(self) -> None:
        """The module, if it is still to be imported, is not waited for any more."""
        if self in sys.meta_path:
            sys.meta_path.remove(self)

    @unseen
    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        if name != self.name or self not in sys.meta_path:
            return None
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            find = getattr(finder, "find_spec", None)
            spec = find(name, path, target) if find is not None else None
            if spec is not None:
                self._watch(spec)
                return spec
        return None

    def _watch(self, spec: Any) -> None:
        """Makes the spec's loader tell when it has executed the module, once."""
        own = spec.loader
        if not hasattr(own, "exec_module"):  # a namespace package, or an old loader
            return
        loader = own() if isinstance(own, type) else own  # that of built-in modules is a class
        plain = loader.exec_module

        @unseen
        def exec_module(module: ModuleType) -> None:
            if module.__name__ != self.name:  # the loader of an archive is that of all its modules
                plain(module)
                return
            vars(loader).pop("exec_module", None)
            if loader is not own:
                module.__loader__ = spec.loader = own
            plain(module)
            self._imported()

        try:
            loader.exec_module = exec_module
        except AttributeError:  # a loader with slots: the module is imported unwatched
            return
        spec.loader = loader

    def _imported(self) -> None:
        if self in sys.meta_path:
            self.cancel()
            self.then()


def _is_initialising(module: ModuleType) -> bool:
    return getattr(getattr(module, "__spec__", None), "_initializing", False)
