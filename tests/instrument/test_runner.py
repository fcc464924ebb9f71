"""``run`` is like python: the same program, plain and instrumented, in processes of their own."""

import signal
import sys
import zipfile
from pathlib import Path

import pytest

PROGRAM = '''
"""Doc of the program."""
import atexit, math, os, sys, threading
print(__name__, __file__, repr(__doc__), __package__, __cached__, type(__loader__).__name__)
print(__spec__ and (__spec__.name, __spec__.origin), list(globals()), __builtins__)
print(sys.argv, sys.path[:2], sys.modules["__main__"].__dict__ is globals())
GAIN = 0.5 * len(sys.argv)
atexit.register(print, "bye", GAIN)
def fail(a=1.5):
    return math.sqrt(
        a
        - 5)
def unhandled(): fail()
mode = sys.argv[1] if len(sys.argv) > 1 else ""
if mode == "error": unhandled()
if mode == "status": sys.exit(3)
if mode == "computed": sys.exit(GAIN and 7)
if mode == "message": sys.exit("a message")
if mode == "float": sys.exit(2.5)
if mode == "none": sys.exit()
if mode == "hook":
    sys.excepthook = lambda kind, error, trace: print("hook", kind, trace.tb_lineno)
    fail()
if mode == "broken hook":
    sys.excepthook = lambda *ignored: 1 / 0
    fail()
if mode == "no hook":
    del sys.excepthook
    fail()
if mode == "leaving hook":
    sys.excepthook = lambda *ignored: sys.exit(9)
    fail()
if mode == "chain":
    try: fail()
    except ValueError as error: raise RuntimeError("x") from error
if mode == "group": raise ExceptionGroup("g", [ValueError(1), TypeError(2.5)])
if mode == "base": raise BaseException("x")
if mode == "thread":
    thread = threading.Thread(target=fail, name="T"); thread.start(); thread.join()
if mode == "os": os._exit(4)
if mode == "import": import missing_module
if mode == "syntax": import broken
if mode == "eval": eval("1 +")
if mode == "warning":
    import warnings; warnings.warn("careful", stacklevel=1)
if mode == "last":
    atexit.register(lambda: print(sys.last_type, sys.last_value, sys.last_traceback.tb_lineno))
    fail()
'''
MODES = ["", "error", "status", "computed", "message", "float", "none", "hook", "broken hook",
         "no hook", "leaving hook", "chain", "group", "base", "thread", "os", "import", "syntax",
         "eval", "warning", "last"]  # fmt: skip


@pytest.mark.parametrize("mode", MODES)
def test_script(both, tmp_path: Path, mode: str) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "broken.py").write_text("x = (1")
    plain, ours = both("program.py", *([mode] if mode else []))
    assert ours == plain


@pytest.mark.parametrize("mode", ["", "error", "status", "import", "syntax"])
def test_module(both, tmp_path: Path, mode: str) -> None:
    (tmp_path / "pkg" / "sub").mkdir(parents=True)
    (tmp_path / "pkg" / "__init__.py").touch()
    (tmp_path / "pkg" / "sub" / "program.py").write_text(PROGRAM)
    (tmp_path / "broken.py").write_text("x = (1")
    plain, ours = both("-m", "pkg.sub.program", *([mode] if mode else []))
    assert ours == plain


@pytest.mark.parametrize("mode", ["", "error"])
def test_package_folder_and_archive(both, tmp_path: Path, mode: str) -> None:
    folder = tmp_path / "app"
    folder.mkdir()
    (folder / "__main__.py").write_text("from helper import x\nprint(x, __package__)\n" + PROGRAM)
    (folder / "helper.py").write_text("x = 0.5")
    with zipfile.ZipFile(tmp_path / "app.zip", "w") as archive:
        archive.write(folder / "__main__.py", "__main__.py")
        archive.write(folder / "helper.py", "helper.py")
    for words in (["app"], ["app.zip"], ["./app/"], ["-m", "app"]):
        plain, ours = both(*words, *([mode] if mode else []))
        assert ours == plain


@pytest.mark.parametrize(
    "words",
    [
        ["missing.py"],
        ["missing/script.py"],
        ["module.py/"],
        ["dangling.py"],
        ["-m", "missing_module"],
        ["-m", "pkg"],
        ["-m", "pkg.missing"],
        ["-m", "module.py"],
        ["-m", "failing"],
        ["-m", "failing.x"],
        ["empty"],
    ],
)
def test_what_cannot_be_run(both, tmp_path: Path, words: list[str]) -> None:
    (tmp_path / "pkg").mkdir()
    (tmp_path / "pkg" / "__init__.py").touch()
    (tmp_path / "module.py").touch()
    (tmp_path / "failing").mkdir()
    (tmp_path / "failing" / "__init__.py").write_text("x = 1 / 0")
    (tmp_path / "failing" / "x.py").touch()
    (tmp_path / "empty").mkdir()
    (tmp_path / "dangling.py").symlink_to("nowhere")
    plain, ours = both(*words)
    assert plain.status != 0
    assert ours == plain


