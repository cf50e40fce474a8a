# Python 3, mpmath 1.4.1, numpy 2.4.6, OpenCV 5.0.0.93. Prints tests/data/oracles/shader.json.
"""Oracles for shader source: pixels and where maps send them, by formulas in 30 digits, and by cv2.projectPoints.

affine, fractional_linear, quadratic and cubic: table 2's and equation 1's plain formulas in raw coordinates, with mpmath.
distort: cv2.projectPoints of the ideal pixel's ray, half a pixel on (OpenCV's centres are integers).
shown: whether both forms R and E are positive.
"""
import json

import cv2
import mpmath as mp
import numpy as np

mp.mp.dps = 30
rng = np.random.default_rng(6)
pixels = (rng.integers((0, 0), (1920, 1080), (14, 2)) + 0.5).tolist()
TERMS = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (0, 3)]

affine = [[12.5, 1.01, -0.03], [-40.25, 0.02, 0.97]]
fractional = [[41000.0, 3.5, 0.4], [9000.0, -0.2, 4.5], [0.8, -2.5e-4, 4e-4], [1.5, 0.0, -1.6e-3]]
scale = np.array([1, 1e-3, 1e-3, 1e-6, 1e-6, 1e-6, 1e-9, 1e-9, 1e-9, 1e-9])
cubic = (np.random.default_rng(8).uniform(-300, 300, (2, 10)) * scale).tolist()
quadratic = [c[:6] for c in cubic]


def linear(c, x, y):
    return mp.mpf(c[0]) + mp.mpf(c[1]) * x + mp.mpf(c[2]) * y


def poly(c, x, y):
    return sum(mp.mpf(k) * mp.mpf(x) ** i * mp.mpf(y) ** j for k, (i, j) in zip(c, TERMS))


K = np.array([[1400.0, 0.0, 955.0], [0.0, 1390.0, 544.0], [0.0, 0.0, 1.0]])
LENS = np.array([-0.21, 0.05, 1e-3, -5e-4, -0.003])
ideal = np.array(pixels) - 0.5
rays = np.stack([(ideal[:, 0] - 955) / 1400, (ideal[:, 1] - 544) / 1390, np.ones(len(ideal))], 1)
distorted = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), K, LENS)[0][:, 0] + 0.5

print(json.dumps({
    "pixels": pixels,
    "affine": {"coefficients": affine, "texture": [[float(linear(c, *p)) for c in affine] for p in pixels]},
    "fractional": {
        "coefficients": fractional,
        "texture": [[float(linear(c, *p) / linear(fractional[2], *p)) for c in fractional[:2]] for p in pixels],
        "shown": [bool(linear(fractional[2], *p) > 0 and linear(fractional[3], *p) > 0) for p in pixels],
    },
    "quadratic": {"coefficients": quadratic, "texture": [[float(poly(c, *p)) for c in quadratic] for p in pixels]},
    "cubic": {"coefficients": cubic, "texture": [[float(poly(c, *p)) for c in cubic] for p in pixels]},
    "distort": {"camera": [1400, 1390, 955, 544], "lens": LENS.tolist(), "texture": distorted.tolist()},
}))
