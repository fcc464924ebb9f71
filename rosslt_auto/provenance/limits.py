"""The range that a number may have: ``# rosslt: 0.0 to 2.0 step 0.1`` beside a literal.

It means what rcl_interfaces/msg/FloatingPointRange and IntegerRange mean: both ends belong to it,
and with a step only its multiples, counted from the lower end, and the upper end.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

_TOLERANCE = 1e-6  # as rclpy has it for parameters: PARAMETER_REL_TOL


class Limits(NamedTuple):
    """``low`` to ``high``, in steps or (None) not; all of the type of the number."""

    low: float
    high: float
    step: float | None = None

    def __str__(self) -> str:
        steps = "" if self.step is None else f" step {self.step!r}"
        return f"{self.low!r} to {self.high!r}{steps}"

    def allows(self, value: Any) -> bool:
        """Whether a number is one of these."""
        if not self.low <= value <= self.high:
            return False
        return self.step is None or any(
            math.isclose(value, near, rel_tol=_TOLERANCE, abs_tol=_TOLERANCE * self.step)
            for near in self.around(value)
        )

    def clamped(self, value: Any) -> Any:
        """The nearest number between both ends, not minding steps."""
        return min(max(value, self.low), self.high)

    def around(self, value: Any) -> list[Any]:
        """The allowed numbers next to `value`, nearest first."""
        value = self.clamped(value)
        step = self.step or (1 if type(self.low) is int else None)
        if step is None:
            return [value]
        count = math.floor((value - self.low) / step)
        near = {self.clamped(_short(self.low + n * step)) for n in (count, count + 1)}
        return sorted(near, key=lambda one: abs(one - value))


def _short(value: Any) -> Any:
    """0.30000000000000004, the third step of 0.1, is 0.3 for people."""
    return float(f"{value:.12g}") if type(value) is float else value