@pytest.mark.parametrize(
    "source",
    ["x = (1", "def f(:\n  pass", "x = 1\n  y = 2", "return 1", "x = 'open", "nonlocal x",
     "x = 1\nx is 1\nf(**a, *b)", "if True:\nx = 1", "print 'x'"],
)  # fmt: skip
def test_syntax_errors(both, tmp_path: Path, source: str) -> None:
    (tmp_path / "bad.py").write_text(source)
    plain, ours = both("bad.py")
    assert plain.status == 1
    assert ours == plain


NOT_AS_FILES = pytest.mark.xfail(
    sys.version_info >= (3, 14), strict=True,
    reason="3.14 says of a file how it cannot be decoded, of the same bytes only that",
)  # fmt: skip


@pytest.mark.parametrize(
    "source",
    [b"x = '\xff'", b"x = 1\n\ny = '\xe9'\n", b"x = 1\n\0y",
     b"\xef\xbb\xbf# coding: latin-1\nx", b"x\n# coding: nosuch\n",
     *(pytest.param(source, marks=NOT_AS_FILES) for source in (
         b"\xff\xfex\0", b"# coding: nosuch\nx", b"# coding: utf-8\nx = '\xff'",
         b"\xef\xbb\xbfx = '\xff'", b"#!python\n# coding: ascii\nx = '\xe9'",
         b"# coding: rot13\nx",
     ))],
    ids=repr,
)  # fmt: skip
def test_what_is_no_text(both, tmp_path: Path, source: bytes) -> None:
    (tmp_path / "bad.py").write_bytes(source)
    plain, ours = both("bad.py")
    assert plain.status == 1
    assert ours == plain


def test_first_path_of_linked_scripts(both, tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "program.py").write_text(
        "import sys, helper\nprint(sys.path[0], __file__)"
    )
    (tmp_path / "real" / "helper.py").write_text("x = 1")
    (tmp_path / "link.py").symlink_to(tmp_path / "real" / "program.py")
    plain, ours = both("link.py")
    assert plain.status == 0
    assert ours == plain


@pytest.mark.parametrize("option", ["-O", "-OO", "-B", "-P", "-Wd", "-Xutf8"])
def test_options_of_the_interpreter(both, tmp_path: Path, option: str) -> None:
    (tmp_path / "program.py").write_text(
        '"""Doc."""\nimport sys\nprint(__doc__, sys.flags)\nassert False, "seen"\n'
    )
    plain, ours = both("program.py", python=(option,))
    assert ours == plain


def test_compiled_scripts(both, tmp_path: Path) -> None:
    import py_compile

    source = tmp_path / "program.py"
    source.write_text("import sys\nprint(__file__, sys.argv, __loader__.__class__)\n1 / 0")
    py_compile.compile(str(source), cfile=str(tmp_path / "compiled.pyc"))
    plain, ours = both("compiled.pyc", "x")
    assert ours == plain


def test_source_encodings(both, tmp_path: Path) -> None:
    (tmp_path / "latin.py").write_bytes(b"# coding: latin-1\nprint(ascii('\xe9'), 0.5)")
    (tmp_path / "bom.py").write_bytes(b"\xef\xbb\xbfprint('\xc3\xa9', 0.5)")
    for name in ("latin.py", "bom.py"):
        plain, ours = both(name)
        assert plain.status == 0
        assert ours == plain


def test_interrupted(both, tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(
        "import atexit\natexit.register(print, 'bye')\nraise KeyboardInterrupt"
    )
    for words in (["program.py"], ["-m", "program"]):
        plain, ours = both(*words)
        assert plain.status == -signal.SIGINT
        assert ours == plain


def test_tracked_inside(tmp_path: Path, both) -> None:
    (tmp_path / "program.py").write_text(
        "import helper, builtins\n"
        "print([n.split('.')[1] for n in vars(builtins) if n.startswith('@rosslt.')\n"
        "       and n.count('.') > 1])\nx = 0.5\n"
    )
    (tmp_path / "helper.py").write_text("x = 0.5")
    plain, ours = both("program.py")
    assert plain.stdout == "[]\n"
    assert ours.stdout == "['__main__', 'helper']\n"
