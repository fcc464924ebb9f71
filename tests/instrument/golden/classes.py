"""Class bodies, methods that have to give exact types, and names that repeat."""

from dataclasses import dataclass, field


@dataclass(order=True)
class Wheel:
    radius: float = 0.1
    teeth: int = field(default=12)
    __slots__ = ("radius", "teeth")

    @property
    def width(self):
        return self.radius * 2

    @width.setter
    def width(self, value):
        self.radius = value / 2

    def __int__(self):
        return self.teeth + 1

    class Tyre:
        pressure = 2.5

    async def roll(self):
        await self.move(1.0, speed=0.5)
        await self.move(2.0, speed=0.7)
