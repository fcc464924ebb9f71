"""Where a program keeps its values: names, attributes and containers of instrumented code.

`replace_everywhere` puts new values in place of old ones: in the namespaces of instrumented
modules and classes, default arguments and closures of their functions, attributes of their
objects, containers, and local variables of functions that are running.
"""

from __future__ import annotations

import builtins
import functools
import sys
import types
import weakref
from collections import deque
from collections.abc import Callable, Sequence
from sys import _getframe
from typing import Any, NamedTuple

from .registry import instrumented_files, instrumented_modules
from .values import is_tracked

Replace = Callable[[Any], Any]

_roots: weakref.WeakSet[Any] = weakref.WeakSet()

CONTAINERS: dict[int, Callable[[Any, Replace], Any]] = {}
"""What replaces the elements of arrays and the like, by the id of their type."""


def add_root(root: Any) -> None:
    """Adds an object (a node) whose attributes belong to the program, wherever it is kept."""
    _roots.add(root)


def _is_root(thing: Any) -> bool:
    try:
        return thing in _roots
    except TypeError:  # not hashable
        return False


class Rebinding(NamedTuple):
    """A truth value to be replaced where it is bound; it does not tell where it came from.

    module, owner, name  an attribute of objects of a class of a module; owner None: the module's
    """

    module: str
    owner: str | None
    name: str
    old: bool
    new: bool

    def apply(self, names: dict[str, Any], put: Callable[[str, Any], None]) -> None:
        if names.get(self.name) is self.old:
            put(self.name, self.new)


def replace_everywhere(replace: Replace, truths: Sequence[Rebinding] = ()) -> None:
    """Puts ``replace(value)`` in place of every tracked value that the program has a name for."""
    walk = _Walk(replace, truths)
    for one in truths:
        module = sys.modules.get(one.module)
        if one.owner is None and module is not None:
            one.apply(module.__dict__, module.__dict__.__setitem__)
    for name in instrumented_modules() | {"__main__"}:
        module = sys.modules.get(name)
        if module is not None:
            walk.visit_namespace(module.__dict__)
    for root in list(_roots):
        walk.visit(root)
    for frame in _running_frames():
        walk.visit_frame(frame)
    walk.finish()


def _running_frames() -> list[types.FrameType]:
    """Frames of instrumented functions, in all threads.

    In another thread only below a call into code that is not instrumented (waiting for messages,
    say): a frame that may go on at any moment is not touched.
    """
    files = instrumented_files()
    own = _getframe()
    found = []
    for innermost in sys._current_frames().values():
        frame: types.FrameType | None = own if _is_below(own, innermost) else innermost
        if frame is not own and innermost.f_code.co_filename in files:
            continue
        while frame is not None:
            if frame.f_code.co_filename in files:
                found.append(frame)
            frame = frame.f_back
    return found


def _is_below(frame: types.FrameType, innermost: types.FrameType) -> bool:
    walked: types.FrameType | None = innermost
    while walked is not None:
        if walked is frame:
            return True
        walked = walked.f_back
    return False


