"""What a drag changes."""

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import pytest

from rosslt_auto.provenance import Source
from rosslt_auto.provenance.limits import Limits
from rosslt_auto.provenance.values import leaf, untracked
from rosslt_auto.views.dragging import Changed, Choice, Choices, Drag, Dragger, Refused, solve
from rosslt_auto.views.scene import Item
from support.tracked import apply, sources_by_name, tracked


@dataclass
class Message:
    fields: dict[str, Any] = field(default_factory=dict)
    message: Any = None


def news(changes: Sequence[Changed]) -> dict[str, Any]:
    return {one.source.parameter: one.new for one in changes}


def test_all_axes_together() -> None:
    message = Message({"x": 2 * tracked(1.0, "a"), "y": tracked(3.0, "b") + 1})
    changes = solve(message, {"x": 5.0, "y": 6.0}, Choice())
    assert news(changes) == {"a": 2.5, "b": 5.0}
    assert {one.source.parameter: one.old for one in changes} == {"a": 1.0, "b": 3.0}


def test_what_is_there_already_changes_nothing() -> None:
    assert solve(Message({"x": tracked(1.0)}), {"x": 1.0}, Choice()) == []


def test_a_chosen_source_is_changed() -> None:
    message = Message({"x": tracked(1.0, "a") + tracked(2.0, "b")})
    chosen = sources_by_name(message.fields["x"])["b"]
    assert news(solve(message, {"x": 5.0}, Choice())) == {"a": 3.0}
    assert news(solve(message, {"x": 5.0}, Choice(sources={"x": chosen}))) == {"b": 4.0}


def of_node(node: str, value: float) -> Any:
    return leaf(Source(node, "count", "float"), value)


def test_a_source_of_the_same_name_in_another_node_is_another() -> None:
    value = of_node("/a", 1.0) + of_node("/b", 2.0)
    chosen = Source("/b", "count", "float")
    [change] = solve(Message({"x": value}), {"x": 5.0}, Choice(sources={"x": chosen}))
    assert (change.source, change.new) == (chosen, 4.0)


A, B = Source("/n", "a", "float"), Source("/n", "b", "float")


def test_a_choice_is_for_one_item() -> None:
    def item(key: str, root: str = "") -> Item:
        return Item(key, "/markers", root, Message())

    choices = Choices()
    choices.policy = "least-change"
    choices.choose(item("/markers/a/1"), "pose.position.x", A)
    choices.choose(item("/markers/b/1", "markers[2]"), "markers[2].pose.position.x", B)
    assert choices.of(item("/markers/a/2")) == Choice("least-change")
    assert choices.of(item("/markers/a/1")).sources == {"pose.position.x": A}
    # In the next message of the array the marker may have another place.
    moved = item("/markers/b/1", "markers[0]")
    assert choices.of(moved) == Choice("least-change", {"markers[0].pose.position.x": B})
    choices.choose(moved, "markers[0].pose.position.x", None)
    assert choices.of(moved).sources == {}


def test_least_change_moves_several() -> None:
    message = Message({"x": tracked(1.0, "a") + tracked(1.0, "b")})
    assert news(solve(message, {"x": 4.0}, Choice("least-change"))) == {
        "a": pytest.approx(2.0),
        "b": pytest.approx(2.0),
    }


def test_discrete_sources_snap() -> None:
    message = Message({"x": tracked(2, "n") * 0.5})
    assert news(solve(message, {"x": 2.2}, Choice())) == {"n": 4}


@pytest.mark.parametrize(
    "message", [Message(), Message({"x": 0.0 * tracked(1.0)}), Message({"y": tracked(1.0)})]
)
def test_what_cannot_be_reached_is_refused(message: Message) -> None:
    with pytest.raises(Refused):
        solve(message, {"x": 5.0}, Choice())


def test_a_drag_follows_the_latest_message() -> None:
    drag = Drag(Message({"x": 2 * tracked(1.0, "a")}), Choice())
    assert news(drag.to(None, {"x": 4.0})) == {"a": 2.0}
    assert news(drag.to(Message({"x": 3 * tracked(2.0, "a")}), {"x": 9.0})) == {"a": 3.0}


