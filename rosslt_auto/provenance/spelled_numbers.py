"""How numbers are written: the shape of an old one, filled with a new value.

A shape is a proposal. Whoever asks reads every proposal back, and takes the first one that is
exactly the value (`spelling`); that is what makes the result right, also in a format with narrower
rules than Python's.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from decimal import Decimal

_SIGNED = re.compile(r"([+-]?)(\s*)(.*)", re.DOTALL)
_FLOAT = re.compile(r"([0-9_]*)(\.?)([0-9_]*)(?:([eE])([+-]?)([0-9_]+))?")
_INT = re.compile(r"(0[xX]|0[oO]|0[bB]|)([0-9a-fA-F_]+)")
_BASES = {"x": 16, "o": 8, "b": 2, "": 10}

_SMALLEST_EXPONENT = -7
_LARGEST_EXPONENT = 16
"""Between these a number without an exponent gets none: what a person would write out."""


def float_spellings(text: str, new: float) -> Iterator[str]:
    """Spellings of `new`, the one most like `text` first."""
    sign, gap, body = _parts(text)
    shape = _FLOAT.fullmatch(body)
    if shape:
        for leading_zero in (False, True):
            for exponent_sign in (shape[5] or "", "+"):
                spelled = _shaped_float(shape, abs(new), leading_zero, exponent_sign)
                yield _with_sign(sign, gap, _is_negative(new), spelled)
    yield repr(new)
    mantissa, _, exponent = repr(new).partition("e")
    if exponent:
        yield f"{mantissa if '.' in mantissa else mantissa + '.0'}e{int(exponent):+d}"


def int_spellings(text: str, old: int, new: int) -> Iterator[str]:
    """Spellings of `new`, the one most like `text`, which is read as `old`, first."""
    sign, gap, body = _parts(text)
    shape = _INT.fullmatch(body)
    if shape:
        if _is_octal_of_yaml(body, abs(old)):
            digits = "0" + format(abs(new), "o").zfill(len(body) - 1)
            yield _with_sign(sign, gap, new < 0, digits)
        yield _with_sign(sign, gap, new < 0, _shaped_int(shape, abs(new)))
    yield repr(new)


def _parts(text: str) -> tuple[str, str, str]:
    found = _SIGNED.fullmatch(text)
    assert found
    return found[1], found[2], found[3]


def _is_negative(value: float) -> bool:
    return math.copysign(1.0, value) < 0


def _with_sign(sign: str, gap: str, negative: bool, spelled: str) -> str:
    if negative:
        return f"-{gap if sign else ''}{spelled}"
    return f"+{gap}{spelled}" if sign == "+" else spelled


# ---------------------------------------------------------------- floats


def _shaped_float(
    shape: re.Match[str], new: float, leading_zero: bool, exponent_sign: str
) -> str:  # fmt: skip
    whole, mark, exponent = shape[1], shape[4], shape[6]
    number = Decimal(repr(new))
    if mark:
        power = _exponent(whole, int(shape[5] + exponent), number)
        spelled = _mantissa(shape, number.scaleb(-power), leading_zero)
        digits = str(abs(power)).zfill(len(exponent) if exponent[0] == "0" else 1)
        if power < 0:
            return f"{spelled}{mark}-{digits}"
        return f"{spelled}{mark}{'+' if exponent_sign == '+' else ''}{digits}"
    if number and not _SMALLEST_EXPONENT <= number.adjusted() < _LARGEST_EXPONENT:
        return re.sub(r"e([+-])0+", r"e\1", repr(new))
    return _mantissa(shape, number, leading_zero)


def _exponent(whole: str, exponent: int, number: Decimal) -> int:
    """The exponent to write `number` with, where one with the integer part `whole` stood."""
    if not number:
        return exponent
    wanted = len(whole.replace("_", "").lstrip("0"))
    digits = number.adjusted() - exponent + 1
    if digits == wanted or (wanted > 1 and 0 < digits <= 4):
        return exponent
    return number.adjusted() + (1 if wanted == 0 else 0)


def _mantissa(shape: re.Match[str], number: Decimal, leading_zero: bool) -> str:
    whole, dot, decimals, mark = shape[1], shape[2], shape[3], shape[4]
    new_whole, _, new_decimals = format(number, "f").partition(".")
    new_decimals = new_decimals.rstrip("0").ljust(len(decimals.replace("_", "")), "0")
    if whole[:1] == "0" and len(whole) > 1:
        new_whole = new_whole.zfill(len(whole.replace("_", "")))
    if not whole and new_whole == "0" and new_decimals and not leading_zero:
        new_whole = ""
    new_whole = _grouped(new_whole, whole)
    if new_decimals:
        return f"{new_whole}.{_grouped(new_decimals[::-1], decimals[::-1])[::-1]}"
    if dot:
        return f"{new_whole}.{'0' if leading_zero else ''}"
    return new_whole if mark and not leading_zero else f"{new_whole}.0"


# ---------------------------------------------------------------- integers


def _shaped_int(shape: re.Match[str], new: int) -> str:
    prefix, digits = shape.groups()
    base = _BASES[prefix[1:].lower()]
    spelled = format(new, {16: "x", 8: "o", 2: "b", 10: "d"}[base])
    if base != 10:
        spelled = spelled.zfill(len(digits.replace("_", "")))
    if digits != digits.lower() or (prefix == "0X" and digits == digits.upper()):
        spelled = spelled.upper()
    return prefix + _grouped(spelled, digits)


def _is_octal_of_yaml(body: str, value: int) -> bool:
    return bool(re.fullmatch("0[0-7]+", body)) and int(body, 8) == value


def _grouped(digits: str, like: str) -> str:
    """`digits` with underscores in groups of the size that `like` has them in, from the right."""
    first, *groups = like.split("_")
    sizes = {len(group) for group in groups}
    if len(sizes) != 1 or len(first) > (size := sizes.pop()) or not size:
        return digits
    start = len(digits) % size
    parts = [digits[:start], *(digits[i : i + size] for i in range(start, len(digits), size))]
    return ("_" if not first else "") + "_".join(part for part in parts if part)
