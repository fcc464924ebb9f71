"""What the rewriter makes of a source text, and what it leaves alone."""

import ast
import dis
import os
import sys
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from textwrap import dedent
from types import CodeType

import pytest

from rosslt_auto.instrument.naming import module_scope
from rosslt_auto.instrument.rewriter import rewrite
from rosslt_auto.instrument.weaving import rewritten_tree


def rewritten(source: str) -> str:
    tree = ast.parse(dedent(source))
    rewrite(tree, module_scope("m", "m.py"), "@t")
    lines = ast.unparse(tree).splitlines()
    return "\n".join(line for line in lines if line and not line.startswith("global @"))


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = 1.5", "x = @t[0]"),
        ("x = -1.5", "x = @t[0]"),
        ("x = - -1", "x = -@t[0]"),
        ("x = 2 * 3.0", "x = @t[0] * @t[1]"),
        ("x = y or 0.5", "x = y or @t[0]"),
        ("x = [0.0] * 36", "x = [@t[0]] * 36"),
        ("x = 3 * (1, y)", "x = 3 * (@t[0], y)"),
        ("x = 'ab' * 3", "x = 'ab' * 3"),
        ("x = (v * 0.5)[0].z", "x = (v * @t[0])[0].z"),
        ("f(1, *a, k=2, **d)", "f(@t[0], *a, k=@t[1], **d)"),
        ("x = y[f(1)]", "x = y[f(@t[0])]"),
        (
            "x = f'{y * 2:{w + 1}}'",
            "x = @t+[0].end(@t+[0].begin(), f'{@t+[0].value(@rosslt.mul(y, @t[0])):{w + 1}}')",
        ),
        (
            "x = f'at {y!r:>5}'",
            "x = @t+[0].text(f'{@t[0]}{y!r:>5}', @t[0], y)",
        ),
        ("x = f': {y=}'", "x = @t+[0].text(f': y={y!r}', y)"),
        ("x = 'text'", "x = @t[0]"),
        ("x = '%d of' % y", "x = @t[0] % y"),
        ("x = '{} of'.format(y)", "x = @t[0].format(y)"),
        ("x = ', '.join(y)", "x = @t[0].join(y)"),
        ("x = {'a': 'b'}", "x = {'a': @t[0]}"),
        ("x = getattr(y, 'a', 'b')", "x = getattr(y, 'a', @t[0])"),
        ("x = y.get('a', 'b')", "x = y.get('a', @t[0])"),
        ("n.create_publisher(T, 'topic', 10)", "n.create_publisher(T, 'topic', @t[0])"),
        ("n.declare_parameter('p', 'v')", "n.declare_parameter('p', @t[0])"),
        ("super().__init__('node')", "super().__init__('node')"),
        ("def f(x='a'):\n    return 'b'", "def f(x=@t[0]):\n    return @t[1]"),
        ("x = {1: 2, 'a': 3}", "x = {1: @t[0], 'a': @t[1]}"),
        ("x = 1 if y > 2 else 3", "x = @t[0] if y > 2 else @t[1]"),
        ("x += 1", "x = @rosslt.iadd(x, @t[0])"),
        ("x += 1.5", "x += @t[0]"),
        ("x = y / -2", "x = @rosslt.truediv(y, @t[0])"),
        ("x = 2 - len(y) + 1", "x = @t[0] - len(y) + @t[1]"),
        ("f(y).x += 1", "f(y).x += @t[0]"),
        ("a[b] += 1", "a[b] += @t[0]"),
        ("def f(a):\n    a.x += 1", "def f(a):\n    a.x = @rosslt.iadd(a.x, @t[0])"),
        ("K = 2\nx = y * K", "K = @t[0]\nx = @rosslt.mul(y, K)"),
        ("K = 2.5\nx = y * K", "K = @t[0]\nx = y * K"),
        ("x = a[y + 1]", "x = a[y + 1]"),
        ("with f(1) as x: pass", "with f(@t[0]) as x:\n    pass"),
        ("x: float = 1", "x: float = @t[0]"),
        ("x = 1 + 2j", "x = 1 + 2j"),
    ],
)
def test_literals(source: str, expected: str) -> None:
    assert rewritten(source) == expected


