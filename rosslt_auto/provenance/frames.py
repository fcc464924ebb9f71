"""Functions whose frames nobody sees.

Our functions that stand between a program and the plain function it calls must not show up in
the program's tracebacks and stacks. CPython leaves out frames that have not yet reached the
instruction RESUME (``_PyFrame_IsIncomplete``, `Include/internal/pycore_frame.h`): it is how a
frame that is still being set up stays out of sight. A function whose instructions all come before
any RESUME is therefore never seen: not in tracebacks, not by ``sys._getframe`` and all that builds
on it (stack levels of warnings, `inspect.stack`), and from 3.12 on not by tracers and profilers.

3.11's tracers are told of a return for every call, so there a RESUME is executed, but one that
stands behind everything else. From 3.12 on a tracer (``sys.settrace``) is told of an exception
that leaves such a function as if it left the caller: with a tracer active from the start, as under
coverage or a debugger, functions stay visible.
"""

from __future__ import annotations

import dis
import os
import sys
from collections.abc import Callable
from types import CodeType, FunctionType, TracebackType
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

_OURS = (os.path.dirname(os.path.dirname(__file__)) + os.sep, "<tracked ", "<fields of ")
"""How the file names of our code begin, those of generated code included."""

_RESUME = dis.opmap["RESUME"]


def _never_complete(code: CodeType) -> CodeType:
    """`code` with its RESUME taken away, or moved behind everything else."""
    instructions = bytearray(code.co_code)
    at = instructions[::2].index(_RESUME) * 2
    if sys.version_info >= (3, 12):
        instructions[at : at + 2] = bytes([dis.opmap["NOP"], 0])
        return code.replace(co_code=bytes(instructions))
    # In the place of RESUME: to the end, where a RESUME is, and back. Jumps count instructions
    # from the next one on; one instruction becomes two, so everything behind moves by one.
    rest = (len(instructions) - at) // 2 - 1
    instructions[at : at + 2] = _instruction("JUMP_FORWARD", rest)
    instructions += bytes([_RESUME, 0]) + _instruction("JUMP_BACKWARD", rest + 3)
    return code.replace(
        co_code=bytes(instructions),
        co_linetable=_place(0, 1) + code.co_linetable + _first_line(code, 3),
        co_exceptiontable=_moved(code.co_exceptiontable, 1),
    )


def _instruction(name: str, argument: int) -> bytes:
    high, low = divmod(argument, 256)
    return bytes([dis.opmap["EXTENDED_ARG"], high, dis.opmap[name], low])


def _first_line(code: CodeType, length: int) -> bytes:
    """An entry for instructions behind `code`: they stand in its first line."""
    lines = [line for _, _, line in code.co_lines() if line is not None]
    return _place(code.co_firstlineno - (lines[-1] if lines else code.co_firstlineno), length)


def _place(delta: int, length: int) -> bytes:
    """An entry of a table of lines (CPython's `Objects/locations.md`), without columns."""
    entry = [0b1_1101_000 | length - 1]
    number = abs(delta) << 1 | (delta < 0)
    while number > 0b11_1111:
        entry.append(number & 0b11_1111 | 0b100_0000)
        number >>= 6
    return bytes([*entry, number])


def _moved(table: bytes, by: int) -> bytes:
    """An exception table (CPython's `Objects/exception_handling_notes.txt`) for moved code.

    Entries are start, length, target, depth; numbers of six bits a byte, the highest first, with
    a mark where more follow and another one where an entry begins.
    """
    numbers, number = [], 0
    for byte in table:
        number = number << 6 | byte & 0b11_1111
        if not byte & 0b100_0000:
            numbers.append(number)
            number = 0
    moved = bytearray()
    for index, number in enumerate(numbers):
        field = index % 4
        number += by if field in (0, 2) else 0
        encoded = [number & 0b11_1111]
        while number := number >> 6:
            encoded.insert(0, number & 0b11_1111 | 0b100_0000)
        encoded[0] |= 0b1000_0000 if field == 0 else 0
        moved += bytes(encoded)
    return bytes(moved)


def _works() -> bool:
    """Whether this interpreter treats such functions as described, in both ways out of them."""

    def inner(wrong: bool) -> int:
        return 1 // 0 if wrong else 1

    try:
        inner.__code__ = _never_complete(inner.__code__)
        if inner(False) != 1:
            return False
        inner(True)
    except ZeroDivisionError as error:
        trace = error.__traceback__
        return trace is not None and trace.tb_next is None
    except Exception:
        return False
    return False


_AVAILABLE = _works() and (sys.version_info < (3, 12) or sys.gettrace() is None)


def unseen(function: F) -> F:
    """Decorator: the frames of `function` (no generator) are not seen any more.

    Does nothing where that would not work.
    """
    if _AVAILABLE and isinstance(function, FunctionType) and _is_seen(function.__code__):
        function.__code__ = _never_complete(function.__code__)
    return function


def _is_seen(code: CodeType) -> bool:
    return _RESUME in code.co_code[:-6:2]  # not done yet


def unseen_methods(cls: type) -> None:
    """Makes the methods that `cls` defines unseen, with the functions that they were made from."""
    for method in vars(cls).values():
        if isinstance(method, FunctionType):
            unseen(method)
            for cell in method.__closure__ or ():
                if isinstance(cell.cell_contents, FunctionType):
                    unseen(cell.cell_contents)


@unseen
def untraced(function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """``function(*args, **kwargs)``, which with all that it calls is no business of a debugger."""
    tracer = sys.gettrace()
    if tracer is None:
        return function(*args, **kwargs)
    sys.settrace(None)
    try:
        return function(*args, **kwargs)
    finally:
        sys.settrace(tracer)


def without_ours(trace: TracebackType | None) -> TracebackType | None:
    """A traceback without the frames of our functions that were seen in it."""
    kept = []
    while trace is not None:
        if not trace.tb_frame.f_code.co_filename.startswith(_OURS):
            kept.append(trace)
        trace = trace.tb_next
    for one in reversed(kept):
        trace = TracebackType(trace, one.tb_frame, one.tb_lasti, one.tb_lineno)
    return trace
