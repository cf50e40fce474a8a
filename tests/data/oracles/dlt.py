# Python 3, numpy 2.4.6, OpenCV 5.0.0: python dlt.py > dlt.json
"""Cameras from points in space: pictures made with plain numbers, algebraic minima by numpy's SVD, matrices that OpenCV
took apart."""
import json
import sys

import cv2
import numpy as np

rng = np.random.default_rng(11)


def turn(w):
    return cv2.Rodrigues(np.asarray(w, float))[0]


def camera(offset, extent):
    f = rng.uniform(800, 3000)
    k = np.array([[f, rng.uniform(-5, 5), rng.uniform(400, 900)], [0, f * rng.uniform(0.9, 1.1), rng.uniform(300, 700)], [0, 0, 1]])
    r = turn(rng.normal(size=3))
    c = offset - r.T @ np.array([0.3, -0.2, rng.uniform(3, 8)]) * extent
    return k, r, c


def project(k, r, c, x):
    h = (x - c) @ r.T @ k.T
    return h[:, :2] / h[:, 2:]


def minimum(x, t):
    """The algebraic minimum in the normalised frames, by LAPACK."""
    n = len(x)
    mean = x.mean(0)
    _, s, vt = np.linalg.svd(x - mean)
    a = np.diag(np.sqrt(n) / s) @ vt
    m = t.mean(0)
    pixel = np.sqrt(((t - m) ** 2).sum() / (2 * n))
    rows = []
    for p, q in zip((x - mean) @ a.T, (t - m) / pixel):
        h = np.append(p, 1)
        z = np.zeros(4)
        rows += [np.concatenate([h, z, -q[0] * h]), np.concatenate([z, h, -q[1] * h])]
    _, s, vt = np.linalg.svd(np.array(rows))
    p = np.array([[pixel, 0, m[0]], [0, pixel, m[1]], [0, 0, 1]]) @ vt[-1].reshape(3, 4)
    p[:, :3] = p[:, :3] @ a
    h = np.column_stack([x - mean, np.ones(n)]) @ p.T
    return h[:, :2] / h[:, 2:], s[10] / s[0]


cases = []
for i, (n, extent, offset, noise, shape) in enumerate([
    (6, 1, 0, 0, (1, 1, 1)), (8, 50, 0, 0, (1, 1, 1)), (20, 300, np.array([3.5e6, 5.8e6, 400]), 0, (1, 1, 0.1)),
    (12, 1, 0, 0, (1, 1, 1e-3)), (7, 1, 0, 0.5, (1, 1, 1)), (30, 10, 0, 1.0, (1, 0.5, 0.3)), (200, 10, 100, 1.0, (1, 1, 1)),
]):
    k, r, c = camera(np.zeros(3) + offset, extent)
    x = np.round(offset + extent * rng.uniform(-1, 1, (n, 3)) * shape, 4)
    t = project(k, r, c, x) + noise * rng.normal(size=(n, 2))
    case = {"object": x.tolist(), "image": t.tolist()}
    if noise:
        predicted, condition = minimum(x, t)
        case |= {"predicted": predicted.tolist(), "condition": condition}
    else:
        case |= {"k": k.tolist(), "rotation": r.tolist(), "center": c.tolist()}
    cases.append(case)

matrices = []
for sign in (1, -1, 3.7, -1e-3):
    k, r, c = camera(np.array([10.0, -20, 30]), 5)
    p = sign * k @ np.column_stack([r, -r @ c])
    kk, rr, cc = cv2.decomposeProjectionMatrix(p)[:3]
    # OpenCV leaves the signs of K's diagonal as they come; for det M < 0 it decomposes the matrix as it is.
    d = np.diag(np.sign(np.diag(kk)))
    kk, rr = kk @ d, d @ rr
    matrices.append({"p": p.tolist(), "k": (kk / kk[2, 2]).tolist(), "rotation": (rr * np.linalg.det(rr)).tolist(), "center": (cc[:3] / cc[3]).ravel().tolist()})
    assert np.allclose(kk / kk[2, 2], k) and np.allclose(rr * np.linalg.det(rr), r)
json.dump({"cases": cases, "matrices": matrices}, sys.stdout, separators=(",", ":"))