@pytest.mark.parametrize(
    "source",
    [
        "'doc'",
        "1",
        "x = True",
        "x = None",
        "x = ''",
        "x = 'a\\0b'",
        "x = y['a']",
        "x = y == 'a'",
        "x = y in ('a', 'b')",
        "x = f'{y}' == z",
        "x = y[f'{z}']",
        "x = {'a': y}",
        "x = {'a', 'b'}",
        "x = f'a'",
        "__all__ = ['a']",
        "__all__ += ['a']",
        "class A:\n    __slots__ = ('a', 'b')",
        "x: 'A' = y",
        "def f(x: 'A') -> 'B':\n    pass",
        "x = open('a', 'w', encoding='b')",
        "x = re.compile('a')",
        "x = y.encode('a')",
        "x = struct.unpack('<d', y)",
        "x = namedtuple('A', 'a b')",
        "parser.add_argument('--x', help='y', default='z')",
        "sys.path.insert(z, 'a')",
        "self.get_logger().info(f'at {x}: ' + 'a')",
        "print(f'{x}', 'a', sep='b')",
        "raise ValueError(f'no {x}')",
        "assert x, f'no {x}'",
        "@register('a')\ndef f():\n    pass",
        "x = y.split(',')",
        "x = yaml.dump(y, stream='a')",
        "x = f'{await y}'",
        "x = b'1'",
        "x = 2j",
        "x = 1e999",
        "x = 9223372036854775808",
        "x: Literal[1]",
        "x: list[1 + 2]",
        "x: Literal[1] = y",
        "def f(x: 1) -> 2:\n    pass",
        "__slots__ = (1, 2)",
        "__version_info__ = (1, 2, 3)",
        "_fields_ = [('x', c_int, 3)]",
        "x = a[0]",
        "x = a[1:2, ::3]",
        "x = a[i + 1]",
        "a[0] = y",
        "del a[0]",
        "x = y < 2",
        "x = 1 < y + 2 < 3",
        "x = y is 1",
        "x = y in (1, 2)",
        "x = y in [1, f, 2 * 3]",
        "x = {1, 2, y}",
        "x = {1 for y in z}",
        "if 1:\n    pass",
        "while 1:\n    pass",
        "x = not 1",
        "if x % 2 and 3:\n    pass",
        "assert 1",
        "for i in range(1, 10, 2):\n    pass",
        "sys.exit(1)",
        "x = round(y, 2)",
        "x = (1).bit_length()",
        "match x:\n    case 1 | [2, 3]:\n        pass",
        "class A(IntEnum):\n    x = 1\n    y = 2 * x",
        "x = Enum('x', {'a': 1})",
        "import math\nx = math.floor(y)",
        "import casadi as math_like\nx = math_like.sin(y)",
        "x = float('inf')",
        "x = int('ff', 16)",
        "x = type(self)",
        "x = type('A', (), {})",
        "x = sin(y)",
        "def __len__(self):\n    return 3",
        "import math\nx = math\\\n .sin(y)".replace("x = math\\\n .sin(y)", "pass"),
    ],
)
def test_left_alone(source: str) -> None:
    assert rewritten(source) == ast.unparse(ast.parse(source))


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = float(y)", "x = @rosslt.call1(float, y)"),
        ("x = float(*y)", "x = @rosslt.call(float, *y)"),
        ("x = sum(y)", "x = @rosslt.items(sum, y)"),
        ("x = sum(y, start=z)", "x = @rosslt.call(sum, y, start=z)"),
        ("x = type(y)", "x = @rosslt.call1(type, y)"),
        ("import math\nx = math.sin(y)", "import math\nx = @rosslt.call1(math.sin, y)"),
        ("import math as m\nx = m.pow(y, z)", "import math as m\nx = @rosslt.call2(m.pow, y, z)"),
        (
            "from math import sin as s\nx = s(y)",
            "from math import sin as s\nx = @rosslt.call1(s, y)",
        ),
        (
            "from math import *\nx = hypot(a, b, c)",
            "from math import *\nx = @rosslt.call(hypot, a, b, c)",
        ),
        ("x = y in range(3)", "x = @rosslt.untracked(y) in range(3)"),
        ("x = 0 < y in range(3)", "x = 0 < @rosslt.untracked(y) in range(3)"),
    ],
)
def test_calls(source: str, expected: str) -> None:
    text = "\n".join(
        line for line in rewritten(source).splitlines() if not line.startswith("global")
    )
    assert text == expected


def test_calls_by_another_name() -> None:
    source = "def f(x, s=math.sin):\n r = math.sqrt\n return s(x) + r(x)"
    assert "return @rosslt.call1(s, x) + @rosslt.call1(r, x)" in rewritten(source)


def test_calls_of_math_imported_in_a_function_used_before() -> None:
    source = "def f(): return s(x)\ndef g():\n from math import sin as s"
    assert "@rosslt.call1(s, x)" in rewritten(source)


def test_methods_that_must_return_exact_numbers() -> None:
    source = (
        "class A:\n    def __float__(self):\n        return self.x * 2\n    __int__ = lambda s: s.x"
    )
    text = rewritten(source)
    assert "return @rosslt.untracked(self.x * 2)" in text
    assert "__int__ = lambda s: @rosslt.untracked(s.x)" in text


def test_enums_of_enums_in_the_module() -> None:
    source = "class Base(Enum):\n    pass\nclass A(Base):\n    x = 1\n    def f(self): return 2"
    text = rewritten(source)
    assert "x = 1" in text and "return @t[0]" in text


def test_names_are_global_in_class_and_module() -> None:
    tree = ast.parse("'doc'\nfrom __future__ import annotations\nx = 1\nclass A:\n 'doc'\n y = 2")
    rewrite(tree, module_scope("m", "m.py"), "@t")
    assert ast.unparse(tree) == dedent(
        """\
        \"\"\"doc\"\"\"
        from __future__ import annotations
        global @t
        x = @t[0]

        class A:
            \"\"\"doc\"\"\"
            global @t
            y = @t[1]"""
    )
    compile(tree, "m.py", "exec")


