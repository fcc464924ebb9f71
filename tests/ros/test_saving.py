"""Saving literals of a node in this process: the files, and what the node knows afterwards."""

import ast
import builtins
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

from rosslt_auto.instrument.hook import instrumented_code
from rosslt_auto.provenance import refresh, registry
from rosslt_auto.provenance.locations import Location, fingerprint
from rosslt_auto.ros import changes, client, parameters, saving
from rosslt_auto.ros.client import Place
from rosslt_auto.ros.observer import Observer
from support.woven import node_in, spinning


class Module:
    """A file of a test, loaded as `run` would load it; its literals are in source order."""

    def __init__(self, path: Path, content: bytes, name: str = "saved_module") -> None:
        self.path, self.name = path, name
        path.write_bytes(content)
        self.namespace: dict[str, Any] = {}
        self.load()

    def load(self) -> None:
        """Loads the file, again if it was loaded before."""
        source = self.path.read_bytes()
        code = instrumented_code(self.name, str(self.path), source, cached=False)
        exec(code, self.namespace)
        [self.literals] = [
            one
            for one in registry.registered()
            if one.file == str(self.path) and one.content == fingerprint(one.file, source)
        ]

    @property
    def locations(self) -> list[Location]:
        return [self.literals.location(index) for index in range(len(self.literals.values))]

    def change(self, **values: Any) -> None:
        by_hint = {location.hint: location for location in self.locations}
        refresh.apply({by_hint[hint]: value for hint, value in values.items()})

    def places(self, node: str = "/robot") -> list[Place]:
        """What a client sees of all literals, as if the node owned them."""
        return [place_of(location, node) for location in self.locations]


def place_of(location: Location, node: str = "/robot") -> Place:
    return client._place(node, parameters.descriptor_of(location), location.value)


def adopt(plan: saving.Plan, places: list[Place]) -> None:
    """Tells this process what was written, without a network."""
    for news in saving._news(plan.files, places).values():
        for message, _ in news:
            changes._adopt(None, message.name, message.value.string_value)


def save(*modules: Module) -> saving.Plan:
    places = [place for module in modules for place in module.places()]
    plan = saving.prepare(places)
    for change in plan.files:
        change.write()
    adopt(plan, places)
    return plan


@pytest.fixture(autouse=True)
def _clean() -> Iterator[None]:
    tables = dict(registry._tables)
    names = set(vars(builtins))
    yield
    registry._tables.clear()
    registry._tables.update(tables)
    for name in set(vars(builtins)) - names:
        delattr(builtins, name)


def module(folder: Path, source: str | bytes, encoding: str = "utf-8") -> Module:
    content = source if isinstance(source, bytes) else source.encode(encoding)
    return Module(folder / "program.py", content)


# ---------------------------------------------------------------- how it is written


@pytest.mark.parametrize(
    ("before", "value", "after"),
    [
        ("x = 0.50\n", 0.75, "x = 0.75\n"),
        ("x = -0.5\n", 2.0, "x = 2.0\n"),
        ("x = 0.5\n", -2.0, "x = -2.0\n"),
        ("x = 1_000\n", 2500, "x = 2_500\n"),
        ("x = 0x0F\n", 31, "x = 0x1F\n"),
        ("x = 1e-3  # keep  this\n", 2e-3, "x = 2e-3  # keep  this\n"),
        ("def f(a): return a\nx = f(0.5)  # é\n", 0.25, "def f(a): return a\nx = f(0.25)  # é\n"),
        ("def f():\r\n\tx = 1.5\t# tab\r\n\treturn x\r\n", 2.5,
         "def f():\r\n\tx = 2.5\t# tab\r\n\treturn x\r\n"),
        ("y = None; x = 3", 4, "y = None; x = 4"),
        ("x = (\n    1.5\n)\n", 2.5, "x = (\n    2.5\n)\n"),
    ],
)  # fmt: skip
def test_only_the_literal_is_written_anew(
    before: str, value: Any, after: str, tmp_path: Path
) -> None:
    program = module(tmp_path, before)
    [location] = program.locations
    refresh.apply({location: value})
    plan = save(program)
    assert not plan.refused
    assert program.path.read_bytes().decode() == after
    assert (location.first, location.value) == (value, value)
    assert saving.prepare(program.places()) == saving.Plan()


