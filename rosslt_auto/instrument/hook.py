"""Join point of instrumentation: ``SourceLoader.get_code``, through which every loader of source
files gets its code.

Finders, loaders and module specs stay everybody's own, so that editable installs,
``spec_from_file_location``, `runpy` and other import hooks work as ever. The advice gives
instrumented code for selected modules; for all others, and whenever instrumenting fails, the
plain code comes from the plain function. Modules in zip archives and those without source have
join points of their own.
"""

from __future__ import annotations

import functools
import sys
import zipimport
from _thread import get_ident
from collections.abc import Callable
from importlib.machinery import BYTECODE_SUFFIXES, SourceFileLoader, SourcelessFileLoader
from types import CodeType
from typing import Any

from ..provenance.frames import unseen, untraced
from ..provenance.joinpoints import JoinPoints
from . import array_calls, cache, compiled, consoles, exact_types, pytest_modules, run_path, tables
from .errors import NotInstrumented, NotNow, NotParsed
from .selection import Selection

_SourceLoader = next(cls for cls in SourceFileLoader.__mro__ if "get_code" in vars(cls))
_WITHOUT_SOURCE = (zipimport.zipimporter, SourcelessFileLoader)
"""Loaders of modules that may exist as ``.pyc`` only."""

_ASPECTS: Any = (array_calls, exact_types, pytest_modules, run_path, consoles, compiled)
"""Further join points, each with `install` and `uninstall`."""

_selections: list[Selection] = []
_points = JoinPoints()
_warned: set[str] = set()

loaded: set[tuple[str, str]] = set()
"""Name and file of the modules whose code came from here."""


def install(selection: Selection) -> None:
    """Instruments the modules that `selection` selects, from their next import on."""
    if selection not in _selections:
        _selections.append(selection)
    for aspect in _ASPECTS:
        aspect.install()
    for loader in (_SourceLoader, *_WITHOUT_SOURCE):
        _points.replace(loader, "get_code", _advised)


def uninstall() -> None:
    """Imports are plain again. Modules that are instrumented already stay so."""
    _selections.clear()
    loaded.clear()
    for aspect in _ASPECTS:
        aspect.uninstall()
    _points.restore()


def selections() -> tuple[Selection, ...]:
    """What is instrumented now."""
    return tuple(_selections)


def selects(name: str, path: str) -> bool:
    """Whether the module `name`, loaded from the source file `path`, is instrumented."""
    return any(selection.selects(name, path) for selection in _selections)


def instrumented_code(
    module: str,
    path: str,
    source: bytes,
    *,
    cached: bool = True,
    compiler: Callable[[Any, str], CodeType] | None = None,
) -> CodeType:
    """Code of a module that produces tracked values; its literals are registered.

    module    dotted name, ``__main__`` for a script
    path      the source file, as tracebacks show it
    source    its content
    cached    whether the cache may be asked and filled
    compiler  compiles the rewritten tree, for loaders that have transformations of their own

    Raises NotParsed, NotInstrumented or NotNow.
    """
    cache_path = cache.path_for(path) if cached else None
    entry = cache.read(cache_path, source, module, path) if cache_path else None
    if entry is None:
        entry = _weave(module, path, source, compiler)
        if cache_path:
            cache.write(cache_path, source, entry)
    tables.publish(entry, source)
    loaded.add((module, path))
    for warning in entry.warnings:
        warn_once(warning, warning)
    return entry.code


def _weave(module: str, *args: Any) -> cache.Entry:
    """`weaving.weave`. It takes long to import, and is not needed with a warm cache."""
    try:
        with _importing:
            from .weaving import weave

            return weave(module, *args)
    except (ImportError, AttributeError, NotInstrumented) as error:
        cause = error.__cause__ if isinstance(error, NotInstrumented) else error
        if (
            isinstance(cause, (ImportError, AttributeError))
            and module.partition(".")[0] in sys.stdlib_module_names
        ):
            raise NotNow from error
        raise


class _Importing:
    """Threads that import what weaving needs itself: the standard library may be selected, too."""

    def __init__(self) -> None:
        self._threads: set[int] = set()

    def __bool__(self) -> bool:
        """Whether this thread is one."""
        return get_ident() in self._threads

    @unseen
    def __enter__(self) -> None:
        self._threads.add(get_ident())

    @unseen
    def __exit__(self, *_: object) -> None:
        self._threads.discard(get_ident())


_importing = _Importing()


def instrumented_or_none(module: str, path: str, source: bytes, **how: Any) -> CodeType | None:
    """As `instrumented_code`; None where that fails, so that plain Python takes over.

    Says so once per module, unless plain Python will fail too.
    """
    try:
        return instrumented_code(module, path, source, **how)
    except (NotParsed, NotNow):
        return None
    except Exception as error:
        say_once(module, path, error)
        return None


def say_once(module: str, path: str, reason: object) -> None:
    """Tells that a module, or a part of it, runs plain."""
    warn_once(module, f"{path} runs without provenance, it could not be instrumented: {reason}")


def warn_once(about: str, message: str) -> None:
    """Logs a message, the first one about something."""
    if about not in _warned:
        _warned.add(about)
        import logging

        logging.getLogger(__name__).warning("%s", message)


def _advised(original: Callable[..., Any]) -> Callable[..., Any]:
    """`original` with our advice around it; by hand, for wrapt takes longer to import than we."""

    @functools.wraps(original)
    def get_code(self: Any, *args: Any, **kwargs: Any) -> Any:
        code = untraced(_advice, self, *args, **kwargs)
        if code is None:
            code = original(self, *args, **kwargs)
            if isinstance(self, _WITHOUT_SOURCE):
                return untraced(_rewritten, code, self, *args, **kwargs)
        return code

    return unseen(get_code)


def _rewritten(code: Any, loader: Any, fullname: str | None = None) -> Any:
    """Code that was loaded without its source, instrumented if it is to be. Raises nothing."""
    try:
        name = fullname if fullname is not None else loader.name
        path = loader.get_filename(name)
        if not path.endswith(BYTECODE_SUFFIXES[0]) or not selects(name, path) or _importing:
            return code
        with _importing:
            from .code_objects import instrumented_or_same

            return instrumented_or_same(code, name)
    except Exception:
        return code


def _advice(loader: Any, fullname: str | None = None) -> CodeType | None:
    """Instrumented code, or None if the plain function is to be called. Raises nothing."""
    try:
        name = fullname if fullname is not None else loader.name
        path = loader.get_filename(name)
        if not selects(name, path) or _importing or path.endswith(BYTECODE_SUFFIXES[0]):
            return None
        source = loader.get_data(path)
        if isinstance(loader, zipimport.zipimporter):
            return instrumented_or_none(name, path, source, cached=False)
        if compiles_plainly(type(loader)):
            return instrumented_or_none(name, path, source)
        return instrumented_or_none(
            name, path, source, cached=False, compiler=loader.source_to_code
        )
    except Exception:
        return None  # whatever it is, the plain function meets it again


def compiles_plainly(loader: type) -> bool:
    compiler = getattr(loader, "source_to_code", None)
    if compiler is vars(_SourceLoader)["source_to_code"]:
        return True
    abc = sys.modules.get("importlib.abc")  # takes long to import, and most do without
    return abc is not None and compiler is abc.InspectLoader.source_to_code
