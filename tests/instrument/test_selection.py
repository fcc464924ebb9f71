"""Which modules are instrumented."""

import os
from pathlib import Path

import pytest

from rosslt_auto.instrument.selection import Selection, folder_of

STDLIB = os.path.dirname(os.__file__)


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    for name in ("pkg/__init__.py", "pkg/sub/__init__.py", "pkg/sub/node.py", "scripts/run.py"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return tmp_path


def test_a_script_belongs_to_its_folder(tree: Path) -> None:
    selection = Selection().with_script(str(tree / "scripts" / "run.py"))
    assert selection.selects("helper", str(tree / "scripts" / "helper.py"))
    assert selection.selects("lib.helper", str(tree / "scripts" / "lib" / "helper.py"))
    assert not selection.selects("pkg", str(tree / "pkg" / "__init__.py"))
    assert not selection.selects("other", str(tree / "scripts_of_others" / "helper.py"))


def test_a_script_in_a_package_belongs_to_the_outermost(tree: Path) -> None:
    assert folder_of(str(tree / "pkg" / "sub" / "node.py")) == str(tree / "pkg")


def test_a_linked_script_belongs_to_where_it_is(tree: Path) -> None:
    link = tree / "link.py"
    link.symlink_to(tree / "scripts" / "run.py")
    assert folder_of(str(link)) == str(tree / "scripts")


def test_installed_packages_in_the_folder_are_not_the_program(tree: Path) -> None:
    selection = Selection(folder=str(tree))
    inside = tree / ".venv" / "lib" / "python3.12" / "site-packages" / "x.py"
    assert not selection.selects("x", str(inside))
    assert Selection(folder=str(inside.parent)).selects("x", str(inside))


def test_standard_library_only_by_name() -> None:
    path = os.path.join(STDLIB, "textwrap.py")
    assert not Selection(folder=STDLIB, package="textwrap").selects("textwrap", path)
    assert Selection(patterns=["text*"]).selects("textwrap", path)


def test_patterns_are_of_dotted_names() -> None:
    selection = Selection(patterns=["pkg", "lib.*"])
    assert selection.selects("pkg", "/x")
    assert not selection.selects("pkg.sub", "/x")
    assert selection.selects("lib.a.b", "/x")
    assert not selection.selects("lib", "/x")


def test_excludes_win() -> None:
    selection = Selection(patterns=["pkg.*"], excludes=["pkg.bad"], folder="/x")
    assert selection.selects("pkg.good", "/y")
    assert not selection.selects("pkg.bad", "/x/pkg/bad.py")


def test_a_package_wherever_it_is_installed() -> None:
    selection = Selection(package="demo_nodes")
    path = "/opt/ws/lib/python3.12/site-packages/demo_nodes/talker.py"
    assert selection.selects("demo_nodes.talker", path)
    assert not selection.selects("demo_nodes_cpp.talker", path)


def test_never_ourselves() -> None:
    selection = Selection(patterns=["*"])
    assert not selection.selects("rosslt_auto.provenance.values", "/x/values.py")
    assert selection.selects("rosslt_auto_user", "/x/rosslt_auto_user.py")


def test_never_what_the_interpreter_changes_in_place() -> None:
    selection = Selection(["*"])
    assert selection.selects("statistics", "/lib/statistics.py")
    assert not selection.selects("_pylong", "/lib/_pylong.py")
