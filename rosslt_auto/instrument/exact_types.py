"""Functions of the standard library that ask for exact types get plain values.

Nearly everything written in C takes a subclass of float, int or str like the plain one. The few
functions that refuse one would fail under us, whoever calls them: nothing can be seen of that in
the source that is rewritten.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from operator import is_
from types import CodeType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints
from ..provenance.values import PlainType

FUNCTIONS: dict[str, tuple[str, ...]] = {
    "_socket": ("getaddrinfo",),  # of a port number: "Int or String expected"
    "sys": ("intern",),  # "can't intern str"
    "marshal": ("dump", "dumps"),  # "unmarshallable object"
    # To a subinterpreter, where everything runs plain: "does not support cross-interpreter data"
    "_xxsubinterpreters": ("run_string", "channel_send"),
    "_xxinterpchannels": ("send",),
}
"""Join points: functions by the module that has them. Not all versions have all of them."""

_points = JoinPoints()


def install() -> None:
    """Wraps the functions as soon as their modules are there. Idempotent."""
    if not _points:
        for module, names in FUNCTIONS.items():
            for name in names:
                _points.replace_when_imported(module, name, _with_plain_arguments)


def uninstall() -> None:
    """The functions are as they were, save where somebody else has wrapped them since."""
    _points.restore()


def _with_plain_arguments(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            plain = _plain(args), _plain(kwargs)
        except RecursionError:  # about which the function itself has something to say
            plain = args, kwargs
        return function(*plain[0], **plain[1])

    return unseen(call)


@unseen
def _plain(thing: Any) -> Any:
    """A value without anything tracked in it; as it is if there is nothing."""
    kind = type(thing)
    if type(kind) is PlainType:
        return thing._v
    if kind is dict:
        plain = [*map(_plain, thing), *map(_plain, thing.values())]
        if all(map(is_, [*thing, *thing.values()], plain)):
            return thing
        return dict(zip(plain[: len(thing)], plain[len(thing) :], strict=True))
    if kind is tuple or kind is list or kind is set or kind is frozenset:
        plain = list(map(_plain, thing))
        return thing if all(map(is_, thing, plain)) else kind(plain)
    if kind is CodeType and type(type(thing.co_filename)) is PlainType:
        consts = tuple(map(_plain, thing.co_consts))  # functions have the file's name, too
        return thing.replace(co_filename=thing.co_filename._v, co_consts=consts)
    return thing
