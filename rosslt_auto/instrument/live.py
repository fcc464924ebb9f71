"""Instruments what has been loaded plain: `@tracked_module`, and its way back.

Functions get rewritten code (``__code__``) and stay the objects that they are, with their
closures; classes and modules likewise. What is running at that moment ends as it began.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import sys
from collections.abc import Iterable
from types import CodeType, FunctionType, ModuleType
from typing import Any
from weakref import WeakKeyDictionary

from ..provenance.locations import Literals
from ..provenance.registry import registered
from . import array_calls, hook
from .code_objects import instrumented_function_code, is_instrumented
from .errors import NotInstrumented, NotParsed
from .evaluated import Evaluated
from .reachable import (
    classes_within,
    functions_behind,
    functions_of_class,
    functions_of_module,
)
from .rewoven import Rewoven, forget, rewoven


def instrument(thing: Any, caller: str | None = None) -> None:
    """Instruments a class, a function or a module in place.

    thing   what is behind decorators is found: wrappers, properties, partial functions
    caller  the file that asks: of a decorated function, what stands there is meant

    Where there is no source, or another one than was loaded, the code itself is rewritten.
    Raises TypeError for anything else. What cannot be instrumented stays plain, which is said once.
    """
    array_calls.install()
    if isinstance(thing, ModuleType):
        _module(thing)
    elif isinstance(thing, type):
        for cls in classes_within(thing):
            _class(cls)
    else:
        functions = list(functions_behind(thing))
        if not functions:
            raise TypeError(
                f"tracked_module takes a class, a function or a module, not {type(thing).__name__}"
            )
        files = {function.__code__.co_filename for function in functions}
        file = caller if caller in files else _innermost(functions[0]).__code__.co_filename
        _functions(f for f in functions if f.__code__.co_filename == file)


def _innermost(function: Any) -> FunctionType:
    found = function
    for _ in range(100):
        function = getattr(function, "__wrapped__", None)
        if type(function) is not FunctionType:
            break
        found = function
    return found


def _module(module: ModuleType) -> None:
    path = getattr(module, "__file__", None)
    functions = [f for f in functions_of_module(module) if not _is_generated(f)]
    if not isinstance(path, str) or not (functions or path.endswith(".py")):
        raise TypeError(f"module {module.__name__} has no Python code")
    if (module.__name__, path) in hook.loaded:
        return
    _functions(functions)
    evaluated = _evaluated(module.__name__, path)
    if evaluated is not None:
        names = vars(module)
        evaluated.track_globals(names)
        for cls in [one for one in names.values() if isinstance(one, type)]:
            if cls.__module__ == module.__name__:
                for inner in classes_within(cls):
                    evaluated.track_attributes(inner)


def _class(cls: type) -> None:
    functions = functions_of_class(cls)
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    path = functions[0].__code__.co_filename if functions else file
    if path is not None and (cls.__module__, path) not in hook.loaded:
        _functions(functions)
        evaluated = _evaluated(cls.__module__, path)
        if evaluated is not None:
            evaluated.track_attributes(cls)


def _is_generated(function: FunctionType) -> bool:
    """Whether a function was made by a library from a text (dataclasses, attrs)."""
    return function.__code__.co_filename.startswith("<")


def _evaluated(module: str, path: str) -> Evaluated | None:
    """What a source says of names that are bound already, None if there is none."""
    try:
        return rewoven(module, path).evaluated
    except (NotParsed, NotInstrumented):
        return None


def _functions(functions: Iterable[FunctionType]) -> None:
    for function in functions:
        code = function.__code__
        module, path = function.__globals__.get("__name__", ""), code.co_filename
        if (module, path) in hook.loaded or is_instrumented(code):
            continue
        try:
            new, evaluated = _rewritten(code, module, path)
        except NotInstrumented as error:
            hook.say_once(module, path, error)
            continue
        function.__code__ = new
        _plain[function] = code
        if evaluated is not None:
            evaluated.track_defaults(function)


def _rewritten(code: CodeType, module: str, path: str) -> tuple[CodeType, Evaluated | None]:
    """Code that was made from the source, else from the code itself. Raises NotInstrumented."""
    with contextlib.suppress(NotParsed, NotInstrumented):
        made = rewoven(module, path)
        if code in made.rewritten:
            return made.rewritten[code], made.evaluated
    # There is no source, or it is not what was loaded.
    return instrumented_function_code(code, module), None


# ---------------------------------------------------------------- and back

_plain: WeakKeyDictionary[FunctionType, CodeType] = WeakKeyDictionary()


def restore() -> None:
    """Gives all functions plain code again, also those that the import hook has instrumented."""
    for function, code in list(_plain.items()):
        if is_instrumented(function.__code__):
            function.__code__ = code
    _plain.clear()
    files = {(one.module, one.file): one for one in registered()}
    paths = {path for _, path in (*files, *hook.loaded)}
    for function in gc.get_objects():
        if type(function) is FunctionType and function.__code__.co_filename in paths:
            key = (function.__globals__.get("__name__", ""), function.__code__.co_filename)
            plain = _plain_codes(*key, files.get(key)).get(function.__code__)
            if plain is not None:
                function.__code__ = plain
    forget()
    _plain_codes.cache_clear()


def make_plain(function: FunctionType) -> None:
    """Gives one function plain code, wherever its rewritten code has come from."""
    code = _plain.pop(function, None)
    if code is None and is_instrumented(function.__code__):
        key = function.__globals__.get("__name__", ""), function.__code__.co_filename
        known = [one for one in registered() if (one.module, one.file) == key]
        code = _plain_codes(*key, known[0] if known else None).get(function.__code__)
    if code is not None:
        function.__code__ = code


@functools.cache
def _plain_codes(module: str, path: str, known: Literals | None) -> dict[CodeType, CodeType]:
    """Plain code of a module by its rewritten code."""
    try:
        if known is None or known.source is None:
            return rewoven(module, path).plain
        return Rewoven(module, path, known.source).plain
    except (NotParsed, NotInstrumented):
        return {}
