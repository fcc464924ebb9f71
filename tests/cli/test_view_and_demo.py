"""The verbs `view`, `markers` and `demo` from outside: what they print, how they end."""

import re
import shutil
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.process import ROOT, SAMPLES, Program, environment, rosslt_auto
from support.waiting import wait_until

NODES = ("interactive_script.py", "slt_trajectory.py", "slt_quad.py")

needs_viser = pytest.mark.skipif(
    subprocess.run([sys.executable, "-c", "import viser"], capture_output=True).returncode != 0,
    reason="viser is not installed",
)


def program(*arguments: str, domain: int) -> Program:
    return Program([sys.executable, "-m", "rosslt_auto", *arguments], environment(domain))


@pytest.fixture
def taken_port() -> Iterator[int]:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        yield taken.getsockname()[1]


@needs_viser
def test_a_port_in_use_is_said(own_domain: int, taken_port: int) -> None:
    outcome = rosslt_auto("view", "--port", str(taken_port), domain=own_domain)
    outcome.assert_clean_failure(1, says=f"127.0.0.1:{taken_port}.*in use")


@pytest.mark.parametrize(
    "arguments",
    [
        ("view", "--port", "nonsense"),
        ("view", "--port", "0"),
        ("demo", "--port", "99999"),
        ("markers", "--nonsense"),
    ],
)
def test_wrong_usage(own_domain: int, arguments: tuple[str, ...]) -> None:
    rosslt_auto(*arguments, domain=own_domain).assert_clean_failure(2)


@pytest.mark.parametrize(
    "arguments", [("view", "a topic"), ("markers", "//x"), ("markers", "--namespace", "1")]
)
def test_names_that_are_none(own_domain: int, arguments: tuple[str, ...]) -> None:
    rosslt_auto(*arguments, domain=own_domain).assert_clean_failure(1, says="no topic name")


def test_without_viser_one_line_says_how_to_get_it(own_domain: int) -> None:
    hidden = "import sys; sys.modules['viser'] = None; from rosslt_auto.cli import main; "
    for verb in ("view", "demo"):
        ended = subprocess.run(
            [sys.executable, "-c", f"{hidden}sys.exit(main(['{verb}']))"],
            env=environment(own_domain), cwd=ROOT, capture_output=True, text=True,
        )  # fmt: skip
        assert ended.returncode == 1
        assert "rosslt_auto[view]" in ended.stderr
        assert len(ended.stderr.splitlines()) == 1, ended.stderr


@needs_viser
@pytest.mark.slow
def test_view_serves_a_page_on_this_machine_only(own_domain: int) -> None:
    with program("view", domain=own_domain) as view:
        [address] = view.stdout.matching(r"^http://127\.0\.0\.1:\d+$")
        with urllib.request.urlopen(address) as answer:
            assert b"<html" in answer.read()
        assert view.stop() == 130
        assert view.stdout.all == [address]
        assert "Traceback" not in str(view)


@needs_viser
@pytest.mark.slow
@pytest.mark.parametrize("how", ["interrupt", "terminate"])
def test_the_demo_comes_up_and_ends_everything(own_domain: int, how: str) -> None:
    with program("demo", "--no-browser", domain=own_domain) as demo:
        [address] = demo.stdout.matching(r"^http://", deadline=60.0)
        with urllib.request.urlopen(address) as answer:
            assert b"<html" in answer.read()
        assert len(_nodes(own_domain)) == len(NODES)
        demo.stderr.matching(r"changes \S+ to \S+ in mission.py:\d+")
        demo.stderr.matching(r"has followed; undone")
        getattr(demo, how)()
        getattr(demo, how)()  # as from a terminal, or make, or timeout, and once more
        assert demo.wait() == 0
        assert demo.stdout.all == [address]
        assert "Traceback" not in "".join(demo.stderr.all), str(demo)
    wait_until(lambda: not _nodes(own_domain), "the nodes have ended too")


@needs_viser
@pytest.mark.slow
def test_a_node_that_ends_ends_the_demo_and_its_last_words_are_seen(
    own_domain: int, tmp_path: Path
) -> None:
    for name in (*NODES, "mission.py"):
        shutil.copy(SAMPLES / name, tmp_path)
    quad = tmp_path / "slt_quad.py"
    quad.write_text(quad.read_text().replace("DELAY = 10", "DELAY = 10 / 0"))
    code = (
        "import sys; from pathlib import Path; from rosslt_auto.cli import demo, main; "
        f"demo.sample_nodes = lambda: Path({str(tmp_path)!r}); sys.exit(main(['demo']))"
    )
    with Program([sys.executable, "-c", code], environment(own_domain)) as demo:
        assert demo.wait() == 1
        assert any("ZeroDivisionError" in line for line in demo.stderr.all), str(demo)
        assert "slt_quad.py has ended with status 1" in demo.stderr.all[-1]
    assert not _nodes(own_domain)


@needs_viser
@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("setpriv"), reason="setpriv is not installed")
def test_a_demo_that_is_killed_takes_its_nodes_with_it(own_domain: int) -> None:
    with program("demo", domain=own_domain) as demo:
        wait_until(lambda: len(_nodes(own_domain)) == len(NODES), "the nodes have started")
        demo.kill()
    wait_until(lambda: not _nodes(own_domain), "the nodes have ended too")


def _nodes(domain: int) -> list[str]:
    """Command lines of the demo's nodes in this domain."""
    found = subprocess.run(["ps", "eww", "-eo", "args"], capture_output=True, text=True).stdout
    return [
        line
        for line in found.splitlines()
        if re.search(rf"ROS_DOMAIN_ID={domain}\b", line)
        and any(f"/{name}" in line for name in NODES)
    ]
