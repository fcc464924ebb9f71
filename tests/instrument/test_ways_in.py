"""All the ways in which Python loads code: the same output, and tracked values in it.

Each program notes with `support.seen` which of its values are tracked when it runs instrumented.
"""

import re
import zipapp
from dataclasses import replace
from pathlib import Path

import pytest

from support.console_scripts import PIP, SETUP_PY
from support.modules import write_modules

_ADDRESS = re.compile(r"0x[0-9a-f]{6,}")
NOTE = "from tests.support.seen import note\n"


def write(folder: Path, **files: str) -> None:
    """Writes modules in which ``note`` is there."""
    write_modules(folder, files, NOTE)


def check(outcomes, folder: Path, *labels: str, plain: tuple[str, ...] = ()) -> None:
    """Both ran well and alike; values by these labels were tracked, those in `plain` were not."""
    theirs, ours = (replace(one, stdout=_ADDRESS.sub("0x", one.stdout)) for one in outcomes)
    assert theirs.status == 0, theirs
    assert ours == theirs
    tracked = {path.stem for path in folder.glob("*.tracked")}
    assert tracked == set(labels)
    assert {path.stem for path in folder.glob("*.plain")} == {*labels, *plain}


def test_ways_of_importing(both, tmp_path: Path) -> None:
    write(
        tmp_path,
        program="""
        import importlib, importlib.util, os, sys, threading
        import first                                   # circular
        from package import inner, lazy_name           # relative imports, PEP 562
        from package.inner import *
        import space.below                             # a namespace package
        def late():
            import imported_late
            return imported_late.value
        note("circular", first.both())
        note("relative", inner.value + there)
        note("pep562", lazy_name)
        note("namespace", space.below.value)
        note("late", late())
        again = importlib.reload(inner)
        note("reload", again.value)
        print(again is inner, again.value, late(), first.both(), sorted(vars(inner)))

        path = os.path.join(os.path.dirname(__file__), "odd name.py")
        spec = importlib.util.spec_from_file_location("odd", path)
        odd = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(odd)
        note("location", odd.value)
        print(odd, odd.__spec__, vars(odd).keys())

        spec = importlib.util.find_spec("lazy")
        spec.loader = importlib.util.LazyLoader(spec.loader)
        lazy = importlib.util.module_from_spec(spec)
        sys.modules["lazy"] = lazy
        spec.loader.exec_module(lazy)
        print(type(lazy).__name__)
        note("lazyloader", lazy.value)
        print(type(lazy).__name__, type(lazy.__loader__).__name__, lazy)

        pid = os.fork()
        if pid == 0:
            import imported_by_child
            note("fork", imported_by_child.value * late())
            os._exit(0)
        print(os.waitpid(pid, 0)[1])
        threads = [threading.Thread(target=importlib.import_module, args=(f"many{i}",))
                   for i in range(4)]
        for thread in threads: thread.start()
        for thread in threads: thread.join()
        note("threads", sum(sys.modules[f"many{i}"].value for i in range(4)))
        for name in ("missing", "package.missing", "broken", "failing"):
            try: importlib.import_module(name)
            except Exception as error: print(type(error), error, name in sys.modules)
        """,
        first="import second\nhere = 1.5\ndef both(): return second.double() + here\n",
        second="import first\ndef double(): return first.here * 2.0\n",
        package____init__="""
        from . import inner
        def __getattr__(name):
            if name == "lazy_name":
                from .deep import value
                return value
            raise AttributeError(name)
        """,
        package__inner="from .deep import value\n__all__ = ['there']\nthere = value * 1.0\n",
        package__deep="value = 2.5\n",
        space__below="value = 3.5\n",
        imported_late="value = 4.5\n",
        lazy="value = 5.5\n",
        broken="value = (1\n",
        failing="value = 1 / 0\n",
        imported_by_child="value = 7.5\n",
        **{f"many{i}": f"value = {i}.5\n" for i in range(4)},
    )
    (tmp_path / "odd name.py").write_text("value = 6.5\n")
    outcomes = both("program.py")
    labels = ("circular", "relative", "pep562", "namespace", "late", "reload", "location",
              "lazyloader", "threads", "fork")  # fmt: skip
    check(outcomes, tmp_path, *labels)


def test_runpy_within_a_program(both, tmp_path: Path) -> None:
    write(
        tmp_path,
        program="""
        import runpy, sys
        names = runpy.run_path("script.py", {"given": 2}, run_name="called")
        note("run_path", names["value"])
        print(sorted(names), names["__name__"], names["__file__"])
        names = runpy.run_module("package", run_name="__main__", alter_sys=True)
        note("run_module", names["value"])
        print(sorted(names), names["__spec__"], sys.argv)
        """,
        script="value = given * 1.5\n",
        package____init__="",
        package____main__="from .beside import half\nvalue = half * 3.0\n",
        package__beside="half = 0.5\n",
    )
    check(both("program.py"), tmp_path, "run_path", "run_module")


