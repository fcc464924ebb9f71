"""The README's pictures from the browser test's screenshots.

    make test-browser SCREENSHOTS=shots
    python tests/tools/make_pictures.py shots docs

needs Pillow, which viser brings along.
"""

import sys
from pathlib import Path

from PIL import Image

FRAMES = [*(f"drag{step}" for step in range(1, 9)), "dragged"]
MILLISECONDS = [900, *(250 for _ in range(6)), 900, 1800]
COLOURS = 128
WIDTH = 800


def reduced(path: Path, width: int | None = None) -> Image.Image:
    """A picture with few colours, which makes it small."""
    with Image.open(path) as file:
        picture = file.convert("RGB")
    if width is not None:
        size = (width, round(picture.height * width / picture.width))
        picture = picture.resize(size, Image.Resampling.LANCZOS)
    return picture.quantize(COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)


def main(shots: Path, target: Path) -> None:
    """Writes the screenshot and the animation, and says how large they are."""
    target.mkdir(exist_ok=True)
    still = target / "page.png"
    reduced(shots / "origin.png").save(still, optimize=True)
    moving = target / "drag.gif"
    first, *others = [reduced(shots / f"{name}.png", WIDTH) for name in FRAMES]
    first.save(
        moving, save_all=True, append_images=others, duration=MILLISECONDS, loop=0, optimize=True
    )
    for path in (still, moving):
        print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
