"""Forcing fields: targets, solutions for several fields, and what counts as reached."""

from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Point32, Twist

from rosslt_auto.provenance.operators import OPERATORS
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.values import leaf, record, untracked
from rosslt_auto.ros import forcing
from rosslt_auto.ros.client import NoAnswer
from rosslt_auto.ros.forcing import CannotForce, Forced, Wanted
from rosslt_auto.ros.observer import TrackedMessage

SPEED = Source("/a", "rosslt.speed", "float")
TURN = Source("/b", "rosslt.turn", "float")
TIME = Source("/a", "rosslt.time", "float")


def message(**values: Any) -> TrackedMessage:
    twist = Twist()
    for path, value in values.items():
        part, _, axis = path.partition("_")
        setattr(getattr(twist, part), axis, value)
    return TrackedMessage(twist)


def wanted(message_type: Any = Twist, **targets: Any) -> list[Wanted]:
    return forcing.wanted_fields(
        message_type, {path.replace("_", "."): target for path, target in targets.items()}
    )


class Arriving:
    """Messages as a subscription gives them."""

    topic = "/cmd"

    def __init__(self, *messages: TrackedMessage) -> None:
        self.messages = list(messages)

    def next(self, deadline: float) -> TrackedMessage:
        if not self.messages:
            raise NoAnswer("no message")
        return self.messages.pop(0)


def verify(
    forced: TrackedMessage, targets: list[Wanted], solution: dict[Source, Any], *after: Any
) -> Forced:
    result = Forced("/cmd")
    result.fields = {one.path: {"target": one.target, "value": None} for one in targets}
    forcing._verify(Arriving(*after), targets, forced, solution, result, 1.0)  # type: ignore[arg-type]
    return result


def test_targets_are_what_the_field_will_show() -> None:
    [x] = forcing.wanted_fields(Point32, {"x": "0.1"})
    assert x.target == 0.10000000149011612
    before = leaf(SPEED, 2.0)
    assert x.shown_by(0.10000000149011612, before)
    assert not x.shown_by(0.1001, before)


def test_a_tiny_target_is_not_zero() -> None:
    """A covariance of 1e-12 is another one than none at all."""
    seen = message(linear_x=leaf(SPEED, 1e-11) * 0.1)
    [x] = targets = wanted(linear_x=3e-12)
    solution = forcing.solve(seen, targets)
    assert solution[SPEED] == pytest.approx(3e-11, rel=1e-9)
    assert not x.shown_by(0.0, seen.fields["linear.x"])
    assert not x.shown_by(1e-12, seen.fields["linear.x"])
    result = verify(seen, targets, solution, message(linear_x=leaf(SPEED, 1e-11) * 0.1))
    assert not result.reached
    assert verify(seen, targets, solution, message(linear_x=leaf(SPEED, 3e-11) * 0.1)).reached


def test_zero_is_shown_by_what_rounding_leaves_of_it() -> None:
    angle = leaf(TURN, 0.0)
    before = record(OPERATORS["cos"], 1.0, angle) * 2
    [x] = wanted(linear_x=0.0)
    assert x.shown_by(1.2246467991473532e-16, before)
    assert not x.shown_by(1e-12, before)


@pytest.mark.parametrize("targets", [{"linear.q": "1"}, {"linear": "1"}, {"linear.x": "fast"}])
def test_targets_that_cannot_be(targets: dict[str, str]) -> None:
    with pytest.raises(CannotForce, match=r"linear"):
        forcing.wanted_fields(Twist, targets)


def test_fields_are_solved_together() -> None:
    speed, turn = leaf(SPEED, 2.0), leaf(TURN, 0.5)
    seen = message(linear_x=speed * turn, angular_z=turn)
    targets = wanted(linear_x="3", angular_z="1.5")
    assert forcing.solve(seen, targets) == {TURN: 1.5}
    changes = forcing.changes_for(seen, {TURN: 1.5})
    assert [change.to_json() for change in changes] == [
        {"node": "/b", "parameter": "rosslt.turn", "old": 0.5, "new": 1.5}
    ]


def test_one_source_cannot_serve_two_targets() -> None:
    speed = leaf(SPEED, 2.0)
    seen = message(linear_x=speed, linear_y=speed + 1)
    with pytest.raises(CannotForce, match=r"linear"):
        forcing.solve(seen, wanted(linear_x=1.0, linear_y=5.0))


def test_what_is_there_needs_no_change() -> None:
    seen = message(linear_x=leaf(SPEED, 2.0))
    assert forcing.solve(seen, wanted(linear_x=2)) == {}


def test_a_source_that_no_node_owns() -> None:
    nobody = Source(None, "rosslt.nobody", "float")
    seen = message(linear_x=leaf(nobody, 2.0))
    with pytest.raises(CannotForce, match="nobody"):
        forcing.changes_for(seen, {nobody: 3.0})


# What counts as reached


