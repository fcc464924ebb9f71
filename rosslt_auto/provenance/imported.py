"""Doing something as soon as the program has imported a module, and not importing it otherwise.

Knows nothing of provenance; it stands here because both `instrument` and `ros` import this package.
All that wait share one finder, which is in ``sys.meta_path`` while there is something to wait for.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

from .frames import unseen


class AfterImport:
    """Calls `then` once a module is imported; at once if it has been imported before."""

    def __init__(self, name: str, then: Callable[[], None]) -> None:
        self.name = name
        self.then = then
        module = sys.modules.get(name)
        if module is not None and not _is_initialising(module):
            then()
        else:
            _FINDER.awaited.setdefault(name, []).append(self)
            _FINDER.stand()

    def cancel(self) -> None:
        """The module, if it is still to be imported, is not waited for any more."""
        waiting = _FINDER.awaited.get(self.name, [])
        if self in waiting:
            waiting.remove(self)
            if not waiting:
                del _FINDER.awaited[self.name]
            _FINDER.stand()


class AfterImports:
    """Calls `then` with each module whose full name is `wanted`, once it is imported.

    Begins with `install`, with those that are imported already.
    """

    def __init__(self, wanted: Callable[[str], bool], then: Callable[[ModuleType], None]) -> None:
        self.wanted = wanted
        self.then = then

    def install(self) -> None:
        if self in _FINDER.kinds:
            return
        for name, module in list(sys.modules.items()):
            if module is not None and self.wanted(name):
                self.then(module)
        _FINDER.kinds.append(self)
        _FINDER.stand()

    def uninstall(self) -> None:
        if self in _FINDER.kinds:
            _FINDER.kinds.remove(self)
            _FINDER.stand()


class _Finder:
    """Lets everybody else find a module, and sees its import through (PEP 451).

    As often as somebody looks for it, until it has been imported without an error. The loader
    stays its own.
    """

    def __init__(self) -> None:
        self.awaited: dict[str, list[AfterImport]] = {}
        self.kinds: list[AfterImports] = []

    def stand(self) -> None:
        """In ``sys.meta_path``, before all others, exactly if somebody waits."""
        if not (self.awaited or self.kinds):
            if self in sys.meta_path:
                sys.meta_path.remove(self)
        elif self not in sys.meta_path:
            sys.meta_path.insert(0, self)

    @unseen
    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        if name not in self.awaited:
            for kind in self.kinds:  # no expression with a frame of its own, which would be seen
                if kind.wanted(name):
                    break
            else:
                return None
        if self not in sys.meta_path:
            return None
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            find = getattr(finder, "find_spec", None)
            spec = find(name, path, target) if find is not None else None
            if spec is not None:
                self._watch(name, spec)
                return spec
        return None

    def _watch(self, name: str, spec: Any) -> None:
        """Makes the spec's loader tell when it has executed the module, once."""
        own = spec.loader
        if not hasattr(own, "exec_module"):  # a namespace package, or an old loader
            return
        loader = own() if isinstance(own, type) else own  # that of built-in modules is a class
        plain = loader.exec_module

        @unseen
        def exec_module(module: ModuleType) -> None:
            if module.__name__ != name:  # the loader of an archive is that of all its modules
                plain(module)
                return
            vars(loader).pop("exec_module", None)
            if loader is not own:
                module.__loader__ = spec.loader = own
            plain(module)
            self._imported(name)

        try:
            loader.exec_module = exec_module
        except AttributeError:  # a loader with slots: the module is imported unwatched
            return
        spec.loader = loader

    def _imported(self, name: str) -> None:
        waiting = self.awaited.pop(name, [])
        self.stand()
        for one in waiting:
            one.then()
        module = sys.modules.get(name)
        for kind in tuple(self.kinds):
            if module is not None and kind.wanted(name):
                kind.then(module)


_FINDER = _Finder()


def _is_initialising(module: ModuleType) -> bool:
    return getattr(getattr(module, "__spec__", None), "_initializing", False)
