"""A round trip for the quadcopter. Edit it while it flies."""

HEIGHT = 1.5
SIDE = 3.0


def mission(goto):
    goto(2.0, 0.5, HEIGHT, yaw=0.8)
    for i in range(2):
        goto(SIDE - 1.5 * i, 2.0 + i, 2.0)
    goto(-2.0, 1.0, 1.0, yaw=-0.6)
    goto(0.0, 0.0, HEIGHT)
