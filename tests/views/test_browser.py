"""The page of the demo in a real browser, used as a person would: with the mouse.

Needs Chromium (Debian: apt install chromium) and Playwright for Python. Apart from the other tests:
`make test-browser`. WebGL is done in software, which takes its time.
"""

import math
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser")
pytest.importorskip("playwright.sync_api")

import imageio.v3 as imageio
import numpy as np
from geometry_msgs.msg import Pose
from playwright.sync_api import TimeoutError, sync_playwright
from visualization_msgs.msg import Marker

from rosslt_auto.views.browser import CAMERA
from support.observer import Observer, Recording
from support.process import SAMPLES, Program, environment, start
from support.waiting import wait_until

CHROMIUM = shutil.which(os.environ.get("CHROMIUM") or "chromium")

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium"),
]

SHOTS = os.environ.get("SCREENSHOTS")
"""A folder for screenshots, if somebody wants them."""

NODES = ("interactive_script.py", "slt_trajectory.py", "slt_quad.py")
TOPICS = ("/trajectory_marker", "/quad_marker")
PATIENCE = 120.0
ARROW = (2.6, 0.5, 1.5)
"""The arrow along x of the quadcopter at (2, 0.5, 1.5)."""

ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
    "--no-first-run",
]

MISSION = """\
HEIGHT = 1.5


def mission(goto):
    goto(2.0, 0.5, HEIGHT, yaw=0.8)
"""


Place = tuple[float, float, float]


