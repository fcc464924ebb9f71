"""Nodes in the many styles that rclpy allows print the same under `run` as without.

Each program in the data folder ends by itself, and prints nothing that depends on time.
"""

from functools import cache

import pytest

from support.domains import reserved_domain
from support.output import normalised
from support.process import DATA, Outcome, finish, start

DRIVEN = ("decorated", "effects", "operations", "other_process", "remarks")
"""Programs of other tests, which need a partner."""

PROGRAMS = sorted(path.stem for path in DATA.glob("*.py") if path.stem not in DRIVEN)


def outcome(program: str, instrumented: bool, check_fields: str | None) -> Outcome:
    with reserved_domain() as domain:
        ended = finish(
            start(
                DATA / f"{program}.py",
                domain=domain,
                instrumented=instrumented,
                ROS_PYTHON_CHECK_FIELDS=check_fields,
            ),
            deadline=60,
        )
    return Outcome(ended.status, normalised(ended.stdout), normalised(ended.stderr))


plain_outcome = cache(outcome)


@pytest.mark.slow
@pytest.mark.parametrize("check_fields", [None, "1"], ids=["fields-unchecked", "fields-checked"])
@pytest.mark.parametrize("program", PROGRAMS)
def test_prints_the_same(program: str, check_fields: str | None) -> None:
    plain = plain_outcome(program, False, check_fields)
    assert plain.stdout
    assert plain.status == (1 if program == "failing_callback" else 0), plain
    assert outcome(program, True, check_fields) == plain
