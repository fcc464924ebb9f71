"""How a literal is written: the text for a new value, in the manner of the old text.

``0.50`` becomes ``0.75``, ``1_000`` becomes ``2_500``, ``0x0F`` becomes ``0x1F``. Every spelling is
read back before it is given: it is exactly the new value, or there is an error. Used where values
are written into files: Python literals (contract: `save`), YAML and JSON scalars (`files`).
"""

from __future__ import annotations

import ast
import functools
import io
import json
import math
import re
import tokenize
import warnings
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from .spelled_numbers import float_spellings, int_spellings
from .spelled_texts import text_spellings


class CannotSpell(ValueError):
    """There is no way to write the value in place of the old text; the message says why."""


def respell(
    text: str, old: Any, new: Any, *, before: str = "", after: str = "", encoding: str = "utf-8"
) -> str:
    """The Python literal for `new` in the manner of `text`.

    text    a literal, with its sign if it has one
    old     its value: a float, int, str or bool
    new     a value of the same type, or an int for a float
    before, after  what stands around it: a sign must not become somebody else's operator
    encoding       the file's; characters that it does not have are escaped

    Raises CannotSpell.
    """
    new = _converted(old, new)
    if same(old, new):
        return text
    spellings: Iterable[str]
    if type(new) is str:
        prefix, quote, body = _python_string(text)
        spellings = text_spellings(prefix, quote, body, new, encoding)
    else:
        spellings = _numbers(text, old, new, ("True", "False"))
    _understand(text, old, _python_value)
    return _fitted(_first(spellings, new, _python_value), before, after)


def respell_piece(
    text: str, old: str, new: str, *, prefix: str = "f", quote: str = '"', encoding: str = "utf-8"
) -> str:
    """`new` in place of the literal piece `text` between the fields of an f-string.

    prefix, quote  how the f-string begins

    Raises CannotSpell.
    """
    new = _converted(old, new)
    if same(old, new):
        return text
    value_of = functools.partial(_piece_value, prefix, quote)
    _understand(text, old, value_of)
    return _first(text_spellings(prefix, quote, text, new, encoding, True), new, value_of)


def respell_json(text: str, old: Any, new: Any, *, encoding: str = "utf-8") -> str:
    """The JSON scalar for `new` in the manner of `text`; see `respell`."""
    new = _converted(old, new)
    if same(old, new):
        return text
    _understand(text, old, json.loads)
    spellings: Iterable[str]
    if type(new) is str:
        ascii_only = "\\u" in text and text.isascii()
        if ascii_only or not _encodable(new, encoding):
            spellings = (json.dumps(new),)
        else:
            spellings = (json.dumps(new, ensure_ascii=False), json.dumps(new))
    else:
        spellings = _numbers(text, old, new, ("true", "false"))
    return _first(spellings, new, json.loads)


def respell_yaml(
    text: str, old: Any, new: Any, *, loader: Any = None, encoding: str = "utf-8"
) -> str:
    """The YAML scalar for `new` in the manner of `text`; see `respell`.

    text    a plain or quoted scalar; block scalars are refused
    loader  the class that will read it, by default `yaml.SafeLoader`
    """
    new = _converted(old, new)
    if same(old, new):
        return text
    if text[:1] in ("|", ">"):
        raise CannotSpell("a block scalar is not rewritten")
    if not _encodable(new, encoding):
        encoding = "ascii"
    spellings: Iterable[str]
    if type(new) is str:
        spellings = _yaml_strings(text, new, encoding)
    else:
        spellings = _numbers(text, old, new, _yaml_words(text))
    contexts = _yaml_contexts(loader, text, old)
    if not contexts:
        raise CannotSpell(f"{text} is not understood as {old!r}")
    return _first(
        spellings,
        new,
        lambda spelled: new if _yaml_contexts(loader, spelled, new) >= contexts else None,
    )


def same(a: Any, b: Any) -> bool:
    """Whether two plain values are the same in type and in every bit that can be written."""
    if type(a) is not type(b) or a != b:
        return False
    return type(a) is not float or math.copysign(1.0, a) == math.copysign(1.0, b)


def _converted(old: Any, new: Any) -> Any:
    if type(old) is float and type(new) is int:
        try:
            new = float(new)
        except OverflowError:
            raise CannotSpell(f"{new} is too large for a float") from None
    if type(new) is not type(old) or type(new) not in (float, int, str, bool):
        raise CannotSpell(f"a {type(old).__name__} does not become a {type(new).__name__}")
    if type(new) is float and not math.isfinite(new):
        raise CannotSpell(f"{new} is no literal")
    return new


def _numbers(text: str, old: Any, new: Any, words: tuple[str, str]) -> Iterable[str]:
    """Spellings of what is no text; `words` are those for true and false."""
    if type(new) is bool:
        return (words[0] if new else words[1],)
    if type(new) is int:
        return int_spellings(text, old, new)
    return float_spellings(text, new)