def test_a_message_that_shows_the_target() -> None:
    forced = message(linear_x=leaf(SPEED, 2.0) * 2)
    old = message(linear_x=leaf(SPEED, 2.0) * 2)
    new = message(linear_x=leaf(SPEED, 3.0) * 2)
    result = verify(forced, wanted(linear_x=6), {SPEED: 3.0}, old, old, new)
    assert result.reached
    assert result.fields["linear.x"] == {"target": 6.0, "value": 6.0}
    assert result.reason is None


def test_no_message() -> None:
    result = verify(message(linear_x=leaf(SPEED, 2.0)), wanted(linear_x=3), {SPEED: 3.0})
    assert not result.reached
    assert "no message" in str(result.reason)
    assert result.to_json()["reason"] == result.reason


LIMIT = Source("/a", "rosslt.limit", "float")


@pytest.mark.parametrize("value", [5.0, leaf(LIMIT, 5.0)], ids=["plain", "from elsewhere"])
def test_the_program_went_another_way(value: Any) -> None:
    """The source has changed, the field does not follow it, and is not the target."""
    forced = message(linear_x=leaf(SPEED, 2.0) * 2)
    result = verify(forced, wanted(linear_x=6), {SPEED: 3.0}, message(linear_x=value))
    assert not result.reached
    assert "5.0" in str(result.reason)
    assert "another path" in str(result.reason)


def test_what_was_not_reached_can_be_taken_back_with_the_command_that_is_named() -> None:
    forced = message(linear_x=leaf(SPEED, 2.0) * 2)
    result = Forced("/cmd", changes=[forcing.Change("/a", "rosslt.speed", 2.0, 3.0)])
    result.fields = {"linear.x": {"target": 6.0, "value": None}}
    after = message(linear_x=leaf(SPEED, 2.0) * 2)
    forcing._verify(Arriving(after), wanted(linear_x=6), forced, {SPEED: 3.0}, result, 1.0)  # type: ignore[arg-type]
    assert "still computed from the old values" in str(result.reason)
    assert str(result.reason).endswith(forcing.UNDO)
    assert "\n" not in str(result.reason)


def test_a_limit_names_its_place() -> None:
    limit = leaf(Source("/a", "rosslt.limit", "float", file="/src/controller.py", line=41), 0.5)
    speed = leaf(SPEED, 2.0)
    seen = message(linear_x=record(OPERATORS["min"], 0.5, speed, limit))
    with pytest.raises(CannotForce) as refusal:
        forcing.solve(seen, wanted(linear_x=1.0), source="rosslt.speed")
    assert str(refusal.value) == "linear.x is limited to 0.5 at controller.py:41"
    assert list(forcing.solve(seen, wanted(linear_x=0.25)).values()) == [0.25]


def test_a_wrong_source_is_told_the_right_ones() -> None:
    seen = message(linear_x=leaf(SPEED, 2.0) * leaf(TURN, 0.5))
    with pytest.raises(CannotForce, match=r"rosslt\.sped.*there are: rosslt\.speed, rosslt\.turn"):
        forcing.solve(seen, wanted(linear_x=3.0), source="rosslt.sped")


def test_the_nearest_of_a_discrete_source_is_named_with_the_command() -> None:
    count = leaf(Source("/a", "rosslt.count", "int"), 4)
    seen = message(linear_x=count * 0.5)
    with pytest.raises(CannotForce, match=r"nearest .* is 3\.5: force linear\.x=3\.5 for that"):
        forcing.solve(seen, wanted(linear_x=3.6))
    assert list(forcing.solve(seen, wanted(linear_x=3.5)).values()) == [7]


def test_both_policies_are_listed() -> None:
    seen = message(linear_x=leaf(SPEED, 2.0) + leaf(TURN, 2.0))
    left = forcing._by_policy(seen, wanted(linear_x=6.0), "left")
    assert [(c["parameter"], c["new"]) for c in left["changes"]] == [("rosslt.speed", 4.0)]
    least = forcing._by_policy(seen, wanted(linear_x=6.0), "least-change")
    found = {c["parameter"]: c["new"] for c in least["changes"]}
    assert found == pytest.approx({"rosslt.speed": 3.0, "rosslt.turn": 3.0})
    never = message(linear_x=record(OPERATORS["abs"], 2.0, leaf(SPEED, 2.0)))
    assert "never negative" in forcing._by_policy(never, wanted(linear_x=-1.0), "left")["reason"]


def test_a_field_that_moves_by_itself() -> None:
    def at(time: float, speed: float) -> TrackedMessage:
        return message(linear_x=leaf(SPEED, speed) * leaf(TIME, time))

    forced = at(1.0, 2.0)
    solution = forcing.solve(forced, wanted(linear_x=6))
    assert solution == {SPEED: 6.0}
    # Messages under way are computed from the old value: they prove nothing.
    assert not verify(forced, wanted(linear_x=6), solution, at(1.5, 2.0)).reached
    result = verify(forced, wanted(linear_x=6), solution, at(1.5, 2.0), at(2.0, 6.0))
    assert result.reached
    assert result.fields["linear.x"] == {"target": 6.0, "value": 12.0, "moving": True}


