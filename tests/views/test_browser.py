"""The page of the demo in a real browser, used as a person would: with the mouse.

Needs Chromium (Debian: apt install chromium) and Playwright for Python. Apart from the other tests:
`make test-browser`. WebGL is done in software, which takes its time.
"""

import math
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser")
pytest.importorskip("playwright.sync_api")

import numpy as np
from geometry_msgs.msg import Pose
from playwright.sync_api import sync_playwright

from support.domains import reserved_domain
from support.observer import Observer, Recording
from support.process import SAMPLES, Program, environment, start
from support.waiting import wait_until

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or "/usr/bin/chromium"

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not os.path.exists(CHROMIUM), reason="there is no Chromium"),
]

SHOTS = os.environ.get("SCREENSHOTS")
"""A folder for screenshots, if somebody wants them."""

NODES = ("interactive_script.py", "slt_trajectory.py", "slt_quad.py")
TOPICS = ("/trajectory_marker", "/quad_marker")
PATIENCE = 120.0

ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]

MISSION = """\
HEIGHT = 1.5


def mission(goto):
    goto(2.0, 0.5, HEIGHT, yaw=0.8)
"""


@dataclass
class Page:
    """The page, and what goes on behind it."""

    tab: Any
    mission: Path
    target: Recording
    quad: Recording

    def shoot(self, name: str) -> None:
        if SHOTS:
            self.tab.screenshot(path=os.path.join(SHOTS, f"{name}.png"), timeout=90_000)

    def pixel(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Where a place is seen, as long as nobody has moved the camera (see `browser`)."""
        box = self.tab.locator("canvas").first.bounding_box()
        camera, centre = np.array((3.5, -4.5, 4.0)), np.array((0.5, 1.0, 1.0))
        ahead = (centre - camera) / np.linalg.norm(centre - camera)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        up = np.cross(right, ahead)
        away = np.array((x, y, z)) - camera
        zoom = box["height"] / 2 / math.tan(math.radians(75.0) / 2) / (away @ ahead)
        return (
            box["x"] + box["width"] / 2 + zoom * (away @ right),
            box["y"] + box["height"] / 2 - zoom * (away @ up),
        )

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """With the mouse, without letting go."""
        mouse = self.tab.mouse
        mouse.move(*start)
        self.tab.wait_for_timeout(500)
        mouse.down()
        for step in range(1, 9):
            mouse.move(*(a + (b - a) * step / 8 for a, b in zip(start, end, strict=True)))
            self.tab.wait_for_timeout(100)

    def mark(self, parameter: str, kind: str) -> Any:
        """The value of a literal in the code panel."""
        return self.tab.locator(f'mark.{kind}[title^="rosslt.{parameter} "]').first


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    folder = tmp_path_factory.mktemp("nodes")
    for name in NODES:
        shutil.copy(SAMPLES / name, folder)
    mission = folder / "mission.py"
    mission.write_text(MISSION)
    with ExitStack() as stack:
        domain = stack.enter_context(reserved_domain())
        for name in NODES:
            stack.enter_context(start(folder / name, domain=domain, instrumented=True))
        command = [sys.executable, "-m", "rosslt_auto", "view", *TOPICS]
        view = stack.enter_context(Program(command, environment(domain)))
        observer = stack.enter_context(Observer(domain))
        target, quad = observer.record(Pose, "target_pose"), observer.record(Pose, "quad_pose")
        [address] = view.stdout.matching("^http://", deadline=60.0)
        playwright = stack.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        stack.callback(browser.close)
        tab = browser.new_page(viewport={"width": 1000, "height": 560})
        tab.set_default_timeout(PATIENCE * 1000)
        tab.goto(address)
        tab.get_by_text("BULGE").first.wait_for()
        quad.until(lambda pose: pose.position.x == 2.0, deadline=PATIENCE)
        tab.wait_for_timeout(3000)  # drawn, in software, with nothing to ask whether it is
        yield Page(tab, mission, target, quad)


def test_the_page_shows_the_code_with_its_literals(page: Page) -> None:
    marked = page.tab.locator("mark").all_inner_texts()
    assert {"1.5", "2.0", "0.5", "0.8", "1.0"} <= set(marked)
    page.shoot("scene")


def test_a_drag_changes_the_literal_and_all_that_follows_from_it(page: Page) -> None:
    # The arrow along x of the quadcopter at (2, 0.5, 1.5).
    page.drag(page.pixel(2.6, 0.5, 1.5), page.pixel(3.3, 0.5, 1.5))
    live = page.mark("mission.mission.goto", "live")
    live.wait_for()
    page.shoot("drag")
    page.tab.mouse.up()

    changed = page.mark("mission.mission.goto", "changed")
    changed.wait_for()
    shown = float(changed.inner_text())
    assert 2.4 < shown < 3.0
    [target] = page.target.next()
    assert target.position.x == pytest.approx(shown, rel=1e-5)
    assert (target.position.y, target.position.z) == (0.5, 1.5)
    page.quad.until(lambda pose: pose.position.x == target.position.x)
    assert page.mission.read_text() == MISSION
    page.shoot("dragged")

    page.tab.get_by_text("goto(2.0, 0.5, HEIGHT, yaw=0.8)").first.wait_for()  # its origin


def test_undo_takes_it_back(page: Page) -> None:
    page.tab.get_by_role("button", name="Undo").click()
    page.target.until(lambda pose: pose.position.x == 2.0, since=len(page.target))
    wait_until(lambda: not page.tab.locator("mark.changed").count(), "the panel shows it")


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
