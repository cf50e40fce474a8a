# Python 3, numpy 2.4.6, scipy 1.17.1: python resample.py > resample.json
"""Nearest and bilinear lookups with every border, by scipy.ndimage.map_coordinates.

SciPy's coordinates are those of texel centres, so a position u is its u - 0.5. Modes: 'grid-constant' is a constant beyond
the edge, 'nearest' the edge texel, 'grid-wrap' the repeated picture, 'reflect' the mirrored one whose edge stands twice.
"""
import json

import numpy as np
from scipy.ndimage import map_coordinates

MODES = {"constant": "grid-constant", "clamp": "nearest", "repeat": "grid-wrap", "mirror": "reflect"}
PICTURES = [
    [[10, 90, 200], [250, 0, 33]],
    [[7]],
    [[12, 240], [100, 3], [77, 180], [255, 64]],
]
# Multiples of 1/8, so that weights and products are exact in single precision; no multiples of 1, where SciPy's mirror
# rounds to the other neighbour.
U = [-9.375, -4.5, -3.125, -2.625, -1.25, -0.5, -0.125, 0.125, 0.25, 0.5, 0.875, 1.375, 1.5, 2.125, 2.5, 2.875, 3.125, 3.5, 4.75, 10.25]
V = [0.5, 1.625, -0.25, 2.125, 0.875, -3.5, 4.125, 1.375, -8.75, 3.375, 1.125, 0.125, 7.5, -1.125, 1.5, 0.75, 2.25, 0.625, 3.875, -0.875]
out = {"u": U, "v": V, "constant": 40, "pictures": []}
for picture in PICTURES:
    a = np.array(picture, dtype=np.float64)
    entry = {"width": a.shape[1], "samples": a.ravel().astype(int).tolist(), "values": {}}
    for name, mode in MODES.items():
        for filter_name, order in (("nearest", 0), ("bilinear", 1)):
            at = np.array([V, U]) - 0.5
            values = map_coordinates(a, at, order=order, mode=mode, cval=40.0, prefilter=False)
            entry["values"][f"{name} {filter_name}"] = [float(np.round(x * 64) / 64) for x in values]
            assert np.max(np.abs(values * 64 - np.round(values * 64))) < 1e-9
    out["pictures"].append(entry)
print(json.dumps(out))
