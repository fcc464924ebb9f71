"""Truth values in messages: fields that remember where their True or False came from.

A field holds plain True or False, so the leaf (`truths.TrackedBool`) is kept beside it: in the
message's slot ``_check_fields``, which generated classes have for a truth value of their own, and
which is replaced by a number with the same truth (`Flags`). Copies of the message copy it.

Join points: the setters of such fields. Which literal a value came from is told by the instruction
of the program that called the setter, see `truth_sites`; code that is not instrumented, and objects
that are no messages, pay nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from sys import _getframe
from types import CodeType, FrameType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.locations import Literals
from ..provenance.registry import registered
from ..provenance.truth_sites import Position, Site
from ..provenance.truths import TrackedBool

SLOT = "_check_fields"

_KNOWN = 4096


class Flags(int):
    """What stands in the slot ``_check_fields``: the truth value that stood there, and leaves.

    leaves  by slot of the message; never changed, copies share it
    """

    leaves: dict[str, TrackedBool]

    def __reduce_ex__(self, protocol: Any) -> Any:
        return bool, (int(self),)

    def __copy__(self) -> Any:
        return self

    def __deepcopy__(self, memo: Any) -> Any:
        return self


def put(message: Any, slot: str, leaf: TrackedBool | None) -> None:
    """Notes where the value in a slot of a message came from; None: it is not known."""
    held = message._check_fields
    if type(held) is Flags:
        leaves = {name: other for name, other in held.leaves.items() if name != slot}
    elif leaf is None:
        return
    else:
        leaves = {}
    if leaf is not None:
        leaves[slot] = leaf
    made = Flags(held)
    made.leaves = leaves
    message._check_fields = made


def replace(message: Any, slot: str, value: Any) -> None:
    """Puts another truth value, tracked or plain, into a field."""
    tracked = type(value) is TrackedBool
    setattr(message, slot, value._v if tracked else value)
    put(message, slot, value if tracked else None)


def leaf_of(message: Any, slot: str) -> TrackedBool | None:
    """Where the value in a slot of a message came from."""
    held = getattr(message, SLOT, None)
    if type(held) is not Flags:
        return None
    leaf = held.leaves.get(slot)
    return leaf if leaf is not None and getattr(message, slot, None) is leaf._v else None


def setter(message_type: Any, name: str, plain: Callable[[Any, Any], None]) -> Callable[..., None]:
    """A setter that does what the plain one does, and notes where the value came from."""
    slot = "_" + name
    store = vars(message_type)[slot].__set__
    constructor = message_type.__init__
    own = getattr(constructor, "__wrapped__", constructor).__code__

    @unseen
    def set_flag(message: Any, value: Any) -> None:
        if value is True or value is False:
            store(message, value)
            _note(message, name, slot, value, own)
        else:
            plain(message, value)
            put(message, slot, None)

    return set_flag


def _note(message: Any, name: str, slot: str, value: bool, own: CodeType) -> None:
    frame = _getframe(1)
    while frame.f_code.co_filename == __file__:  # where frames cannot be hidden
        frame = frame.f_back  # type: ignore[assignment]
    keyword = None
    if frame.f_code is own:  # the constructor
        keyword = name
        frame = frame.f_back  # type: ignore[assignment]
        if frame is None:
            return
    code = frame.f_code
    known = _sites.get(id(code)) or _learn(code)
    leaf = None
    if known.by_offset:
        site = known.by_offset.get((frame.f_lasti, keyword))
        if site is not None:
            leaf = _origin(known.literals, site, frame, value)
    put(message, slot, leaf)


# ---------------------------------------------------------------- sites


class _Sites:
    """The sites of a code object by the offset of their instruction and their keyword."""

    __slots__ = ("by_offset", "code", "literals")

    def __init__(
        self, code: CodeType, literals: Any, by_offset: dict[tuple[int, str | None], Site]
    ) -> None:
        self.code = code  # kept, so that its id is no other's
        self.literals = literals
        self.by_offset = by_offset


_sites: dict[int, _Sites] = {}
"""By the id of a code object: hashing one takes long."""


def _learn(code: CodeType) -> _Sites:
    if len(_sites) >= _KNOWN:
        _sites.clear()
    made = _Sites(code, None, {})
    for literals in registered():
        if literals.file == code.co_filename:
            by_offset = _by_offset(code, literals)
            if by_offset:
                made = _Sites(code, literals, by_offset)
    _sites[id(code)] = made
    return made


def _by_offset(code: CodeType, literals: Literals) -> dict[tuple[int, str | None], Site]:
    by_position: dict[Position, list[Site]] = {}
    for site in literals.truth_sites.sites:
        by_position.setdefault(site.position, []).append(site)
    found = {}
    for index, (line, end_line, column, end_column) in enumerate(code.co_positions()):
        position: Any = (line, column, end_line, end_column)
        for site in by_position.get(position, ()):
            found[2 * index, site.keyword] = site
    return found


def _origin(literals: Literals, site: Site, frame: FrameType, value: bool) -> TrackedBool | None:
    if site.path:
        return _field_at(site.path, frame, value)
    leaves = []
    for place in site.literals:
        index = literals.index_at(place)
        if index is None:
            return None
        leaves.append((index, literals.location(index).value))
    if len(leaves) > 1:  # the one that has this value
        leaves = [leaf for leaf in leaves if leaf[1] is value]
    return literals.truth(leaves[0][0], value) if len(leaves) == 1 else None


def _field_at(path: tuple[str, ...], frame: FrameType, value: bool) -> TrackedBool | None:
    """The leaf of a field of another message, found without calling anything of the program."""
    first, *rest, last = path
    names = frame.f_locals
    held = names[first] if first in names else frame.f_globals.get(first)
    for name in rest:
        if hasattr(type(held), "_fields_and_field_types"):
            held = getattr(held, "_" + name, None)
        else:
            held = getattr(held, "__dict__", {}).get(name)
    if not hasattr(type(held), "_fields_and_field_types"):
        return None
    leaf = leaf_of(held, "_" + last)
    return leaf if leaf is not None and leaf._v is value else None


__all__ = ["SLOT", "Flags", "leaf_of", "put", "replace", "setter"]
