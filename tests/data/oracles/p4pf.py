# Python 3, numpy 2.4.6, scipy 1.17.1: python p4pf.py > p4pf.json
"""Cameras of unknown principal distance: exact pictures made with plain numbers, and for noisy ones the least minimum that scipy finds from
many starts."""
import json
import sys

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(4)


def project(q, x, center):
    r = Rotation.from_rotvec(q[1:4]).as_matrix()
    d = (x - center) @ r.T + q[4:7]
    return np.exp(q[0]) * d[:, :2] / d[:, 2:], d[:, 2]


def best(x, t, q0):
    center, size = x.mean(0), np.ptp(x, axis=0).max()
    found = None
    for i in range(60):
        q = q0.copy()
        if i:
            q[0] += rng.uniform(-1.5, 1.5)
            q[1:4] = Rotation.random(random_state=rng).as_rotvec() if i % 2 else q[1:4] + rng.normal(size=3) * 0.2
            q[4:7] = [0, 0, np.exp(q[0]) * size / np.ptp(t, axis=0).max()]

        def f(q):
            p, z = project(q, x, center)
            return (p - t).ravel() if (z > 0).all() else np.full(8, 1e4)

        try:
            s = least_squares(f, q, xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=[1, 1, 1, 1, size, size, size], max_nfev=500)
        except ValueError:
            continue
        if found is None or s.cost < found.cost:
            found = s
    return found


cases = []
for i in range(30):
    plane, noise = i % 3 == 1, 0.5 if i % 5 == 4 else 0.0
    offset = np.array([3.5e6, 5.8e6, 400.0]) if i % 7 == 6 else np.zeros(3)
    size = 200 if i % 7 == 6 else 1
    while True:
        x = rng.uniform(-1, 1, (4, 3)) * size
        if plane:
            x[:, 2] = 0
        x = np.round(x + offset, 4)
        f = float(np.exp(rng.uniform(np.log(400), np.log(4000))))
        w = rng.normal(size=3)
        distance = size * rng.uniform(2.2, 6)
        r = Rotation.from_rotvec(w).as_matrix()
        if plane and abs(r[2, 2]) > 0.85:
            continue  # too near to parallel
        place = np.array([rng.uniform(-0.5, 0.5) * size, rng.uniform(-0.5, 0.5) * size, distance])
        q = np.concatenate([[np.log(f)], w, place])
        t, z = project(q, x, x.mean(0))
        area = lambda a, b, c: abs(np.cross(b - a, c - a)) / max(np.sum((b - a) ** 2), np.sum((c - a) ** 2), np.sum((c - b) ** 2))
        if (z > 0.3 * size).all() and min(area(t[0], t[1], t[2]), area(t[0], t[1], t[3]), area(t[1], t[2], t[3])) > 0.1:
            break
    center = x.mean(0) - r.T @ place
    pp = [960.0, 540.0]
    if noise:
        t = np.round(t + noise * rng.normal(size=(4, 2)), 3)
        s = best(x, t, q)
        r = Rotation.from_rotvec(s.x[1:4]).as_matrix()
        center = x.mean(0) - r.T @ s.x[4:7]
        f, residual = float(np.exp(s.x[0])), float(np.sqrt(2 * s.cost / 8))
    else:
        residual = 0.0
    cases.append({"object": x.tolist(), "image": (t + pp).tolist(), "principal_point": pp, "f": f, "rotation": r.tolist(), "center": center.tolist(), "residual": residual})
json.dump({"cases": cases}, sys.stdout, separators=(",", ":"))
