"""Random Python modules as source texts, for hypothesis.

A program computes with floats (`f0`, `f1` ...), ints (`i0` ...), texts (`s0` ...) and lists of
floats (`v0` ...), in loops, functions, closures, comprehensions and classes. Wherever it decides
what to do next it says so: `t(what)` notes what in `trace` and gives it back. Two runs with the
same trace have computed the same expressions.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from hypothesis import strategies as st

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

PROLOGUE = """\
import array
import math
import statistics
from math import hypot, sqrt
trace = []
def t(what):
    trace.append(int(what))
    return what
"""

FLOAT, INT, TEXT, LIST = "fisv"

# F, I, S, V stand for operands, N for a float or an int, C for a condition. Literals that are
# written out have no location or are no number of the expression's.
EXPRESSIONS: dict[str, tuple[str, ...]] = {
    FLOAT: (
        "(N + F)", "(F - N)", "(F * F)", "(N * F)", "(F / N)", "(N / N)", "(F // N)", "(F % F)",
        "-F", "+F", "(F ** 2)", "abs(F)", "min(F, F)", "max(F, F, F)", "round(F, 2)", "float(I)",
        "math.sin(N)", "math.cos(F)", "math.atan2(F, F)", "sqrt(abs(F))", "hypot(F, F)",
        "math.exp(min(F, 3.0))", "math.tanh(F)", "math.radians(F)", "math.fmod(F, F)",
        "math.log(F)", "math.asin(F)", "math.copysign(F, F)", "math.fsum(V)", "(math.pi * F)",
        "sum(V)", "sum(V, F)", "sum([q * F for q in V])", "sum(q + F for q in V)", "max(V)",
        "V[t(I % len(V))]", "(F if C else F)", "(lambda q, k=F: q - k)(F)",
        "float(str(F))", "divmod(F, F)[0]", "divmod(F, F)[1]", "pow(F, 2)",
        "statistics.mean([F, F])", "(lambda *a: a[-1])(F, F)",
        "[q for q in V if t(q > F)][0]", "{'a': F}['a']", "(F, F)[1]", "scaled(F)",
        "shifted(F, by=F)", "Box(F).doubled()", "Box(F).value", "next(countdown(F))",
        "math.prod([F, F])", "math.dist([F, F], [F, F])", "(int(I) * F)",
        "sorted([F, F], key=lambda q: t(q > 0))[0]", "dict(k=F).get('k', F)", "apply(scaled, F)",
    ),
    INT: (
        "(I + I)", "(I - I)", "(I * I)", "(I // I)", "(I % I)", "-I", "~I", "abs(I)", "int(F)",
        "round(F)", "math.floor(F)", "math.ceil(F)", "math.trunc(F)", "min(I, I)", "max(I, I)",
        "(I if C else I)", "(I << 2)", "(I >> 1)", "(I & I)", "(I | I)", "(I ^ I)",
        "((I % 9) ** 2)",
        "int(str(I))", "sum([I, I])", "sum(q * I for q in range(3))",
        "math.gcd(I, I)", "divmod(I, I)[1]", "(lambda n, m=I: n * m)(I)", "math.isqrt(abs(I))",
        "len(t(0) * [I] + [I])", "apply(abs, I)", "int(math.copysign(I, F))",
    ),
    TEXT: (
        "(S + S)", 'f"{S} {F:.2f}"', 'f"{I:d}|{F!r:>9}"', 'f"{I}{S!r}"', "'%d of %s' % (I, S)",
        "'%5.1f' % F", "'{} {:.1f}'.format(S, F)", "'{a:>4}'.format(a=I)", "str(F)", "str(I)",
        "S[1:]", "S[-2:]", "'-'.join([S, S])", "(S * 2)", "(S if C else S)", "S.upper()",
        "S.strip()", 'f"{F}"',
        "(lambda q='z': q + S)()",  "str(round(F, 1))",
    ),
    LIST: (
        "[F, F]", "[F, F, F]", "[q * F for q in V]", "[F + q for q in (F, F)]", "(V + V)[:4]",
        "([q for q in V if t(q < F)] + [F])", "list(map(math.sin, V))", "[*V, F][-3:]",
        "list(reversed(V))", "([F] * 2)", "[math.sin(q) for q in V]", "list(countdown(F))",
        "([a - b for a, b in zip(V, V)] or [F])", "([k * q for k, q in enumerate(V)] + [F])",
        "[float(q) for q in (str(F), str(I))]",
    ),
}  # fmt: skip
ENDING: dict[str, tuple[str, ...]] = {
    FLOAT: ("F.real", "min(V, default=F)", 'float(f"{F:.3f}")', "float('%.2f' % F)"),
    INT: ("int('%d' % I)", "len(S)", "F.as_integer_ratio()[0]", "I.bit_length()"),
    TEXT: ("''.join(map(str, V))", "S.rjust(5)", "S.title()", "repr(I)", "S.partition('b')[0]",
           "S.replace('a', 'b')", "format(F, '.3f')", 'f"{F:{I % 7 + 1}.1f}"'),
    LIST: ("sorted(V)", "[float(q) for q in array.array('d', V)]"),
}  # fmt: skip
"""Where provenance ends, or a choice is made unseen."""

CONDITIONS = ("t(N < N)", "t(F > F)", "t(I == I)", "t(S < S)", "t(F and I)", "(not t(I != I))",
              "t(F < F <= F)", "t(F in V)")  # fmt: skip

FLOATS = ("0.5", "1.5", "2.0", "0.25", "3.75", "1e-3", "0.1", "12.5", "0.0", "-1.5", "-0.75")
INTS = ("1", "2", "3", "5", "7", "10", "0", "-2", "-3", "12")
TEXTS = ("'a'", "'bc'", "'x '", "''", "'a-1'", "'/odom'")
LITERALS = {FLOAT: FLOATS, INT: INTS, TEXT: TEXTS, LIST: ("[0.5, 1.5]", "[2.0]")}

DEFINITIONS = """\
def scaled(x, by=FLOAT):
    y = x * by
    return y