def _first(spellings: Iterable[str], new: Any, value_of: Callable[[str], Any]) -> str:
    """The first of the spellings that is read as `new`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Python, about the escapes that a program uses
        for spelled in spellings:
            try:
                if same(value_of(spelled), new):
                    return spelled
            except Exception:  # each reader has its own; a proposal that cannot be read is none
                continue
    raise CannotSpell(f"{new!r} cannot be written here")


def _understand(text: str, value: Any, value_of: Callable[[str], Any]) -> None:
    """Raises CannotSpell unless `text` is read as `value`."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            understood = same(value_of(text), value)
    except Exception:  # each reader has its own
        understood = False
    if not understood:
        raise CannotSpell(f"{text} is not understood as {value!r}")


def _encodable(value: Any, encoding: str) -> bool:
    try:
        str(value).encode(encoding)
    except UnicodeEncodeError:
        return False
    return True


# ---------------------------------------------------------------- Python


_STRING = re.compile(r"([A-Za-z]*)('''|\"\"\"|'|\")(.*)\2", re.DOTALL)
_NAME_BEFORE = re.compile(r"\w\Z")
_SPACE = re.compile(r"(?:\s|\\\r?\n|#[^\r\n]*)*")


def _python_value(text: str) -> Any:
    return ast.literal_eval(f"({text})")


def _python_string(text: str) -> tuple[str, str, str]:
    """Prefix, quote and body of a string literal."""
    found = _STRING.fullmatch(text)
    if found is None or _count_strings(text) != 1:
        raise CannotSpell("it is written as several strings in a row")
    if "f" in found[1].lower() or "b" in found[1].lower():
        raise CannotSpell(f"it is no plain string: {text}")
    return found[1], found[2], found[3]


def _count_strings(text: str) -> int:
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(f"({text}\n)").readline))
    except (tokenize.TokenError, SyntaxError):
        return 0
    return sum(token.type == tokenize.STRING for token in tokens)


def _piece_value(prefix: str, quote: str, piece: str) -> str | None:
    tree: Any = ast.parse(f"({prefix}{quote}{piece}{quote})", mode="eval").body
    if isinstance(tree, ast.Constant):
        return str(tree.value)
    if all(isinstance(part, ast.Constant) for part in tree.values):
        return "".join(part.value for part in tree.values)
    return None


def _fitted(spelled: str, before: str, after: str) -> str:
    """`spelled` so that it stays one operand between `before` and `after`."""
    follows = after[_SPACE.match(after).end() :]  # type: ignore[union-attr]
    if spelled[0] in "+-" and (follows.startswith("**") or follows[:1] in (".", "[", "(")):
        return f"({spelled})"
    if _NAME_BEFORE.search(before) and re.match(r"\w", spelled):
        spelled = " " + spelled
    if re.match(r"\w", after) and re.search(r"[\w.]\Z", spelled):
        spelled += " "
    return spelled


# ---------------------------------------------------------------- JSON and YAML


_CONTEXTS = ("{}\n", "key: {}\n", "- {}\n", "[{}]\n", "{{key: {}}}\n", "[{}, 0]\n")
"""Where a scalar can stand. One that can stand wherever the old one can is right."""


def _yaml_contexts(loader: Any, text: str, value: Any) -> set[str]:
    """The contexts in which `text` is `value`; for a number they do not matter."""
    contexts = _CONTEXTS if type(value) is str else _CONTEXTS[-1:]
    return {one for one in contexts if _is_in_yaml(loader, one, text, value)}


def _is_in_yaml(loader: Any, context: str, text: str, value: Any) -> bool:
    import yaml

    try:
        found = yaml.load(context.format(text), Loader=loader or yaml.SafeLoader)
        while isinstance(found, (dict, list)):
            found = found["key"] if isinstance(found, dict) else found[0]
    except (yaml.YAMLError, ValueError, LookupError):
        return False
    return same(found, value)


def _yaml_words(text: str) -> tuple[str, str]:
    """The words for true and false that go with `text`."""
    for words in (("true", "false"), ("yes", "no"), ("on", "off")):
        if text.lower() in words:
            if text.isupper():
                return words[0].upper(), words[1].upper()
            if text[0].isupper():
                return words[0].title(), words[1].title()
            return words
    return "true", "false"


def _yaml_strings(text: str, new: str, encoding: str) -> Iterator[str]:
    single = "'" + new.replace("'", "''") + "'"
    if new.isprintable() and _encodable(new, encoding):
        if text[:1] not in ("'", '"'):
            yield new
        if text[:1] != '"':
            yield single
    yield '"' + "".join(_yaml_char(char, encoding) for char in new) + '"'


def _yaml_char(char: str, encoding: str) -> str:
    if char in '\\"':
        return "\\" + char
    if char in "\n\t\r":
        return {"\n": "\\n", "\t": "\\t", "\r": "\\r"}[char]
    if char.isprintable() and _encodable(char, encoding):
        return char
    code = ord(char)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
