"""`install` and `uninstall`: what they leave behind, looked for everywhere."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

PROGRAM = '''
import array, builtins, importlib, json, os, sys, types
if sys.argv[1] == "all":
    import numpy, rclpy.node, rclpy.executors, yaml, zipimport, std_msgs.msg

# Ours and the program, and modules that change when somebody asks for names of theirs.
NOT_COMPARED = ("rosslt_auto", "m", "wrapt", "__main__", "collections", "_collections_abc",
                "typing")

def snapshot():
    """Every name in every module and class that is there, and what it is bound to."""
    found = {("finders",): list(map(id, sys.meta_path)), ("hooks",): list(map(id, sys.path_hooks))}
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] in NOT_COMPARED:
            continue
        for key, value in list(vars(module).items()):
            if isinstance(value, types.ModuleType) or key == "__warningregistry__":
                continue
            found[name, key] = id(value)
            if isinstance(value, type):
                for attribute, inner in list(vars(value).items()):
                    # what Python itself keeps in classes and changes as it likes
                    if not attribute.startswith("_abc_") and attribute != "__annotations__":
                        found[name, key, attribute] = id(inner)
                        keep.append(inner)
    return found

keep = []
with open("m.py", "w") as file:
    file.write("""
import math
X = 0.5
class C:
    gain = 1.5
    def f(self, k=2.5): return math.sin(self.gain) * k + float(X) + len(f"{k}{X}")
made = C()
made.kept = [3.5, {"a": (4.5, 5)}]
def running():
    yield 6.5
    yield 7.5
def plain(x): return x
""")
sys.path.insert(0, os.getcwd())
before = snapshot()
modules = set(sys.modules)
import rosslt_auto
from rosslt_auto.provenance.values import is_tracked
rosslt_auto.uninstall()
rosslt_auto.install(["m"])
rosslt_auto.install(["m"])
import m
if sys.argv[1] == "all":
    @rosslt_auto.tracked_module
    def own(k=8.5):
        return k * 9.5
    assert is_tracked(own())
assert is_tracked(m.made.f()) and is_tracked(m.X)
code = m.C.f.__code__
if sys.argv[2:]:
    running = m.running()
    assert is_tracked(next(running))
    rosslt_auto.uninstall()
    assert is_tracked(next(running)), "it ends as it began"
    assert not is_tracked(next(m.running()))
    del running
rosslt_auto.uninstall()
rosslt_auto.uninstall()
values = [m.made.f(), m.X, m.C.gain, m.made.kept[0], m.made.kept[1]["a"][0], next(m.running())]
assert not any(map(is_tracked, values)), values
if sys.argv[1] == "all":
    assert not is_tracked(own())
    del own
assert code != m.C.f.__code__
after = snapshot()
for key in before.keys() | after.keys():
    # modules that we alone have imported are no trace
    if before.get(key) != after.get(key) and (key[0] in modules or key[0] == "finders"):
        print("changed:", *key)
print("done")
rosslt_auto.install(["m"])
importlib.reload(m)
assert is_tracked(m.C().f())
'''


@pytest.mark.parametrize("words", [["little"], ["all"], ["little", "while running"]])
def test_nothing_is_left_behind(tmp_path: Path, words: list[str]) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    ended = subprocess.run(
        [sys.executable, "program.py", *words],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (ended.stdout, ended.stderr) == ("done\n", "")
