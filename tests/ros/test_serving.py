"""Nodes that do not spin answer all the same; nodes that spin answer by themselves."""

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node

from rosslt_auto.ros import changes, declared, parameters, serving
from support.observer import Observer
from support.process import environment
from support.waiting import wait_until
from support.woven import Table, node_in, spinning

ASPECTS = (parameters, declared, changes, serving)


@pytest.fixture
def node(domain: int) -> Iterator[Node]:
    for aspect in ASPECTS:
        aspect.install()
    with node_in(domain) as made:
        yield made
    for aspect in reversed(ASPECTS):
        aspect.uninstall()


@pytest.fixture
def table(node: Node) -> Table:
    made = Table(count=5)
    parameters.own(node, made.location("count"))
    return made


class Applied:
    """In which threads changes have been applied."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.threads: list[str] = []
        plain = parameters.refresh.apply

        def apply(wanted: Any) -> None:
            self.threads.append(threading.current_thread().name)
            plain(wanted)

        monkeypatch.setattr(parameters.refresh, "apply", apply)


@pytest.fixture
def applied(monkeypatch: pytest.MonkeyPatch) -> Applied:
    return Applied(monkeypatch)


def test_a_node_that_does_nothing_is_served(
    node: Node, table: Table, observer: Observer, applied: Applied
) -> None:
    assert table.name("count") in observer.list_parameters("/robot")
    assert observer.get("/robot", table.name("count")) == 5
    [result] = observer.set("/robot", {table.name("count"): 7})
    assert result.successful
    assert table.read("count") == 7
    assert applied.threads == ["rosslt_auto serving"]


def test_a_node_without_locations_is_as_deaf_as_without_us(node: Node, observer: Observer) -> None:
    assert not serving._server.nodes
    assert serving._server.thread is None


def test_a_change_is_applied_where_the_node_publishes(
    node: Node, table: Table, observer: Observer, applied: Applied
) -> None:
    stop = threading.Event()

    def publish_in_a_loop() -> None:
        while not stop.is_set():
            if serving.pending:  # as the publishing aspect does
                serving.run_pending(node)
            time.sleep(0.01)

    thread = threading.Thread(target=publish_in_a_loop, name="the program's")
    thread.start()
    [result] = observer.set("/robot", {table.name("count"): 7})
    stop.set()
    thread.join()
    assert result.successful
    assert applied.threads == ["the program's"]


@pytest.mark.parametrize("executor_class", [SingleThreadedExecutor, MultiThreadedExecutor])
def test_a_spinning_node_answers_by_itself(
    node: Node, table: Table, observer: Observer, applied: Applied, executor_class: Any
) -> None:
    with spinning(node, executor_class(context=node.context)):
        for value in range(6, 16):
            [result] = observer.set("/robot", {table.name("count"): value})
            assert result.successful
            assert table.read("count") == value
    assert "rosslt_auto serving" not in applied.threads


def test_a_node_that_is_spun_now_and_then(node: Node, table: Table, observer: Observer) -> None:
    """Both take turns, and no request gets lost."""
    executor = SingleThreadedExecutor(context=node.context)
    stop = threading.Event()

    def spin_now_and_then() -> None:
        pause = 0.001
        while not stop.is_set():
            executor.add_node(node)
            executor.spin_once(timeout_sec=0.01)
            executor.remove_node(node)
            stop.wait(pause)
            pause = pause * 2 if pause < 0.5 else 0.001

    thread = threading.Thread(target=spin_now_and_then)
    thread.start()
    for value in range(100, 130):
        [result] = observer.set("/robot", {table.name("count"): value})
        assert result.successful
        assert table.read("count") == value
    stop.set()
    thread.join()
    executor.shutdown()


def test_a_long_callback_is_not_interrupted_by_changes(
    node: Node, table: Table, observer: Observer
) -> None:
    inside, seen = threading.Event(), []

    def callback() -> None:
        timer.cancel()
        inside.set()
        end = time.monotonic() + 4 * serving.RECENTLY
        while time.monotonic() < end:
            seen.append(table.read("count"))
            time.sleep(0.01)

    timer = node.create_timer(0.0, callback)
    with spinning(node):
        assert inside.wait(10)
        [result] = observer.set("/robot", {table.name("count"): 7})
        assert result.successful
        assert set(seen) == {5}


def test_a_callback_of_the_program_that_fails(
    node: Node, table: Table, observer: Observer, caplog: pytest.LogCaptureFixture
) -> None:
    def fails(requested: Any) -> Any:
        raise ValueError("mine")

    node.declare_parameter("gain", 1.0)
    node.add_on_set_parameters_callback(fails)
    client = observer._parameters("/robot")
    from rclpy.parameter import Parameter

    client.set_parameters([Parameter("gain", value=2.0).to_parameter_msg()])
    wait_until(lambda: "mine" in caplog.text, "the message")
    # It goes on serving.
    assert observer.set("/robot", {table.name("count"): 7})[0].successful


def test_a_destroyed_node_is_let_go(domain: int, node: Node, table: Table) -> None:
    wait_until(lambda: serving._server.in_wait is not None, "the thread to wait")
    other = Table(x=1.0)
    with node_in(domain, "short_lived") as short:
        parameters.own(short, other.location("x"))
        wait_until(lambda: short in serving._server.nodes, "the node to be served")
    assert short not in serving._server.nodes
    wait_until(lambda: serving._server.in_wait is not None, "the other to be served")


ENDINGS = {
    "falls off its end": "",
    "shuts down": "rclpy.shutdown()",
    "destroys the node and shuts down": "node.destroy_node()\nrclpy.shutdown()",
    "exits": "import sys; sys.exit(3)",
    "raises": "raise ValueError('mine')",
    "interrupts itself": "import os, signal; os.kill(os.getpid(), signal.SIGINT)\n"
    "while rclpy.ok():\n    time.sleep(0.01)",
    "is terminated": "import os, signal; os.kill(os.getpid(), signal.SIGTERM)\n"
    "while rclpy.ok():\n    time.sleep(0.01)",
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_program_ends_as_without_us(ending: str, domain: int, tmp_path: Path) -> None:
    script = tmp_path / "ends.py"
    script.write_text(
        "import time\nimport rclpy\nfrom std_msgs.msg import Float64\nrclpy.init()\n"
        "node = rclpy.create_node('ends')\npublisher = node.create_publisher(Float64, 'x', 1)\n"
        "for i in range(5):\n    publisher.publish(Float64(data=0.5))\n    time.sleep(0.02)\n"
        + ENDINGS[ending]
    )
    outcomes = []
    for run in ([], ["-m", "rosslt_auto", "run"]):
        started = time.monotonic()
        done = subprocess.run(
            [sys.executable, *run, str(script)],
            env=environment(domain), capture_output=True, text=True, timeout=60, check=False,
            cwd=Path(__file__).parents[2],
        )  # fmt: skip
        outcomes.append((done.returncode, done.stdout, done.stderr))
        took = time.monotonic() - started
    assert outcomes[0] == outcomes[1]
    assert took < 20
