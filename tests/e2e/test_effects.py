"""Where the change of a literal takes effect: table 3.2 of the design, line by line."""

import itertools
import math
from collections.abc import Callable, Iterator

import pytest
from geometry_msgs.msg import Inertia, PointStamped, Pose

from support.locations import literal_parameter
from support.observer import Observer, Recording
from support.process import DATA, SAMPLES, rosslt_auto, start

EFFECTS = DATA / "effects.py"
SWEEPER = SAMPLES / "sweeper.py"
BEACON = SAMPLES / "beacon.py"


@pytest.fixture(scope="module")
def effects(domain: int, observer: Observer) -> Iterator[Recording]:
    with start(EFFECTS, domain=domain, instrumented=True) as program:
        recording = observer.record(Inertia, "effects")
        recording.first(2)
        yield recording
        assert program.running, program


@pytest.mark.parametrize(
    ("source", "first", "field"),
    [
        ("ixy = 6.0", 6.0, lambda message: message.ixy),
        ("MODULE = 1.0", 1.0, lambda message: message.m),
        ("MODULE = 1.0", 1.0, lambda message: message.iyy / 10.0),
        ("class_attribute = 2.0", 2.0, lambda message: message.com.x),
        ("self.attribute = 3.0", 3.0, lambda message: message.com.y),
        ("enclosed = 4.0", 4.0, lambda message: message.com.z),
        ("argument=5.0", 5.0, lambda message: message.ixx),
        ('"nested": [7.0]', 7.0, lambda message: message.ixz),
    ],
    ids=[
        "executed again and again",
        "module constant",
        "module constant computed from another",
        "class attribute",
        "attribute set in __init__",
        "closure variable",
        "default argument",
        "element of a container",
    ],
)
def test_change_is_seen(
    effects: Recording,
    observer: Observer,
    source: str,
    first: float,
    field: Callable[[Inertia], float],
) -> None:
    parameter = literal_parameter(observer, "/effects", EFFECTS, source)
    assert field(effects.next()[0]) == first
    for value in (128.0, first):  # and back
        [result] = observer.set("/effects", {parameter: value})
        assert result.successful, result.reason
        # At the latest in the second message: one may have been under way.
        assert field(effects.next(2)[-1]) == value


def test_declared_parameter_that_was_read_once_is_live(
    effects: Recording, observer: Observer
) -> None:
    for value in (90.0, 9.0):
        [result] = observer.set("/effects", {"gain": value})
        assert result.successful, result.reason
        assert effects.next(2)[-1].iyz == value


def test_declared_parameter_is_a_source_without_a_file(
    effects: Recording, observer: Observer
) -> None:
    outcome = rosslt_auto("echo", "/effects", "--once", "--json", domain=observer.domain)
    [source] = outcome.json["fields"]["iyz"]["sources"]
    assert source["node"] == "/effects"
    assert source["parameter"] == "gain"
    assert source["value"] == 9.0
    assert source.get("file") is None


def test_accumulated_state_keeps_what_was_added(effects: Recording, observer: Observer) -> None:
    step = literal_parameter(observer, "/effects", EFFECTS, "self.total += 0.5")
    before = effects.next()[0].izz
    since = len(effects)
    observer.set("/effects", {step: 0.25})
    effects.next(6)
    totals = [before, *(message.izz for message in effects.messages[since:])]
    steps = [later - earlier for earlier, later in itertools.pairwise(totals)]
    # All steps are the old one, then all are the new one: no jump. (All exact in binary.)
    changed = steps.index(0.25)
    assert set(steps[:changed]) <= {0.5}
    assert set(steps[changed:]) == {0.25}
    assert len(steps) - changed >= 4

    start_value = literal_parameter(observer, "/effects", EFFECTS, "self.total = 0.0")
    since = len(effects)
    observer.set("/effects", {start_value: 1000.0})
    effects.next(6)
    totals = [message.izz for message in effects.messages[since:]]
    steps = [later - earlier for earlier, later in itertools.pairwise(totals)]
    # The state is shifted once.
    assert steps.count(1000.25) <= 1
    assert set(steps) <= {0.25, 1000.25}
    assert totals[-1] > 1000.0
    observer.set("/effects", {start_value: 0.0, step: 0.5})


def test_sweeper_with_another_radius_and_another_step(own_observer: Observer) -> None:
    with start(SWEEPER, domain=own_observer.domain, instrumented=True):
        poses = own_observer.record(Pose, "sweep")
        radius = literal_parameter(own_observer, "/sweeper", SWEEPER, "RADIUS = 2.0")
        step = literal_parameter(own_observer, "/sweeper", SWEEPER, "STEP = 0.05")
        pose = poses.next()[0].position
        assert math.hypot(pose.x, pose.y) == pytest.approx(2.0)

        own_observer.set("/sweeper", {radius: 3.0})
        pose = poses.next(2)[-1].position
        assert math.hypot(pose.x, pose.y) == pytest.approx(3.0)

        own_observer.set("/sweeper", {step: 0.125})
        poses.next(2)
        angles = [pose.position.z * math.tau for pose in poses.next(5)]
        steps = [later - earlier for earlier, later in itertools.pairwise(angles)]
        assert steps == pytest.approx([0.125] * 4)


def test_node_that_never_spins(own_observer: Observer) -> None:
    domain = own_observer.domain
    with start(BEACON, domain=domain, instrumented=True) as beacon:
        points = own_observer.record(PointStamped, "beacon")
        points.first(2)

        # Executed again and again.
        outcome = rosslt_auto("force", "/beacon", "point.x=4.5", "--json", domain=domain)
        assert outcome.status == 0, outcome
        x = literal_parameter(own_observer, "/beacon", BEACON, "point.x = 3.0")
        assert outcome.json["changes"] == [
            {"node": "/beacon", "parameter": x, "old": 3.0, "new": 4.5}
        ]
        assert points.next(2)[-1].point.x == 4.5

        # A negative literal is one location, sign and all.
        outcome = rosslt_auto("force", "/beacon", "point.y=7.0", "--json", domain=domain)
        y = literal_parameter(own_observer, "/beacon", BEACON, "point.y = -2.0")
        assert outcome.json["changes"] == [
            {"node": "/beacon", "parameter": y, "old": -2.0, "new": 7.0}
        ]

        # A local of main(), executed once before the loop.
        outcome = rosslt_auto("force", "/beacon", "point.z=3.0", "--json", domain=domain)
        assert outcome.json["changes"] == [
            {"node": "/beacon", "parameter": "rosslt.beacon.main.height", "old": 1.5, "new": 2.75}
        ]
        assert points.next(2)[-1].point.z == 3.0

        # And from any parameter client.
        [result] = own_observer.set("/beacon", {x: 1.25})
        assert result.successful, result.reason
        assert points.next(3)[-1].point.x == 1.25
        assert beacon.running
        assert beacon.stop() == 0
        assert "Traceback" not in str(beacon)
