"""The paper's operations as a program uses them, on another process' messages."""

from pathlib import Path

from support.process import SAMPLES, finish, start

PROGRAM = Path(__file__).parent / "data" / "operations.py"


def test_force_value_and_reevaluate(domain: int) -> None:
    with start(SAMPLES / "talker.py", domain=domain, instrumented=True) as talker:
        outcome = finish(start(PROGRAM, domain=domain, instrumented=True))
        talker.stop()
    assert outcome.status == 0, outcome
    assert outcome.stdout.splitlines() == [
        "expression 2 * count True",
        "changed [('/talker', 'rosslt.talker.Talker.init.count', 5, 7)]",
        "shown 14",
        "reevaluated 10 14 14",
        "changed again [10]",
        "location rosslt.operations.gain 5.0",
        "refused FieldError",
    ]
