"""Numbers and texts of YAML and JSON files as sources: where in the file each one stands.

A program loads a file with the plain function; `track` then puts leaves in place of the scalars of
what it got, as far as they are certainly those of the file. Changing one rewrites its range of
the file and nothing else, and only while the file is the one that was loaded.
"""

from __future__ import annotations

import bisect
import codecs
import itertools
import logging
import os
import re
import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from types import FrameType
from typing import Any

from . import file_positions
from .external import LocalSource
from .file_positions import Scalar
from .registry import free_name, register_source
from .source_files import Edit, NotWritten, SourceFile
from .sources import SourceChangeRefused
from .spelling import CannotSpell, respell_json, respell_yaml, same
from .tokens import module_prefix, token
from .values import leaf

LIMIT = 256 * 1024
SCALARS = 4096
"""Files of more bytes or scalars are data, not settings: tracking them would take too long."""

Keys = tuple[Any, ...]
"""How a value is reached in what was loaded: keys of dicts and indices of lists."""

_log = logging.getLogger(__name__)
_lock = threading.RLock()
_documents: dict[tuple[str, str], Document] = {}
_CONTAINERS = (dict, list, OrderedDict)


class FileLocation(LocalSource):
    """A scalar of a file that the program has loaded.

    document  the file
    keys      how it is reached
    range     offsets of its characters in the file's text
    """

    def __init__(self, document: Document, keys: Keys, scalar: Scalar, parameter: str) -> None:
        super().__init__(parameter, scalar.value, _hint(keys), document.source.path)
        self.document = document
        self.keys = keys
        self.scalar: Scalar | None = scalar
        self.written = scalar.value
        self.place()

    def place(self) -> None:
        """Notes where it stands now."""
        if self.scalar is not None:
            self.line, self.column = self.document.source.position(self.scalar.start)
            self.text = self.document.source.line(self.line)

    def found_again(self, scalar: Scalar) -> None:
        """The file has been read again; if it has another value now, so has the location."""
        self.scalar = scalar
        if not same(self.written, scalar.value):
            self.written_as(scalar.value)

    def written_as(self, value: Any) -> None:
        """Notes what the file has now."""
        assert self.scalar is not None
        self.written = self.scalar.value = value
        self.leaf = leaf(self, value)

    @property
    def range(self) -> tuple[int, int] | None:
        """None if the file does not have it any more."""
        return (self.scalar.start, self.scalar.end) if self.scalar is not None else None

    @property
    def group(self) -> Document:
        return self.document

    def check(self, value: Any) -> Any:
        """Also raises SourceChangeRefused if the file is not what was loaded any more."""
        value = super().check(value)
        self.document.verify(self, value)
        return value

    def change(self, value: Any) -> None:
        self.document.change({self: value})

    def change_together(self, changes: Mapping[Any, Any]) -> None:
        self.document.change(changes)

    def start_with(self, value: Any) -> None:
        """Only the program gets it: nobody has asked to change the file."""
        self.leaf = leaf(self, value)


