"""Literals of this process, the locations that values come from.

`create_location` of the paper (Section IV-A): the first time control flow reaches a literal, it
gets its value from a parameter, and from then on it can be changed at run time. Here every
instrumented module has a table - a plain list, because reading it must cost one subscript - whose
entries are the literals' current values, each a leaf of the expression graph.
"""

from __future__ import annotations

import ast
import linecache
import os
import zlib
from collections.abc import Callable, Iterable, Iterator
from importlib.util import decode_source
from typing import Any, NamedTuple

from .limits import Limits
from .operators import LITERAL, SOURCE
from .sources import Source
from .truth_sites import Bound, TruthSites
from .truths import truth_leaf
from .values import literal_leaf, settle


class LiteralInfo(NamedTuple):
    """What the rewriter knows of a literal.

    parameter     full parameter name (contract: Locations and parameters)
    hint          the name it is shown by
    named         bound to a name, not just an operand
    line, column  from 1 and from 0, as in Python's ast; likewise end_line, end_column
    repeated      whether it stands in a loop, None if that depends on how its function is called
    limits, frozen  what its remark says: (low, high, step), and whether nobody may change it
    """

    parameter: str
    hint: str
    named: bool
    line: int
    column: int
    end_line: int
    end_column: int
    repeated: bool | None = None
    limits: tuple[Any, ...] | None = None
    frozen: bool = False


class Location(Source):
    """A literal of this process.

    first     the value that stands in the source file
    given     whether it got another value at start, before its first use
    leaf      the current leaf, which is what the program gets from now on
    """

    def __init__(self, literals: Literals, index: int, info: LiteralInfo) -> None:
        value = literals.values[index]
        super().__init__(
            None, info.parameter, type(value).__name__, info.hint, info.named,
            literals.file, info.line, info.column,
        )  # fmt: skip
        self.literals = literals
        self.index = index
        self.info = info
        self.limits = Limits(*info.limits) if info.limits is not None else None
        self.frozen = info.frozen
        self.first = value
        self.given = False

    # Two literals are never the same location, whatever their names.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def text(self) -> str:
        return self.literals.line(self.info.line)

    @text.setter
    def text(self, value: str | None) -> None:
        pass

    @property
    def leaf(self) -> Any:
        # Not counted as an execution, see `_CountingTable`.
        held = list.__getitem__(self.literals.table, self.index)
        return self.literals.truth(self.index, held) if type(held) is bool else held

    @property
    def value(self) -> Any:
        return self.leaf._v

    @property
    def repeated(self) -> bool:  # type: ignore[override]
        """Whether the program executes this literal again and again (design 3.2)."""
        if self.info.repeated is not None:
            return self.info.repeated
        return self.literals.executions(self.index) > 1

    def change(self, value: Any) -> None:
        """Gives the literal a value that `check` has passed, from its next execution on."""
        self.literals.table[self.index] = literal_leaf(self.literals, self.index, value)


class _CountingTable(list):
    """The table of a module in a node's first moments: counts how often each literal is executed.

    Whether a literal is executed once or again and again decides what its change does to values
    computed before (`refresh`). That shows soon; then a plain list takes over and costs nothing.
    """

    LOOK_UPS = 20_000

    def __init__(self, leaves: Iterable[Any], done: Callable[[], None]) -> None:
        super().__init__(leaves)
        self.counts = [0] * len(self)
        self.total = 0
        self.done = done

    def __getitem__(self, index: int) -> Any:  # type: ignore[override]
        self.counts[index] += 1
        self.total += 1
        if self.total > self.LOOK_UPS:
            self.done()
        return list.__getitem__(self, index)