def test_large_displays_are_data() -> None:
    rows = ", ".join(f"({i}, {i}.5)" for i in range(200))
    assert rewritten(f"x = [{rows}]\ny = 1").endswith("y = @t[0]")


def test_long_sums_and_chains_of_elif() -> None:
    sums = "x = " + " + ".join(["y"] * 900) + " + 1\n"
    chain = "if a: x = 1\n" + "".join(f"elif a == {i}: x = {i}\n" for i in range(300))
    tree = ast.parse(sums + chain)
    assert len(rewrite(tree, module_scope("m", "m.py"), "@t").values) == 302
    compile(tree, "m.py", "exec")


@pytest.mark.parametrize(
    ("source", "repeated"),
    [
        ("x = 1", False),
        ("for i in y: x = 1", True),
        ("while y: x = 1", True),
        ("x = [1 for i in y]", True),
        ("x = [i for i in (1, y)]", False),
        ("class A: x = 1", False),
        ("def f(): x = 1", None),
        ("def f(x=1): pass", False),
        ("def f():\n for i in y: x = 1", True),
        ("for i in y:\n def f(): x = 1", None),
        ("f = lambda: 1", None),
        ("for i in y: pass\nelse: x = 1", False),
    ],
)
def test_repeated(source: str, repeated: bool | None) -> None:
    infos = rewrite(ast.parse(source), module_scope("m", "m.py"), "@t").infos
    assert infos[0].repeated is repeated


# ------------------------------------------------------------ positions, over real programs

_LIBRARY = [
    "argparse", "calendar", "colorsys", "dataclasses", "difflib", "fractions", "inspect",
    "ipaddress", "random", "statistics", "string", "textwrap", "turtle", "typing", "_pydecimal",
    "asyncio.base_events", "json.encoder", "unittest.mock", "xml.dom.minidom",
]  # fmt: skip
_COMPARED = {
    "CALL", "BINARY_OP", "LOAD_ATTR", "LOAD_METHOD", "BINARY_SUBSCR", "STORE_SUBSCR",
    "RAISE_VARARGS", "COMPARE_OP", "CONTAINS_OP", "GET_ITER", "FOR_ITER", "IMPORT_NAME",
    "CALL_FUNCTION_EX", "DELETE_SUBSCR",
}  # fmt: skip


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _positions(code: CodeType) -> Counter:
    """Where everything is that can raise an error."""
    return Counter(
        (instruction.opname.replace("METHOD", "ATTR"), tuple(instruction.positions))
        for instruction in dis.get_instructions(code)
        if instruction.opname in _COMPARED and instruction.positions
    )


def _in_f_strings(tree: ast.AST) -> Iterator[tuple]:
    """Where something is put around f-strings and their values: it raises nothing."""
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            for at in (node, *(part.value for part in node.values if hasattr(part, "format_spec"))):
                yield at.lineno, at.end_lineno, at.col_offset, at.end_col_offset


@pytest.mark.parametrize("name", _LIBRARY)
def test_positions_stay(name: str) -> None:
    path = find_spec(name).origin
    source = Path(path).read_bytes()
    tree = compile(source, path, "exec", ast.PyCF_ONLY_AST, dont_inherit=True)
    literals = set(_in_f_strings(tree))
    infos = rewrite(tree, module_scope(name, path), "@t").infos
    names = [info.parameter for info in infos]
    assert len(set(names)) == len(names)
    literals |= {(i.line, i.end_line, i.column, i.end_column) for i in infos}
    plain = compile(source, path, "exec", dont_inherit=True)
    code = compile(tree, path, "exec", dont_inherit=True)
    for one, other in zip(_codes(plain), _codes(code), strict=True):
        assert (one.co_name, one.co_cellvars, one.co_freevars) == (
            other.co_name, other.co_cellvars, other.co_freevars,
        )  # fmt: skip
        assert one.co_varnames == tuple(name for name in other.co_varnames if name[0] != "@")
        assert one.co_firstlineno == other.co_firstlineno
        missing = _positions(one).keys() - _positions(other).keys()
        # An operator that has become a call of ours; a method's call, as 3.12 compiles it.
        ours = {"BINARY_OP"} if sys.version_info < (3, 12) else _COMPARED
        missing = {
            key
            for key in missing
            if key[0] not in ours or ("CALL", key[1]) not in _positions(other)
        }
        more = {
            key
            for key in _positions(other).keys() - _positions(one).keys()
            if key[1] not in literals and key[0] not in ("BINARY_OP", "CALL")  # folded; ours
        }
        assert (missing, more) == (set(), set())


def test_what_the_library_executes_is_left_to_it() -> None:
    """A debugger's program has no frames of ours between the debugger and itself."""
    source = b"exec(command, names)\nspeed = 0.5\n"
    library = str(Path(os.__file__).with_name("bdb.py"))
    for path, found in (("/robot/node.py", True), (library, False)):
        tree, *_ = rewritten_tree("bdb", path, source)
        assert ("@rosslt.execute" in ast.unparse(tree)) is found
        assert "speed = 0.5" not in ast.unparse(tree)