class _Walk:
    """One walk over everything that can be reached; each object is visited once."""

    def __init__(self, replace: Replace, truths: Sequence[Rebinding] = ()) -> None:
        self.replace = replace
        self.truths = [one for one in truths if one.owner is not None]
        self.modules = instrumented_modules() | {"__main__"}
        self.seen = {id(vars(builtins))}  # in every namespace; the tables of literals are there
        self.keep: list[Any] = []  # what was visited lives until the end: ids stay unique
        self.stack: list[Any] = []

    def finish(self) -> None:
        """Visits what is still to be visited."""
        while self.stack:
            self._visit_object(self.stack.pop())

    def visit(self, thing: Any) -> None:
        """Notes an object whose parts are to be visited."""
        if id(thing) not in self.seen:
            self.seen.add(id(thing))
            self.keep.append(thing)
            self.stack.append(thing)

    def new(self, value: Any) -> Any:
        """What stands in place of `value`; notes it for a visit if it has parts."""
        if is_tracked(value):
            return self.replace(value)
        kind = type(value)
        if kind is tuple or (isinstance(value, tuple) and hasattr(kind, "_make")):
            return self._new_tuple(value)
        if kind not in _ATOMS:
            self.visit(value)
        return value

    def _new_tuple(self, value: Any) -> Any:
        items = [self.new(item) for item in value]
        if all(a is b for a, b in zip(items, value, strict=True)):
            return value
        return tuple(items) if type(value) is tuple else type(value)._make(items)

    def _visit_object(self, thing: Any) -> None:
        kind = type(thing)
        if id(kind) in CONTAINERS:
            CONTAINERS[id(kind)](thing, self.replace)
        elif kind is dict or isinstance(thing, dict):
            self._visit_dict(thing)
        elif isinstance(thing, (list, deque)):
            self._visit_sequence(thing)
        elif kind is types.FunctionType:
            self._visit_function(thing)
        elif kind is types.MethodType:
            self.visit(thing.__self__)
            self.visit(thing.__func__)
        elif kind is functools.partial:
            self._visit_partial(thing)
        elif isinstance(thing, type):
            if thing.__module__ in self.modules:
                self._visit_class(thing)
        elif kind is set or kind is frozenset:
            for item in thing:
                self.new(item)
        else:
            self._visit_instance(thing)

    def _visit_partial(self, thing: Any) -> None:
        self.new(thing.func)
        self._visit_dict(thing.keywords)
        arguments = self._new_tuple(thing.args)
        if arguments is not thing.args:
            thing.__setstate__((thing.func, arguments, thing.keywords, vars(thing)))

    def visit_namespace(self, names: dict[str, Any]) -> None:
        """A module's namespace."""
        self._visit_dict(names)

    def _visit_dict(self, thing: dict[Any, Any]) -> None:
        for key, value in list(thing.items()):
            new = self.new(value)
            if new is not value:
                dict.__setitem__(thing, key, new)

    def _visit_sequence(self, thing: Any) -> None:
        for index, value in enumerate(list(thing)):
            new = self.new(value)
            if new is not value:
                thing[index] = new

    def _visit_function(self, function: types.FunctionType) -> None:
        if function.__module__ not in self.modules:
            return
        if function.__defaults__:
            new = self._new_tuple(function.__defaults__)
            if new is not function.__defaults__:
                function.__defaults__ = new
        if function.__kwdefaults__:
            self._visit_dict(function.__kwdefaults__)
        for cell in function.__closure__ or ():
            try:
                value = cell.cell_contents
            except ValueError:  # empty
                continue
            new = self.new(value)
            if new is not value:
                cell.cell_contents = new

    def _rebind(self, cls: type, names: Any, put: Callable[[str, Any], None]) -> None:
        for one in self.truths:
            if any(c.__name__ == one.owner and c.__module__ == one.module for c in cls.__mro__):
                one.apply(names, put)

    def _visit_class(self, cls: type) -> None:
        self._rebind(cls, vars(cls), functools.partial(type.__setattr__, cls))
        for name, value in list(vars(cls).items()):
            if isinstance(value, (staticmethod, classmethod)):
                self.visit(value.__func__)
                continue
            if isinstance(value, property):
                for accessor in (value.fget, value.fset, value.fdel):
                    if accessor is not None:
                        self.visit(accessor)
                continue
            new = self.new(value)
            if new is not value:
                type.__setattr__(cls, name, new)

    def _visit_instance(self, thing: Any) -> None:
        cls = type(thing)
        if not (cls.__module__ in self.modules or _is_root(thing) or _is_message(cls)):
            self._visit_callback(thing)
            return
        names = getattr(thing, "__dict__", None)
        if type(names) is dict:
            self._rebind(cls, names, names.__setitem__)
            self._visit_dict(names)
        for base in cls.__mro__:
            slots = base.__dict__.get("__slots__", ())
            for slot in (slots,) if isinstance(slots, str) else slots:
                self._visit_slot(thing, slot, base)
        if cls.__module__ in self.modules:
            self.visit(cls)

    def _visit_slot(self, thing: Any, slot: str, base: type) -> None:
        if slot.startswith("__") and not slot.endswith("__"):
            slot = f"_{base.__name__.lstrip('_')}{slot}"
        descriptor = base.__dict__.get(slot)
        if not isinstance(descriptor, types.MemberDescriptorType):
            return
        try:
            value = descriptor.__get__(thing)
        except AttributeError:  # not set
            return
        new = self.new(value)
        if new is not value:
            descriptor.__set__(thing, new)

    def _visit_callback(self, thing: Any) -> None:
        """Of somebody else's object (a timer, a subscription) only what it calls back."""
        names = getattr(thing, "__dict__", None)
        if type(names) is dict:
            for name in ("callback", "_callback"):
                if name in names:
                    self.new(names[name])

    def visit_frame(self, frame: types.FrameType) -> None:
        """Local variables of a running function."""
        if frame.f_locals is frame.f_globals:
            return
        changed = False
        names = frame.f_locals
        for name, value in list(names.items()):
            new = self.new(value)
            if new is not value:
                names[name] = new
                changed = True
        if changed and sys.version_info < (3, 13):  # from there on f_locals writes through, PEP 667
            import ctypes  # slow to import, and not there in subinterpreters

            ctypes.pythonapi.PyFrame_LocalsToFast(ctypes.py_object(frame), ctypes.c_int(0))


_ATOMS = frozenset(
    {float, int, bool, str, bytes, bytearray, type(None), types.ModuleType, types.CodeType}
    | {types.BuiltinFunctionType, complex, range, types.FrameType, types.TracebackType}
)


def _is_message(cls: type) -> bool:
    return hasattr(cls, "_fields_and_field_types")