def test_bom_and_coding_line(tmp_path: Path) -> None:
    bom = module(tmp_path, "\ufeffx = 1.5  # ü\n")
    bom.change(x=2.5)
    assert not save(bom).refused
    assert bom.path.read_bytes() == "\ufeffx = 2.5  # ü\n".encode()

    (tmp_path / "other").mkdir()
    latin = module(
        tmp_path / "other", "# -*- coding: latin-1 -*-\nt = 'über'; x = 1.5  # ß\n", "latin-1"
    )
    latin.change(x=10.25)
    assert not save(latin).refused
    text = "# -*- coding: latin-1 -*-\nt = 'über'; x = 10.25  # ß\n"
    assert latin.path.read_bytes() == text.encode("latin-1")


def test_several_changes_in_one_line_and_again(tmp_path: Path) -> None:
    program = module(tmp_path, "a = 1; b, c = 2.5, -3.0; d = a + 4\n")
    program.change(a=100, c=30.25)
    assert not save(program).refused
    assert program.path.read_text() == "a = 100; b, c = 2.5, 30.25; d = a + 4\n"
    # The others on the line are known at their new places, the first time and every time.
    for b, c in (("7.5", "-2.25"), ("70000.5", "3.25"), ("-0.5", "-12345.75")):
        program.change(b=float(b), c=float(c))
        assert not save(program).refused
        assert program.path.read_text() == f"a = 100; b, c = {b}, {c}; d = a + 4\n"
        for location in program.locations:
            tree = ast.parse(program.path.read_text())
            at = (location.line, location.column)
            assert any((n.lineno, n.col_offset) == at and ast.literal_eval(n) == location.first
                       for n in ast.walk(tree)
                       if isinstance(n, (ast.Constant, ast.UnaryOp)))  # fmt: skip
            assert location.text == program.path.read_text().strip()


def test_parentheses_that_a_sign_needs(tmp_path: Path) -> None:
    program = module(tmp_path, "e = None\ndef f(k):\n    return k ** 2.0\nx = 3.0 ** f(1.0)\n")
    [base] = [one for one in program.locations if one.first == 3.0]
    refresh.apply({base: -4.0})
    assert not save(program).refused
    assert "x = (-4.0) ** f(1.0)\n" in program.path.read_text()
    refresh.apply({base: 5.0})
    assert not save(program).refused
    assert "x = (5.0) ** f(1.0)\n" in program.path.read_text()


def test_a_number_in_an_f_string(tmp_path: Path) -> None:
    """Written where its place is certain, refused otherwise; never anywhere else."""
    program = module(tmp_path, 'x = 1.5\nt = f"a {x * 2.5:.2f} b {2.5 * x}"\n')
    for location in [one for one in program.locations if one.first == 2.5]:
        refresh.apply({location: 4.5})
    plan = save(program)
    after = 'x = 1.5\nt = f"a {x * 4.5:.2f} b {4.5 * x}"\n'
    before = after.replace("4.5", "2.5")
    assert program.path.read_text() == (before if plan.refused else after)


def strings(program: Module) -> dict[str, Location]:
    return {one.first: one for one in program.locations if one.kind == "str"}


@pytest.mark.parametrize(
    ("before", "value", "after"),
    [
        ("x = 'left'; y = 'right'\n", "it's", "x = 'it\\'s'; y = 'right'\n"),
        ('x = "left"  # "left"\n', "über", 'x = "über"  # "left"\n'),
        ("x = r'left'\n", "a b", "x = r'a b'\n"),
        ('x = """left"""; y = 1.5\n', "one\ntwo", None),
    ],
)
def test_texts(before: str, value: str, after: str | None, tmp_path: Path) -> None:
    program = module(tmp_path, before)
    refresh.apply({strings(program)["left"]: value})
    assert not save(program).refused
    assert after in (None, program.path.read_text())
    # Once more, with all that stands behind it.
    others = {one: one.value * 2 for one in program.locations}
    refresh.apply(others)
    assert not save(program).refused
    again: dict[str, Any] = {}
    exec(program.path.read_text(), again)
    assert [again[name] for name in "xy" if name in again] == list(others.values())