class Document:
    """A YAML or JSON file as it was when it was last loaded or changed here."""

    def __init__(self, language: str, source: SourceFile, prefix: str) -> None:
        self.language = language
        self.source = source
        self.prefix = prefix
        self.loader: Any = None
        self.locations: dict[Keys, FileLocation] = {}
        self._root: file_positions.Node = None
        self._read = False
        self._edited = False
        self._by_scalar: dict[int, FileLocation] = {}

    def read(self, source: SourceFile, loader: Any) -> None:
        """Notes where everything stands in the file as it is now.

        Raises what the language's parser raises.
        """
        known = self.source.content, self.source.encoding, self.loader
        if self._read and known == (source.content, source.encoding, loader):
            return
        self._edited = self._read
        if self.language == "json":
            root = file_positions.json_positions(source.text)
        else:
            root = file_positions.yaml_positions(source.text, loader)
        if len(file_positions.scalars(root)) > SCALARS:
            root = None
        self.source, self.loader, self._root = source, loader, root
        self._read = True
        self._by_scalar = {}
        for location in self.locations.values():
            location.scalar = None

    # ------------------------------------------------------------ what the program gets

    def tracked(self, value: Any) -> Any:
        """What was loaded, with leaves in place of the file's scalars; containers stay the same."""
        read: dict[int, FileLocation] = {}
        if type(value) not in _CONTAINERS:
            value = self._leaf(self._root, value, (), (), read)
        stack: list[tuple[Any, Any, Keys, tuple[str, ...]]] = [(self._root, value, (), ())]
        seen: set[int] = set()
        while stack:
            node, container, keys, tokens = stack.pop()
            if id(container) in seen:
                continue
            seen.add(id(container))
            for key, item, below, name in _items(node, container):
                where, names = (*keys, key), (*tokens, name)
                if type(item) in _CONTAINERS:
                    stack.append((below, item, where, names))
                else:
                    container[key] = self._leaf(below, item, where, names, read)
        for location in read.values():
            location.reads += 1
        return value

    def _leaf(
        self, node: Any, value: Any, keys: Keys, tokens: tuple[str, ...], read: dict[int, Any]
    ) -> Any:  # fmt: skip
        """The leaf for a scalar that was loaded, or `value` if it is not certainly this one."""
        if not isinstance(node, Scalar) or not same(value, node.value):
            return value
        location = self._by_scalar.get(id(node)) or self._location(node, keys, tokens)
        if location is None:
            return value
        read[id(location)] = location
        return location.leaf

    def _location(self, scalar: Scalar, keys: Keys, tokens: tuple[str, ...]) -> Any:
        """The location of a scalar: the one that was reached by the same keys before, or new."""
        known = self.locations.get(keys)
        if known is not None and known.kind == type(scalar.value).__name__:
            known.found_again(scalar)
            known.place()
        else:
            if not LocalSource.can_be(scalar.value):
                return None
            if known is not None:
                parameter = known.parameter
            else:
                parameter = ".".join((self.prefix, *tokens))
                if self._edited:
                    parameter = free_name(parameter)
            known = self.locations[keys] = FileLocation(self, keys, scalar, parameter)
            register_source(known)
        self._by_scalar[id(scalar)] = known
        return known

    # ------------------------------------------------------------ changes

    def verify(self, location: FileLocation, value: Any) -> None:
        """Raises SourceChangeRefused if `value` cannot be written now."""
        try:
            self._edit(location, value)
            self.source.verify()
        except (CannotSpell, NotWritten) as error:
            raise SourceChangeRefused(f"{location.parameter}: {error}") from None

    def change(self, changes: Mapping[FileLocation, Any]) -> None:
        """Writes values that `verify` has passed into the file, in one step.

        Raises SourceChangeRefused, the file untouched.
        """
        with _lock:
            try:
                edits = {one: self._edit(one, value) for one, value in changes.items()}
                self.source = self.source.write(edits.values())
            except (CannotSpell, NotWritten) as error:
                names = ", ".join(location.parameter for location in changes)
                raise SourceChangeRefused(f"{names}: {error}") from None
            self._move(list(edits.values()))
            for location, value in changes.items():
                location.written_as(value)
            for location in self.locations.values():
                location.place()

    def _edit(self, location: FileLocation, value: Any) -> Edit:
        scalar = location.scalar
        if scalar is None:
            raise NotWritten(f"{self.source.path} does not have it any more")
        text = self.source.text[scalar.start : scalar.end]
        encoding = self.source.encoding
        if self.language == "json":
            new = respell_json(text, scalar.value, value, encoding=encoding)
        else:
            new = respell_yaml(text, scalar.value, value, loader=self.loader, encoding=encoding)
        return Edit(scalar.start, scalar.end, new)

    def _move(self, edits: list[Edit]) -> None:
        """After edits: where all scalars stand now."""
        edits.sort()
        ends = [edit.end for edit in edits]
        grown = list(
            itertools.accumulate((len(e.text) - (e.end - e.start) for e in edits), initial=0)
        )
        for scalar in file_positions.scalars(self._root):
            before = grown[bisect.bisect_right(ends, scalar.start)]
            scalar.end += grown[bisect.bisect_right(ends, scalar.end)]
            scalar.start += before


def _items(node: Any, container: Any) -> Iterator[tuple[Any, Any, Any, str]]:
    """Key or index, value, position and token of what is in both of them."""
    if isinstance(node, file_positions.Mapping) and type(container) in (dict, OrderedDict):
        taken: set[str] = set()
        for key, below in node.items.items():
            name = _token(str(key), taken)
            if key in container:
                yield key, container[key], below, name
    elif isinstance(node, file_positions.Sequence) and type(container) is list:
        pairs = zip(container, node.items, strict=False)
        for index, (item, below) in enumerate(pairs if len(container) == len(node.items) else ()):
            yield index, item, below, f"_{index}"


def _token(key: str, taken: set[str]) -> str:
    wanted = name = token(key)
    number = 1
    while name in taken:
        number += 1
        name = f"{wanted}_{number}"
    taken.add(name)
    return name


def _hint(keys: Keys) -> str | None:
    """The last key that says something, with the indices behind it: ``gains[0]``."""
    hint = ""
    for key in reversed(keys):
        if not isinstance(key, int):
            return f"{key}{hint}"
        hint = f"[{key}]{hint}"
    return hint or None


def track(
    value: Any, path: str, content: bytes, encoding: str, language: str, frame: FrameType,
    loader: Any = None, text: str | None = None,
) -> Any:  # fmt: skip
    """`value`, loaded from a file, with leaves in place of what certainly stands in the file.

    path, content, encoding  the file as it is now
    language                 "json" or "yaml"
    frame                    of the code that has loaded it; its module gives the names
    loader                   the class of loader that was used, for YAML
    text                     what was loaded; None if it was the file itself

    Raises nothing: where it is not clear, `value` stays as it is.
    """
    if len(content) > LIMIT:
        _log.debug("%s is too large to be tracked", path)
        return value
    try:
        if content.startswith(codecs.BOM_UTF8) and codecs.lookup(encoding).name == "utf-8":
            encoding = "utf-8-sig"  # parsers do not agree on whether a mark counts
        source = SourceFile(path, content, encoding)
        if text is not None and text.removeprefix("\ufeff") not in _as_read(source.text):
            return value
        with _lock:
            return _document(source, language, frame, loader).tracked(value)
    except Exception:
        _log.debug("%s is not tracked", path, exc_info=True)
        return value


def _as_read(text: str) -> tuple[str, str]:
    """A file's text as programs read it: with its line ends as they are, and with Python's."""
    return text, re.sub("\r\n?", "\n", text)


def _document(source: SourceFile, language: str, frame: FrameType, loader: Any) -> Document:
    key = (os.path.realpath(source.path), language)
    document = _documents.get(key)
    if document is None:
        stem = os.path.splitext(os.path.basename(source.path))[0]
        document = Document(language, source, free_name(f"{module_prefix(frame)}.{token(stem)}"))
    document.read(source, loader)
    _documents[key] = document
    return document
