"""Functions of libraries that ask for exact types get plain values.

Nearly everything written in C takes a subclass of float, int or str like the plain one. The few
functions that refuse one would fail under us, whoever calls them: nothing can be seen of that in
the source that is rewritten.
"""

from __future__ import annotations

import functools
from operator import is_
from types import CodeType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints
from ..provenance.values import PlainType

FUNCTIONS: dict[str, tuple[str, ...]] = {
    "_socket": ("getaddrinfo",),  # of a port number: "Int or String expected"
    "sys": ("intern",),  # "can't intern str"
    "orjson": ("dumps",),  # "not JSON serializable: float"
    "torch.serialization": ("save",),  # torch.load refuses to call float and str
    "csv": ("field_size_limit",),  # "limit must be an integer"
    "marshal": ("dump", "dumps"),  # "unmarshallable object"
    # To a subinterpreter, where everything runs plain: "does not support cross-interpreter data"
    "_xxsubinterpreters": ("run_string", "channel_send"),  # up to 3.12
    "_xxinterpchannels": ("send",),
    "_interpreters": ("run_string", "exec", "call", "set___main___attrs"),
    "_interpchannels": ("send",),
    "_interpqueues": ("put",),
    # Python code that asks ``type(x) is str``
    "multiprocessing.forkserver": ("set_forkserver_preload",),
    "multiprocessing.connection": ("address_type",),
    "multiprocessing.managers": ("BaseManager.register",),
    "unittest.case": ("TestCase._getAssertEqualityFunc",),
    "unittest.mock": ("_patch_multiple", "patch.multiple"),
    "h5py._hl.base": ("find_item_type",),
    "wsgiref.handlers": ("BaseHandler._convert_string_type",),
    "wsgiref.headers": ("Headers._convert_string_type",),
    "wsgiref.validate": ("check_string_type",),
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


def _with_plain_arguments(function: Any) -> Any:
    if isinstance(function, classmethod):
        return classmethod(_with_plain_arguments(function.__func__))

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            plain = made_plain(args), made_plain(kwargs)
        except RecursionError:  # about which the function itself has something to say
            plain = args, kwargs
        return function(*plain[0], **plain[1])

    return unseen(call)


@unseen
def made_plain(thing: Any) -> Any:
    """A value without anything tracked in it; as it is if there is nothing."""
    kind = type(thing)
    if type(kind) is PlainType:
        return thing._v
    if kind is dict:
        plain = [*map(made_plain, thing), *map(made_plain, thing.values())]
        if all(map(is_, [*thing, *thing.values()], plain)):
            return thing
        return dict(zip(plain[: len(thing)], plain[len(thing) :], strict=True))
    if kind is tuple or kind is list or kind is set or kind is frozenset:
        plain = list(map(made_plain, thing))
        return thing if all(map(is_, thing, plain)) else kind(plain)
    if kind is CodeType and type(type(thing.co_filename)) is PlainType:
        consts = tuple(map(made_plain, thing.co_consts))  # functions have the file's name, too
        return thing.replace(co_filename=thing.co_filename._v, co_consts=consts)
    return thing
