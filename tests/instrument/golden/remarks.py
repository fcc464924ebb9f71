"""What comments say."""

OFFSET = 0.25  # rosslt: off
SPEED = 0.5  # rosslt: 0.0 to 2.0 step 0.1
MASS = 4.0  # rosslt: frozen
WRONG = 4.0  # rosslt: 5 to 6


def plain(x):  # rosslt: off
    return float(x) + 0.5, f"{x} metres"


class Frozen:
    """Nobody changes it.

    rosslt: frozen
    """

    wheels = 4

    def turn(self, angle):
        return angle * 2.0
