"""Runs a program as ``python SCRIPT ARG...`` and ``python -m MODULE ARG...`` do, instrumented.

What CPython does in `Modules/main.c` (pymain_run_python) and `Python/pythonrun.c`: argv and
``sys.path[0]``, a fresh ``__main__``, what is printed of an uncaught exception, how the process
ends. For ``-m``, folders and zip files it calls what CPython calls, ``runpy._run_module_as_main``.
"""

from __future__ import annotations

import builtins
import importlib.util
import io
import marshal
import os
import sys
from collections.abc import Callable, Sequence
from importlib.machinery import BYTECODE_SUFFIXES, SourceFileLoader, SourcelessFileLoader
from types import CodeType, ModuleType, TracebackType
from typing import Any

from ..provenance.frames import without_ours
from . import hook
from .selection import Selection, is_installed, is_stdlib

_kept: list[Any] = []  # our own __main__ must outlive its entry in sys.modules


def run(target: str, args: Sequence[str], *, as_module: bool, selection: Selection) -> int:
    """Runs `target`, a script's path or (`as_module`) a module's name, and returns its exit status.

    The selection is completed by the script's folder or the module's package, and installed.
    SystemExit is passed on, KeyboardInterrupt too (after it was shown): left alone, they end the
    process as they would end a plain one.
    """
    return (run_module if as_module else run_script)(target, args, selection)


def run_script(path: str, args: Sequence[str], selection: Selection) -> int:
    """Runs the script, folder or zip file at `path`; see `run`."""
    sys.argv = [path, *args]
    if _has_main_inside(path):
        _set_first_path(_absolute(path), always=True)
        hook.install(selection.with_folder(os.path.realpath(path)))
        _new_main()
        return _execute(lambda: _run_module_as_main("__main__", alter_argv=False))
    try:
        with io.open_code(_absolute(path)) as file:  # not normalised: no file.py/
            content = file.read()
    except OSError as error:
        return _cannot_open(path, error)
    _set_first_path(os.path.dirname(os.path.realpath(path)))
    file_name = _absolute(path)
    selection = selection.with_script(path)
    if not path.endswith(".py"):
        from .console_scripts import wrapped_package

        package = wrapped_package(content)
        if package is not None:
            selection = selection.with_package(package)
    hook.install(selection)
    main = _new_main()
    main.__file__ = file_name
    main.__cached__ = None  # type: ignore[attr-defined]
    if path.endswith(BYTECODE_SUFFIXES[0]):
        main.__loader__ = SourcelessFileLoader("__main__", file_name)
        return _execute(lambda: exec(_code_in(content), vars(main)))
    main.__loader__ = SourceFileLoader("__main__", file_name)
    return _execute(lambda: exec(_code_of(content, file_name), vars(main)))


def run_module(name: str, args: Sequence[str], selection: Selection) -> int:
    """Runs the module or package `name` as ``python -m`` does; see `run`."""
    sys.argv = ["-m", *args]
    _set_first_path(os.getcwd())
    hook.install(_selection_for_module(name, selection))
    _new_main()
    return _execute(lambda: _run_module_as_main(name))


def run_prompt(selection: Selection) -> int:
    """Opens Python's prompt, as ``python`` alone does; see `run`.

    What is typed is instrumented, and modules that are imported from the current folder.
    """
    from .prompt import interact

    sys.argv = [""]
    _set_first_path("")
    hook.install(selection.with_folder(os.getcwd()))
    return interact(vars(_new_main()))


def _selection_for_module(name: str, selection: Selection) -> Selection:
    """Its package, or the folder of a module that is in none and not installed."""
    top = name.partition(".")[0]
    try:
        spec = importlib.util.find_spec(top)
    except (ImportError, ValueError):
        spec = None
    selection = selection.with_package(top)
    if spec is not None and spec.origin and spec.submodule_search_locations is None:
        origin = os.path.realpath(spec.origin)
        if not is_stdlib(origin) and not is_installed(origin):
            selection = selection.with_folder(os.path.dirname(origin))
    return selection


# ---------------------------------------------------------------- the program's surroundings


