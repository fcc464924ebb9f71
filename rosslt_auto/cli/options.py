"""Options that several verbs have."""

from __future__ import annotations

import argparse
import math

from . import PROGRAM


def parser(verb: str, description: str) -> argparse.ArgumentParser:
    """The parser of a verb."""
    return argparse.ArgumentParser(prog=f"{PROGRAM} {verb}", description=description)


def add_json(to: argparse.ArgumentParser) -> None:
    """``--json``"""
    to.add_argument("--json", action="store_true", help="print JSON and nothing else")


def add_timeout(to: argparse.ArgumentParser, default: float | None, what: str) -> None:
    """``--timeout S``"""
    to.add_argument("--timeout", type=seconds, default=default, metavar="S", help=what)


def seconds(text: str) -> float:
    """A positive number of seconds."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is no positive number of seconds")
    return value
