"""``run --show-rewritten``: what a program becomes, without running it."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

from . import Failure, say, seen_enough

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosslt_auto.instrument.showing import File

    from .run import Command


def show(command: Command) -> int:
    """Prints the program's file and those of the modules that ``--module`` names.

    Returns the exit status: 0, or 1 if there is nothing to show or one cannot be shown.
    """
    status = 0
    try:
        for number, file in enumerate(_files(command)):
            if number:
                print()
            status |= _print(file)
        sys.stdout.flush()
    except Failure as failure:
        say(str(failure))
        return 1
    except BrokenPipeError:
        return seen_enough()
    return status


def _files(command: Command) -> Iterator[File]:
    from rosslt_auto.instrument import showing
    from rosslt_auto.instrument.selection import Selection

    assert command.target is not None
    folder = os.getcwd() if command.as_module else os.path.dirname(os.path.realpath(command.target))
    sys.path[0] = folder
    program = showing.program_file(command.target, command.as_module)
    if program is None:
        raise Failure(f"no source of {command.target} is found")
    patterns = list(command.modules)
    package = None if command.as_module else _wrapped_package(program.path)
    if package is not None:
        patterns += [package, f"{package}.*"]
    yield program
    selection = Selection(patterns, command.excluded)
    shown = {program.path}
    for pattern in patterns:
        for file in showing.matching_files(pattern):
            if file.path not in shown and selection.selects(*file):
                shown.add(file.path)
                yield file


def _wrapped_package(path: str) -> str | None:
    if path.endswith(".py"):
        return None
    from rosslt_auto.instrument.console_scripts import wrapped_package

    return wrapped_package(_read(path))


def _read(path: str) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise Failure(f"{path}: {error.strerror}") from None


def _print(file: File) -> int:
    from rosslt_auto.instrument.errors import NotInstrumented, NotParsed
    from rosslt_auto.instrument.showing import rewritten_source

    source = _read(file.path)
    try:
        text = rewritten_source(file.module, file.path, source)
    except (NotParsed, NotInstrumented) as error:
        say(f"{file.path}: {error}")
        return 1
    print(f"# {file.module}: {file.path}")
    print(text, end="", flush=True)
    return 0
