"""``locations``: what can be changed now, in all nodes or in one."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import Failure, need_ros, options, say, show

if TYPE_CHECKING:
    from rosslt_auto.ros.client import Place
    from rosslt_auto.ros.observer import Observer


def main(words: Sequence[str]) -> int:
    """Prints the locations that nodes own: literals that have reached a message."""
    parser = options.parser("locations", "Lists what can be changed now.")
    parser.add_argument("node", metavar="NODE", nargs="?", help="only of this node")
    options.add_timeout(parser, 5.0, "seconds to look for nodes (default: 5)")
    options.add_json(parser)
    arguments = parser.parse_args(words)
    need_ros()

    from rosslt_auto.ros.observer import Observer

    with Observer("locations") as observer:
        places = _find(observer, arguments.node, arguments.timeout)
    if arguments.json:
        show.print_json([place.to_json() for place in places])
    elif places:
        _print(places)
    else:
        say("no locations: no literal of a node under `run` has reached a message yet")
    return 0


def _find(observer: Observer, node: str | None, timeout: float) -> list[Place]:
    from rosslt_auto.ros.client import NoAnswer, wait_until

    deadline = time.monotonic() + timeout
    if node is not None:
        node = "/" + node.lstrip("/")
        try:
            wait_until(lambda: observer.knows_node(node), deadline, f"there is no node {node}")
            return observer.parameters.places(node, timeout)
        except NoAnswer as error:
            raise Failure(str(error)) from None
    observer.settle(deadline)
    places: list[Place] = []
    for name in sorted(observer.nodes_with_locations()):
        try:
            places += observer.parameters.places(name, timeout)
        except NoAnswer as error:
            say(str(error))
    return places


def _print(places: list[Place]) -> None:
    from rich.text import Text

    from rosslt_auto.provenance.limits import Limits

    console = show.console()
    node = None
    for place in places:
        if place.node != node:
            node = place.node
            console.print(Text(node, style="bold"))
        values: list[Any] = [(repr(place.value), "bold")]
        if place.first != place.value:
            values.append((f"  (in the file: {place.first!r})", "yellow"))
        if place.frozen:
            values.append(("  frozen", "yellow"))
        if place.range is not None:
            values.append((f"  ({Limits(*place.range)})", "dim"))
        console.print(Text.assemble("  ", (place.parameter, "green"), " = ", *values))
        where = show.place(place.file, place.line, place.column)
        console.print(Text.assemble("    ", (where, "magenta"), f"  {place.text}"))
