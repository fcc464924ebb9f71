"""Instructions that `bytecode` (0.19) can neither read nor write, and what stands for them there.

Those of interpolations in t-strings (PEP 750), and of defaults of type parameters (PEP 696). In
their places it is shown instructions that take as many values and leave one: ``IS_OP`` takes two,
``MATCH_CLASS`` three. Their argument is marked by bits that no code has there, and holds that of
the instruction (see CPython's `dis`).
"""

from __future__ import annotations

import opcode
from types import CodeType
from typing import Any

_INTERPOLATION = opcode.opmap.get("BUILD_INTERPOLATION")  # since 3.14
_INTRINSIC = opcode.opmap.get("CALL_INTRINSIC_2")  # since 3.12
_MAY_NEED_SUBSTITUTES = {_INTERPOLATION, _INTRINSIC}
_SET_TYPE_PARAMETER_DEFAULT = 5  # since 3.13
_TAKES_TWO, _TAKES_THREE = opcode.opmap["IS_OP"], opcode.opmap["MATCH_CLASS"]
_STANDING = frozenset({"IS_OP", "MATCH_CLASS"})
_MARK, _IS_INTRINSIC, _HAS_SPECIFICATION = 0x80, 0x40, 0x01
_ARGUMENT = 0x3F


def readable(code: CodeType) -> CodeType:
    """Code as `bytecode` can read it; the same one if it can read all of that.

    Raises ValueError if there is our mark already: a class pattern of more than 127 parts.
    """
    changed = False
    instructions = bytearray(code.co_code)
    if not _MAY_NEED_SUBSTITUTES.intersection(instructions[::2]):
        return code
    for at in range(0, len(instructions), 2):
        name, argument = instructions[at : at + 2]
        other = _substitute(name, argument)
        if other is not None:
            instructions[at : at + 2] = other
            changed = True
        elif name in (_TAKES_TWO, _TAKES_THREE) and argument & _MARK:
            raise ValueError("a class pattern of too many parts")
    return code.replace(co_code=bytes(instructions)) if changed else code


def executable(code: CodeType) -> CodeType:
    """What has been made of code that `readable` has changed, as Python executes it."""
    instructions = bytearray(code.co_code)
    for at in range(0, len(instructions), 2):
        name, argument = instructions[at : at + 2]
        if name in (_TAKES_TWO, _TAKES_THREE) and argument & _MARK:
            original = "CALL_INTRINSIC_2" if argument & _IS_INTRINSIC else "BUILD_INTERPOLATION"
            instructions[at : at + 2] = opcode.opmap[original], argument & _ARGUMENT
    return code.replace(co_code=bytes(instructions))


def _substitute(name: int, argument: int) -> tuple[int, int] | None:
    if name == _INTERPOLATION:
        other = _TAKES_THREE if argument & _HAS_SPECIFICATION else _TAKES_TWO
        return other, argument | _MARK
    if name == _INTRINSIC and argument == _SET_TYPE_PARAMETER_DEFAULT:
        return _TAKES_TWO, argument | _MARK | _IS_INTRINSIC
    return None


def name_of(instr: Any) -> str:
    """The name of an instruction of `bytecode`, or of the one it stands for."""
    name: str = instr.name
    if name in _STANDING and instr.arg & _MARK:
        return "CALL_INTRINSIC_2" if instr.arg & _IS_INTRINSIC else "BUILD_INTERPOLATION"
    return name


def has_specification(instr: Any) -> bool:
    """Whether what stands for an interpolation takes a format specification."""
    return bool(instr.arg & _HAS_SPECIFICATION)
