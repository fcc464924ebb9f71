"""``save``: current values of changed literals go into the files that the literals came from."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

from . import Failure, need_ros, options, say


def main(words: Sequence[str]) -> int:
    """Writes files, or prints the diff; status 1 if something that changed could not be saved."""
    parser = options.parser(
        "save", "Writes current values of changed literals into the source files they came from."
    )
    parser.add_argument("nodes", metavar="NODE", nargs="*", help="only of these nodes")
    parser.add_argument(
        "--diff", action="store_true", help="only print what would change, as a unified diff"
    )
    options.add_timeout(parser, 5.0, "seconds to look for nodes (default: 5)")
    arguments = parser.parse_args(words)
    need_ros()

    from rosslt_auto.ros import saving
    from rosslt_auto.ros.observer import Observer

    with Observer("save") as observer:
        nodes = _find(observer, arguments.nodes, arguments.timeout)
        saver = saving.Saver(observer)
        places = saver.places(arguments.timeout, say)
        silent = [node for node in nodes if node not in {place.node for place in places}]
        plan = saving.prepare(saving.selected(places, nodes) if nodes else places)
        for node in silent:
            say(f"{node} has no locations")
        for place in plan.given:
            say(saving.where_given(place))
        if arguments.diff:
            sys.stdout.write(plan.diff())
            refused = plan.refused
        else:
            report = saver.write(plan, places)
            for literal in report.literals:
                print(literal)
            for node in report.untold:
                say(f"{node} has not taken notice: until it is started again, it shows old values")
            refused = report.refused
    for reason in refused:
        say(f"not saved: {reason}")
    if not (plan.files or plan.refused or plan.given):
        say("nothing to save: no literal has another value than its file")
    return 1 if refused else 0


def _find(observer: Any, names: Sequence[str], timeout: float) -> list[str]:
    """The full names of these nodes, once they and all others are known. Raises Failure."""
    from rosslt_auto.ros.client import NoAnswer, wait_until

    deadline = time.monotonic() + timeout
    nodes = ["/" + name.lstrip("/") for name in names]
    for node in nodes:
        try:
            wait_until(lambda node=node: observer.knows_node(node), deadline, node)  # type: ignore[misc]
        except NoAnswer:
            raise Failure(f"there is no node {node}") from None
    observer.settle(deadline)
    return nodes
