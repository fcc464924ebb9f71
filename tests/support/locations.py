"""Finding what can be changed by where it stands in the source."""

from pathlib import Path

from support.observer import Observer
from support.waiting import wait_until


def line_of(file: Path, text: str) -> int:
    """The number of the only line of a file in which `text` stands."""
    lines = file.read_text().splitlines()
    [number] = [number for number, line in enumerate(lines, start=1) if text in line]
    return number


def literal_parameter(observer: Observer, node: str, file: Path, text: str) -> str:
    """The parameter of the first literal of the line in which `text` stands.

    Waits until it is declared, which it is when it first reaches a published message.
    """
    place = f"{file}:{line_of(file, text)}:"

    def find() -> str | None:
        names = observer.list_parameters(node, "rosslt")
        columns = {}
        for name in names:
            description = observer.describe(node, name).description
            if description.startswith(place):
                columns[int(description.removeprefix(place).split()[0])] = name
        return columns[min(columns)] if columns else None

    return wait_until(find, f"a parameter of {node} for {text!r}", interval=0.05)
