"""``echo``: messages with the provenance of their tracked fields."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from . import Failure, need_ros, options, show

TOPIC_TIMEOUT = 5.0
"""Seconds for a topic to appear, unless told otherwise."""


def main(words: Sequence[str]) -> int:
    """Prints messages until interrupted, or one with --once."""
    parser = options.parser("echo", "Prints messages with the provenance of their tracked fields.")
    parser.add_argument("topic", metavar="TOPIC")
    parser.add_argument("--field", metavar="PATH", help="only this field, or those below it")
    parser.add_argument("--once", action="store_true", help="only one message")
    options.add_timeout(parser, None, "give up when no message comes for so many seconds")
    options.add_json(parser)
    arguments = parser.parse_args(words)
    need_ros()

    from rosslt_auto.ros import paths
    from rosslt_auto.ros.client import NoAnswer
    from rosslt_auto.ros.observer import CannotObserve, Observer

    with Observer("echo") as observer:
        try:
            deadline = time.monotonic() + (arguments.timeout or TOPIC_TIMEOUT)
            subscription = observer.subscribe(arguments.topic, deadline=deadline)
            if arguments.field is not None:
                arguments.field = paths.normal(arguments.field)
                paths.field_type(subscription.message_type, arguments.field)
            print_one = _print_json if arguments.json else _Printer()
            while True:
                if arguments.timeout is not None:
                    deadline = time.monotonic() + arguments.timeout
                message = subscription.next(None if arguments.timeout is None else deadline)
                if arguments.field is not None:
                    paths.get(message.message, arguments.field)
                fields = _selected(message.fields, arguments.field)
                print_one(subscription.topic, subscription.type_name, fields)
                if arguments.once:
                    return 0
        except (CannotObserve, NoAnswer, paths.FieldError) as error:
            raise Failure(str(error)) from None


def _selected(fields: dict[str, Any], path: str | None) -> dict[str, Any]:
    if path is None:
        return fields
    return {
        name: value
        for name, value in fields.items()
        if name == path or name.startswith((f"{path}.", f"{path}["))
    }


def _print_json(topic: str, type_name: str, fields: dict[str, Any]) -> None:
    show.print_json(
        {
            "topic": topic,
            "type": type_name,
            "fields": {path: show.field_to_json(value) for path, value in fields.items()},
        }
    )


class _Printer:
    """Messages for people."""

    def __init__(self) -> None:
        self.console = show.console()

    def __call__(self, topic: str, type_name: str, fields: dict[str, Any]) -> None:
        from rich.text import Text

        lines = [Text.assemble((topic, "bold"), f"  {type_name}")]
        if not fields:
            lines.append(Text("  no provenance", style="dim"))
        for path, value in fields.items():
            shown = show.field_to_json(value)
            lines.append(
                Text.assemble(
                    "  ", (path, "cyan"), " = ", (repr(shown["value"]), "bold"),
                    ("  = ", "dim"), shown["expression"],
                )
            )  # fmt: skip
            lines.extend(_source_line(*pair) for pair in show.sources_with_values(value))
        for line in lines:
            self.console.print(line)
        self.console.file.flush()


def _source_line(source: Any, value: Any) -> Any:
    from rich.text import Text

    where = show.place(source.file, source.line, source.column) or source.parameter
    return Text.assemble(
        "    ", (source.hint, "green"), f" = {value!r}  ", (where, "magenta"),
        f"  {source.text or ''}", (f"  ({source.node})", "dim"),
    )  # fmt: skip
