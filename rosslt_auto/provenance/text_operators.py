"""The operators that strings can pass through: further rows of the table in `operators`.

Their inverses read: a wanted text is taken apart again, along the pieces that it was made of,
and each piece is parsed back into a value of the kind it came from.
"""

from __future__ import annotations

import re
import string
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from .operator_table import AnyOperands, Inverse, Operator, add

Piece = tuple[Any, str | None, str]
"""A value, its conversion (None, "s", "r", "a" or "%"), and its format specification."""


class NoSuchText(ValueError):
    """A wanted text cannot be made here."""


def formatted(value: Any, conversion: str | None, spec: str) -> str:
    """One piece as text: as in an f-string, or with a printf-style specification ("%")."""
    if conversion == "%":
        return spec % (value,)
    convert = _CONVERSIONS.get(conversion)
    if convert is not None:
        value = convert(value)
    return format(value, spec)


_CONVERSIONS: dict[str | None, Callable[[Any], str]] = {"s": str, "r": repr, "a": ascii}


def parsed(text: str, old: Any, conversion: str | None, spec: str) -> Any:
    """The value of the kind of `old` whose formatted text is `text`; raises NoSuchText.

    A text with fewer digits than the specification would print is accepted: ``4`` for ``4.00``.
    """
    kind = spec[-1:] if spec else ""
    bare = text.strip().strip(_fill(spec)) if type(old) is not str else text
    try:
        value = _READERS[type(old)](bare.replace(",", ""), kind)
    except (KeyError, ValueError):
        raise NoSuchText(f"{text!r} is not a {type(old).__name__}") from None
    if type(old) is not str:
        return value
    for candidate in (value, value.strip()):
        if formatted(candidate, conversion, spec) == text:
            return candidate
    raise NoSuchText(f"{text!r} does not fit {spec!r}")


def _fill(spec: str) -> str:
    found = re.match(r"(.)[<>=^]", spec)
    fill = found.group(1) if found else " "
    return " " if fill in "0123456789+-." else fill


_BASES = {"x": 16, "X": 16, "o": 8, "b": 2}


def _read_int(text: str, kind: str) -> int:
    return int(text, _BASES.get(kind, 10))


def _read_float(text: str, kind: str) -> float:
    return float(text.removesuffix("%")) / 100 if kind == "%" else float(text)


_READERS = {int: _read_int, float: _read_float, str: lambda text, kind: text}


# ---------------------------------------------------------------- pieces


def join_pieces(*operands: Any) -> str:
    """The text of an f-string; `operands` are (value, conversion, specification) in a row."""
    return "".join(formatted(*piece) for piece in pieces_of(operands))


def pieces_of(operands: Sequence[Any]) -> list[Piece]:
    """`operands` in threes."""
    return list(zip(*[iter(operands)] * 3, strict=True))


def _piece_inverse(index: int) -> Inverse | None:
    if index % 3:
        return None

    def inverse(target: str, *operands: Any) -> Any:
        texts = [formatted(*piece) for piece in pieces_of(operands)]
        at = index // 3
        middle = cut(target, "".join(texts[:at]), "".join(texts[at + 1 :]))
        return parsed(middle, operands[index], *operands[index + 1 : index + 3])

    return inverse


def cut(target: str, before: str, after: str) -> str:
    """What stands in `target` between two texts that have to be there."""
    if not isinstance(target, str):
        raise NoSuchText(f"{target!r} is not a text")
    if len(target) < len(before) + len(after):
        raise NoSuchText("the text is too short")
    if not target.startswith(before):
        raise NoSuchText(f"the text has to begin with {before!r}")
    if not target.endswith(after):
        raise NoSuchText(f"the text has to end with {after!r}")
    return target[len(before) : len(target) - len(after)]


# ---------------------------------------------------------------- templates


def percent_pieces(template: str, args: tuple[Any, ...]) -> list[Piece] | None:
    """What ``template % args`` is made of; None if it is more than plain positional pieces."""
    pieces: list[Piece] = []
    rest = list(args)
    end = 0
    for found in re.finditer(r"%([-+ #0]*\d*(?:\.\d+)?)([a-zA-Z%])", template):
        if found.group(2) == "%":
            continue
        if not rest:
            return None
        pieces += [(_unescaped(template[end : found.start()], "%"), None, "")]
        pieces += [(rest.pop(0), "%", found.group())]
        end = found.end()
    pieces.append((_unescaped(template[end:], "%"), None, ""))
    return None if rest else pieces


def format_pieces(
    template: str, args: tuple[Any, ...], names: dict[str, Any]
) -> list[Piece] | None:
    """What ``template.format(*args, **names)`` is made of; None if a specification is nested."""
    pieces: list[Piece] = []
    formatter = string.Formatter()
    count = 0
    before = ""
    try:
        for text, field, spec, conversion in formatter.parse(template):
            before += text  # doubled braces come as texts of their own
            if field is None:
                continue
            if spec and "{" in spec:
                return None
            if field == "" or field[0] in ".[":
                field, count = f"{count}{field}", count + 1
            value, _ = formatter.get_field(field, args, names)
            pieces += [(before, None, ""), (value, conversion, spec or "")]
            before = ""
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        return None
    return [*pieces, (before, None, "")]


def _unescaped(text: str, sign: str) -> str:
    return text.replace(sign * 2, sign)


