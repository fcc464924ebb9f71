"""Waiting for what has to happen, with a deadline."""

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

# Seconds within which anything that has to happen happens, on a slow machine under load too.
DEADLINE = 30.0


class DeadlineMissed(AssertionError):
    """What was waited for did not happen in time."""


def wait_until(
    condition: Callable[[], T], what: str, deadline: float = DEADLINE, interval: float = 0.01
) -> T:
    """The first true result of `condition`, which is asked every `interval` seconds.

    For what has no event to wait for, such as the ROS graph as another process sees it.
    """
    end = time.monotonic() + deadline
    while not (result := condition()):
        if time.monotonic() > end:
            raise DeadlineMissed(f"not within {deadline} s: {what}")
        time.sleep(interval)
    return result
