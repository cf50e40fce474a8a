"""A small problem of Bundle Adjustment in the Large, its image points computed by the formula of the format.

Writes bal.txt and bal.txt.gz. Run with numpy 2.x and scipy 1.x.
"""
import gzip
import os

import numpy as np
from scipy.spatial.transform import Rotation

here = os.path.dirname(os.path.abspath(__file__))
cameras = np.array([
    [0.1, -0.2, 0.3, 1.0, 2.0, -30.0, 500.0, -0.11, 0.02],
    [-0.4, 0.25, 1.2, -3.0, 0.5, -25.0, 800.0, 0.07, -0.03],
])
points = np.array([[4.0, 5.0, 6.0], [-7.0, 3.0, -2.0], [1.5, -6.0, 0.25]])
lines = ["2 3 6"]
for j, x in enumerate(points):
    for i, c in enumerate(cameras):
        p = Rotation.from_rotvec(c[:3]).apply(x) + c[3:6]
        p = -p[:2] / p[2]
        s = p @ p
        u = c[6] * (1 + c[7] * s + c[8] * s * s) * p
        lines.append(f"{i} {j} {float(u[0])!r} {float(u[1])!r}")
lines += [repr(float(v)) for v in np.concatenate([cameras.ravel(), points.ravel()])]
text = "\n".join(lines) + "\n"
with open(os.path.join(here, "bal.txt"), "w") as f:
    f.write(text)
with open(os.path.join(here, "bal.txt.gz"), "wb") as f:
    f.write(gzip.compress(text.encode(), mtime=0))
