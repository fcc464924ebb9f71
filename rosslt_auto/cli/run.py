"""``run``: a program as python would run it, with provenance."""

from __future__ import annotations

import atexit
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from . import NO_ROS, say

if TYPE_CHECKING:
    import argparse

_NAMED = 5  # patterns, where many are in vain


class Command:  # no dataclass: that takes long to import
    """A parsed command line of `run`.

    target     the script, or with `as_module` the module; None for a `prompt`
    arguments  what belongs to the program
    """

    def __init__(self) -> None:
        self.target: str | None = None
        self.prompt = False
        self.as_module = False
        self.arguments: list[str] = []
        self.modules: list[str] = []
        self.excluded: list[str] = []
        self.read_only = False
        self.show_rewritten = False


class _Usage(Exception):
    pass


def main(words: Sequence[str]) -> int:
    """Runs the program; returns its exit status, or leaves as the program leaves."""
    try:
        command = parse(words)
    except _Usage as mistake:
        _parser().error(str(mistake))
    if command is None:
        _parser().print_help()
        return 0
    if command.show_rewritten:
        from . import rewritten

        return rewritten.show(command)

    from rosslt_auto import processes, startup
    from rosslt_auto.instrument import runner, subinterpreters
    from rosslt_auto.instrument.selection import Selection
    from rosslt_auto.ros import weave

    weave.prepare(command.arguments, read_only=command.read_only)
    subinterpreters.install()
    processes.install(command.arguments, command.read_only)
    if command.modules:
        atexit.register(_tell_unmatched, command.modules)
    selection = Selection([*command.modules, *startup.patterns()], command.excluded)
    if command.target is None:
        return runner.run_prompt(selection)
    status = runner.run(
        command.target, command.arguments, as_module=command.as_module, selection=selection
    )
    if status:
        _explain(getattr(sys, "last_value", None))
    return status


def _tell_unmatched(patterns: Sequence[str]) -> None:
    """At the end: which patterns were in vain, perhaps for a mistake in writing."""
    from fnmatch import filter as matching

    in_vain = [pattern for pattern in patterns if not matching(sys.modules, pattern)]
    if in_vain:
        named = ", ".join(in_vain[:_NAMED])
        others = f" and {more} more" if (more := len(in_vain) - _NAMED) > 0 else ""
        say(f"--module {named}{others}: the program has imported no such module")


def _explain(error: BaseException | None) -> None:
    """After the traceback of a program that has not found ROS: how to get it."""
    if isinstance(error, ModuleNotFoundError) and error.name == "rclpy":
        say(NO_ROS.format(error))


def parse(words: Sequence[str]) -> Command | None:
    """The command; None if help is asked for. Raises for wrong usage.

    By hand, and without argparse: everything behind the script or module belongs to the program,
    options, ``--`` and all, and starting should take no time.
    """
    command = Command()
    rest = list(words)
    while rest:
        word = rest.pop(0)
        option, equals, value = word.partition("=")
        if word in ("-h", "--help"):
            return None
        if word == "-i":
            command.prompt = True
        elif word == "--read-only":
            command.read_only = True
        elif word == "--show-rewritten":
            command.show_rewritten = True
        elif option in ("--module", "--exclude"):
            if not equals:
                if not rest:
                    raise _Usage(f"argument {option}: expected a pattern")
                value = rest.pop(0)
            (command.modules if option == "--module" else command.excluded).append(value)
        elif word == "-m" or (word.startswith("-m") and not word.startswith("--")):
            command.as_module = True
            command.target = word[2:] or (rest.pop(0) if rest else None)
            break
        elif word == "--":
            command.target = rest.pop(0) if rest else None
            break
        elif word.startswith("-") and word != "-":
            raise _Usage(f"unrecognized option: {word}")
        else:
            command.target = word
            break
    if command.prompt:
        if command.target or command.show_rewritten:
            raise _Usage("-i opens a prompt, and nothing can be run with it")
        return command
    if not command.target:
        raise _Usage("a script or -m MODULE is required (or -i, for a prompt)")
    if command.target == "-" and not command.as_module:
        raise _Usage("a program on standard input cannot be run, it has to be in a file")
    command.arguments = rest
    return command


def _parser() -> argparse.ArgumentParser:
    import argparse

    from .options import parser

    made = parser("run", "Runs a program as python would, and tracks where its numbers come from.")
    made.usage = (
        "%(prog)s [--module PATTERN]... [--exclude PATTERN]... [--read-only] [--show-rewritten] "
        "(SCRIPT | -m MODULE) [ARG...], or -i"
    )
    made.add_argument(
        "--module", action="append", metavar="PATTERN",
        help="track modules of this name too (* and ? as in file names)",
    )  # fmt: skip
    made.add_argument("--exclude", action="append", metavar="PATTERN", help="leave these alone")
    made.add_argument(
        "--read-only", action="store_true", help="provenance, but nobody can change anything"
    )
    made.add_argument(
        "--show-rewritten", action="store_true",
        help="run nothing, print what the program and modules of --module become",
    )  # fmt: skip
    made.add_argument("-i", action="store_true", help="open a prompt, and track what is typed")
    made.add_argument("-m", metavar="MODULE", help="run a module, as python -m does")
    made.add_argument("script", metavar="SCRIPT", nargs="?", help="run a script")
    made.add_argument(
        "arguments", metavar="ARG", nargs=argparse.REMAINDER,
        help="everything behind the script or module belongs to the program",
    )  # fmt: skip
    return made