def test_a_drag_keeps_to_its_source() -> None:
    drag = Drag(Message({"x": tracked(1.0, "a") + tracked(0.0, "b")}), Choice())
    assert news(drag.to(None, {"x": 4.0})) == {"a": 4.0}
    turned = Message({"x": tracked(0.0, "b") + tracked(4.0, "a")})
    assert news(drag.to(turned, {"x": 5.0})) == {"a": 5.0}


def test_a_drag_does_not_slip_to_the_next_waypoint() -> None:
    drag = Drag(Message({"x": tracked(1.0, "first")}), Choice())
    assert news(drag.to(None, {"x": 2.0})) == {"first": 2.0}
    assert news(drag.to(Message({"x": tracked(7.0, "second")}), {"x": 3.0})) == {"first": 3.0}


def test_a_drag_remembers_the_values_before() -> None:
    drag = Drag(Message({"x": tracked(1.0, "a")}), Choice())
    for old, new in ((1.0, 2.0), (2.0, 3.0)):
        drag.made(drag.to(Message({"x": tracked(old, "a")}), {"x": new}))
    [change] = drag.changed.values()
    assert (change.old, change.new) == (1.0, 3.0)


@pytest.mark.parametrize(
    ("start", "factor", "target", "new"),
    [
        (-2.0, 1.0, -1.4027904867895817, -1.403),
        (500_000.0, 1.0, 500_000.12345678, 500_000.1234),
        (0.0, 1.0, 1234.5678901, 1235.0),
        (1.0, 1.0, 1.000012345678, 1.00001235),
        (3.0, 7.0, 25.123456789, 3.589),
        (2.0, 1.0, 2.0, 2.0),
    ],
)
def test_a_drag_writes_no_more_digits_than_a_hand_can_mean(
    start: float, factor: float, target: float, new: float
) -> None:
    message = Message({"x": factor * tracked(start, "a")})
    drag = Drag(message, Choice())
    for done in (0.3, 0.9999, 1.0):  # what counts is the whole way, not the last step
        at = factor * start + done * (target - factor * start)
        changes = drag.to(message, {"x": at})
        drag.made(changes)
        for one in changes:
            message = Message({"x": factor * tracked(one.new, "a")})
    assert untracked(message.fields["x"]) == pytest.approx(factor * new, rel=1e-12)


def test_digits_that_matter_are_kept() -> None:
    value = apply("exp", 20.0 * tracked(1.0, "a"))
    drag = Drag(Message({"x": value}), Choice())
    target = math.exp(20.0123456)
    [change] = drag.to(None, {"x": target})
    assert len(repr(change.new)) < len("1.00061728")
    assert math.exp(20.0 * change.new) - target < 1e-3 * (target - math.exp(20.0))


def test_digits_are_not_taken_off_what_is_limited() -> None:
    source = Source("/node", "a", "float")
    source.limits = Limits(0.0, 1.23456)
    drag = Drag(Message({"x": leaf(source, 1.0)}), Choice())
    [change] = drag.to(None, {"x": 1.23456})
    assert change.new == 1.23456


def test_the_last_target_is_reached_and_others_are_passed_over() -> None:
    applied: list[float] = []
    go_on = threading.Event()

    def apply(changes: Sequence[Changed]) -> None:
        assert go_on.wait(10.0)
        applied.append(changes[0].new)

    dragger = Dragger(Drag(Message({"x": tracked(0.0)}), Choice()), lambda: None, apply)
    for i in range(1, 101):
        dragger.to({"x": float(i)})
    go_on.set()
    dragger.release(10.0)
    assert applied[-1] == 100.0
    assert len(applied) <= 3


def test_a_refusal_is_reported_and_does_not_end_the_drag() -> None:
    reasons: list[str] = []
    applied: list[float] = []
    heard = threading.Event()

    def apply(changes: Sequence[Changed]) -> None:
        if changes[0].new > 5:
            raise ValueError("too far")
        applied.append(changes[0].new)

    def report(reason: str) -> None:
        reasons.append(reason)
        heard.set()

    drag = Drag(Message({"x": tracked(0.0)}), Choice())
    dragger = Dragger(drag, lambda: None, apply, report)
    dragger.to({"x": 9.0})
    assert heard.wait(10.0)
    dragger.to({"x": 2.0})
    dragger.release(10.0)
    assert reasons == ["too far", ""]
    assert applied == [2.0]
    assert [one.new for one in drag.changed.values()] == [2.0]