def test_texts_in_a_row_are_refused(tmp_path: Path) -> None:
    source = "x = ('one '\n     'two')\ny = 1.5\n"
    program = module(tmp_path, source)
    refresh.apply({strings(program)["one two"]: "three"})
    program.change(y=2.5)
    [reason] = save(program).refused
    assert f"{program.path}:1:5: " in reason and "several strings" in reason
    assert program.path.read_text() == source


def test_pieces_of_an_f_string(tmp_path: Path) -> None:
    source = 'n = 2\nx = f"left {n * 2.5} right {n}"; y = 1.5\n'
    program = module(tmp_path, source)
    pieces = strings(program)
    refresh.apply({pieces[" right "]: " -> {1} ", program.locations[-1]: 7.5})
    plan = save(program)
    if sys.version_info < (3, 12):
        [reason] = plan.refused
        assert "f-string" in reason and program.path.read_text() == source
        return
    assert not plan.refused
    after = source.replace(" right ", " -> {{1}} ").replace("1.5", "7.5")
    assert program.path.read_text() == after
    refresh.apply({pieces["left "]: "l ", pieces[" right "]: " r ", program.locations[-1]: 1.5})
    assert not save(program).refused
    assert program.path.read_text() == source.replace(" right ", " r ").replace("left ", "l ")


# ---------------------------------------------------------------- refusals


def test_mode_is_kept_and_links_stay(tmp_path: Path) -> None:
    program = module(tmp_path, "x = 1.5\n")
    program.path.chmod(0o751)
    program.change(x=2.5)
    assert not save(program).refused
    assert program.path.stat().st_mode & 0o777 == 0o751
    assert os.listdir(tmp_path) == ["program.py"]


def test_a_file_that_is_not_the_one_that_was_loaded(tmp_path: Path) -> None:
    program = module(tmp_path, "x = 1.5\ny = 2.5\nz = 3.5\n")
    program.change(x=9.5, z=8.5)
    edited = "x = 1.5\ny = 2.75\nz = 3.5  # mine\n"
    program.path.write_text(edited)
    plan = saving.prepare(program.places())
    assert not plan.files
    [reason] = plan.refused
    assert "lines 2, 3 differ" in reason and str(program.path) in reason
    assert program.path.read_text() == edited

    program.path.write_text("# new\nx = 1.5\n")
    [reason] = saving.prepare(program.places()).refused
    assert "lines 1, 2, 3 differ" in reason
    program.path.write_text("x = 1.5\ny = 2.5\nz = 3.5\n# new\n")
    [reason] = saving.prepare(program.places()).refused
    assert "other lines differ" in reason


def test_a_change_between_reading_and_writing(tmp_path: Path) -> None:
    program = module(tmp_path, "x = 1.5\n")
    program.change(x=2.5)
    plan = saving.prepare(program.places())
    program.path.write_text("x = 1.5  # mine\n")
    with pytest.raises(saving.NotWritten, match="line 1 differs"):
        plan.files[0].write()
    assert program.path.read_text() == "x = 1.5  # mine\n"


