"""Where what is selected comes from, and the choice of source, as the page's controls show them."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("viser")

from geometry_msgs.msg import Pose
from visualization_msgs.msg import Marker

from rosslt_auto.provenance import Source
from rosslt_auto.views.dragging import Choices
from rosslt_auto.views.handles import Handles
from rosslt_auto.views.listing import Listing
from rosslt_auto.views.origin import Origin, named
from rosslt_auto.views.scene import Item, Scene
from rosslt_auto.views.shapes import MARKER
from support.tracked import tracked


@dataclass
class Message:
    message: Any
    fields: dict[str, Any] = field(default_factory=dict)


class Control:
    """What viser gives for a control: new options set its value back, and tell so."""

    def __init__(self, options: tuple[str, ...] = (), value: str = "") -> None:
        self._options = options
        self.value = value
        self.visible = True
        self.content = ""
        self.callback: Any = lambda event: None

    @property
    def options(self) -> tuple[str, ...]:
        return self._options

    @options.setter
    def options(self, options: tuple[str, ...]) -> None:
        self._options, self.value = options, options[0]
        self.callback(SimpleNamespace(client=None))

    def on_update(self, callback: Any) -> None:
        self.callback = callback

    def choose(self, value: str) -> None:
        """As somebody in a browser."""
        assert value in self._options
        self.value = value
        self.callback(SimpleNamespace(client="somebody"))


class Page:
    """Two markers, both a + b high, and the controls."""

    def __init__(self) -> None:
        self.scene = Scene()
        self.choices = Choices()
        self.listing = Listing()
        for number in (1, 2):
            value = tracked(1.0, "a") + tracked(2.0, "b")
            marker = Marker(ns="m", id=number, type=Marker.CUBE)
            marker.pose.position.z = 3.0
            self.scene.receive("/t", MARKER, Message(marker, {"pose.position.z": value}))
        self.controls: dict[str, Control] = {}
        self.html = Control()
        self.origin = Origin(self, self)  # type: ignore[arg-type]

    def add_dropdown(
        self, label: str, options: tuple[str, ...], initial_value: str = "", visible: bool = True
    ) -> Control:
        self.controls[label] = Control(options, initial_value or options[0])
        return self.controls[label]

    def add_html(self, content: str) -> Control:
        return self.html

    def note_sources(self, item: Item, paths: Any) -> None:
        pass

    def select(self, number: int) -> Control:
        """The choice that is offered for a marker."""
        item = self.scene.get(f"/t/m/{number}")
        assert item is not None
        [handle] = Handles().of(item)
        self.origin.draw(handle.key, handle)
        return self.controls["Change"]

    def chosen(self, number: int) -> list[str]:
        item = self.scene.get(f"/t/m/{number}")
        assert item is not None
        return [source.parameter for source in self.choices.of(item).sources.values()]


@pytest.fixture
def page() -> Page:
    return Page()


def test_a_source_is_chosen_for_what_is_selected_only(page: Page) -> None:
    change = page.select(1)
    assert change.options == ("automatic", "z: a (/node)", "z: b (/node)")
    change.choose("z: b (/node)")
    assert page.chosen(1) == ["b"]
    assert page.select(2).value == "automatic"
    assert page.chosen(2) == []
    assert page.select(1).value == "z: b (/node)"
    change.choose("automatic")
    assert page.chosen(1) == []


def test_what_a_drag_will_change_is_marked(page: Page) -> None:
    def marked(number: int) -> str:
        page.select(number)
        [row] = [row for row in page.html.content.split("<tr ") if row.startswith("class=will")]
        return "a" if ">a<br>" in row else "b"

    assert (marked(1), marked(2)) == ("a", "a")
    page.select(1).choose("z: b (/node)")
    assert (marked(1), marked(2)) == ("b", "a")


def test_a_policy_is_chosen_for_all(page: Page) -> None:
    page.controls["Policy"].choose("least-change")
    assert page.choices.policy == "least-change"


def test_what_has_no_handle_is_shown_without_a_choice(page: Page) -> None:
    page.scene.receive("/pose", "geometry_msgs/msg/Pose", Message(Pose()))
    page.origin.draw("/pose", None)
    assert "/pose  : no provenance" in page.html.content
    assert not page.controls["Change"].visible
    page.origin.draw("/gone", None)
    assert "Click something" in page.html.content


def test_names_tell_sources_apart() -> None:
    one, other = (Source("/n", f"rosslt.{part}.speed", "float") for part in ("a", "b"))
    third = Source("/n", "rosslt.c.yaw", "float")
    options = [
        ("pose.position.x", one),
        ("pose.position.x", other),
        ("pose.position.z", third),
        ("pose.orientation.z", third),
    ]
    assert named(options) == {
        "x: speed (/n) rosslt.a.speed": [options[0]],
        "x: speed (/n) rosslt.b.speed": [options[1]],
        "z: yaw (/n)": [options[2]],
        "orientation.z: yaw (/n)": [options[3]],
    }
