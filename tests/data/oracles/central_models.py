# Python 3, NumPy 2.4.6, OpenCV 5.0.0 (opencv-python-headless), pycolmap 4.2.1. Prints tests/data/oracles/central_models.json.
"""Image points of directions, by OpenCV's projectPoints and fisheye.projectPoints and by pycolmap's img_from_cam."""
import json

import cv2
import numpy as np
import pycolmap

rng = np.random.default_rng(20261122)
cases = []


def directions(limit_degrees, count):
    """Unit directions within an angle of the axis, some scaled: a projection must not depend on the length."""
    angle = np.radians(limit_degrees) * np.sqrt(rng.uniform(0, 1, count))
    turn = rng.uniform(0, 2 * np.pi, count)
    d = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], 1)
    return d * rng.uniform(0.3, 30, (count, 1))


def record(program, model, parameters, d, image):
    ok = [i for i in range(len(d)) if image[i] is not None and np.all(np.isfinite(image[i]))]
    cases.append({
        "program": program, "model": model, "parameters": [float(p) for p in parameters],
        "directions": [[float(c) for c in d[i]] for i in ok],
        "image": [[float(c) for c in image[i]] for i in ok],
    })


K = [1203.5, 1187.25, 639.25, 481.75]
matrix = np.array([[K[0], 0, K[2]], [0, K[1], K[3]], [0, 0, 1]])
coefficients = [-0.281, 0.0713, 1.1e-3, -6.2e-4, 0.0131, 0.0172, -0.0214, 0.0036,
                8.3e-4, -4.1e-4, -7.7e-4, 2.9e-4, 0.031, -0.047]
zero = np.zeros(3)
for n in (4, 5, 8, 12, 14):
    d = directions(32, 24)
    image, _ = cv2.projectPoints(d.reshape(-1, 1, 3), zero, zero, matrix, np.array(coefficients[:n]))
    record("OpenCV", f"{n} coefficients", K + coefficients[:n], d, image.reshape(-1, 2))
d = directions(85, 24)
k = [0.0312, -0.0147, 0.0063, -0.0011]
image, _ = cv2.fisheye.projectPoints(d.reshape(-1, 1, 3), zero, zero, matrix, np.array(k), alpha=0.0)
record("OpenCV", "fisheye", K + k, d, image.reshape(-1, 2))
if hasattr(cv2, "omnidir"):
    d = directions(85, 24)
    distortion = np.array([[-0.11, 0.021, 7e-4, -3e-4]])
    image, _ = cv2.omnidir.projectPoints(d.reshape(-1, 1, 3), zero, zero, matrix, 1.21, distortion)
    record("OpenCV", "omnidir", K + [1.21] + list(distortion[0]), d, image.reshape(-1, 2))

f, fx, fy, cx, cy = 611.3, 611.3, 598.7, 513.4, 391.9
models = {
    "SIMPLE_PINHOLE": ([f, cx, cy], 70), "PINHOLE": ([fx, fy, cx, cy], 70),
    "SIMPLE_RADIAL": ([f, cx, cy, -0.11], 45), "RADIAL": ([f, cx, cy, -0.11, 0.017], 45),
    "OPENCV": ([fx, fy, cx, cy, -0.11, 0.017, 1.2e-3, -7e-4], 45),
    "OPENCV_FISHEYE": ([fx, fy, cx, cy, 0.031, -0.015, 0.0063, -0.0011], 110),
    "FULL_OPENCV": ([fx, fy, cx, cy, -0.11, 0.017, 1.2e-3, -7e-4, 0.004, 0.021, -0.013, 0.002], 45),
    "FOV": ([fx, fy, cx, cy, 0.93], 80),
    "SIMPLE_RADIAL_FISHEYE": ([f, cx, cy, 0.021], 110), "RADIAL_FISHEYE": ([f, cx, cy, 0.021, -0.004], 110),
    "THIN_PRISM_FISHEYE": ([fx, fy, cx, cy, 0.031, -0.015, 1.2e-3, -7e-4, 0.0063, -0.0011, 9e-4, -5e-4], 75),
    "RAD_TAN_THIN_PRISM_FISHEYE": ([fx, fy, cx, cy, 0.031, -0.015, 0.0063, -0.0011, 4e-4, -6e-5, 1.2e-3, -7e-4,
                                    9e-4, -5e-4, 3e-4, -2e-4], 75),
    "SIMPLE_DIVISION": ([f, cx, cy, -0.13], 70), "DIVISION": ([fx, fy, cx, cy, -0.13], 70),
    "SIMPLE_FISHEYE": ([f, cx, cy], 110), "FISHEYE": ([fx, fy, cx, cy], 110),
    "EUCM": ([fx, fy, cx, cy, 0.57, 1.13], 80), "EQUIRECTANGULAR": ([2000, 1000], 179),
}
for name, (parameters, limit) in models.items():
    camera = pycolmap.Camera(model=name, width=1024, height=800, params=parameters)
    d = directions(limit, 20)
    record("pycolmap", name, parameters, d, [camera.img_from_cam(v.reshape(1, 3))[0] if camera.img_from_cam(v.reshape(1, 3)) is not None else None for v in d])
print(json.dumps({"cases": cases}))
