"""Instrumenting code for which there is no source: literals in the code object itself.

For modules that exist as ``.pyc`` only, functions whose source is gone, and code that a program has
compiled by itself. The result is what `rewriter` makes of the source, but for what a code object
does not show:

- what the compiler has computed, ``2 * 0.3``, is one location, at the place of the expression;
- the elements of a constant tuple or list stand where Python would write them in the place of the
  whole; where that is as wide as something else, on several lines, or the constant holds the
  defaults of a function, they all stand at its beginning;
- ``"%s %s" % (a, b)`` is compiled as the f-string ``f"{a!s} {b!s}"``, and gives the same locations
  as that one; an f-string without values is a text like any other;
- f-strings with ``and``, ``or``, conditions or comprehensions in them stay as they are, and so do
  calls with ``*args`` or ``**keywords``;
- a constant that is returned from inside of ``try: ... finally: ...`` stands at the end of that,
  the body of ``lambda: 1.5`` at the beginning of its line (3.12);
- of ``True`` and ``False`` nothing is known;
- targets in brackets, ``[a, b] = 1, 2`` and ``(a, b), c = (1, 2), d``, are told apart, where names
  of locations from source go by the first.

Code objects are taken apart and put together with the library `bytecode`.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from types import CodeType

from .errors import NotInstrumented
from .naming import Scope, module_scope
from .tables import PREFIX, publish


def instrumented_code_object(code: CodeType, module: str, scope: Scope | None = None) -> CodeType:
    """The code of a module's body, made to produce tracked values; its literals are registered.

    module  dotted name
    scope   under which its locations are named; None: that of the module

    Code that is instrumented already is given back as it is. Raises NotInstrumented.
    """
    return _instrumented(code, module, "rewrite_code", scope)


def instrumented_function_code(code: CodeType, module: str) -> CodeType:
    """The same for the code of a function; all that the function has beside it fits as before.

    Its defaults have been computed and stay plain; those of functions in it are tracked.
    """
    return _instrumented(code, module, "rewrite_function")


def instrumented_or_same(code: CodeType, module: str, scope: Scope | None = None) -> CodeType:
    """As `instrumented_code_object`; where that fails, says so once and gives `code` as it is."""
    try:
        return instrumented_code_object(code, module, scope)
    except NotInstrumented as error:
        from .hook import say_once  # which has code without source as one of its ways

        say_once(module, code.co_filename, error)
        return code


def _instrumented(
    code: CodeType, module: str, rewriting: str, scope: Scope | None = None
) -> CodeType:
    if is_instrumented(code):
        return code
    path = code.co_filename
    scope = scope or module_scope(module, path)
    table = f"{PREFIX}{scope.path}.{_fingerprint(code)}"
    try:
        from . import code_walk  # takes long to import, and most programs do without
        from .weaving import entry_of

        made, rewritten = getattr(code_walk, rewriting)(code, scope, table)
        entry = entry_of(module, path, table, made, rewritten)
    except Exception as error:
        raise NotInstrumented(f"{type(error).__name__}: {error}") from error
    publish(entry, None)
    return made


def is_instrumented(code: CodeType) -> bool:
    """Whether code, or some of the code in it, looks up our names."""
    return any(name.startswith(PREFIX) for one in nested(code) for name in one.co_names)


def nested(code: CodeType) -> Iterator[CodeType]:
    """A code object and all that are in it."""
    waiting = [code]
    while waiting:
        one = waiting.pop()
        yield one
        waiting += [constant for constant in one.co_consts if isinstance(constant, CodeType)]


def _fingerprint(code: CodeType) -> str:
    """What tells code from all other code, and is the same in every process."""
    crc = 0
    for one in nested(code):
        plain = [c for c in one.co_consts if not isinstance(c, (CodeType, frozenset))]
        where = f"{one.co_filename}:{one.co_firstlineno}:{one.co_qualname}"
        names = f"{where} {one.co_names} {plain!r}"
        for part in (names.encode("utf-8", "replace"), one.co_code, one.co_linetable):
            crc = zlib.crc32(part, crc)
    return f"{crc:08x}"
