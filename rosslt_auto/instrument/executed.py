"""Code that a program makes at run time and executes: ``exec(text)``, ``eval(text)``.

Calls of `exec` and `eval` in rewritten code come here. A text is rewritten like a module, under
the name of the module whose namespace it is executed in: ``rosslt.<module>.executed.<hint>``, from
the second text on ``executed_2`` and so on. Code that has been compiled before is rewritten as it
is (`code_objects`). Its literals can be changed at run time, but there is no file to save them to.

What a text means does not depend on us: namespaces, `__future__` features and builtins are those
of the caller. Where our names cannot be found, in namespaces with builtins of their own, code stays
plain.
"""

from __future__ import annotations
import __future__

import builtins
import sys
from types import CodeType, FrameType
from typing import Any

from ..provenance.frames import unseen, untraced
from ..provenance.tokens import calling_frame
from ..provenance.values import untracked
from .exact_types import made_plain

CALL_EXECUTE = "@rosslt.execute"
"""The name under which rewritten code finds `execute`, in `builtins`."""

PLAIN_TREE = "@rosslt.plain_tree"
"""And that of `plain_tree`."""

_MOST = 200
"""So many texts of a program are rewritten; later ones, which it makes up as it goes, are not."""

_MODES = {exec: "exec", eval: "eval"}
_OPTIMIZED = 1
"""`inspect.CO_OPTIMIZED`, the flag of a function's code; that module takes long to import."""

_FEATURES = 0
for _name in __future__.all_feature_names:
    _FEATURES |= getattr(__future__, _name).compiler_flag

_known: dict[Any, CodeType] = {}
_counts: dict[str, int] = {}


@unseen
def execute(function: Any, /, *args: Any) -> Any:
    """``function(*args)``; if it is `exec` or `eval`, what it executes is tracked."""
    if function is exec or function is eval:
        return function(*untraced(_prepared, function, args))
    return function(*args)


@unseen
def plain_tree(source: Any) -> Any:
    """What `compile` takes: it wants names and constants of exact types in syntax trees."""
    ast = sys.modules.get("ast")
    if ast is not None and isinstance(source, ast.AST):
        for node in ast.walk(source):
            for name, value in ast.iter_fields(node):
                plain = made_plain(value)
                if plain is not value:
                    setattr(node, name, plain)
    return source


def publish() -> None:
    """Lets rewritten code find these functions."""
    vars(builtins).update({CALL_EXECUTE: execute, PLAIN_TREE: plain_tree})


def _prepared(function: Any, args: tuple[Any, ...]) -> tuple[Any, ...]:
    """Arguments with which the function does for us what it would do for our caller."""
    frame = calling_frame()
    if frame is None:
        return args
    names = args[1] if len(args) > 1 else None
    local = args[2] if len(args) > 2 else None
    if names is None:
        names = frame.f_globals
        local = _locals(frame) if local is None else local
    elif local is None:
        local = names
    if not isinstance(names, dict):
        return args  # its own error
    if "__builtins__" not in names and frame.f_builtins is not vars(builtins):
        names["__builtins__"] = frame.f_builtins
    return _code(_MODES[function], untracked(args[0]), frame, names, local), names, local


def _locals(frame: FrameType) -> Any:
    if sys.version_info >= (3, 13) and frame.f_code.co_flags & _OPTIMIZED:
        return dict(frame.f_locals)  # PEP 667: a copy each time
    return frame.f_locals


def _code(mode: str, source: Any, frame: FrameType, names: dict[str, Any], local: Any) -> Any:
    """What is to be executed instead of `source`; itself if only the function can say more."""
    visible = names.get("__builtins__", builtins) in (builtins, vars(builtins))
    # Others may have an answer for any name, ours as well.
    visible = visible and type(names) is dict and type(local) is dict
    try:
        if type(source) is CodeType:
            return _compiled(source, *_module(names, frame)) if visible else source
        if type(source) not in (str, bytes):
            return source
        flags = frame.f_code.co_flags & _FEATURES
        if mode == "eval":
            source = source.lstrip(" \t" if type(source) is str else b" \t")
        if visible:
            return _from_text(mode, source, flags, *_module(names, frame))
        return compile(source, "<string>", mode, flags, dont_inherit=True)
    except Exception:
        return source  # whatever it is, the function meets it again


def _module(names: dict[str, Any], frame: FrameType) -> tuple[str, str]:
    """Name and file of the module that a namespace belongs to, else of the caller's."""
    for namespace in (names, frame.f_globals):
        name, file = namespace.get("__name__"), namespace.get("__file__")
        if type(name) is str and name:
            return name, file if type(file) is str else frame.f_code.co_filename
    return "__main__", frame.f_code.co_filename


def _compiled(code: CodeType, module: str, file: str) -> CodeType:
    from .selection import is_installed, is_stdlib

    key = code, code.co_filename, module  # equal code may come from different files
    if key not in _known:
        path = code.co_filename
        if code.co_freevars or len(_known) >= _MOST or is_stdlib(path) or is_installed(path):
            return code
        from .code_objects import instrumented_or_same

        _known[key] = instrumented_or_same(code, module, _scope(module, file))
    return _known[key]


def _scope(module: str, file: str) -> Any:
    from .naming import Scope, module_scope

    outer = module_scope(module, file).path
    number = _counts[outer] = _counts.get(outer, 0) + 1
    return Scope(f"{outer}.executed" + (f"_{number}" if number > 1 else ""), None)


def _from_text(mode: str, text: Any, flags: int, module: str, file: str) -> CodeType:
    key = mode, text, flags, module
    if key not in _known:
        if len(_known) >= _MOST:
            return compile(text, "<string>", mode, flags, dont_inherit=True)
        _known[key] = _woven(mode, text, flags, module, file)
    return _known[key]


def _woven(mode: str, text: Any, flags: int, module: str, file: str) -> CodeType:
    import ast  # like the others, not needed by programs that execute nothing

    tree: Any = compile(text, "<string>", mode, flags | ast.PyCF_ONLY_AST, dont_inherit=True)
    from . import hook, tables
    from .cache import table_name
    from .rewriter import Rewriter
    from .weaving import entry_of

    try:
        scope = _scope(module, file)
        content = text.encode("utf-8", "replace") if type(text) is str else text
        table = table_name(scope.path, "<string>", content)
        walk = Rewriter(scope, table)
        if mode == "exec":
            walk.module(tree)
        else:
            walk.expression(tree.body, (mode, False))
        rewritten = walk.finish()
        code = compile(tree, "<string>", mode, flags, dont_inherit=True)
        tables.publish(entry_of(module, "<string>", table, code, rewritten), None)
        return code
    except Exception as error:
        code = compile(text, "<string>", mode, flags, dont_inherit=True)
        hook.say_once(f"{module}: {mode}", "<string>", error)
        return code