def test_another_path_is_no_motion() -> None:
    """A branch on the changed source: its value stays, as often as it is published."""
    forced = message(linear_x=leaf(SPEED, 0.5) * 2)
    after = [message(linear_x=leaf(SPEED, 2.5) * 10) for _ in range(3)]
    before = message(linear_x=leaf(SPEED, 0.5) * 2)
    result = verify(forced, wanted(linear_x=5), {SPEED: 2.5}, before, *after)
    assert not result.reached
    assert "linear.x is 25.0; with the new values the program took another path" in str(
        result.reason
    )


def test_motion_may_be_seen_after_the_change_only() -> None:
    forced = message(linear_x=leaf(SPEED, 2.0) * 1.0)
    after = [message(linear_x=leaf(SPEED, 6.0) * time) for time in (1.5, 2.0)]
    assert not verify(forced, wanted(linear_x=6), {SPEED: 6.0}, *after[:1]).reached
    assert verify(forced, wanted(linear_x=6), {SPEED: 6.0}, *after).reached


def test_what_stays_as_it_is_is_no_change() -> None:
    seen = message(linear_x=leaf(SPEED, 2.0))
    assert forcing.changes_for(seen, {SPEED: 2.0}) == []


def test_a_history_kept_to_first_order_proves_nothing() -> None:
    def at(time: float, speed: float) -> TrackedMessage:
        source = leaf(SPEED, speed)
        op = OPERATORS["linear"]
        value = record(op, speed * time, speed * time, source, speed, time, 1)
        return message(linear_x=value)

    result = verify(at(1.0, 2.0), wanted(linear_x=6), {SPEED: 6.0}, at(2.0, 6.0))
    assert not result.reached
    assert untracked(result.fields["linear.x"]["value"]) == 12.0


# Taking back


class Parameters:
    """Parameters of nodes: by node None where it is gone, else by name."""

    def __init__(self, nodes: dict[str, dict[str, Any] | None]) -> None:
        self.nodes = nodes
        self.parameters = self

    def knows_node(self, name: str) -> bool:
        return self.nodes.get(name) is not None

    def get(self, node: str, names: list[str], timeout: float) -> list[Any]:
        there = self.nodes[node]
        if there is None:
            raise NoAnswer(f"{node} has no parameter services in reach")
        return [there.get(name) for name in names]

    def set(self, changes: list[forcing.Change], timeout: float) -> None:
        for change in changes:
            there = self.nodes[change.node]
            assert there is not None
            there[change.parameter] = change.new


def test_only_what_is_still_as_forced_is_taken_back(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    forced = {"/a": "kept", "/b": "ended", "/c": "anew", "/d": "elsewhere"}
    forcing.journal.add([forcing.Change("/a", "earlier", 0.5, 0.75)])
    forcing.journal.add([forcing.Change(node, name, 1.0, 2.0) for node, name in forced.items()])
    nodes: dict[str, dict[str, Any] | None] = {
        "/a": {"kept": 2.0, "earlier": 0.75}, "/b": None, "/c": {}, "/d": {"elsewhere": 3.0},
    }  # fmt: skip
    back, left = forcing.undo(Parameters(nodes))  # type: ignore[arg-type]
    assert [change.to_json() for change in back] == [
        {"node": "/a", "parameter": "kept", "old": 2.0, "new": 1.0}
    ]
    assert nodes["/a"] == {"kept": 1.0, "earlier": 0.75} and nodes["/d"] == {"elsewhere": 3.0}
    assert [text.split(", ", 1)[0] for text in left] == [
        "ended of /b",
        "anew of /c",
        "elsewhere of /d",
    ]
    assert "ended with its node" in left[0]
    assert "is 3.0 now" in left[2]
    [earlier], _ = forcing.undo(Parameters(nodes))  # type: ignore[arg-type]
    assert (earlier.parameter, earlier.new) == ("earlier", 0.5)
    assert forcing.undo(Parameters(nodes)) == ([], [])  # type: ignore[arg-type]


def test_a_dry_run_that_cannot_be_lists_what_each_source_could_do() -> None:
    count = leaf(Source("/a", "rosslt.count", "int"), 4)
    seen = message(linear_x=count * leaf(SPEED, 0.5))
    told = forcing._tell(
        Forced("/cmd", dry_run=True), seen, wanted(linear_x=3.3), "left", "rosslt.count"
    )
    assert "nearest that can be reached" in str(told.reason)
    found = {entry["parameter"]: entry for entry in told.alternatives["linear.x"]}
    assert found["rosslt.speed"]["new"] == pytest.approx(0.825)
    assert "int" in found["rosslt.count"]["reason"]
    assert told.changes == []


def test_a_dry_run_of_what_is_so_already_leaves_sources_as_they_are() -> None:
    seen = message(linear_x=leaf(Source("/a", "rosslt.count", "int"), 4) * leaf(SPEED, 0.5))
    told = forcing._tell(Forced("/cmd", dry_run=True), seen, wanted(linear_x=2.0), "left", None)
    assert told.changes == [] and told.reason is None
    assert [entry["new"] for entry in told.alternatives["linear.x"]] == [4, 0.5]
