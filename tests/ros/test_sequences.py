"""Which fields of messages are woven."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from visualization_msgs.msg import Marker

from rosslt_auto.provenance import mentioned
from rosslt_auto.ros import sequences
from rosslt_auto.ros.fields import tracked_fields
from support.instrumented import loaded


@pytest.fixture(autouse=True)
def _nothing_mentioned(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    sequences.uninstall()
    monkeypatch.setattr(mentioned, "_names", set())
    monkeypatch.setattr(mentioned, "_unread", [])
    monkeypatch.setattr(mentioned, "_any", False)
    yield
    sequences.uninstall()


def attributes(cls: type) -> dict[str, Any]:
    return {name: vars(cls)[name] for name in (*cls._fields_and_field_types, "__init__")}  # type: ignore[attr-defined]


def woven(plain: dict[str, Any], cls: type) -> set[str]:
    now = attributes(cls)
    return {name for name, thing in plain.items() if thing is not now[name]}


def test_what_nobody_mentions_is_plain(tmp_path: Path) -> None:
    plain = {cls: attributes(cls) for cls in (JointState, Marker, Bool)}
    sequences.install()
    with loaded("x = 1.5", tmp_path):
        assert not any(woven(before, cls) for cls, before in plain.items())


def test_what_is_mentioned_is_woven_before_and_after(tmp_path: Path) -> None:
    plain = {cls: attributes(cls) for cls in (JointState, Marker)}
    program = """
        from sensor_msgs.msg import JointState

        def state():
            msg = JointState()
            msg.velocity = [1.5, 2.0]
            return msg
    """
    sequences.install()
    with loaded(program, tmp_path) as one:
        assert woven(plain[JointState], JointState) == {"velocity", "__init__"}
        assert not woven(plain[Marker], Marker)
        assert set(tracked_fields(one.names.state())) == {"velocity[0]", "velocity[1]"}
        sequences.uninstall()
        assert not woven(plain[JointState], JointState)
        sequences.install()
        assert woven(plain[JointState], JointState) == {"velocity", "__init__"}


@pytest.mark.parametrize("source", [None, b"setattr(msg, name, value)"])
def test_any_field_may_be_meant(source: bytes | None) -> None:
    plain = {cls: attributes(cls) for cls in (JointState, Marker, Bool)}
    sequences.install()
    mentioned.read(source)
    assert woven(plain[JointState], JointState) == {"position", "velocity", "effort", "__init__"}
    assert woven(plain[Marker], Marker) == {"frame_locked", "mesh_use_embedded_materials"}
    assert woven(plain[Bool], Bool) == {"data"}


def test_names_count_wherever_they_stand() -> None:
    mentioned.read(b"msg.alpha = kind(beta=1)\nfill({'gamma': 2})\n# delta")
    names = ("alpha", "beta", "gamma", "delta", "epsilon", "alph")
    assert [mentioned.is_mentioned(name) for name in names] == [True] * 4 + [False] * 2
