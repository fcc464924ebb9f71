"""Join points: what is typed into consoles and into the cells of notebooks.

For programs that open a console, ``code.interact()`` or IPython's, and for notebooks, whose kernel
is IPython: what is typed is tracked like the program itself, ``rosslt.console.in_3.x`` being from
the third input. ``run -i`` opens such a console (`prompt`). Python's own prompt is one since 3.13;
up to 3.12 it executes in C what it reads, and stays plain. (So does ``run -m code``: there the
module is a program of its own.) No console is imported here for a program that does without.
"""

from __future__ import annotations

import collections
import functools
from collections.abc import Callable
from types import CodeType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints

CONSOLES = {
    "code": "InteractiveInterpreter.runcode",
    "_pyrepl.console": "InteractiveColoredConsole.runcode",  # Python's own prompt since 3.13
    "IPython.core.interactiveshell": "InteractiveShell.run_code",
}
"""Methods that execute the code of an input, or of one statement of it, by their module."""

_points = JoinPoints()
_counts: collections.Counter[str] = collections.Counter()


def install() -> None:
    """Instruments inputs as soon as there is a console. Idempotent."""
    if not _points:
        for module, method in CONSOLES.items():
            _points.replace_when_imported(module, method, _advised)


def uninstall() -> None:
    """Inputs are plain again, save where somebody else has wrapped the method since."""
    _points.restore()


def _advised(original: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(original)
    def run(self: Any, code: Any, *args: Any, **kwargs: Any) -> Any:
        return original(self, _instrumented(self, code, *args, **kwargs), *args, **kwargs)

    return unseen(run)


def _instrumented(console: Any, code: Any, result: Any = None, **_: Any) -> Any:
    """The code of an input, instrumented. Raises nothing.

    result  where IPython notes the number of the cell
    """
    try:
        if type(code) is not CodeType:
            return code
        from .code_objects import instrumented_or_same
        from .naming import Scope, module_scope

        names = console.locals if result is None else console.user_ns
        name = names.get("__name__")
        module = name if type(name) is str and name else "__console__"
        outer = module_scope(module, "console").path
        label = _label(outer, getattr(result, "execution_count", None))
        return instrumented_or_same(code, module, Scope(label, None))
    except Exception:
        return code


def _label(outer: str, number: int | None) -> str:
    """The scope of an input; the second statement of a cell has ``_2`` behind its number."""
    if number is None:
        number = _counts[outer] = _counts[outer] + 1
        return f"{outer}.in_{number}"
    label = f"{outer}.in_{number}"
    _counts[label] += 1
    return label if _counts[label] == 1 else f"{label}_{_counts[label]}"