def shifted(x, *, by, offset=FLOAT):
    def inner(z):
        return z + offset + x
    return inner(by)
def apply(f, *args):
    return f(*args)
def countdown(x):
    step = FLOAT
    for _ in range(3):
        yield x
        x -= step
class Box:
    factor = FLOAT
    def __init__(self, value):
        self.value = value + FLOAT
    def doubled(self):
        self.value *= self.factor
        return self.value
"""


class _Writer:
    """Writes one program.

    number  chooses one between two, both included
    forms   of expressions, by kind
    names   by kind: the names that are bound where it writes
    lines   what is written
    """

    def __init__(
        self, number: Callable[[int, int], int], forms: dict[str, tuple[str, ...]]
    ) -> None:
        self.number = number
        self.forms = forms
        self.names: dict[str, list[str]] = {kind: [] for kind in EXPRESSIONS}
        self.lines: list[str] = []
        self.indent = ""
        self.numbers = 0

    def pick(self, choices: Any) -> Any:
        return choices[self.number(0, len(choices) - 1)]

    def line(self, text: str) -> None:
        self.lines.append(self.indent + text)

    def expression(self, kind: str, depth: int = 2) -> str:
        """An expression of a kind, its operands `depth` deep at most."""
        choice = self.number(0, 9)
        if choice < 2 or not depth:
            known = self.names[kind]
            return self.pick(known) if known and choice % 2 == 0 else self.pick(LITERALS[kind])
        return self.filled(self.pick(self.forms[kind]), depth - 1)

    def filled(self, form: str, depth: int) -> str:
        """A form with operands in it; simple ones in an f-string, of which quotes were the end."""
        depth = 0 if 'f"' in form else depth
        words = []
        for before, letter, after in zip(" " + form, form, form[1:] + " ", strict=False):
            if letter not in "FISVNC" or before.isalnum() or after.isalnum():
                words.append(letter)
            elif letter == "C":
                words.append(self.filled(self.pick(CONDITIONS), 0))
            else:
                kind = self.pick((FLOAT, INT)) if letter == "N" else letter.lower()
                words.append(self.operand(kind, depth))
        return "".join(words)

    def operand(self, kind: str, depth: int) -> str:
        text = self.expression(kind, depth)
        return f"({text})" if text[0] in "-+~" or text.isdigit() else text

    def bind(self, kind: str) -> str:
        """A name for something of a kind: a new one, or one that is bound."""
        if self.names[kind] and self.number(0, 2) == 0:
            return self.pick(self.names[kind])
        name = f"{kind}{self.numbers}"
        self.numbers += 1
        self.names[kind].append(name)
        return name

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """What is written in it is below `head`; what is bound only there is unknown after it."""
        self.line(head)
        before = {kind: list(names) for kind, names in self.names.items()}
        self.indent += "    "
        yield
        self.indent = self.indent[:-4]
        self.names = before

    def statements(self, least: int, most: int, depth: int) -> None:
        for _ in range(self.number(least, most)):
            choice = self.number(0, 15)
            if choice < 8 or not depth:
                self.assignment()
            else:
                compound = self.pick((self.branch, self.loop, self.counting, self.attempt,
                                      self.function, self.filling))  # fmt: skip
                compound(depth - 1)

    def assignment(self) -> None:
        kind = self.pick((FLOAT, FLOAT, FLOAT, INT, TEXT, LIST))
        how = self.number(0, 5)
        if how == 0 and self.names[FLOAT]:
            sign = self.pick(("+", "-", "*", "/", "//", "%"))
            self.line(f"{self.pick(self.names[FLOAT])} {sign}= {self.expression(FLOAT)}")
        elif how == 1:
            values = f"{self.expression(FLOAT)}, {self.expression(INT)}"
            self.line(f"{self.bind(FLOAT)}, {self.bind(INT)} = {values}")
        elif how == 2 and self.names[LIST]:
            held = self.pick(self.names[LIST])
            self.line(self.pick((
                f"{held}.append({self.expression(FLOAT)})",
                f"{held}[0] = {self.expression(FLOAT)}",
                f"{held}[-1] *= {self.expression(FLOAT)}",
            )))  # fmt: skip
        elif how == 3:
            value = self.expression(FLOAT)
            self.line(f"t(({self.bind(FLOAT)} := {value}) > 0)")
        else:
            value = self.expression(kind, 3)
            self.line(f"{self.bind(kind)} = {value}")

    def branch(self, depth: int) -> None:
        with self.block(f"if {self.filled(self.pick(CONDITIONS), 1)}:"):
            self.statements(1, 2, depth)
        with self.block("else:"):
            self.statements(1, 2, depth)

    def loop(self, depth: int) -> None:
        held = self.expression(LIST)
        with self.block(f"for q in {held}[:3]:"):
            self.names[FLOAT].append("q")
            self.statements(1, 2, depth)

    def counting(self, depth: int) -> None:
        name = f"n{self.numbers}"
        self.numbers += 1
        self.line(f"{name} = {self.pick(INTS[:3])}")
        with self.block(f"while t({name} > 0):"):
            self.line(f"{name} -= 1  # rosslt: off")  # else a change of it may never end
            self.statements(1, 2, depth)

    def attempt(self, depth: int) -> None:
        with self.block("try:"):
            self.statements(1, 2, depth)
        with self.block("except (ArithmeticError, ValueError, IndexError) as error:"):
            self.line("t(len(str(error)))")

    def function(self, depth: int) -> None:
        """One that is called at once: its names are its own, but for those that it closes over."""
        name = f"function{self.numbers}"
        self.numbers += 1
        with self.block(f"def {name}(f, i={self.pick(INTS)}, s={self.pick(TEXTS)}):"):
            for kind, own in ((FLOAT, "f"), (INT, "i"), (TEXT, "s")):
                self.names[kind] = [own]
            self.names[LIST] = []
            self.statements(1, 3, depth)
            self.line(f"return {self.expression(FLOAT)}")
        value = f"{name}({self.expression(FLOAT)})"
        self.line(f"{self.bind(FLOAT)} = {value}")

    def filling(self, depth: int) -> None:
        """A dictionary, and what is read from it."""
        key = self.expression(TEXT, 1)
        self.line(f"table = {{{key}: {self.expression(FLOAT)}, 'k': {self.expression(FLOAT)}}}")
        self.line("table['k'] += 1.5")
        self.line(f"{self.bind(FLOAT)} = sum(table.values())")


@st.composite
def program_texts(
    draw: Callable[[st.SearchStrategy[Any]], Any], longest: int = 7, ending: bool = False
) -> str:
    """A program; it may end with an error.

    longest  the most statements that it has outside of others
    ending   whether provenance may end in it
    """
    return written(lambda low, high: draw(st.integers(low, high)), longest, ending)


def written(number: Callable[[int, int], int], longest: int, ending: bool) -> str:
    """A program of such choices."""
    forms = {kind: known + ENDING[kind] * ending for kind, known in EXPRESSIONS.items()}
    writer = _Writer(number, forms)
    definitions = DEFINITIONS
    while "FLOAT" in definitions:
        definitions = definitions.replace("FLOAT", writer.pick(FLOATS[:7]), 1)
    writer.line("f0, i0, s0 = 2.5, 3, 'ab'")
    writer.line("v0 = [1.25, 0.5, 4.0]")
    for name in ("f0", "i0", "s0", "v0"):
        writer.names[name[0]].append(name)
    writer.statements(1, longest, 2)
    return PROLOGUE + definitions + "\n".join(writer.lines) + "\n"