def _template_inverse(target: str, template: str, args: tuple[Any, ...], percent: bool) -> str:
    """The template that gives `target` with the same values: only its own text may differ."""
    found = percent_pieces(template, args) if percent else format_pieces(template, args, {})
    if found is None:
        raise NoSuchText("the template cannot be taken apart")
    values = found[1::2]  # between the texts
    pattern = "(.*?)" + "(.*?)".join(re.escape(formatted(*piece)) for piece in values) + "(.*)"
    if not values:
        pattern = "(.*)"
    match = re.fullmatch(pattern, target, re.DOTALL)
    if match is None:
        raise NoSuchText("the values that stand in the text have to stay")
    signs = _signs(template, percent)
    texts = [_escaped(text, percent) for text in match.groups()]
    return "".join(t + s for t, s in zip(texts, [*signs, ""], strict=True))


def _signs(template: str, percent: bool) -> list[str]:
    if percent:
        signs = re.finditer(r"%[-+ #0]*\d*(?:\.\d+)?[a-zA-Z%]", template)
        return [found.group() for found in signs if found.group() != "%%"]
    return [f"{{{found}}}" for found in re.findall(r"(?<!\{)\{([^{}]*)\}", template)]


def _escaped(text: str, percent: bool) -> str:
    return text.replace("%", "%%") if percent else text.replace("{", "{{").replace("}", "}}")


def _percent(template: str, *args: Any) -> str:
    return template % args


def _format(template: str, *args: Any) -> str:
    return template.format(*args)


def _templated(percent: bool) -> Any:
    take_apart = (
        percent_pieces if percent else (lambda template, args: format_pieces(template, args, {}))
    )

    def make_inverse(index: int) -> Inverse:
        def inverse(target: str, template: str, *args: Any) -> Any:
            if index == 0:
                return _template_inverse(target, template, args, percent)
            marked = tuple(_Marked(arg, i + 1 == index) for i, arg in enumerate(args))
            found = take_apart(template, marked)
            at = [
                i for i, (value, _, _) in enumerate(found or ()) if getattr(value, "wanted", False)
            ]
            if len(at) != 1:
                raise NoSuchText("the value does not stand in the text once")
            pieces = [
                (value.value if isinstance(value, _Marked) else value, conversion, spec)
                for value, conversion, spec in found or ()
            ]
            flat = [part for piece in pieces for part in piece]
            solve = _piece_inverse(3 * at[0])
            assert solve is not None
            return solve(target, *flat)

        return inverse

    return make_inverse


class _Marked:
    """An argument on its way through a template."""

    def __init__(self, value: Any, wanted: bool) -> None:
        self.value = value
        self.wanted = wanted


# ---------------------------------------------------------------- rows


def _joined(separator: str, *parts: str) -> str:
    return separator.join(parts)


def _join_inverse(index: int) -> Inverse | None:
    if index == 0:
        return None

    def inverse(target: str, separator: str, *parts: str) -> str:
        before = "".join(part + separator for part in parts[: index - 1])
        after = "".join(separator + part for part in parts[index:])
        return cut(target, before, after)

    return inverse


def _part_inverse(index: int) -> Inverse:
    inverse = _join_inverse(index + 1)
    assert inverse is not None
    return lambda target, *parts: inverse(target, "", *parts)


def _sliced(text: str, *bounds: Any) -> str:
    return text[bounds[0]] if len(bounds) == 1 else text[slice(*bounds)]


def _unsliced(target: str, text: str, *bounds: Any) -> str:
    start, stop, step = (
        slice(*bounds).indices(len(text)) if len(bounds) > 1 else (bounds[0] % len(text), None, 1)
    )
    if stop is None:
        stop = start + 1
    if step != 1 or (len(bounds) == 1 and len(target) != 1):
        raise NoSuchText("only a whole part of the text can be replaced")
    return text[:start] + target + text[max(start, stop) :]


def _unrepeated(target: str, text: str, count: int) -> str:
    piece = target[: len(target) // count]
    if piece * count != target:
        raise NoSuchText(f"the text has to be {count} times the same")
    return piece


def _recount(target: str, text: str, count: int) -> int:
    times = len(target) // len(text)
    if text * times != target:
        raise NoSuchText(f"the text has to be {text!r} repeated")
    return times


def _unstrip(target: str, text: str) -> str:
    bare = text.strip()
    return text.replace(bare, target) if bare else target


def _unstr(target: str, value: Any) -> Any:
    return parsed(target, value, None, "")


for _row in (
    Operator("concat", "+", 12, lambda a, b: a + b,
             (lambda t, a, b: cut(t, "", b), lambda t, a, b: cut(t, a, ""))),
    Operator("repeat", "*", 13, lambda a, n: a * n, (_unrepeated, _recount)),
    Operator("str", "str", None, str, (_unstr,)),
    Operator("repr", "repr", None, repr, (None,)),
    AnyOperands("slice", "slice", _sliced, lambda index: _unsliced if index == 0 else None),
    AnyOperands("join", "join", _joined, _join_inverse),
    # What is left of a text that was cut, as long as its parts keep their lengths.
    AnyOperands("excerpts", "excerpts", partial(_joined, ""), _part_inverse),
    AnyOperands("pieces", "f", join_pieces, _piece_inverse),
    AnyOperands("percent", "%", _percent, _templated(True)),
    AnyOperands("format", "format", _format, _templated(False)),
    Operator("upper", "upper", None, str.upper),
    Operator("lower", "lower", None, str.lower),
    Operator("strip", "strip", None, str.strip, (_unstrip,)),
    # What is left of a text that has grown too long a history: its sources, and no way back.
    Operator("remembered", "from", None, lambda text, *sources: text,
             domain="of this text no more is known than its sources"),
):  # fmt: skip
    add(_row)
