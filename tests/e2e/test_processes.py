"""Nodes in processes that an instrumented program starts with `multiprocessing`."""

import pytest
from std_msgs.msg import Float64

from support.observer import Observer
from support.process import DATA, rosslt_auto, start


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_node_in_another_process(method: str, own_observer: Observer) -> None:
    domain = own_observer.domain
    with start(DATA / "other_process.py", method, domain=domain, instrumented=True):
        recording = own_observer.record(Float64, "from_child")
        assert recording.first(1)[0].data == 1.5
        own_observer.wait_for_parameter("/child", "rosslt.other_process.GAIN")
        assert rosslt_auto("force", "/from_child", "data=6.0", domain=domain).status == 0
        recording.until(lambda message: message.data == 6.0)