class Literals:
    """All literals of one loaded module.

    name     of its table
    source   what was loaded, None if nobody said so; `content` is its fingerprint
    loaded   the same, even if the file has been saved with other values since
    """

    def __init__(
        self,
        name: str,
        module: str,
        file: str,
        values: tuple[Any, ...],
        describe: Callable[[], list[LiteralInfo]],
        publish: Callable[[list[Any]], None],
        source: bytes | None = None,
    ) -> None:
        self.name = name
        self.module = module
        self.file = file
        self.values = values
        self.describe = describe
        self.source = self.loaded = source
        self._content: str | None = None
        self._lines: list[str] | None = None
        self._publishers = {name: publish}
        self.table: list[Any] = [literal_leaf(self, i, value) for i, value in enumerate(values)]
        self.counts: list[int] | None = None
        self._infos: list[LiteralInfo] | None = None
        self._locations: dict[int, Location] = {}
        self._truths: dict[tuple[int, bool], Any] = {}
        self._sites: TruthSites | None = None
        self._indices: dict[tuple[int, int], int] | None = None

    @property
    def content(self) -> str | None:
        if self._content is None and self.source is not None:
            self._content = fingerprint(self.file, self.source)
        return self._content

    def line(self, number: int) -> str:
        """A line of the source as it was loaded, whatever the file has now."""
        if self.source is None:
            return linecache.getline(self.file, number).strip()
        if self._lines is None:
            try:
                self._lines = decode_source(self.source).split("\n")
            except (SyntaxError, UnicodeError):
                self._lines = []
        return self._lines[number - 1].strip() if 0 < number <= len(self._lines) else ""

    def publish(self, table: list[Any]) -> None:
        """Gives the table to the code that reads it."""
        for publish in list(self._publishers.values()):
            publish(table)

    def publish_as(self, name: str, publish: Callable[[list[Any]], None]) -> None:
        """The same for code that reads it by this name, from now on."""
        self._publishers[name] = publish
        publish(self.table)

    def publish_no_more(self, name: str) -> None:
        """The code that reads the table by this name is gone."""
        self._publishers.pop(name, None)

    def now_in(self, source: bytes, infos: list[LiteralInfo], values: tuple[Any, ...]) -> None:
        """Notes that the file has other values at other places now, see `saved`."""
        self.source, self._content, self._lines = source, None, None
        self._infos, self.values = infos, values
        for index, location in list(self._locations.items()):
            location.info = infos[index]
            location.line, location.column = location.info.line, location.info.column
            location.first = values[index]
            location.moves += 1

    def start_counting(self) -> None:
        """Counts executions until enough are known."""
        counting = _CountingTable(self.table, self._stop_counting)
        self.table = counting
        self.counts = counting.counts
        self.publish(counting)

    def _stop_counting(self) -> None:
        if type(self.table) is not list:
            self.table = list.copy(self.table)
            self.publish(self.table)

    def executions(self, index: int) -> int:
        """How often the literal was seen to be executed; not more than the first few times."""
        return self.counts[index] if self.counts else 0

    @property
    def infos(self) -> list[LiteralInfo]:
        if self._infos is None:
            self._infos = list(self.describe())
        return self._infos

    def location(self, index: int) -> Location:
        found = self._locations.get(index)
        if found is None:
            found = self._locations.setdefault(index, Location(self, index, self.infos[index]))
        return found

    def truth(self, index: int, value: bool) -> Any:
        """The leaf of a truth value; the table has the plain value, which the program gets."""
        key = index, value
        found = self._truths.get(key)
        if found is None:
            found = self._truths.setdefault(key, truth_leaf(value, LITERAL, self, index))
        return found

    def bound(self, index: int) -> Bound | None:
        """What the truth value at an index is bound to, if that is known."""
        for place, bound in self.truth_sites.bound.items():
            if self.index_at(place) == index:
                return bound
        return None

    def index_at(self, place: tuple[int, int]) -> int | None:
        """The index of the literal that stood at a (line, column) when the module was loaded."""
        if self._indices is None:
            self._indices = {(i.line, i.column): at for at, i in enumerate(self.describe())}
        return self._indices.get(place)

    @property
    def truth_sites(self) -> TruthSites:
        """Where truth values of the module get into messages."""
        if self._sites is None:
            try:
                tree = ast.parse(self.loaded or b"")
            except (SyntaxError, ValueError, RecursionError):
                tree = ast.Module([], [])
            self._sites = TruthSites(tree)
        return self._sites

    def known_locations(self) -> Iterator[Location]:
        yield from list(self._locations.values())


def fingerprint(path: str, source: bytes) -> str:
    """What tells a source file from all others, and from itself after an edit."""
    return f"{zlib.crc32(source, zlib.crc32(os.fsencode(path))):08x}"


def source_of(node: Any) -> Source:
    """The source of a leaf."""
    settle(node)
    if node._op is LITERAL:
        return node._a.location(node._b)
    if node._op is SOURCE:
        return node._a
    raise TypeError("not a leaf")
