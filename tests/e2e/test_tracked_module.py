"""`@tracked_module` on a node in a program that plain python runs."""

import pytest
from std_msgs.msg import Float64

from support.observer import Observer
from support.process import DATA, rosslt_auto, start

GAIN = "rosslt.decorated.Pacer.gain"
OFFSET = "rosslt.decorated.Pacer.init.offset"


@pytest.mark.slow
@pytest.mark.parametrize("instrumented", [False, True], ids=["plain python", "under run"])
def test_a_decorated_node(own_observer: Observer, instrumented: bool) -> None:
    domain = own_observer.domain
    given = ("--ros-args", "-p", f"{OFFSET}:=1.5")
    node = start(DATA / "decorated.py", *given, domain=domain, instrumented=instrumented)
    with node:
        pace = own_observer.record(Float64, "pace")
        assert pace.first(1)[0].data == 3.5

        echo = rosslt_auto("echo", "/pace", "--once", "--json", domain=domain)
        field = echo.json["fields"]["data"]
        assert field["expression"] == "gain * 4.0 + offset"
        gain, *_ = field["sources"]
        assert (gain["parameter"], gain["node"], gain["line"]) == (GAIN, "/pacer", 12)
        assert {OFFSET, "rosslt.decorated.Pacer.on_timer.data"} <= {
            source["parameter"] for source in field["sources"]
        }

        force = rosslt_auto("force", "/pace", "data=9.5", "--json", domain=domain)
        assert force.json["reached"] is True, force
        assert force.json["changes"] == [
            {"node": "/pacer", "parameter": GAIN, "old": 0.5, "new": 2.0}
        ]
        assert {message.data for message in pace.next(2)} == {9.5}
        # What is not decorated is tracked under `run` only.
        echo = rosslt_auto("echo", "/plain", "--once", "--json", domain=domain)
        assert bool(echo.json["fields"]) == instrumented
    assert "Traceback" not in str(node)
