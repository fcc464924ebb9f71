"""Join point: what is typed into a console, ``code.InteractiveInterpreter.runcode``.

For programs that open a console, ``code.interact()``: what is typed into it is tracked like the
program itself, ``rosslt.console.in_3.x`` being from the third input. (``run -m code`` stays plain:
there the module is a program of its own.) The module is not imported here for a program that does
without.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import CodeType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints

_points = JoinPoints()
_inputs: dict[str, int] = {}


def install() -> None:
    """Instruments inputs as soon as module `code` is imported. Idempotent."""
    if not _points:
        _points.replace_when_imported("code", "InteractiveInterpreter.runcode", _advised)


def uninstall() -> None:
    """Inputs are plain again, save where somebody else has wrapped the method since."""
    _points.restore()


def _advised(original: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(original)
    def runcode(self: Any, code: Any) -> Any:
        return original(self, _instrumented(self, code))

    return unseen(runcode)


def _instrumented(console: Any, code: Any) -> Any:
    """The code of an input, instrumented. Raises nothing."""
    try:
        if type(code) is not CodeType:
            return code
        from .code_objects import instrumented_or_same
        from .naming import Scope, module_scope

        name = console.locals.get("__name__")
        module = name if type(name) is str and name else "__console__"
        outer = module_scope(module, "console").path
        number = _inputs[outer] = _inputs.get(outer, 0) + 1
        return instrumented_or_same(code, module, Scope(f"{outer}.in_{number}", None))
    except Exception:
        return code
