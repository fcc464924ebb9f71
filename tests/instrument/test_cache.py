"""The cache of rewritten code."""

import os
import stat
import sys
from pathlib import Path

import pytest

from rosslt_auto.instrument import cache, hook, tables, weaving

SOURCE = b"'doc'\nx = 0.5\ndef f(): return x + 1\n"


@pytest.fixture(autouse=True)
def _writing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", None)


@pytest.fixture
def module(tmp_path: Path) -> str:
    path = tmp_path / "m.py"
    path.write_bytes(SOURCE)
    return str(path)


@pytest.fixture
def woven(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the modules that had to be rewritten."""
    names: list[str] = []
    weave = weaving.weave

    def counting(module, *args):
        names.append(module)
        return weave(module, *args)

    monkeypatch.setattr(weaving, "weave", counting)
    return names


def load(path: str, source: bytes = SOURCE, name: str = "m"):
    namespace: dict = {}
    exec(hook.instrumented_code(name, path, source), namespace)
    return namespace


def test_second_load_rewrites_nothing(module: str, woven: list[str]) -> None:
    first, second = load(module), load(module)
    assert woven == ["m"]
    assert first["__doc__"] == second["__doc__"] == "doc"
    assert second["f"]() == 1.5
    assert second["f"].__code__.co_filename == module


def test_a_changed_source_is_rewritten_whatever_its_time(module: str, woven: list[str]) -> None:
    load(module)
    times = os.stat(module)
    os.utime(module, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert load(module, SOURCE.replace(b"0.5", b"0.7"))["x"] == 0.7
    assert woven == ["m", "m"]


def test_other_name_or_place_is_another_entry(
    module: str, woven: list[str], tmp_path: Path
) -> None:
    load(module)
    load(module, name="other")
    copy = tmp_path / "copy"
    copy.mkdir()
    os.rename(tmp_path / "__pycache__", copy / "__pycache__")
    load(str(copy / "m.py"))
    assert woven == ["m", "other", "m"]


def test_entries_have_a_tag_of_their_own(module: str) -> None:
    load(module)
    (entry,) = Path(module).parent.joinpath("__pycache__").iterdir()
    assert entry.name == f"m.{sys.implementation.cache_tag}.rosslt-{cache.FORMAT}.pyc"
    assert cache.path_for(module) == str(entry)


def test_levels_of_optimization_are_kept_apart(module: str) -> None:
    import subprocess

    code = (
        "from rosslt_auto.instrument import hook; import sys;"
        f"hook.instrumented_code('m', {module!r}, open({module!r}, 'rb').read())"
    )
    for option in ("-O", "-OO"):
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        subprocess.run([sys.executable, option, "-c", code], check=True, env=environment)
    names = sorted(path.name for path in Path(module).parent.joinpath("__pycache__").iterdir())
    assert [name.split(".")[2] for name in names] == ["opt-1", "opt-2"]


def test_prefix(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "prefix"))
    load(module)
    assert not (tmp_path / "__pycache__").exists()
    assert len(list((tmp_path / "prefix").rglob("m.*.pyc"))) == 1


def test_nothing_is_written_if_the_user_says_so(
    module: str, woven: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    load(module)
    assert not Path(module).parent.joinpath("__pycache__").exists()


def test_nothing_is_written_where_it_cannot_be(module: str, monkeypatch) -> None:
    def refuse(*args, **keywords):
        raise PermissionError("read-only")

    monkeypatch.setattr(os, "replace", refuse)
    assert load(module)["x"] == 0.5
    assert list(Path(module).parent.joinpath("__pycache__").iterdir()) == []
    monkeypatch.setattr(os, "open", refuse)
    assert load(module)["x"] == 0.5
    monkeypatch.setattr(os, "makedirs", refuse)
    assert load(module)["x"] == 0.5


def test_permissions_are_those_of_the_source(module: str) -> None:
    os.chmod(module, 0o600)
    load(module)
    assert stat.S_IMODE(os.stat(cache.path_for(module)).st_mode) == 0o600


@pytest.mark.parametrize("length", [0, 3, 16, 20, 30, -1])
def test_cut_off_entries_are_ignored(module: str, woven: list[str], length: int) -> None:
    load(module)
    path = Path(cache.path_for(module))
    path.write_bytes(path.read_bytes()[:length])
    assert load(module)["x"] == 0.5
    assert woven == ["m", "m"]
    load(module)
    assert woven == ["m", "m"]  # it has been replaced


@pytest.mark.parametrize("payload", [b"", b"N", b"i\x01\x00\x00\x00", b"\xff" * 20, b"(\x06"])
def test_wrong_entries_are_ignored(module: str, woven: list[str], payload: bytes) -> None:
    path = Path(cache.path_for(module))
    path.parent.mkdir()
    path.write_bytes(cache._header(SOURCE) + payload)
    assert load(module)["x"] == 0.5
    assert woven == ["m"]


def test_entries_of_another_rewriter_are_ignored(
    module: str, woven: list[str], monkeypatch
) -> None:
    load(module)
    monkeypatch.setattr(cache, "_engine", b"else")
    load(module)
    assert woven == ["m", "m"]


def test_names_are_read_late(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from rosslt_auto.provenance.locations import source_of

    load(module)
    monkeypatch.setattr(
        tables, "_describe", lambda infos: pytest.fail("asked for names that nobody wants")
    )
    namespace = load(module)
    monkeypatch.undo()
    assert source_of(namespace["x"]).parameter == "rosslt.m.x"
