# Python 3, numpy 2.4.6, OpenCV 5.0.0, mpmath: python intersection.py > intersection.json
"""Points from rays and pictures: minima by Gauss-Newton in 40 digits with numerical derivatives, from OpenCV's linear triangulation."""
import json
import sys

import cv2
import mpmath as mp
import numpy as np

mp.mp.dps = 40
rng = np.random.default_rng(8)


def look(center, target, up):
    f = target - center
    f /= np.linalg.norm(f)
    r = np.cross(f, up)
    r /= np.linalg.norm(r)
    return np.array([r, np.cross(f, r), f])


def project(cam, x):
    d = [mp.mpf(float(a)) for a in cam["center"]]
    d = [a - b for a, b in zip(x, d)]
    h = [sum(mp.mpf(float(cam["rotation"][i][j])) * d[j] for j in range(3)) for i in range(3)]
    f, g, s, cx, cy = (mp.mpf(float(v)) for v in cam["interior"])
    return [f * h[0] / h[2] + s * h[1] / h[2] + cx, g * h[1] / h[2] + cy]


def solve(cams, images, covariances, origin):
    u = [[[mp.mpf(float(v)) for v in row] for row in np.linalg.cholesky(np.linalg.inv(np.array(c))).T] for c in covariances]

    def residuals(x):
        out = []
        for cam, t, w in zip(cams, images, u):
            p = project(cam, x)
            v = [mp.mpf(float(a)) - b for a, b in zip(t, p)]
            out += [w[0][0] * v[0] + w[0][1] * v[1], w[1][0] * v[0] + w[1][1] * v[1]]
        return mp.matrix(out)

    ps = []
    for cam in cams[:2]:
        f, g, s, cx, cy = cam["interior"]
        k = np.array([[f, s, cx], [0, g, cy], [0, 0, 1]])
        r = np.array(cam["rotation"])
        ps.append(k @ np.column_stack([r, -r @ (np.array(cam["center"]) - origin)]))
    h = cv2.triangulatePoints(ps[0], ps[1], np.array(images[0]).reshape(2, 1), np.array(images[1]).reshape(2, 1)).ravel()
    x = [mp.mpf(float(v)) for v in h[:3] / h[3] + origin]
    for _ in range(12):
        r = residuals(x)
        j = mp.matrix(len(r), 3)
        for k in range(3):
            e = mp.mpf(10) ** -15
            up, down = list(x), list(x)
            up[k] += e
            down[k] -= e
            d = (residuals(up) - residuals(down)) / (2 * e)
            for i in range(len(r)):
                j[i, k] = d[i]
        step = mp.lu_solve(j.T * j, -(j.T * r))
        x = [a + b for a, b in zip(x, step)]
    assert max(abs(s) for s in step) < mp.mpf(10) ** -20
    r = residuals(x)
    q = (j.T * j) ** -1
    vpv = sum(v * v for v in r)
    return {"point": [float(v) for v in x], "vpv": float(vpv), "sigma0": float(mp.sqrt(vpv / (len(r) - 3))),
            "cofactor": [[float(q[i, k]) for k in range(3)] for i in range(3)]}


def nearest(rays):
    """Normal equations in 40 digits."""
    n, b = mp.zeros(3), mp.zeros(3, 1)
    for c, d, w in rays:
        c, d = [mp.mpf(float(v)) for v in c], [mp.mpf(float(v)) for v in d]
        l = mp.sqrt(sum(v * v for v in d))
        d = [v / l for v in d]
        for i in range(3):
            for k in range(3):
                m = w * ((1 if i == k else 0) - d[i] * d[k])
                n[i, k] += m
                b[i] += m * c[k]
    x = mp.lu_solve(n, b)
    return [float(v) for v in x], float(mp.sqrt(min(mp.eigsy(n, eigvals_only=True)) / sum(w for _, _, w in rays)))


cases = []
for count, extent, offset, distance, noise in [(2, 1, np.zeros(3), 5, 1.0), (3, 10, np.zeros(3), 30, 0.5), (6, 300, np.array([3.5e6, 5.8e6, 400.0]), 1000, 2.0),
                                               (2, 1, np.zeros(3), 500, 0.1), (40, 5, np.array([10.0, 20, 30]), 20, 3.0)]:
    cams, images, covariances = [], [], []
    truth = offset + rng.normal(size=3) * extent * 0.1
    for i in range(count):
        side = rng.normal(size=3) * extent
        center = np.round(truth + np.array([0, 0, distance]) + side, 6)
        r = look(center, truth + rng.normal(size=3) * extent * 0.1, np.array([0, 1.0, 0.1]))
        cam = {"center": center.tolist(), "rotation": r.tolist(), "interior": [float(v) for v in np.round([1000 + 50 * i, 1010, 2 * i, 500, 400], 3)]}
        cams.append(cam)
        p = project(cam, [mp.mpf(float(v)) for v in truth])
        c = np.diag(rng.uniform(0.2, 2, 2)) + 0.1 if i % 2 else np.eye(2) * rng.uniform(0.2, 2)
        covariances.append(c.tolist())
        images.append([round(float(v) + noise * rng.normal(), 3) for v in p])
    cases.append({"cameras": cams, "images": images, "covariances": covariances, "solution": solve(cams, images, covariances, truth)})

rays = []
for angle, offset in [(1, 0), (1e-3, 0), (1e-6, 0), (0.3, 4e6)]:
    origins = np.round(offset + rng.normal(size=(4, 3)) * 10, 4)
    target = offset + np.array([0, 0, 10 / angle])
    directions = np.round(target - origins + rng.normal(size=(4, 3)) * 0.01, 4)
    weights = [1.0, 2.0, 0.5, 3.0]
    point, measure = nearest(list(zip(origins, directions, weights)))
    rays.append({"origins": origins.tolist(), "directions": directions.tolist(), "weights": weights, "point": point, "measure": measure})
json.dump({"cases": cases, "rays": rays}, sys.stdout, separators=(",", ":"))
