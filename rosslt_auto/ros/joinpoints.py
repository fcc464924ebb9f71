"""Weaving: advice around functions of other people's classes, and taking it off again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import wrapt

Advice = Callable[[Callable[..., Any], Any, tuple[Any, ...], dict[str, Any]], Any]
"""``advice(wrapped, instance, args, kwargs)``, as wrapt calls it."""


class JoinPoints:
    """The join points of one aspect."""

    def __init__(self) -> None:
        self._woven: list[tuple[type, str, Any, Any]] = []

    def __bool__(self) -> bool:
        return bool(self._woven)

    def advise(self, cls: type, name: str, advice: Advice) -> None:
        """Puts `advice` around the method `name` that `cls` itself defines."""
        original = cls.__dict__[name]
        wrapper = wrapt.FunctionWrapper(original, advice)
        setattr(cls, name, wrapper)
        self._woven.append((cls, name, original, wrapper))

    def restore(self) -> None:
        """Takes all advice off, last first; where somebody else has wrapped it since, it stays."""
        while self._woven:
            cls, name, original, wrapper = self._woven.pop()
            if cls.__dict__.get(name) is wrapper:
                setattr(cls, name, original)
