"""`multiprocessing` under `run`: the same results as plain, from instrumented processes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

PROGRAM = """
import builtins, multiprocessing, os, runpy, sys, threading
from concurrent.futures import ProcessPoolExecutor
import helper
GAIN = 0.5
def work(x): return GAIN * x + helper.OFFSET, type(GAIN).__name__
def tables():
    names = {n.split(".")[1] for n in vars(builtins) if n.startswith("@rosslt.")
             and n.count(".") > 1}
    with open("tables", "w") as file: print(*sorted(names), file=file)
def child(queue, pipe, x): queue.put((x * 2.0, {"a": [GAIN, f"{x:.1f} m"]})); pipe.send(x)
def fails(x):
    raise ValueError(GAIN)
class Shape:
    def __init__(self, r=1.5): self.r = r
    def area(self): return self.r * 3
def forked():
    if os.fork():
        print(os.waitstatus_to_exitcode(os.wait()[1]))
    else:
        try: print(GAIN, flush=True)
        finally: sys.exit(GAIN and 3)
if __name__ == "__main__":
    context = multiprocessing.get_context(sys.argv[1])
    context.set_forkserver_preload(["__main__", "helper"])
    with context.Pool(1) as pool:
        print(pool.map(work, [1, 2.5, GAIN]), pool.apply(tables))
        try: pool.apply(fails, (1,))
        except ValueError as error: print(repr(error), error.__cause__)
    queue, (near, far) = context.Queue(), context.Pipe()
    process = context.Process(target=child, args=(queue, far, GAIN), name="first")
    process.start()
    print(queue.get(), near.recv(), process.join(), process.exitcode)
    with ProcessPoolExecutor(1, mp_context=context) as executor:
        print(list(executor.map(work, [0.25, 3])), executor.submit(Shape(2.5).area).result())
    print(context.Value("d", GAIN).value, context.Array("i", [1, 2, 3])[:])
    thread = threading.Thread(target=lambda: print(GAIN + 1))
    thread.start(); thread.join()
    process = context.Process(target=fails, args=(1,), name="second")
    process.start(); process.join()
    print(process.exitcode, runpy.run_path("other.py", run_name="x")["y"])
    forked()
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "helper.py").write_text("OFFSET = 0.25\n")
    (tmp_path / "other.py").write_text("y = 1.5\n")
    return tmp_path


def outcome(folder: Path, *words: str, path: Path = ROOT) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, *words], cwd=folder, capture_output=True, text=True, timeout=120,
        env={**os.environ, "PYTHONPATH": str(path), "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "how"),
    [("spawn", ["program.py"]), ("spawn", ["-m", "program"]), ("fork", ["program.py"]),
     ("forkserver", ["program.py"])],
    ids=str,
)  # fmt: skip
def test_results_are_those_of_plain_processes(folder: Path, method: str, how: list[str]) -> None:
    plain = outcome(folder, *how, method)
    assert plain[1].endswith("0.5\n3\n"), plain
    assert (folder / "tables").read_text() == "\n"
    assert outcome(folder, "-m", "rosslt_auto", "run", *how, method) == plain
    main = {"__main__", "__mp_main__", "program"}
    first, second = (folder / "tables").read_text().split()
    assert (first in main and second == "helper") or (first == "helper" and second in main)


@pytest.mark.slow
def test_a_process_that_cannot_have_us_runs_plain(folder: Path) -> None:
    broken = folder / "broken"
    (broken / "rosslt_auto").mkdir(parents=True)
    (folder / "program.py").write_text(
        PROGRAM.replace("    context =", "    import rosslt_auto.processes as p\n"
                        f"    p.__file__ = {str(broken / 'rosslt_auto' / 'x.py')!r}\n    context =")
    )  # fmt: skip
    (broken / "rosslt_auto" / "__init__.py").write_text("raise RuntimeError('broken')\n")
    _, stdout, stderr = outcome(
        folder, "-c", f"import sys; sys.path[0] = {str(ROOT)!r}; from rosslt_auto.cli import main;"
        "sys.exit(main(['run', 'program.py', 'spawn']))", path=broken,
    )  # fmt: skip
    assert stdout.endswith("0.5\n3\n") and (folder / "tables").read_text() == "\n"
    assert "rosslt_auto: a process runs without provenance: broken\n" in stderr


SUBINTERPRETERS = """
try: import _xxsubinterpreters as interpreters
except ImportError: import _interpreters as interpreters
one = interpreters.create()
n, text = 5, "a text"
interpreters.run_string(one, "print(n, text, 0.5)", {"n": n, "text": text})
interpreters.destroy(one)
interpreters.destroy(interpreters.create())
"""


def test_subinterpreters_run_plain_and_that_is_said(folder: Path) -> None:
    (folder / "program.py").write_text(SUBINTERPRETERS)
    status, stdout, stderr = outcome(folder, "program.py")
    assert (status, stdout, stderr) == (0, "5 a text 0.5\n", "")
    status, stdout, stderr = outcome(folder, "-m", "rosslt_auto", "run", "program.py")
    assert (status, stdout) == (0, "5 a text 0.5\n")
    assert stderr == "rosslt_auto: subinterpreters run without provenance\n"


def test_asked_for_in_a_subinterpreter_we_refuse(folder: Path) -> None:
    inside = (
        f"import sys; sys.path[:0] = ['.', {str(ROOT)!r}]; import rosslt_auto\n"
        "rosslt_auto.install(['helper'])\n"
        "f = rosslt_auto.tracked_module(lambda: 0.5)\n"
        "import helper; from rosslt_auto.provenance import is_tracked\n"
        "print(f(), is_tracked(f()), is_tracked(helper.OFFSET))"
    )
    (folder / "program.py").write_text(
        "try: import _xxsubinterpreters as s\nexcept ImportError: import _interpreters as s\n"
        f"one = s.create()\ns.run_string(one, {inside!r})\ns.destroy(one)\n"
    )
    expected = 0, "0.5 False False\n", "rosslt_auto: subinterpreters run without provenance\n"
    assert outcome(folder, "program.py") == expected
