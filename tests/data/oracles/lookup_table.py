# Python 3, OpenCV 5.0.0.93 (opencv-python-headless), numpy 2.4.6, mpmath 1.4.1. Prints tests/data/oracles/lookup_table.json.
"""Oracles for lookup tables and for the approximation of expensive maps.

maps: cv2.initUndistortRectifyMap (CV_32FC1) of a camera, the same camera matrix before and after, every 7th pixel.
remap: cv2.remap, INTER_LINEAR, of a float image by random maps that stay inside it.
undistort: pixels of the photograph and their undistorted place, by mpmath.findroot in 30 digits, OpenCV's integer centres.
"""
import json

import cv2
import mpmath as mp
import numpy as np

mp.mp.dps = 30
W, H = 160, 120
F, CX, CY = 130.0, 80.5, 57.25
LENS = (-0.21, 0.06, 1e-3, -5e-4, -0.004)  # k1, k2, p1, p2, k3

k = np.array([[F, 0, CX], [0, F, CY], [0, 0, 1]])
mx, my = cv2.initUndistortRectifyMap(k, np.array(LENS), None, k, (W, H), cv2.CV_32FC1)
maps = [[x, y, float(mx[y, x]), float(my[y, x])] for y in range(0, H, 7) for x in range(0, W, 7)]

rng = np.random.default_rng(3)
image = rng.uniform(0, 255, (12, 16)).astype(np.float32)
rx = rng.uniform(0, 15, (9, 11)).astype(np.float32)
ry = rng.uniform(0, 11, (9, 11)).astype(np.float32)
out = cv2.remap(image, rx, ry, cv2.INTER_LINEAR)

k1, k2, p1, p2, k3 = (mp.mpf(c) for c in LENS)


def distort(x, y):
    r = x * x + y * y
    radial = 1 + r * (k1 + r * (k2 + r * k3))
    return (x * radial + 2 * p1 * x * y + p2 * (r + 2 * x * x),
            y * radial + p1 * (r + 2 * y * y) + 2 * p2 * x * y)


undistort = []
for px in range(0, W, 23):
    for py in range(0, H, 17):
        dx, dy = (mp.mpf(px) - CX) / F, (mp.mpf(py) - CY) / F
        x, y = mp.findroot(lambda x, y: [distort(x, y)[0] - dx, distort(x, y)[1] - dy], (dx, dy))
        undistort.append([px, py, float(x * F + CX), float(y * F + CY)])

print(json.dumps({
    "versions": {"opencv": cv2.__version__, "numpy": np.__version__, "mpmath": mp.__version__},
    "size": [W, H], "camera": [F, CX, CY], "lens": LENS,
    "maps": maps, "undistort": undistort,
    "remap": {"image": image.ravel().tolist(), "size": [16, 12], "target": [11, 9],
              "x": rx.ravel().tolist(), "y": ry.ravel().tolist(), "out": out.ravel().tolist()},
}))
