"""Coordinates with pyproj (Cython, with parameters that are declared str)."""

import pyproj

ZONE = 32
DATUM = "WGS84"
HALF = 0.5

to_utm = pyproj.Transformer.from_crs("EPSG:4326", f"EPSG:326{ZONE}", always_xy=True)
print([round(x, 3) for x in to_utm.transform(9.0 + HALF, 48.0)])
print([round(x, 4) for x in pyproj.Geod(ellps=DATUM).fwd(9.0, 48.0, 45.0 * HALF, 300)])
print([round(x, 3) for x in pyproj.Proj(proj="utm", zone=ZONE + 1, ellps=DATUM)(12.5, HALF)])
print(pyproj.CRS.from_epsg(4326).name, pyproj.CRS("+proj=utm +zone=33").to_dict())
try:
    pyproj.CRS("nothing " + DATUM)
except pyproj.exceptions.CRSError as error:
    print(error)
