"""For programs under test: notes whether a value is tracked, without printing it."""

from typing import Any


def note(label: str, value: Any) -> None:
    """Leaves an empty file ``<label>.tracked`` or ``<label>.plain`` in the current folder."""
    kind = "plain" if type(type(value)) is type else "tracked"
    open(f"{label}.{kind}", "w").close()