@pytest.mark.parametrize("gone", ["file", "folder", "device"])
def test_a_file_that_is_not_there(gone: str, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    program = module(folder, "x = 1.5\n")
    program.change(x=2.5)
    program.path.unlink()
    if gone == "folder":
        folder.rmdir()
        folder.write_text("")
    elif gone == "device":
        os.mkfifo(program.path)
    [reason] = saving.prepare(program.places()).refused
    assert ("no regular file" if gone == "device" else "not on this machine") in reason


@pytest.mark.parametrize("what", ["file", "folder"])
def test_read_only(what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if os.geteuid() == 0:  # who may write everything
        monkeypatch.setattr(os, "access", lambda path, mode: bool(os.stat(path).st_mode & 0o200))
    program = module(tmp_path, "x = 1.5\n")
    program.change(x=2.5)
    plan = saving.prepare(program.places())
    target = program.path if what == "file" else tmp_path
    target.chmod(0o555)
    try:
        with pytest.raises(saving.NotWritten, match="cannot be written"):
            plan.files[0].write()
    finally:
        target.chmod(0o755)
    assert program.path.read_text() == "x = 1.5\n"


def test_nothing_half_done_in_a_file_and_other_files_go_on(tmp_path: Path) -> None:
    (tmp_path / "good").mkdir()
    bad = module(tmp_path, "x = 1.5\ny = 2.5\n")
    good = module(tmp_path / "good", "z = 3.5\n")
    bad.change(x=9.5, y=8.5)
    good.change(z=7.5)
    other = [place for place in bad.places("/other") if place.parameter.endswith(".y")]
    other = [Place(**{**vars(place), "value": 8.75}) for place in other]
    plan = saving.prepare([*bad.places(), *other, *good.places()])
    [reason] = plan.refused
    assert "several values: 8.5 in /robot, 8.75 in /other" in reason
    for change in plan.files:
        change.write()
    assert bad.path.read_text() == "x = 1.5\ny = 2.5\n"
    assert good.path.read_text() == "z = 7.5\n"


def test_two_nodes_with_the_same_value(tmp_path: Path) -> None:
    program = module(tmp_path, "x = 1.5\n")
    program.change(x=2.5)
    plan = saving.prepare([*program.places("/a"), *program.places("/b")])
    assert len(plan.files[0].edits) == 1 and not plan.refused
    assert set(saving._news(plan.files, [*program.places("/a"), *program.places("/b")])) == {
        "/a", "/b"
    }  # fmt: skip


def test_a_file_with_two_paths(tmp_path: Path) -> None:
    program = module(tmp_path, "x = 1.5; y = 2.5\n")
    link = tmp_path / "link.py"
    link.symlink_to(program.path)
    other = Module(link, program.path.read_bytes(), "other_module")
    for one, name in ((program, "x"), (other, "y")):
        one.change(**{name: 10.25})
    places = [*program.places("/a"), *other.places("/b")]
    # A node's unchanged literals are its values, too.
    assert "several values" in saving.prepare(places).refused[0]
    plan = saving.prepare(saving.selected(places, {"/b"}))
    assert not plan.refused
    plan.files[0].write()
    adopt(plan, places)
    assert link.is_symlink() and program.path.read_text() == "x = 1.5; y = 10.25\n"
    assert [(one.first, one.value) for one in program.locations] == [(1.5, 10.25), (10.25, 2.5)]
    assert [(one.first, one.value) for one in other.locations] == [(1.5, 1.5), (10.25, 10.25)]
    assert program.literals.content != other.literals.content


def test_a_value_given_at_start_is_no_literal(tmp_path: Path) -> None:
    name = "rosslt.saved_module.x"
    registry.set_initial_values({name: 7.5}, pytest.fail)
    try:
        program = module(tmp_path, "x = 1.5\ny = 2.5\n")
    finally:
        registry._initial.clear()
    program.change(y=3.5)
    plan = save(program)
    assert [place.parameter for place in plan.given] == [name]
    assert "given at start" in saving.where_given(plan.given[0])
    assert program.path.read_text() == "x = 1.5\ny = 3.5\n"


# ---------------------------------------------------------------- what the nodes know


@pytest.mark.parametrize("early", [True, False], ids=["told before", "told afterwards"])
def test_a_program_that_loads_the_saved_file_again(early: bool, tmp_path: Path) -> None:
    program = module(tmp_path, "def f():\n    a = 1.5; b = 2.5\n    return a, b\n")
    old = program.namespace["f"]
    refresh.apply({program.locations[0]: 10.25})
    places = program.places()
    plan = saving.prepare(places)
    plan.files[0].write()
    if early:
        adopt(plan, places)
    program.load()
    if not early:
        adopt(plan, places)
    assert program.namespace["f"] is not old
    assert program.namespace["f"]() == old() == (10.25, 2.5)
    program.change(b=3.5)
    assert program.namespace["f"]() == (10.25, 3.5)
    assert not save(program).refused
    assert program.path.read_text() == "def f():\n    a = 10.25; b = 3.5\n    return a, b\n"


def test_a_program_that_loads_the_file_as_it_was_before(tmp_path: Path) -> None:
    before = b"def f():\n    return 1.5\n"
    program = module(tmp_path, before)
    refresh.apply({program.locations[0]: 2.5})
    save(program)
    program.path.write_bytes(before)
    program.load()
    assert program.namespace["f"]() == 1.5
    assert program.locations[0].first == 1.5
    assert saving.prepare(program.places()) == saving.Plan()


@pytest.mark.parametrize("wrong", ["text", "fingerprint", "file", "place", "json"])
def test_news_that_is_not_true(wrong: str, tmp_path: Path) -> None:
    program = module(tmp_path, "x = 1.5\n")
    [location] = program.locations
    path, before = str(program.path), program.literals.content or ""
    after = fingerprint(path, b"x = 2.5\n")
    edit: list[Any] = [1, 4, 1, 7, "2.5", 2.5]
    program.path.write_bytes(b"x = 2.5\n")
    if wrong == "text":
        edit[4] = "3.5"
    elif wrong == "fingerprint":
        after = "00000000"
    elif wrong == "file":
        program.path.write_bytes(b"x = 1.5\n")
    elif wrong == "place":
        edit[0] = 99
    message = changes.saved_parameter(path, before, after, [edit])  # type: ignore[list-item]
    text = message.value.string_value
    refusals: list[str] = []

    class Node:
        def get_logger(self) -> Any:
            return self

        def warning(self, text: str) -> None:
            refusals.append(text)

    changes._adopt(Node(), path, text[:-5] if wrong == "json" else text)
    assert len(refusals) == 1
    assert (location.first, location.value, location.column) == (1.5, 1.5, 4)
    assert program.literals.content == before


@pytest.mark.parametrize(
    "first", [0.5, -0.0, 3, "a", "a; content 00000000", "x'; given at start: y", '"; "', "ü\n"]
)
@pytest.mark.parametrize("given", [None, "", "-p", "/a; content 00000000.yaml"])
@pytest.mark.parametrize("content", [None, "0123abcd"])
@pytest.mark.parametrize("frozen", [False, True])
def test_what_a_descriptor_says_is_read_back(
    first: Any, given: Any, content: Any, frozen: bool
) -> None:
    text = f"in the source file: {first!r}"
    text += f"; content {content}" if content else ""
    text += "; frozen" if frozen else ""
    text += "" if given is None else f"; given at start: {given}" if given else "; given at start"
    assert client._constraints(text) == (first, content, frozen, given)
    assert str(client._constraints(text)[0]) == str(first)


@pytest.mark.parametrize("text", ["", "in the source file: ", "in the source file: x; content 1"])
def test_descriptors_that_say_nothing(text: str) -> None:
    assert client._constraints(text) == (None, None, False, None)


# ---------------------------------------------------------------- over the network


@pytest.fixture
def robot(own_domain: int) -> Iterator[Node]:
    for aspect in (parameters, changes):
        aspect.install()
    with node_in(own_domain) as node, spinning(node):
        yield node
    for aspect in (changes, parameters):
        aspect.uninstall()


def test_the_view_saves(
    robot: Node, own_domain: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(own_domain))
    program = module(tmp_path, "a = 1.5; b = 2.5\n")
    for location in program.locations:
        parameters.own(robot, location)
    with Observer("test") as observer:
        observer.settle(float("inf"))
        saver = saving.ViewSaver(observer)
        for number in (10.25, 1.75):
            program.change(b=number)
            changed = [place for place in program.places() if saving.differs(place)]
            assert f"+a = 1.5; b = {number}\n" in saver.diff(changed)
            assert saver.save(changed) == "saved 1 value in program.py"
            assert program.path.read_text() == f"a = 1.5; b = {number}\n"
            assert [one.first for one in program.locations] == [1.5, number]
            [_, b] = observer.parameters.places("/robot", 5.0)
            assert b.first == b.value == number
            assert b.text == program.path.read_text().strip()
        with pytest.raises(saving.CannotSave, match="nothing"):
            saver.save(program.places())
        program.change(a=7.5)
        program.path.write_text("a = 2; b = 1.75\n")
        for action in (saver.diff, saver.save):
            with pytest.raises(saving.CannotSave, match="line 1 differs"):
                action(program.places())
