"""Literals keep the way they were written, and are exactly the new value."""

import ast
import json
import warnings

import pytest
import yaml
from hypothesis import assume, given
from hypothesis import strategies as st

from rosslt_auto.provenance.spelling import (
    CannotSpell,
    respell,
    respell_json,
    respell_piece,
    respell_yaml,
    same,
)

finite = st.floats(allow_nan=False, allow_infinity=False)
float_texts = st.sampled_from(
    ["0.5", ".5", "5.", "0.50", "1e-3", "1E3", "1.50e+03", "100e-3", ".5e3", "1_000.5", "007.5"]
    + ["-1.5", "- 1.5", "+2.0", "1.e5", "1e-300", "0.000_001", "0.0", "-0.0", "0e0", "1e22"]
)
int_texts = st.sampled_from(
    ["5", "0", "00", "-7", "- 7", "+3", "1_000", "1_000_000", "10_0_0", "0xFF", "0xff", "0XAB"]
    + ["0x0f", "0xFFFF_0000", "0x_ff", "0o17", "0O7", "0b0101", "0B1", "-0x10", "0b1111_0000"]
)
string_texts = st.sampled_from(
    ["''", '""', "'abc'", '"abc"', '"""a\nb"""', "'''x'''", r"r'a\d'", 'R"x"', "u'x'", r"'\x1b[0m'"]
    + [r"'\033[0m'", r"'a\tb'", "'a\tb'", r"'\d'", r"'\N{BULLET} x'", "'a\\\nb'", "'''a\r\nb'''"]
    + [r"'it\'s'", r'"\u00e9"', "'é'", r"r'\''"]
)


