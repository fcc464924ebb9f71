"""``force``: fields of a topic's messages get new values where they come from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from . import Failure, need_ros, options, say, show

POLICIES = ("left", "least-change")


def main(words: Sequence[str]) -> int:
    """Forces the fields; status 0 when a message has shown it."""
    parser = options.parser(
        "force",
        "Makes fields of the next messages have these values by changing their sources, together.",
    )
    parser.add_argument("topic", metavar="TOPIC", nargs="?")
    parser.add_argument("targets", metavar="PATH=VALUE", nargs="*", help="such as data=14")
    parser.add_argument(
        "--undo", action="store_true", help="take the latest force back; again for the one before"
    )
    parser.add_argument(
        "--policy", choices=POLICIES, default="left", help="which sources to change (default: left)"
    )
    parser.add_argument("--source", metavar="PARAMETER", help="change only this one")
    parser.add_argument("--dry-run", action="store_true", help="only say what would change")
    options.add_timeout(parser, 5.0, "seconds to wait for a message (default: 5)")
    options.add_json(parser)
    arguments = parser.parse_args(words)
    if arguments.undo:
        if arguments.topic is not None:
            parser.error("--undo takes back whatever was forced last: no TOPIC")
        need_ros()
        return _undo(arguments)
    if not arguments.targets:
        parser.error("the following arguments are required: TOPIC PATH=VALUE")
    targets: dict[str, str] = {}
    for target in arguments.targets:
        path, equals, value = target.partition("=")
        if not (path and equals and value):
            parser.error(f"{target!r} is not PATH=VALUE")
        if path in targets:
            parser.error(f"{path} is given twice")
        targets[path] = value
    need_ros()
    return _force(arguments, targets)


def _force(arguments: Any, targets: dict[str, str]) -> int:
    from rosslt_auto.ros.client import ChangeRefused, NoAnswer
    from rosslt_auto.ros.forcing import CannotForce, Forced, force
    from rosslt_auto.ros.observer import CannotObserve, Observer

    with Observer("force") as observer:
        try:
            result = force(
                observer,
                arguments.topic,
                targets,
                policy=arguments.policy,
                source=arguments.source,
                dry_run=arguments.dry_run,
                timeout=arguments.timeout,
            )
        except (CannotObserve, CannotForce, ChangeRefused, NoAnswer) as error:
            if not arguments.json:
                raise Failure(str(error)) from None
            result = Forced(arguments.topic, arguments.dry_run, reason=str(error))
    if arguments.json:
        show.print_json(result.to_json())
    else:
        _print(result)
    if result.reason is not None:
        say(result.reason)
        return 1
    return 0


def _undo(arguments: Any) -> int:
    from rosslt_auto.ros.client import ChangeRefused, NoAnswer
    from rosslt_auto.ros.forcing import undo
    from rosslt_auto.ros.observer import Observer

    changes: list[Any] = []
    left: list[str] = []
    with Observer("force") as observer:
        try:
            changes, left = undo(observer, arguments.timeout)
            reason = "; ".join(left) or None
            if not changes and reason is None:
                reason = "nothing has been forced in this domain that could be taken back"
        except (ChangeRefused, NoAnswer) as error:
            reason = str(error)
    if arguments.json:
        document: dict[str, Any] = {"changes": [change.to_json() for change in changes]}
        show.print_json(document if reason is None else {**document, "reason": reason})
    else:
        _print_changes("changed back", changes)
    if reason is not None:
        say(reason)
        return 1
    return 0


def _print_changes(verb: str, changes: Sequence[Any]) -> None:
    from rich.text import Text

    console = show.console()
    for change in changes:
        console.print(
            Text.assemble(
                f"{verb} ", (change.parameter, "green"), (f" of {change.node}", "dim"),
                f": {change.old!r} -> ", (repr(change.new), "bold"),
            )
        )  # fmt: skip


def _print(result: Any) -> None:
    from rich.text import Text

    console = show.console()
    verb = "would change" if result.dry_run else "changed"
    if not result.changes and result.reason is None:
        console.print("nothing to change")
    _print_changes(verb, result.changes)
    for path, entries in result.alternatives.items():
        for entry in entries:
            answer = entry.get("reason") or f"-> {entry['new']!r}"
            console.print(f"  {path}: {entry['parameter']} alone {answer}", style="dim")
    for policy, answer in result.policies.items():
        changes = [f"{one['parameter']} -> {one['new']!r}" for one in answer.get("changes", ())]
        told = answer.get("reason") or ", ".join(changes) or "nothing to change"
        console.print(f"  --policy {policy}: {told}", style="dim", highlight=False)
    if result.reached:
        for path, entry in result.fields.items():
            moving = f"  (moves by itself, was to be {entry['target']!r})"
            console.print(
                Text.assemble(
                    result.topic, "  ", (path, "cyan"), f" = {entry['value']!r}",
                    (moving if entry.get("moving") else "", "dim"),
                )
            )  # fmt: skip
