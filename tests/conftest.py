"""Fixtures of all tests."""

import inspect
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

from support.domains import reserved_domain
from support.process import NETWORK

if TYPE_CHECKING:  # imported where it is needed: most tests do without ROS
    from support.observer import Observer

os.environ.update(NETWORK)  # for the observer in this process too
# A sourced ROS or a run under `ros2 launch` may have set these; the tests say when they want them.
for _name in ("ROS_PYTHON_CHECK_FIELDS", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY", "ROS_NAMESPACE"):
    os.environ.pop(_name, None)


# How long an example takes says more of the machine than of what is tested; and a change should
# fail for what it does and not for new examples: those are for --hypothesis-profile=explore.
_SETTINGS = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.register_profile("explore", _SETTINGS)
settings.register_profile("same for all", _SETTINGS, derandomize=True)
settings.load_profile("same for all")

NETWORKED = ("cli", "e2e", "ros", "views")
"""Folders whose tests find each other over DDS, in time that a busy machine may not give them."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="take what the rewriter makes as expected"
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A networked test that fails is tried again, twice at most; the report marks it with R."""
    here = Path(__file__).parent
    for item in items:
        if item.path.relative_to(here).parts[0] in NETWORKED:
            item.add_marker(pytest.mark.flaky(reruns=2))


@pytest.fixture(scope="session", autouse=True)
def _ros_logs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Log files of the nodes go where pytest cleans up."""
    folder = tmp_path_factory.mktemp("ros_logs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOG_DIR", str(folder))
        yield folder


@pytest.fixture(scope="module", autouse=True)
def _nothing_stays_woven() -> Iterator[None]:
    """Advice that the tests of a module leave in rclpy would meet those of other modules."""
    yield
    from rosslt_auto.ros import weave

    assert not weave.is_prepared(), "rclpy is still waited for"
    node = sys.modules.get("rclpy.node")
    if node is not None:
        made = [name for name in vars(node.Node) if name.startswith("create_")]
        woven = [name for name in made if not inspect.isfunction(vars(node.Node)[name])]
        assert not woven, f"still woven: {woven}"


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    """A ROS domain for the tests of a module that share their processes."""
    with reserved_domain() as number:
        yield number


@pytest.fixture(scope="module")
def observer(domain: int) -> Iterator["Observer"]:
    """An uninstrumented node in the module's domain."""
    from support.observer import Observer

    with Observer(domain) as node:
        yield node


@pytest.fixture
def own_domain() -> Iterator[int]:
    """A ROS domain for one test alone."""
    with reserved_domain() as number:
        yield number


@pytest.fixture
def own_observer(own_domain: int) -> Iterator["Observer"]:
    """An uninstrumented node in the test's own domain."""
    from support.observer import Observer

    with Observer(own_domain) as node:
        yield node
