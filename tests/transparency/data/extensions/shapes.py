"""Geometry with Shapely (ufuncs in C) and pictures with Pillow (C)."""

from PIL import Image, ImageDraw, ImageFilter
from shapely import affinity
from shapely.geometry import LineString, Point, Polygon, box

SIZE = 0.5
COUNT = 3
NAME = "front"

area = Polygon([(0, 0), (COUNT, 0), (COUNT, COUNT), (0, SIZE)])
print(area.area, Point(SIZE, COUNT).buffer(SIZE).area, area.contains(Point(1, SIZE)))
print(LineString([(0, 0), (SIZE, COUNT)]).length, affinity.rotate(area, 90 * SIZE).bounds)
print(
    box(0, 0, SIZE, COUNT).wkt, area.simplify(SIZE).area, Point(0, 0).distance(Point(COUNT, SIZE))
)

image = Image.new("RGB", (40, 10 * COUNT), (255, COUNT, 0))
draw = ImageDraw.Draw(image)
draw.line((0, 0, COUNT * 5, 20), fill=(0, 0, COUNT), width=COUNT)
draw.text((COUNT, 2), f"{NAME} {COUNT}", fill="white")
draw.ellipse([COUNT, COUNT, 20, 20], outline="#ff00" + "ff")
image.putpixel((COUNT, 1), (1, 2, COUNT))
small = image.resize((10 * COUNT, 20)).rotate(45.0 * SIZE).filter(ImageFilter.GaussianBlur(SIZE))
print(image.getpixel((COUNT, 1)), sum(image.tobytes()), small.crop((COUNT, COUNT, 20, 20)).size)
