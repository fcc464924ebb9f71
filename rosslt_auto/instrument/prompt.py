"""Python's prompt with inputs that are tracked: ``run -i``.

The interpreter's own prompt executes in C what it reads, up to Python 3.12. This one does what that
does (`Modules/main.c`, pymain_run_stdin) with the standard library's console, whose inputs
`consoles` instruments.
"""

from __future__ import annotations

import os
import sys
from typing import Any

_MORE = 'Type "help", "copyright", "credits" or "license" for more information.'


def interact(names: dict[str, Any]) -> int:
    """Reads, executes and prints until the input ends, in the namespace `names`.

    Returns the exit status; SystemExit is passed on.
    """
    import code

    console = code.InteractiveConsole(names, "<stdin>")
    _run_startup(console)
    prepare = getattr(sys, "__interactivehook__", None)  # history and completion, see `site`
    if prepare is not None and sys.stdin.isatty():
        prepare()
    banner = "" if sys.flags.quiet else f"Python {sys.version} on {sys.platform}\n{_MORE}"
    console.interact(banner, exitmsg="")
    return 0


def _run_startup(console: Any) -> None:
    """Executes the file that PYTHONSTARTUP names, as it is."""
    path = os.environ.get("PYTHONSTARTUP")
    if not path or sys.flags.ignore_environment:
        return
    try:
        with open(path, "rb") as file:
            exec(compile(file.read(), path, "exec", dont_inherit=True), console.locals)
    except OSError as error:
        print(f"Could not open PYTHONSTARTUP\n{type(error).__name__}: {error}", file=sys.stderr)
    except Exception:
        console.showtraceback()
