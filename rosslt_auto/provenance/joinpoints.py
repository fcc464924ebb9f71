"""Weaving: advice around functions of other people's classes and modules, and taking it off again.

Knows nothing of provenance; it stands here because both `instrument` and `ros` import this package.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from typing import Any

from .imported import AfterImport

Make = Callable[[Any], Any]
"""Gives the replacement of an original."""

Advice = Callable[[Callable[..., Any], Any, tuple[Any, ...], dict[str, Any]], Any]
"""``advice(wrapped, instance, args, kwargs)``, as wrapt calls it."""


class JoinPoints:
    """The join points of one aspect; true from the first one on, until they are restored."""

    def __init__(self) -> None:
        self._in_use = False
        self._waiting: list[AfterImport] = []
        self._woven: dict[tuple[Any, str], tuple[Any, Any]] = {}

    def __bool__(self) -> bool:
        return self._in_use

    def replace(self, owner: Any, name: str, make: Make) -> None:
        """Replaces what the class or module `owner` itself calls `name`, once.

        Nothing happens where there is no such thing, or where ours is there still: under what
        somebody else has wrapped around it (see `restore`), it would come in twice.
        """
        original = vars(owner).get(name)
        known = self._woven.get((owner, name))
        if original is None or (known is not None and known[0] is not original):
            return
        ours = make(original)
        setattr(owner, name, ours)
        self._woven[owner, name] = original, ours
        self._in_use = True

    def advise(self, cls: type, name: str, advice: Advice) -> None:
        """Puts `advice` around the method `name` that `cls` itself defines, else AttributeError."""
        if name not in vars(cls):
            raise AttributeError(f"{cls.__name__} has no method {name} of its own")
        self.replace(cls, name, around(advice))

    def when_imported(self, module: str, then: Callable[[], None]) -> None:
        """Calls `then` as soon as a module is imported, and not after `restore`."""
        self._waiting.append(AfterImport(module, then))
        self._in_use = True

    def replace_when_imported(self, module: str, path: str, make: Make) -> None:
        """As `replace`, as soon as a module is imported.

        path  ``function`` or ``Class.method``
        """
        self.when_imported(module, partial(self._replace_in, module, path, make))

    def restore(self) -> None:
        """All is as it was, last first; what somebody else has wrapped since stays under that."""
        while self._waiting:
            self._waiting.pop().cancel()
        for (owner, name), (original, ours) in reversed(list(self._woven.items())):
            if vars(owner).get(name) is ours:
                setattr(owner, name, original)
                del self._woven[owner, name]
        self._in_use = False

    def _replace_in(self, module: str, path: str, make: Make) -> None:
        owner: Any = sys.modules.get(module)
        *classes, name = path.split(".")
        for cls in classes:
            owner = getattr(owner, cls, None)
        if owner is not None:
            self.replace(owner, name, make)


def around(advice: Advice) -> Make:
    """Makes functions with `advice` around them."""

    def make(original: Any) -> Any:
        import wrapt  # slow to import, see tests/cli/test_run_program.py

        return wrapt.FunctionWrapper(original, advice)

    return make
