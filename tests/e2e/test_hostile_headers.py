"""Headers that nobody of ours has sent: the node goes on, its messages get through, one warning."""

import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Int32, UInt8MultiArray

from support.observer import Observer, Recording
from support.process import SAMPLES, rosslt_auto, start


def real_header(observer: Observer) -> bytes:
    headers = observer.record(UInt8MultiArray, "foo/_provenance")
    return bytes(headers.first(1)[0].data)


def send(observer: Observer, headers: list[bytes], numbers: Recording) -> None:
    publisher = observer.publisher(UInt8MultiArray, "foo/_provenance")
    for header in headers:
        publisher.publish(UInt8MultiArray(data=header))
        numbers.next()  # messages come in between
    observer.destroy(publisher)


def broken(header: bytes) -> dict[str, list[bytes]]:
    return {
        "empty": [b""],
        "unknown version": [b"\xff" + header[1:], b"\x00" + header[1:]],
        "truncated": [header[:length] for length in range(1, len(header), len(header) // 8 or 1)],
        "bit flipped": [
            header[:at] + bytes([header[at] ^ 0x55]) + header[at + 1 :]
            for at in range(1, len(header), len(header) // 12 or 1)
        ],
        "noise": [bytes(range(256)) * 4, b"\xc1" * 64, b"\xdd\xff\xff\xff\xff"],
        "nested": [header[:1] + b"\x91" * 5000],
    }


@pytest.mark.slow
def test_broken_headers(own_observer: Observer) -> None:
    domain = own_observer.domain
    with (
        start(SAMPLES / "talker.py", domain=domain, instrumented=True),
        start(SAMPLES / "scaler.py", domain=domain, instrumented=True) as scaler,
    ):
        numbers = own_observer.record(Int32, "foo")
        scaled = own_observer.record(Twist, "scaled")
        scaled.first(2)
        for name, headers in broken(real_header(own_observer)).items():
            before = len(scaled)
            send(own_observer, headers, numbers)
            assert scaler.running, f"{name}: {scaler}"
            scaled.first(before + len(headers) - 1)
            assert {message.linear.x for message in scaled.messages} == {3.5}, name
        assert "Traceback" not in str(scaler)
        warnings = [line for line in scaler.stderr.all if "header" in line or "provenance" in line]
        assert 1 <= len(warnings) <= 2, scaler  # one for the version, one for what is malformed

        # The real ones are still understood, by the scaler and by everybody.
        outcome = rosslt_auto("force", "/scaled", "linear.x=6.0", "--json", domain=domain)
        assert outcome.status == 0, outcome
        assert outcome.json["changes"][0]["node"] == "/talker"