@pytest.mark.parametrize("words", [["-m", "pack"], ["-m", "pack.tool", "x"], ["pack"]])
def test_a_package_as_program(both, tmp_path: Path, words: list[str]) -> None:
    write(
        tmp_path,
        pack____init__="version = 1.5\n",
        pack____main__="import sys\nvalue = 2.5\nnote('main', value)\nprint(sys.argv, value)\n",
        pack__tool="from . import version\nimport sys\nvalue = version * 2.0\n"
        "note('main', value)\nprint(sys.argv, value, __package__)\n",
    )
    check(both(*words), tmp_path, "main")


def test_a_module_in_a_namespace_package_as_program(both, tmp_path: Path) -> None:
    write(
        tmp_path,
        space__program="from . import beside\nnote('main', beside.value * 2.0)\nprint(__spec__)\n",
        space__beside="value = 0.5\n",
    )
    check(both("-m", "space.program"), tmp_path, "main")


def test_a_zip_application(both, tmp_path: Path) -> None:
    source = tmp_path / "source"
    write(
        source,
        app____init__="",
        app__main="from .beside import value\ndef main():\n    note('zipped', value * 2.0)\n"
        "    print(value, __file__, __loader__.archive)\n",
        app__beside="value = 0.5\n",
    )
    zipapp.create_archive(source, tmp_path / "app.pyz", main="app.main:main", compressed=True)
    check(both("app.pyz"), tmp_path, "zipped")


PIP_SCRIPT = PIP.format(module="demo.app")
COLCON_SCRIPT = SETUP_PY.format(distribution="demo==0.1", name="talker")
APP = """
import sys
from .gains import gain
def main():
    note("app", gain * 2.0)
    print(sys.argv, gain * 2.0, __name__)
    return 0
"""


def install_demo(site: Path, package: Path) -> None:
    """What an installer leaves of package `demo`, whose code is in `package`."""
    write(package, demo____init__="", demo__app=APP, demo__gains="gain = 1.5\n")
    information = site / "demo-0.1.dist-info"
    information.mkdir(parents=True)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: demo\nVersion: 0.1\n")
    (information / "entry_points.txt").write_text("[console_scripts]\ntalker = demo.app:main\n")


@pytest.mark.parametrize("script", [PIP_SCRIPT, COLCON_SCRIPT], ids=["pip", "colcon"])
def test_started_as_ros2_run_and_launch_do(both, tmp_path: Path, script: str) -> None:
    site = tmp_path / "lib" / "python3" / "site-packages"
    install_demo(site, site)
    talker = tmp_path / "lib" / "demo" / "talker"
    talker.parent.mkdir()
    talker.write_text(script)
    # `ros2 run --prefix 'python -m rosslt_auto run'`, and a launch file's prefix, come to this:
    words = (str(talker), "one", "--ros-args", "-r", "__node:=other", "--params-file", "/none")
    check(both(*words, path=(site,), options=()), tmp_path, "app")


@pytest.mark.parametrize("how", ["path", "finder"])
def test_an_editable_installation(both, tmp_path: Path, how: str) -> None:
    site, source = tmp_path / "environment" / "site-packages", tmp_path / "elsewhere" / "src"
    install_demo(site, source)
    if how == "path":  # what a .pth file does
        path: tuple[Path, ...] = (site, source)
        start = ""
    else:
        path = (site,)
        start = "import __editable___demo_finder as finder; finder.install()\n"
        (site / "__editable___demo_finder.py").write_text(
            "import sys\n"
            "from importlib.util import spec_from_file_location\n"
            f"MAPPING = {{'demo': {str(source / 'demo')!r}}}\n"
            "class Finder:\n"
            "    @classmethod\n"
            "    def find_spec(cls, name, path=None, target=None):\n"
            "        if name in MAPPING:\n"
            "            return spec_from_file_location(name, MAPPING[name] + '/__init__.py')\n"
            "def install(): sys.meta_path.append(Finder)\n"
        )
    (tmp_path / "sitecustomize").mkdir()
    (tmp_path / "sitecustomize" / "sitecustomize.py").write_text(start)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "talker").write_text(PIP_SCRIPT)
    check(both("bin/talker", "x", path=(tmp_path / "sitecustomize", *path)), tmp_path, "app")


def test_patterns_choose_among_other_modules(both, tmp_path: Path) -> None:
    write(
        tmp_path,
        app__program="import library.used, library.left, other\n"
        "note('used', library.used.value); note('left', library.left.value)\n"
        "note('other', other.value); note('main', 1.5)\n",
        lib__library____init__="",
        lib__library__used="value = 0.5\n",
        lib__library__left="value = 1.5\n",
        lib__other="value = 2.5\n",
    )
    options = ("--module", "library.*", "--exclude", "*.left")
    outcomes = both("app/program.py", path=(tmp_path / "lib",), options=options)
    check(outcomes, tmp_path, "used", "main", plain=("left", "other"))