def value_of(text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ast.literal_eval(f"({text})")


@pytest.mark.parametrize(
    ("text", "new", "expected"),
    [
        ("0.50", 0.75, "0.75"),
        ("0.50", 1, "1.00"),
        ("2.0", 3, "3.0"),
        ("0.5", 0.123456, "0.123456"),
        ("0.5", 1.4142135623730954, "1.4142135623730954"),
        (".5", 0.75, ".75"),
        (".5", 1.5, "1.5"),
        (".5", -0.25, "-.25"),
        ("5.", 6.0, "6."),
        ("5.", 5.5, "5.5"),
        ("1e-3", 0.0025, "2.5e-3"),
        ("1e-3", 0.5, "5e-1"),
        ("1E3", 2500.0, "2.5E3"),
        ("100e-3", 0.15, "150e-3"),
        ("1.50e-03", 0.002, "2.00e-03"),
        ("1e+3", 2e5, "2e+5"),
        ("1e-3", 0.0, "0e-3"),
        ("0.0", 0.00005, "0.00005"),
        ("1.0", 5e-20, "5e-20"),
        ("1_000.5", 2e6, "2_000_000.0"),
        ("-1.5", 2.0, "2.0"),
        ("- 1.5", -2.0, "- 2.0"),
        ("+1.5", 2.0, "+2.0"),
        ("1.5", -2.0, "-2.0"),
        ("-(1.5)", -2.5, "-2.5"),
        ("1_000", 2500, "2_500"),
        ("1_000", 7, "7"),
        ("0xFF", 10, "0x0A"),
        ("0x0f", 31, "0x1f"),
        ("0xFFFF_0000", 1, "0x0000_0001"),
        ("0o17", 8, "0o10"),
        ("0b1010", 5, "0b0101"),
        ("00", 5, "5"),
        ("True", False, "False"),
        ("'a'", "it's", r"'it\'s'"),
        ('"a"', "it's", '"it\'s"'),
        (r"'\x1b[0m'", "\x1b[1m", r"'\x1b[1m'"),
        (r"'\033[0m'", "\033[0m\033", r"'\033[0m\033'"),
        (r"r'a\d'", r"b\d", r"r'b\d'"),
        (r"r'a\d'", "b\n", r"'b\n'"),
        ('"""a\nb"""', "a\nc\nd", '"""a\nc\nd"""'),
        ("'''a\r\nb'''", "a\nb\nc", "'''a\r\nb\r\nc'''"),
        ('"""a"""', 'say "x"', '"""say "x\\""""'),
        ("'a b'", "a\tb", r"'a\tb'"),
        ("'a\tb'", "a\tb\t", "'a\tb\t'"),
    ],
)
def test_a_literal_keeps_its_manner(text, new, expected):
    assert respell(text, value_of(text), new) == expected


def check(text, new):
    old = value_of(text)
    spelled = respell(text, old, new)
    assert same(value_of(spelled), new)
    assert respell(text, old, old) == text
    assert respell(spelled, new, new) == spelled
    return spelled


@given(float_texts, finite)
def test_floats_are_exact(text, new):
    spelled = check(text, new)
    if "e" not in text.lower() and "e" not in spelled.lower():
        kept = len(text.partition(".")[2].replace("_", ""))
        assert len(spelled.partition(".")[2].replace("_", "")) >= kept
    if "e" in text.lower():
        assert "e" in spelled.lower() and ("E" in text) == ("E" in spelled)


@given(int_texts, st.integers())
def test_ints_are_exact_and_keep_their_base(text, new):
    spelled = check(text, new).lstrip("+- ")
    text = text.lstrip("+- ")
    if text[:2].lower() in ("0x", "0o", "0b"):
        assert spelled[:2] == text[:2]
        digits = spelled[2:].replace("_", "")
        assert len(digits) >= len(text[2:].replace("_", ""))


@given(string_texts, st.text(st.characters(), max_size=12))
def test_strings_are_exact_and_keep_their_quotes(text, new):
    spelled = check(text, new)
    assert spelled[-1] == text[-1]
    if "\n" not in text and "\r" not in text:
        assert "\n" not in spelled and "\r" not in spelled


@given(string_texts, st.text(max_size=6))
def test_what_an_encoding_lacks_is_escaped(text, new):
    spelled = respell(text, value_of(text), new, encoding="ascii")
    if text.isascii():
        assert spelled.isascii()
    assert value_of(spelled) == new


@given(st.sampled_from([("f", '"'), ("F", "'"), ("f", '"""'), ("f", "'''")]), st.text(max_size=8),
       st.text(max_size=8))  # fmt: skip
def test_pieces_of_f_strings_double_their_braces(how, old, new):
    prefix, quote = how
    text = respell_piece("", "", old, prefix=prefix, quote=quote)
    spelled = respell_piece(text, old, new, prefix=prefix, quote=quote)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert eval(f"{prefix}{quote}{spelled}{{0}}{quote}") == new + "0"


def test_a_piece_keeps_what_stays():
    assert respell_piece(r"a\x41{{", "aA{", "aA{}") == r"a\x41{{}}"


@pytest.mark.parametrize(
    ("text", "new"),
    [("1.5", "x"), ("5", 1.5), ("5", True), ("1.5", float("nan")), ("1.5", float("inf")),
     ("1.5", 10**400), ("'a'", 5), ("'a' 'b'", "x"), ("'a'\n'b'", "x")],
)  # fmt: skip
def test_what_cannot_be_written_is_refused(text, new):
    with pytest.raises(CannotSpell, match=r"\w"):
        respell(text, value_of(text), new)


@pytest.mark.parametrize(("text", "old"), [("x", 5), ("6", 5), ("5", 5.0), ("f'{x}'", "5")])
def test_a_text_that_is_not_the_old_value_is_refused(text, old):
    with pytest.raises(CannotSpell):
        respell(text, old, old * 2)


@pytest.mark.parametrize(
    ("before", "text", "new", "after"),
    [
        ("", "2", -3, " ** 2"),
        ("", "2", -3, " # a\n ** 2"),
        ("-", "2", -3, "**2"),
        ("", "2.5", -3.5, ".hex()"),
        ("1-", "2", -3, ""),
        ("1 if 0 else", ".5", 1.5, ""),
        ("", "1_0", 20, "if 1 else 0"),
        ("", "5.", 6.5, "if 1 else 0"),
        ("2 **", "2", -1, ""),
    ],
)
def test_a_new_literal_stays_one_operand(before, text, new, after):
    spelled = respell(text, value_of(text), new, before=before, after=after)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert eval(f"({before}{spelled}{after}\n)") == eval(f"({before} ({new}) {after}\n)")


yaml_texts = st.sampled_from(
    [
        "0.5",
        ".5",
        "5.",
        "0.50",
        "1.0e-3",
        "-0.5",
        "1_0.5",
        "5",
        "0x1F",
        "010",
        "0b11",
        "1_000",
        "-3",
    ]
    + [
        "abc",
        "a b",
        "'a'",
        '"a"',
        "'it''s'",
        '"\\u00e9"',
        "yes",
        "True",
        "OFF",
        "'5'",
        "a, b",
        "1e3",
    ]
)


@given(yaml_texts, finite, st.integers(), st.text(max_size=8), st.booleans())
def test_yaml_scalars_are_exact(text, a_float, an_int, a_text, a_bool):
    old = yaml.safe_load(text)
    new = {float: a_float, int: an_int, str: a_text, bool: a_bool}[type(old)]
    try:
        spelled = respell_yaml(text, old, new)
    except CannotSpell:
        assert any("\ud800" <= char <= "\udfff" for char in new)
        return
    assert same(yaml.safe_load(f"k: {spelled} # c\nl: 1\n")["k"], new)
    assert same(yaml.safe_load(f"- {spelled}\n- 1\n")[0], new)
    if yaml.safe_load(f"[{text}]") == [old]:
        assert yaml.safe_load(f"[{spelled}, 1]") == [new, 1]
    assert respell_yaml(spelled, new, new) == spelled


@pytest.mark.parametrize(
    ("text", "new", "expected"),
    [
        (".5", -0.5, "-0.5"),
        ("1.0e-3", 100.0, "1.0e+2"),
        ("0.50", 1, "1.00"),
        ("010", 9, "011"),
        ("0x0f", 31, "0x1f"),
        ("abc", "x", "x"),
        ("abc", "5", "'5'"),
        ("abc", "no", "'no'"),
        ("abc", "x: y", "'x: y'"),
        ("abc", "a\nb", '"a\\nb"'),
        ("abc", "", "''"),
        ("abc", "---", "'---'"),
        ("a, b", "a, c", "a, c"),
        ("'a'", "it's", "'it''s'"),
        ('"a"', "b", '"b"'),
        ("yes", False, "no"),
        ("OFF", True, "ON"),
        ("True", False, "False"),
    ],
)
def test_a_yaml_scalar_keeps_its_manner(text, new, expected):
    assert respell_yaml(text, yaml.safe_load(text), new) == expected


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [("|\n  a", "a", "b"), (".inf", 1.0, 2.0), ("5", 5, 2.5), ("1.5", 1.5, float("inf"))],
)
def test_yaml_refuses(text, old, new):
    with pytest.raises(CannotSpell):
        respell_yaml(text, old, new)


json_texts = st.sampled_from(
    ["0.5", "1e3", "1E-05", "-2.50", "5", "-7", '"a"', r'"\u00e9"', "true"]
)
any_text = st.text(st.characters(), max_size=8)


@given(json_texts, finite, st.integers(), any_text, st.booleans())
def test_json_scalars_are_exact(text, a_float, an_int, a_text, a_bool):
    old = json.loads(text)
    new = {float: a_float, int: an_int, str: a_text, bool: a_bool}[type(old)]
    assume(not (type(new) is int and abs(new) > 10**300))
    spelled = respell_json(text, old, new, encoding="ascii")
    assert spelled.isascii()
    assert same(json.loads(spelled), new)


def test_json_keeps_its_manner():
    assert respell_json("1.50", 1.5, 2) == "2.00"
    assert respell_json("1E5", 1e5, 2e5) == "2E5"
    assert respell_json('"é"', "é", "é\n") == '"é\\n"'
    assert respell_json(r'"\u00e9"', "é", "éé") == r'"\u00e9\u00e9"'
