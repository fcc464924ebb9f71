"""The output of programs without what differs between any two runs."""

import re

# A frame is the line with the place, then the source line and the marks below it.
_OUR_FRAMES = re.compile(r'  File "[^"]*/(?:rosslt_auto|wrapt)/[^"]*", line .*\n(?:    .*\n?)*')
_TIME = re.compile(r"\[\d{9,}\.\d+\]|\b\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d+")
_ADDRESS = re.compile(r"0x[0-9a-f]{6,}")


def normalised(text: str) -> str:
    """Without times, addresses of objects, and our frames in tracebacks.

    That rclpy's callbacks pass through us may be seen there, and nowhere else.
    """
    return _ADDRESS.sub("0x...", _TIME.sub("[time]", _OUR_FRAMES.sub("", text)))
