# Python 3, numpy 2.4.6, scipy 1.17.1, opencv 5.0.0: python area.py > area.json
"""Pyramids, and lookups in them by level and by ellipse, in float64.

"levels": means over areas as products with matrices of overlaps, and OpenCV's INTER_AREA of the same sizes. "trilinear": two
lookups by scipy.ndimage.map_coordinates of order 1. "ewa": the ellipse by its principal axes (numpy.linalg.eigh), every texel of the
padded level weighed. "waves": the mean of a plane wave under the weight (1 - r²)² over an ellipse, 48 J₃(k)/k³ of the wave at the centre.
Positions count from the picture's corner. Pixels whose level is chosen within 1e-4 of a change are left out.
"""
import json

import cv2
import numpy as np
from scipy.ndimage import map_coordinates
from scipy.special import jv

rng = np.random.default_rng(5)
H, W = 37, 53
picture = rng.integers(0, 256, (H, W)).astype(np.float64)
CONSTANT = 40.0
BORDERS = {
    "constant": (dict(mode="constant", constant_values=CONSTANT), "grid-constant"),
    "clamp": (dict(mode="edge"), "nearest"),
    "repeat": (dict(mode="wrap"), "grid-wrap"),
    "mirror": (dict(mode="symmetric"), "reflect"),
}


def overlap(n, m):
    """Shares of n texels in m texels of the same length in all."""
    edges = np.arange(m + 1) * n / m
    low, high = np.maximum(edges[:-1, None], np.arange(n)), np.minimum(edges[1:, None], np.arange(n) + 1)
    return np.maximum(high - low, 0) * m / n


def pyramid(ratio):
    levels, k = [picture], 0
    back = int(np.ceil(np.log(2) / np.log(ratio) - 1e-9))
    while levels[-1].shape != (1, 1):
        k += 1
        h, w = (max(1, int(n / ratio**k)) for n in (H, W))
        fine = levels[max(0, k - back)]
        levels.append(overlap(fine.shape[0], h) @ fine @ overlap(fine.shape[1], w).T)
    return levels


out = {"width": W, "samples": picture.ravel().astype(int).tolist(), "constant": CONSTANT, "levels": {}, "lookups": []}
for ratio in (2.0, 1.5, 1.12, 3.0):
    out["levels"][str(ratio)] = [dict(width=a.shape[1], values=a.ravel().round(6).tolist()) for a in pyramid(ratio)]
first = pyramid(2.0)[1]
out["opencv"] = cv2.resize(picture.astype(np.float32), first.shape[::-1], interpolation=cv2.INTER_AREA).ravel().astype(float).tolist()


def trilinear(levels, ratio, u, v, jacobian, mode):
    texel = np.linalg.svd(jacobian)[1][0] / np.sqrt(3)
    detail = np.clip(np.log(max(texel, 1e-30)) / np.log(ratio), 0, len(levels) - 1)
    k = int(detail)
    share = np.clip((texel / ratio**k - 1) / (ratio - 1), 0, 1)

    def at(level):
        h, w = level.shape
        at = [[v * h / H - 0.5], [u * w / W - 0.5]]
        return map_coordinates(level, at, order=1, mode=mode, cval=CONSTANT)[0]

    nearest = at(levels[int(np.floor(detail + 0.5))])
    fine, coarse = at(levels[k]), at(levels[min(k + 1, len(levels) - 1)])
    margins = [abs(detail - np.round(detail)) if 0 < detail < len(levels) - 1 else 1, abs(detail % 1 - 0.5)]
    return (1 - share) * fine + share * coarse, nearest, min(margins)


def ellipse(covariance, own, anisotropy, ratio):
    values, vectors = np.linalg.eigh(covariance)
    short, long = values - own
    most = 0.5 * ratio**2
    long = np.clip(long, 3 / 16, most * anisotropy**2)
    short = max(np.clip(short, 3 / 16, most), long / anisotropy**2)
    return vectors @ np.diag([short, long]) @ vectors.T


def ewa(levels, ratio, u, v, jacobian, anisotropy, pad):
    longest, shortest = np.linalg.svd(jacobian)[1] ** 2 / 12
    texels = max(shortest, longest / anisotropy**2) / (3 / 16 + 1 / 12)
    detail = np.clip(0.5 * np.log(max(texels, 1e-30)) / np.log(ratio), 0, len(levels) - 1)
    level = levels[int(detail)]
    h, w = level.shape
    scale = np.diag([w / W, h / H])
    own = (1 - max(w / W, h / H) ** 2) / 12
    inverse = np.linalg.inv(8 * ellipse(scale @ jacobian @ jacobian.T @ scale / 12, own, anisotropy, ratio))
    PAD = 130
    padded = np.pad(level, PAD, **pad)
    y, x = np.mgrid[0 : h + 2 * PAD, 0 : w + 2 * PAD] + 0.5 - PAD
    x, y = x - u * w / W, y - v * h / H
    near = 1 - (inverse[0, 0] * x * x + 2 * inverse[0, 1] * x * y + inverse[1, 1] * y * y)
    assert near[0].max() <= 0 and near[-1].max() <= 0 and near[:, 0].max() <= 0 and near[:, -1].max() <= 0
    weight = np.maximum(near, 0) ** 2
    margin = abs(detail - np.round(detail)) if 0 < detail < len(levels) - 1 else 1
    return (weight * padded).sum() / weight.sum(), margin


PYRAMIDS = {ratio: pyramid(ratio) for ratio in (2.0, 1.5)}
while len(out["lookups"]) < 240:
    n = len(out["lookups"])
    ratio = [2.0, 1.5][n % 2]
    anisotropy = int(rng.choice([1, 4, 16]))
    border = list(BORDERS)[(n // 2) % 4]
    pad, mode = BORDERS[border]
    u, v = rng.uniform(-5, W + 5), rng.uniform(-5, H + 5)
    a, b = rng.uniform(0, 2 * np.pi, 2)
    turn = lambda t: np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    long = 2 ** rng.uniform(-2, 5)
    j = turn(a) @ np.diag([long, long * 2 ** rng.uniform(-4, 0)]) @ turn(b)
    levels = PYRAMIDS[ratio]
    tri, nearest, margin = trilinear(levels, ratio, u, v, j, mode)
    mean, other = ewa(levels, ratio, u, v, j, anisotropy, pad)
    if min(margin, other) < 1e-4:
        continue
    out["lookups"].append(dict(ratio=ratio, anisotropy=anisotropy, border=border, u=u, v=v, j=j.ravel().tolist(), trilinear=tri, nearest=nearest, ewa=mean))

# A wave of 60 + 50 cos(2π(f·(x, y))) texels, seen through ellipses of which level 0 holds all: axes of √12 · 0.85 to √12 · 1.02 texels and longer.
SIDE = 96
out["waves"] = {"side": SIDE, "cases": []}
for _ in range(40):
    f = rng.uniform(-0.12, 0.12, 2)
    u, v = rng.uniform(44, 52, 2)
    t = rng.uniform(0, 2 * np.pi)
    axes = np.array([rng.uniform(1.3, 3.0), 1]) * rng.uniform(0.85, 1.02)
    turn = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    jacobian = turn @ np.diag(axes) * np.sqrt(12)
    k = 2 * np.pi * np.linalg.norm(np.sqrt(8) * np.diag(axes) @ turn.T @ f)
    wave = 60 + 50 * 48 * jv(3, k) / k**3 * np.cos(2 * np.pi * f @ [u, v])
    out["waves"]["cases"].append(dict(f=f.tolist(), u=u, v=v, j=jacobian.ravel().tolist(), mean=wave))
print(json.dumps(out))