def _new_main() -> ModuleType:
    """A fresh ``__main__`` as the interpreter prepares it."""
    _kept.append(sys.modules.get("__main__"))
    main = ModuleType("__main__")
    main.__loader__ = None
    if sys.version_info < (3, 14):  # PEP 649: made when asked for
        main.__annotations__ = {}
    main.__builtins__ = builtins  # type: ignore[attr-defined]
    sys.modules["__main__"] = main
    return main


def _set_first_path(folder: str, always: bool = False) -> None:
    """What the interpreter puts first for a script or a module takes the place of our own."""
    if not sys.flags.safe_path:
        sys.path[0] = folder
    elif always:
        sys.path.insert(0, folder)


def _has_main_inside(path: str) -> bool:
    """Whether `path` is a folder or an archive, which Python puts on the path to run it."""
    if os.path.isdir(path):
        return True
    from pkgutil import get_importer

    return os.path.isfile(path) and get_importer(path) is not None


def _absolute(path: str) -> str:
    """As CPython makes a script's path absolute: not normalised."""
    if os.path.isabs(path):
        return path
    return os.path.join(os.getcwd(), path)


def _cannot_open(path: str, error: OSError) -> int:
    program = sys.orig_argv[0] if sys.orig_argv else sys.executable
    print(
        f"{program}: can't open file {_absolute(path)!r}: [Errno {error.errno}] {error.strerror}",
        file=sys.stderr,
    )
    return 2


def _code_of(source: bytes, path: str) -> CodeType:
    # Scripts are not cached, as in plain Python.
    code = hook.instrumented_or_none("__main__", path, source, cached=False)
    if code is None:
        try:
            code = compile(source, path, "exec", dont_inherit=True)
        except SyntaxError as error:
            from .file_errors import as_of_file

            raise as_of_file(error, source, path) from None
    return code


def _code_in(content: bytes) -> CodeType:
    if content[:4] != importlib.util.MAGIC_NUMBER:
        raise RuntimeError("Bad magic number in .pyc file")
    code = marshal.loads(memoryview(content)[16:])
    from .code_objects import instrumented_or_same

    return instrumented_or_same(code, "__main__")


# ---------------------------------------------------------------- how it ends


def _run_module_as_main(name: str, alter_argv: bool = True) -> None:
    import runpy

    runpy._run_module_as_main(name, alter_argv)  # type: ignore[attr-defined]


def _execute(program: Callable[[], object]) -> int:
    try:
        program()
    except SystemExit:
        raise
    except KeyboardInterrupt as error:
        _show(error)
        # Left alone it ends the process by SIGINT, as shells expect; it has been shown.
        sys.excepthook = lambda *ignored: None
        raise
    except BaseException as error:
        _show(error)
        return 1
    return 0


def _show(error: BaseException) -> None:
    """What CPython does with an uncaught exception (PyErr_PrintEx)."""
    trace = error.__traceback__ = _without_our_frames(error)
    sys.last_type, sys.last_value, sys.last_traceback = type(error), error, trace
    if sys.version_info >= (3, 12):
        sys.last_exc = error
    show = getattr(sys, "excepthook", None)
    if show is None:
        print("sys.excepthook is missing", file=sys.stderr)
        show = sys.__excepthook__
    sys.audit("sys.excepthook", show, type(error), error, trace)
    try:
        show(type(error), error, trace)
    except SystemExit:
        raise
    except BaseException as second:
        second.__context__ = None
        in_hook = second.__traceback__
        second.__traceback__ = in_hook.tb_next if in_hook else None
        import traceback

        print("Error in sys.excepthook:", file=sys.stderr)
        traceback.print_exception(second)
        print("\nOriginal exception was:", file=sys.stderr)
        sys.__excepthook__(type(error), error, trace)


def _without_our_frames(error: BaseException) -> TracebackType | None:
    """The traceback as from the program; of an interrupt, which strikes anywhere, none of ours."""
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_filename == __file__:
        trace = trace.tb_next
    return without_ours(trace) if isinstance(error, KeyboardInterrupt) else trace
