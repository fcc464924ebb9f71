"""Parameter names of literals: what they are called, and that ROS can say them."""

import ast
import re
from pathlib import Path
from textwrap import dedent

import pytest

from rosslt_auto.instrument.naming import module_scope, submodules
from rosslt_auto.instrument.rewriter import rewrite
from rosslt_auto.provenance.tokens import module_tokens, token


def names(source: str, module: str = "m", path: str = "/x/m.py", reserved=()) -> list[str]:
    tree = ast.parse(dedent(source))
    infos = rewrite(tree, module_scope(module, path), "@t", reserved).infos
    prefix = f"rosslt.{module}."
    return [info.parameter.removeprefix(prefix) for info in infos]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = 1", ["x"]),
        ("x: float = 1.0", ["x"]),
        ("self.count = 5", ["count"]),
        ("a.b.c = 3", ["c"]),
        ("d['speed'] = 1.0", ["speed"]),
        ("d[i] = 1.0", ["d"]),
        ("x += 1", ["x"]),
        ("x = y = 1", ["x"]),
        ("a, b = 1, 2", ["a", "b"]),
        ("x = -1.5", ["x"]),
        ("x = 2 * (y + 1)", ["x", "x_2"]),
        ("x = [1, (2, 3)]", ["x", "x_2", "x_3"]),
        ("x = {'speed': 1.0, 'gain': 2.0}", ["speed", "gain"]),
        ("x = 1 if y else 2", ["x", "x_2"]),
        ("f(x=1)", ["x"]),
        ("self.create_timer(0.5, cb)", ["create_timer"]),
        ("math.sin(0.3)", ["sin"]),
        ("x = f(1)(2)", ["f", "f_2"]),
        ("def f(a, b=1, *, c=2): return 3", ["f.b", "f.c", "f.f"]),
        ("f = lambda x=1: x + 2", ["lambda.x", "lambda.f"]),
        ("class A:\n def __init__(self): self.k = 1", ["A.init.k"]),
        ("class A:\n k = 1\n class B:\n  k = 2", ["A.k", "A.B.k"]),
        ("def f():\n def g():\n  x = 1", ["f.g.x"]),
        ("for speed in (1, 2): pass", ["speed", "speed_2"]),
        ("xs = [y * 2 for y in [1]]", ["xs", "y"]),
        ("if (n := 10): pass", ["n"]),
        ("__private = 1", ["private"]),
        ("größe = 1", ["gr__e"]),
        ("x = 1\nx = 2\nx = 3", ["x", "x_2", "x_3"]),
        ("x = 1\nx_2 = 5\nx = 2", ["x", "x_2", "x_3"]),
    ],
)
def test_hint(source: str, expected: list[str]) -> None:
    assert names(source) == expected


@pytest.mark.parametrize(
    ("source", "named"),
    [
        ("x = 1", True),
        ("x = -1", True),
        ("x = [1]", True),
        ("f(x=1)", True),
        ("x = {'a': 1}", True),
        ("def f(x=1): pass", True),
        ("x = [0.0] * n", True),
        ("x = y + 1", False),
        ("x += 1", False),
        ("f(1)", False),
        ("f([1])", False),
        ("def f(): return 1", False),
    ],
)
def test_named(source: str, named: bool) -> None:
    (info,) = rewrite(ast.parse(source), module_scope("m", "m.py"), "@t").infos
    assert info.named is named


def test_scopes_of_the_same_name_continue_numbering() -> None:
    source = """
    class A:
        @property
        def x(self): y = 1
        @x.setter
        def x(self, v): y = 2
    """
    assert names(source) == ["A.x.y", "A.x.y_2"]


def test_no_name_is_the_prefix_of_another() -> None:
    source = """
    speed = 1
    class speed:
        limit = 2
    def f():
        g = 3
        def g(): h = 4
    """
    assert names(source) == ["speed_2", "speed.limit", "f.g_2", "f.g.h"]


def test_a_package_leaves_the_names_of_its_modules_alone(tmp_path: Path) -> None:
    for name in ("talker.py", "__init__.py", "__main__.py"):
        (tmp_path / name).touch()
    reserved = submodules(str(tmp_path / "__init__.py"))
    assert "talker" in reserved and "init" not in reserved
    assert names("talker = 1\nclass talker:\n k = 2", reserved=reserved) == [
        "talker_3",
        "talker_2.k",
    ]
    assert submodules(str(tmp_path / "talker.py")) == frozenset()


def test_stable_under_edits_elsewhere() -> None:
    before = "def f():\n    x = 1\ndef g():\n    x = 2\n"
    after = "# a line\nimport os\ndef f():\n    y = 0\n    x = 1\n\n\ndef g():\n    x = 2\n"
    assert set(names(before)) <= set(names(after))


@pytest.mark.parametrize(
    ("name", "path", "expected"),
    [
        ("talker", "/a/talker.py", "talker"),
        ("pkg.sub.talker", "/a/pkg/sub/talker.py", "pkg.sub.talker"),
        ("__main__", "/a/my-node.py", "my_node"),
        ("__main__", "/a/2d.py", "_2d"),
        ("__main__", "/a/app/__main__.py", "main"),
        ("__main__", "/a/bin/talker", "talker"),
        ("__main__", "/a/v1.2.py", "v1_2"),
        ("pkg.__main__", "/a/pkg/__main__.py", "pkg.main"),
        ("not a.name", "/a/b.py", "not_a.name"),
    ],
)
def test_module(name: str, path: str, expected: str) -> None:
    assert module_tokens(name, path) == expected


@pytest.mark.parametrize("name", ["", "_", "__", "____", "__x", "__init__", "2", "é", "a b", "_x"])
def test_tokens_can_be_said_on_a_command_line(name: str) -> None:
    assert re.fullmatch(r"(?!__)[A-Za-z_][A-Za-z0-9_]*", token(name))


def test_positions_are_those_of_ast() -> None:
    (info,) = rewrite(ast.parse("ü = f(x=-\\\n  1.5)"), module_scope("m", "m.py"), "@t").infos
    assert (info.line, info.column, info.end_line, info.end_column) == (1, 9, 2, 5)


def test_source_order_not_order_of_the_tree() -> None:
    assert names("@d(1)\ndef f(x=2): return 3 if (y := 4) else 5") == [
        "d", "f.x", "f.f", "f.y", "f.f_2",
    ]  # fmt: skip
