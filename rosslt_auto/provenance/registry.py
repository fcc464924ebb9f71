"""What this process has sources of, by name: the literals of all instrumented modules, and others.

Values that are given at start wait here for the literals that are going to have them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .locations import LiteralInfo, Literals, Location
from .sources import SourceChangeRefused

_tables: dict[str, Literals] = {}
_others: dict[str, Any] = {}
_initial: dict[str, Any] = {}
_refused: list[Callable[[str], None]] = []
_counting: list[bool] = []
"""Whether executions are counted: empty, or not."""


def register_literals(
    name: str,
    module: str,
    file: str,
    values: tuple[Any, ...],
    describe: Callable[[], list[LiteralInfo]],
    publish: Callable[[list[Any]], None],
    source: bytes | None = None,
) -> Literals:
    """Makes the table of a module's literals.

    name      unique for the file, its content and the module; the same one again (a reload) gives
              the same table, with the values that it has now
    describe  gives a LiteralInfo per value, asked for when the first location is needed
    publish   is given the list that the rewritten code has to read; may be called again later
    source    the content of the file
    """
    found = _tables.get(name)
    if found is None:
        found = Literals(name, module, file, values, describe, publish, source)
        _tables[name] = found
        if _initial:
            _apply_initial(found)
        if _counting:
            found.start_counting()
        else:
            publish(found.table)
    else:
        found.publish_as(name, publish)
    return found


def count_executions() -> None:
    """From now on it is seen which literals are executed again and again.

    Called when the first node is made. What a program does before, importing modules and computing
    their constants, happens once, and should take no longer than it does without us.
    """
    if not _counting:
        _counting.append(True)
        for literals in list(_tables.values()):
            literals.start_counting()


def registered() -> list[Literals]:
    """The literals of all modules that have a table, in the order of their loading."""
    return list(_tables.values())


def rename(literals: Literals, name: str) -> None:
    """Makes a table one that will be found by this name, unless there is another one."""
    if name not in _tables and _tables.get(literals.name) is literals:
        _tables[name] = _tables.pop(literals.name)
        literals.name = name


def set_initial_values(values: Mapping[str, Any], refused: Callable[[str], None]) -> None:
    """Values by parameter name for literals that will be registered later (`-p` at start).

    `refused` is told why a literal cannot have the value that was given for it.
    """
    _initial.update(values)
    _refused[:] = [refused]


def _tell(refusal: SourceChangeRefused) -> None:
    for tell in _refused:
        tell(str(refusal))


def _apply_initial(literals: Literals) -> None:
    if not any(name.startswith("rosslt.") for name in _initial):
        return
    for index, info in enumerate(literals.infos):
        if info.parameter in _initial:
            location = literals.location(index)
            try:
                value = location.check(_initial[info.parameter])
            except SourceChangeRefused as refusal:
                _tell(refusal)
            else:
                location.change(value)
                location.given = True


def register_source(source: Any) -> None:
    """Makes a source of this process that is no literal (`external.LocalSource`) known by name.

    It takes the value that was given for it at start, if there is one.
    """
    _others[source.parameter] = source
    if source.parameter in _initial:
        try:
            source.start_with(source.check(_initial[source.parameter]))
        except SourceChangeRefused as refusal:
            _tell(refusal)


def free_name(wanted: str) -> str:
    """`wanted` as a parameter name, made different where it is taken.

    No name may be the dotted prefix of another one.
    """
    taken = [*_others]
    for literals in list(_tables.values()):
        taken += [info.parameter for info in literals.infos]
    name, number = wanted, 1
    while True:
        clash = next((other for other in taken if _clash(name, other)), None)
        if clash is None:
            return name
        number += 1
        # A literal called like a part of the name: that part is what has to give way.
        behind = wanted[len(clash) :] if wanted.startswith(f"{clash}.") else ""
        name = f"{wanted.removesuffix(behind) if behind else wanted}_{number}{behind}"


def _clash(name: str, other: str) -> bool:
    return name == other or name.startswith(f"{other}.") or other.startswith(f"{name}.")


def instrumented_files() -> set[str]:
    """The files of all modules that have a table."""
    return {literals.file for literals in _tables.values()}


def instrumented_modules() -> set[str]:
    """The names of all modules that have a table."""
    return {literals.module for literals in _tables.values()}


def location_of(parameter: str) -> Any:
    """The location in this process that has this parameter name, None if there is none.

    A `Location`, the latest if there are several, or an `external.LocalSource`.
    """
    other = _others.get(parameter)
    if other is not None:
        return other
    for literals in reversed(list(_tables.values())):
        for index, info in enumerate(literals.infos):
            if info.parameter == parameter:
                return literals.location(index)
    return None


def changed_locations() -> list[Location]:
    """Locations whose value is no longer the one in the source file."""
    return [
        location
        for literals in list(_tables.values())
        for location in literals.known_locations()
        if location.value != location.first
    ]