@dataclass
class Page:
    """The page, and what goes on behind it."""

    tab: Any
    mission: Path
    script: Program
    observer: Observer
    target: Recording
    quad: Recording
    curve: Recording

    def shoot(self, name: str) -> None:
        if SHOTS:
            self.tab.screenshot(path=os.path.join(SHOTS, f"{name}.png"), timeout=90_000)

    def pixel(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Where a place is seen, as long as nobody has moved the camera."""
        box = self.tab.locator("canvas").first.bounding_box()
        camera, centre = np.array(CAMERA.position), np.array(CAMERA.look_at)
        ahead = (centre - camera) / np.linalg.norm(centre - camera)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        up = np.cross(right, ahead)
        away = np.array((x, y, z)) - camera
        zoom = box["height"] / 2 / math.tan(CAMERA.field_of_view / 2) / (away @ ahead)
        return (
            box["x"] + box["width"] / 2 + zoom * (away @ right),
            box["y"] + box["height"] / 2 - zoom * (away @ up),
        )

    def drawn(self) -> None:
        """Waits until the page has dealt with what the mouse has done, and has drawn that."""
        self.tab.evaluate(
            "() => new Promise(go => requestAnimationFrame(() => requestAnimationFrame(go)))"
        )

    def hover(self, place: Place) -> None:
        """Until what can be dragged there says so by its colour: a slow page draws late."""
        x, y = self.pixel(*place)
        around = {"x": x - 4, "y": y - 4, "width": 9, "height": 9}

        def is_yellow() -> bool:
            self.tab.mouse.move(x + 60, y + 60)
            self.tab.mouse.move(x, y)
            self.drawn()
            shot = imageio.imread(self.tab.screenshot(clip=around, timeout=PATIENCE * 1000))
            colours = shot[..., :3].astype(int)
            return bool((colours[..., 2] < colours[..., :2].min(axis=-1) - 40).any())

        wait_until(is_yellow, f"something to drag at {place}", PATIENCE)

    def drag(self, start: Place, end: Place, frames: str = "") -> None:
        """With the mouse, from one place to another, without letting go."""
        mouse = self.tab.mouse
        a, b = self.pixel(*start), self.pixel(*end)
        self.hover(start)
        mouse.down()
        for step in range(1, 9):
            mouse.move(*(p + (q - p) * step / 8 for p, q in zip(a, b, strict=True)))
            self.drawn()
            if frames:
                self.shoot(f"{frames}{step}")

    def click(self, place: Place, shows: str) -> None:
        """Until the page shows the text: a slow one may not have drawn what is clicked."""
        text = self.tab.get_by_text(shows).first
        canvas = self.tab.locator("canvas").first

        def clicked() -> bool:
            self.tab.mouse.move(*self.pixel(*place))
            self.drawn()
            if "pointer" not in (canvas.get_attribute("style") or ""):
                return False  # nothing to click is there yet
            self.tab.mouse.down()
            self.tab.mouse.up()
            with suppress(TimeoutError):
                text.wait_for(timeout=3000)
            return text.is_visible()

        wait_until(clicked, f"a click shows {shows!r}", PATIENCE)

    def marker(self, number: int) -> Any:
        """The next message of the curve (0), its control point (1), its end (2)."""
        return self.curve.until(lambda marker: marker.id == number, since=len(self.curve))

    def mark(self, parameter: str, kind: str) -> Any:
        """The value of a literal in the code panel."""
        return self.tab.locator(f'mark.{kind}[title^="rosslt.{parameter} "]').first

    def press(self, button: str) -> None:
        self.tab.get_by_role("button", name=button).last.click()

    def choose(self, what: str, option: str) -> None:
        """An option of a dropdown."""
        self.tab.get_by_label(what).first.click()
        self.tab.get_by_role("option", name=option).first.click()

    def arrive(self, x: float, z: float) -> None:
        """Waits until the quadcopter is there."""

        def there(pose: Pose) -> bool:
            return (pose.position.x, pose.position.y, pose.position.z) == (x, 0.5, z)

        self.quad.until(there, since=len(self.quad), deadline=PATIENCE)


@pytest.fixture
def chromium() -> Iterator[Any]:
    """A browser of its own, too: one that has drawn for long in software becomes slow."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Any, own_domain: int, own_observer: Observer, tmp_path: Path) -> Iterator[Page]:
    """The page when the quadcopter has arrived, with nodes and a mission of its own."""
    folder = tmp_path / "sample_nodes"
    folder.mkdir()
    for name in NODES:
        shutil.copy(SAMPLES / name, folder)
    mission = folder / "mission.py"
    mission.write_text(MISSION)
    target = own_observer.record(Pose, "target_pose")
    quad = own_observer.record(Pose, "quad_pose")
    curve = own_observer.record(Marker, "trajectory_marker")
    with ExitStack() as stack:
        script, *_ = [
            stack.enter_context(start(folder / name, domain=own_domain, instrumented=True))
            for name in NODES
        ]
        command = [sys.executable, "-m", "rosslt_auto", "view", *TOPICS]
        view = stack.enter_context(Program(command, environment(own_domain), cwd=tmp_path))
        [address] = view.stdout.matching("^http://", deadline=60.0)
        tab = _tab(chromium, address)
        stack.callback(tab.close)
        tab.get_by_text("HEIGHT = ").first.wait_for(timeout=60_000)
        page = Page(tab, mission, script, own_observer, target, quad, curve)
        page.arrive(2.0, 1.5)
        yield page


def _tab(browser: Any, address: str) -> Any:
    """A page of its own, without the remark that it is drawn in software."""
    tab = browser.new_page(viewport={"width": 1000, "height": 560})
    tab.set_default_timeout(PATIENCE * 1000)
    tab.goto(address)
    tab.get_by_text("BULGE").first.wait_for()
    tab.add_style_tag(content=".mantine-Notifications-root { display: none }")
    return tab


def _control_point(page: Page) -> Place:
    at = page.marker(1).pose.position
    return at.x, at.y, at.z


def _click_control_point(page: Page) -> None:
    x, y, z = _control_point(page)
    page.click((x - 0.05, y - 0.05, z - 0.05), shows="/trajectory_marker pose.position")


def test_the_page_shows_literals_origins_and_what_cannot_be_shown(page: Page) -> None:
    wait_until(
        lambda: (
            {"1.5", "2.0", "0.5", "0.8", "1.0"} <= set(page.tab.locator("mark").all_inner_texts())
        ),
        "the literals are marked",
        PATIENCE,
    )
    _click_control_point(page)
    page.tab.get_by_text("slt_trajectory.py:").first.wait_for()
    page.shoot("origin")

    publisher = page.observer.publisher(Marker, "trajectory_marker", subscribers=2)
    publisher.publish(Marker(ns="strange", type=77))
    page.tab.get_by_text("unknown marker type 77").first.wait_for()
    publisher.publish(Marker(ns="strange", action=Marker.DELETE))
    wait_until(lambda: not page.tab.get_by_text("type 77").count(), "it is gone", PATIENCE)


def test_a_drag_changes_the_literal_and_all_that_follows_until_it_is_undone(page: Page) -> None:
    page.drag(ARROW, (3.3, 0.5, 1.5), frames="drag")
    live = page.mark("mission.mission.goto", "live")
    live.wait_for()
    page.tab.mouse.up()

    changed = page.mark("mission.mission.goto", "changed")
    changed.wait_for()
    shown = float(changed.inner_text())
    assert 2.4 < shown < 3.0
    for target in page.target.next(10):  # it does not snap back
        assert target.position.x == pytest.approx(shown, rel=1e-5)
        assert (target.position.y, target.position.z) == (0.5, 1.5)
    page.quad.until(lambda pose: pose.position.x == target.position.x)
    assert page.marker(2).pose.position.x == target.position.x
    assert page.mission.read_text() == MISSION
    page.shoot("dragged")

    page.tab.get_by_text("goto(2.0, 0.5, HEIGHT, yaw=0.8)").first.wait_for()  # its origin

    page.press("Undo")
    page.target.until(lambda pose: pose.position.x == 2.0, since=len(page.target))
    wait_until(lambda: not page.tab.locator("mark.changed").count(), "the panel shows it")
    page.arrive(2.0, 1.5)


def _lift_control_point(page: Page) -> None:
    """By its arrow along z."""
    x, y, z = _control_point(page)
    page.drag((x, y, z + 0.35), (x, y, z + 0.8))
    page.tab.mouse.up()


def test_the_source_can_be_chosen(page: Page) -> None:
    _click_control_point(page)
    page.choose("Change", "z: HEIGHT")
    _lift_control_point(page)
    page.mark("mission.HEIGHT", "changed").wait_for()
    assert not page.mark("slt_trajectory.BULGE", "changed").count()
    page.target.until(lambda pose: abs(pose.position.z - 1.5) > 0.05, since=len(page.target))


def test_a_policy_can_be_chosen(page: Page) -> None:
    page.choose("Policy", "least-change")
    _lift_control_point(page)
    page.mark("mission.HEIGHT", "changed").wait_for()
    page.mark("slt_trajectory.BULGE", "changed").wait_for()


def test_points_of_the_curve_can_be_dragged(page: Page) -> None:
    # Elsewhere, so that there is a curve between the points of which nothing else is.
    page.mission.write_text(MISSION.replace("2.0", "-1.0"))
    page.arrive(-1.0, 1.5)
    point = page.marker(0).points[10]
    page.click((point.x, point.y, point.z), shows="points[10]")
    page.drag((point.x, point.y, point.z + 0.35), (point.x, point.y, point.z + 0.7))
    page.tab.mouse.up()
    page.tab.locator("mark.changed").first.wait_for()
    page.shoot("point")
    page.curve.until(lambda line: line.id == 0 and line.points[10] != point, since=len(page.curve))


def test_what_can_be_turned_has_a_ring(page: Page) -> None:
    def on_ring(angle: float) -> Place:
        return 2.0 + 0.468 * math.cos(angle), 0.5 + 0.468 * math.sin(angle), 1.5

    # The ring is a quarter of a circle; its left end, which nothing else is in front of.
    page.drag(on_ring(0.8 + 1.35), on_ring(0.3 + 1.35))
    page.tab.mouse.up()
    changed = page.mark("mission.mission.yaw", "changed")
    changed.wait_for()
    assert float(changed.inner_text()) < 0.7


def test_two_browsers_see_the_same_and_one_may_go_while_it_drags(page: Page) -> None:
    other = Page(**vars(page) | {"tab": _tab(page.tab.context.browser, page.tab.url)})
    other.drag(ARROW, (3.3, 0.5, 1.5))
    page.mark("mission.mission.goto", "live").wait_for()
    other.tab.close()
    page.mark("mission.mission.goto", "changed").wait_for()

    page.press("Undo")
    page.arrive(2.0, 1.5)
    page.drag(ARROW, (3.0, 0.5, 1.5))  # nobody else holds the handle any more
    page.mark("mission.mission.goto", "live").wait_for()


def test_save_shows_the_diff_and_writes_the_file(page: Page) -> None:
    page.drag(ARROW, (3.0, 0.5, 1.5))
    page.tab.mouse.up()
    changed = page.mark("mission.mission.goto", "changed")
    changed.wait_for()
    page.press("Save …")
    page.tab.get_by_text("-    goto(2.0, 0.5, HEIGHT, yaw=0.8)").first.wait_for()
    page.shoot("save")
    assert page.mission.read_text() == MISSION
    page.press("Save")
    page.tab.get_by_text("saved 1 value in mission.py").first.wait_for()
    before, after = MISSION.split("2.0")
    text = page.mission.read_text()
    assert text.startswith(before) and text.endswith(after)
    written = float(text.removeprefix(before).removesuffix(after))
    assert page.target.next()[0].position.x == written > 2.1
    wait_until(lambda: not page.tab.locator("mark.changed").count(), "nothing is left to save")


def test_a_broken_mission_is_shown_and_the_last_good_one_goes_on(page: Page) -> None:
    page.mission.write_text(MISSION + "    goto(1.0, oops, 1.0)\n")
    page.tab.get_by_text("NameError: name 'oops' is not defined").first.wait_for()
    assert page.target.next()[0].position.x == 2.0
    page.shoot("error")
    page.mission.write_text(MISSION.replace("2.0", "1.0"))
    page.target.until(lambda pose: pose.position.x == 1.0, since=len(page.target))
    wait_until(
        lambda: not page.tab.locator(".rosslt .error").count(), "the error is gone", PATIENCE
    )


def test_a_node_may_end_while_one_drags(page: Page) -> None:
    page.drag(ARROW, (3.0, 0.5, 1.5))
    page.script.kill()
    page.tab.mouse.move(*page.pixel(3.3, 0.5, 1.5))
    page.tab.get_by_text("/interactive_script").first.wait_for()
    page.shoot("ended")
    page.tab.mouse.up()
    page.tab.get_by_text("BULGE").first.wait_for()  # the page goes on
