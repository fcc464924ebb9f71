"""Executes small programs plain and instrumented, for comparisons of what they write."""

import contextlib
import io
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import CodeType

from rosslt_auto.instrument import hook
from rosslt_auto.instrument.code_objects import instrumented_code_object


def from_source(source: str, path: Path) -> CodeType:
    return hook.instrumented_code("program", str(path), source.encode(), cached=False)


def plain(source: str, path: Path) -> CodeType:
    return compile(source, str(path), "exec", dont_inherit=True)


def from_code(source: str, path: Path) -> CodeType:
    return instrumented_code_object(plain(source, path), "program")


def output(source: str, path: Path, make: Callable[[str, Path], CodeType]) -> str:
    """What a program writes, with its traceback at the end if it fails."""
    path.write_text(source)
    code = make(source, path)
    out = io.StringIO()
    namespace = {"__name__": "program", "__builtins__": __builtins__}
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        try:
            exec(code, namespace)
        except BaseException as error:
            trace = error.__traceback__.tb_next
            out.write("".join(traceback.format_exception(type(error), error, trace)))
    sys.modules.pop("program", None)
    return out.getvalue()


WAYS = {"source": from_source, "code object": from_code}
"""What instruments a program, by its name."""
