# Python 3, numpy 2.4.6, scipy 1.17.1, mpmath 1.4.1, opencv 5.0.0: python filters.py > filters.json
"""Cubic and Lanczos lookups with every border.

"exact": the kernels' defining formulas with 30 digits (Mitchell & Netravali 1988 eq. 8; sinc(x) sinc(x/n), normalised), the taps
through numpy's padding. "scipy": the cubic B-spline by scipy.ndimage.map_coordinates, order 3 without prefilter. "opencv": remap of
a float picture with INTER_CUBIC and INTER_LANCZOS4, good to 2e-4 of a level here.
Positions count from the picture's corner; the programs' are those of texel centres, half a texel less.
"""
import json

import cv2
import numpy as np
from mpmath import mp, mpf, sin, pi, floor
from scipy.ndimage import map_coordinates

mp.dps = 30
rng = np.random.default_rng(20)
H, W, PAD = 9, 12, 24
picture = rng.integers(0, 256, (H, W)).astype(np.float64)
# Multiples of 1/32, to which OpenCV rounds positions of its Lanczos; then whole and half texels.
u = (rng.integers(-6 * 32, (W + 6) * 32, 70) / 32).tolist() + [0.5, 3.5, 4.0, 11.5, 12.0, 0.0]
v = (rng.integers(-6 * 32, (H + 6) * 32, 70) / 32).tolist() + [0.5, 2.5, 5.0, 8.5, 9.0, 0.0]
CONSTANT = 40.0
BORDERS = {
    "constant": (dict(mode="constant", constant_values=CONSTANT), "grid-constant", cv2.BORDER_CONSTANT),
    "clamp": (dict(mode="edge"), "nearest", cv2.BORDER_REPLICATE),
    "repeat": (dict(mode="wrap"), "grid-wrap", cv2.BORDER_WRAP),
    "mirror": (dict(mode="symmetric"), "reflect", cv2.BORDER_REFLECT),
}


def cubic(b, c):
    def k(x):
        x = abs(x)
        if x < 1:
            return ((12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + (6 - 2 * b)) / 6
        if x < 2:
            return ((-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6
        return mpf(0)

    return 2, k


def lanczos(n):
    sinc = lambda x: mpf(1) if x == 0 else sin(pi * x) / (pi * x)
    return n, lambda x: sinc(x) * sinc(x / n) if abs(x) < n else mpf(0)


KERNELS = {
    "keys -0.75": cubic(mpf(0), mpf(3) / 4),
    "keys -1": cubic(mpf(0), mpf(1)),
    "catmull_rom": cubic(mpf(0), mpf(1) / 2),
    "mitchell": cubic(mpf(1) / 3, mpf(1) / 3),
    "b_spline": cubic(mpf(1), mpf(0)),
    "lanczos2": lanczos(2),
    "lanczos3": lanczos(3),
    "lanczos4": lanczos(4),
}


def lookup(padded, kernel, x, y):
    n, k = kernel
    x, y = mpf(x) - mpf(1) / 2, mpf(y) - mpf(1) / 2
    i, j = int(floor(x)), int(floor(y))
    taps = range(1 - n, n + 1)
    wx, wy = [k(x - (i + t)) for t in taps], [k(y - (j + t)) for t in taps]
    total = sum(wx) * sum(wy)
    value = sum(b * a * mpf(padded[j + s + PAD, i + t + PAD]) for s, b in zip(taps, wy) for t, a in zip(taps, wx))
    return float(value / total)


out = {"width": W, "samples": picture.ravel().astype(int).tolist(), "u": u, "v": v, "constant": CONSTANT, "values": {}}
maps = [(np.array([c]) - 0.5).astype(np.float32) for c in (u, v)]
for border, (pad, scipy_mode, cv_border) in BORDERS.items():
    padded = np.pad(picture, PAD, **pad)
    for name, kernel in KERNELS.items():
        out["values"][f"exact {border} {name}"] = [lookup(padded, kernel, x, y) for x, y in zip(u, v)]
    at = np.array([v, u]) - 0.5
    spline = map_coordinates(picture, at, order=3, mode=scipy_mode, cval=CONSTANT, prefilter=False)
    out["values"][f"scipy {border} b_spline"] = spline.tolist()
    for name, flag in (("keys -0.75", cv2.INTER_CUBIC), ("lanczos4", cv2.INTER_LANCZOS4)):
        got = cv2.remap(picture.astype(np.float32), *maps, flag, borderMode=cv_border, borderValue=CONSTANT)
        out["values"][f"opencv {border} {name}"] = got.ravel().astype(float).tolist()
print(json.dumps(out))
