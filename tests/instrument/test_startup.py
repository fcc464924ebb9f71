"""`ROSSLT_AUTO_MODULES`: processes that others start, in an environment with our `.pth` file."""

import os
import shutil
import subprocess
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
HOOK = ROOT / "packaging" / "rosslt_auto.pth"

TABLES = """
import builtins, sys
STEP = 1.5
def tables():
    return sorted({n.split(".")[1] for n in vars(builtins) if n.startswith("@rosslt.")
                   and n.count(".") > 1})
"""
NODE = """#!{python}
import sys
from tables import tables
SPEED = 0.5
print("{name}", SPEED * 2, sys.argv[1:], __name__, sys.flags.optimize, tables())
"""
LAUNCH = """
import subprocess, sys
for command in {commands}:
    print(subprocess.run(command).returncode, flush=True)
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A virtual environment in which this package and what it needs are installed."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, symlinks=True)
    site = Path(sysconfig.get_path("purelib", "venv", {"base": folder, "installed_base": folder}))
    installed = sysconfig.get_path("purelib")
    (site / "__editable__.rosslt_auto.pth").write_text(f"{ROOT}\n{installed}\n")
    shutil.copy(HOOK, site)
    return folder


class Started:
    """Programs of a folder, started by the environment's interpreter."""

    def __init__(self, environment: Path, folder: Path) -> None:
        self.folder = folder
        self.python = str(environment / "bin" / "python")
        (folder / "tables.py").write_text(TABLES)

    def node(self, name: str, code: str = "") -> str:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(NODE.format(python=self.python, name=path.stem) + code)
        path.chmod(0o755)
        return str(path)

    def __call__(self, *words: str, modules: str | None = None, **variables: str) -> list[str]:
        """Exit status, what is printed, and what is said on stderr."""
        kept = {name: v for name, v in os.environ.items() if not name.startswith("PYTHON")}
        changes = {"ROSSLT_AUTO_MODULES": modules} if modules is not None else {}
        done = subprocess.run(
            [self.python, *words], cwd=self.folder, capture_output=True, text=True, timeout=120,
            env={**kept, "PYTHONPATH": str(self.folder), **changes, **variables},
        )  # fmt: skip
        return [str(done.returncode), *done.stdout.splitlines(), done.stderr]


@pytest.fixture
def started(environment: Path, tmp_path: Path) -> Started:
    return Started(environment, tmp_path)


@pytest.mark.slow
def test_what_a_launch_file_starts(started: Started) -> None:
    """A script by its path and by its name, a console script and a module by their package."""
    by_path, by_name = started.node("far/away.py"), started.node("driver.py")
    other = started.node("other.py")
    started.node("pkg/__init__.py"), started.node("pkg/node.py", "def main(): return 3\n")
    console = Path(started.node("talker"))
    console.write_text(f"#!{started.python}\nimport sys\nfrom pkg.node import main\n"
                       "if __name__ == '__main__':\n    sys.exit(main())\n")  # fmt: skip
    commands = [[by_path, "x"], [started.python, "-O", by_name, "-m", "y"], [other],
                [str(console), "z"], [started.python, "-m", "pkg.node"]]  # fmt: skip
    (started.folder / "launch.py").write_text(LAUNCH.format(commands=commands))
    plain = started("launch.py")
    wanted = "pkg*, driver,*/far/aw?y.py"
    status, *lines, errors = started("launch.py", modules=wanted)
    assert (status, errors) == ("0", "")
    stripped = [line.rpartition("[")[0] for line in lines]
    assert stripped == [line.rpartition("[")[0] for line in plain[1:-1]]
    tables = [line.rpartition("[")[2] for line in lines if line.endswith("]")]
    assert tables[0] == "'__main__']"  # the folder of the script, not the one on PYTHONPATH
    assert tables[1] == "'__main__', 'tables']"
    assert tables[2] == "]"
    assert tables[3:] == ["'pkg']"] * 4  # the package and its module, twice
    assert all(line.endswith("[]") for line in plain[1:-1] if line.endswith("]"))


@pytest.mark.slow
def test_a_failure_looks_as_without_us(started: Started) -> None:
    script = started.node("driver.py", "def f(x):\n    return 1 / (x - 0.5)\nf(SPEED)\n")
    plain, ours = started(script), started(script, modules="driver")
    assert ours[1] == f"{plain[1].removesuffix('[]')}['__main__', 'tables']"
    assert (ours[0], ours[2]) == (plain[0], plain[2]) and "ZeroDivisionError" in plain[2]


def test_unset_or_without_a_match_nothing_of_ours_is_loaded(started: Started) -> None:
    code = "import sys, json; print(sorted(n for n in sys.modules if n.startswith('rosslt')))"
    assert started("-c", code) == ["0", "[]", ""]
    assert started("-c", code, modules=" , ")[1:] == ["['rosslt_auto', 'rosslt_auto.startup']", ""]
    assert started("-c", code, modules="pkg")[1:] == ["['rosslt_auto', 'rosslt_auto.startup']", ""]


def test_run_takes_the_variable_as_further_patterns(started: Started) -> None:
    started.node("far/away.py")
    found = started("-m", "rosslt_auto", "run", "far/away.py", modules="tables")
    assert found[0] == "0" and found[1].endswith("['__main__', 'tables']"), found


@pytest.mark.parametrize("where", ["__init__.py", "startup.py", "processes.py"])
def test_our_errors_never_break_a_process(started: Started, where: str) -> None:
    """With a broken installation: one line, and the program as it is."""
    broken = started.folder / "broken" / "rosslt_auto"
    shutil.copytree(ROOT / "rosslt_auto", broken, ignore=shutil.ignore_patterns("__pycache__"))
    (broken / where).write_text("raise RuntimeError('broken')\n")
    started.node("pkg.py")
    status, line, errors = started(
        "-m", "pkg", "a", modules="pkg", PYTHONPATH=f"{broken.parent}:{started.folder}"
    )
    assert (status, line) == ("0", "pkg 1.0 ['a'] __main__ 0 []")
    assert errors == "rosslt_auto: a process runs without provenance: broken\n"


def test_the_wheel_has_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The build backend adds it, with a line in RECORD, so that uninstalling removes it."""
    import csv
    import importlib.util
    import zipfile

    pytest.importorskip("setuptools.build_meta", reason="builds are isolated, tests may be without")
    spec = importlib.util.spec_from_file_location("backend", ROOT / "packaging" / "backend.py")
    assert spec is not None and spec.loader is not None
    backend = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(backend)
    wheel = tmp_path / "a.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("a/__init__.py", "x = 1")
        archive.writestr("a-1.dist-info/RECORD", "a/__init__.py,,\na-1.dist-info/RECORD,,\n")
    backend.add(str(wheel), str(HOOK))
    with zipfile.ZipFile(wheel) as archive:
        assert archive.read("rosslt_auto.pth") == HOOK.read_bytes()
        assert archive.read("a/__init__.py") == b"x = 1"
        rows = list(csv.reader(archive.read("a-1.dist-info/RECORD").decode().splitlines()))
    assert rows[2][0] == "rosslt_auto.pth" and rows[2][2] == str(HOOK.stat().st_size)
