"""The command line. Each verb is a module, imported when it is used."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

VERBS = {
    "run": "run a program with provenance",
    "echo": "print messages and where their fields come from",
    "force": "give fields of messages new values by changing their sources",
    "locations": "list what can be changed now",
    "save": "write changed literals into their source files",
    "view": "see messages in the browser and drag what can be changed",
    "markers": "the same for RViz, as interactive markers",
    "demo": "show the quadcopter example, or with --terminal two sample nodes",
}

PROGRAM = "python -m rosslt_auto"

NO_ROS = (
    'ROS 2 is not found ({}): install it with `pip install "rosslt_auto[ros]"`, '
    "or source a ROS 2 installation (`source /opt/ros/<distribution>/setup.bash`)"
)


class Failure(Exception):
    """What could not be done, in one line for people; the exit status is 1."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a verb; returns the exit status: 0 done, 1 could not be done, 2 wrong usage."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or words[0] not in VERBS:
        return _overview(words)
    verb, *words = words
    if verb == "run":  # a program ends as it ends
        from . import run

        return run.main(words)
    try:
        status: int = import_module(f".{verb}", __package__).main(words)
        sys.stdout.flush()
        return status
    except Failure as failure:
        say(str(failure))
        return 1
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        return seen_enough()


def seen_enough() -> int:
    """Whoever reads our output has left. What Python flushes at its end must find an open file."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def say(message: str) -> None:
    """One line to people, beside the results."""
    print(f"rosslt_auto: {message}", file=sys.stderr)


def need_ros() -> None:
    """Raises Failure where rclpy cannot be imported, with both ways to get it."""
    try:
        import rclpy.node  # noqa: F401
    except ImportError as error:
        raise Failure(NO_ROS.format(str(error).splitlines()[0])) from None


def _overview(words: list[str]) -> int:
    import argparse

    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Tracks where every number in a ROS 2 message came from, and changes it there.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="verbs:\n"
        + "\n".join(f"  {verb:<10} {summary}" for verb, summary in VERBS.items())
        + f"\n\n`{PROGRAM} VERB --help` tells more.",
    )
    parser.add_argument("verb", metavar="VERB", choices=list(VERBS), help="what to do, see below")
    parser.add_argument("arguments", metavar="...", nargs=argparse.REMAINDER)
    parser.parse_args(words)  # ends the process: only --help and mistakes come here
    return 2
