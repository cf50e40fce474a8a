# Python 3, numpy 2.4.6, scipy 1.17.1: python area_tables.py > area_tables.json
"""Means over rectangles and under boxes convolved with boxes, texel by texel on padded pictures; volumes between their levels.

"rectangle": shares of texels that a rectangle covers. "strips": rectangles around pieces of the parallelogram. "repeated": weights
by numpy.convolve, interpolated between whole positions. "volume": scipy.ndimage.map_coordinates of order 1 in two levels that are
means of overlaps. Positions count from the picture's corner.
"""
import json

import numpy as np
from scipy.ndimage import map_coordinates

rng = np.random.default_rng(11)
H, W = 23, 31
picture = rng.integers(0, 256, (H, W)).astype(np.float64)
CONSTANT = 40.0
PAD = 400
BORDERS = {
    "constant": (dict(mode="constant", constant_values=CONSTANT), "grid-constant"),
    "clamp": (dict(mode="edge"), "nearest"),
    "repeat": (dict(mode="wrap"), "grid-wrap"),
    "mirror": (dict(mode="symmetric"), "reflect"),
}
padded = {name: np.pad(picture, PAD, **pad) for name, (pad, _) in BORDERS.items()}


def shares(start, end, n):
    edges = np.arange(n + 2 * PAD + 1) - PAD
    return np.maximum(np.minimum(edges[1:], end) - np.maximum(edges[:-1], start), 0)


def mean(border, u, v, width, height):
    x = shares(u - width / 2, u + width / 2, W)
    y = shares(v - height / 2, v + height / 2, H)
    assert abs(x.sum() - width) < 1e-9 and abs(y.sum() - height) < 1e-9
    return y @ padded[border] @ x / (width * height)


def strips(border, u, v, j, most):
    (us, ul), (vs, vl) = j
    around = max(abs(us) + abs(ul), 1) * max(abs(vs) + abs(vl), 1)
    n = int(np.clip(np.ceil(around / max(abs(np.linalg.det(j)), 1)), 1, max(most, 1)))
    columns = sorted((j[:, 0], j[:, 1]), key=np.linalg.norm, reverse=True)
    size = np.maximum(np.abs(columns[0]) / n + np.abs(columns[1]), 1)
    at = [np.array([u, v]) + ((k + 0.5) / n - 0.5) * columns[0] for k in range(n)]
    return float(np.mean([mean(border, *p, *size) for p in at]))


def spline(order, at, squared, n):
    width = int(np.clip(np.round(np.sqrt(max(1, 1 + (squared - 2) / order))), 1, (n - 1) // order + 1))
    weights = np.ones(1)
    for _ in range(order):
        weights = np.convolve(weights, np.ones(width) / width)
    first = at - len(weights) / 2
    start = int(np.floor(first))
    all = np.zeros(n + 2 * PAD)
    for shift, share in ((0, 1 - (first - start)), (1, first - start)):
        all[start + shift + PAD : start + shift + PAD + len(weights)] += share * weights
    return all


def overlap(n, m):
    edges = np.arange(m + 1) * n / m
    low, high = np.maximum(edges[:-1, None], np.arange(n)), np.minimum(edges[1:, None], np.arange(n) + 1)
    return np.maximum(high - low, 0) * m / n


D = [5, 6, 9]
volume = [rng.integers(0, 256, D).astype(np.float64)]
while volume[-1].size > 1:
    fine = volume[-1]
    a, b, c = (overlap(n, max(1, n // 2)) for n in fine.shape)
    volume.append(np.einsum("ai,bj,ck,ijk->abc", a, b, c, fine))

out = {"width": W, "samples": picture.ravel().astype(int).tolist(), "cases": [], "volume": {"size": D[::-1], "samples": volume[0].ravel().astype(int).tolist(), "cases": []}}
for n in range(120):
    border = list(BORDERS)[n % 4]
    most = int(rng.choice([0, 1, 4, 16]))
    j = rng.normal(size=(2, 2)) * 2 ** rng.uniform(-2, 4)
    u, v = rng.uniform(-12, W + 12), rng.uniform(-12, H + 12)
    if n % 3 == 0:
        u, v = W / 2 + rng.uniform(-3, 3), H / 2 + rng.uniform(-3, 3)
    width, height = np.maximum(np.abs(j).sum(axis=1), 1)
    case = dict(border=border, u=u, v=v, j=j.ravel().tolist(), most=most)
    case["rectangle"] = mean(border, u, v, width, height)
    case["strips"] = strips(border, u, v, j, most)
    squared = (j**2).sum(axis=1)
    case["repeated"] = [float(spline(o, v, squared[1], H) @ padded[border] @ spline(o, u, squared[0], W)) for o in (1, 2, 3)]
    out["cases"].append(case)
    at = [rng.uniform(-3, d + 3) for d in D]
    size = 2 ** rng.uniform(-1, 5)
    texel = max(1, size / np.sqrt(3))
    level = min(int(np.log2(texel)), len(volume) - 1)
    share = np.clip(texel / 2**level - 1, 0, 1)

    def look(level):
        a = volume[level]
        at_level = [[x * m / d - 0.5] for x, m, d in zip(at, a.shape, D)]
        return map_coordinates(a, at_level, order=1, mode=BORDERS[border][1], cval=CONSTANT)[0]

    value = (1 - share) * look(level) + share * look(min(level + 1, len(volume) - 1))
    out["volume"]["cases"].append(dict(border=border, at=at[::-1], size=size, value=value))
print(json.dumps(out))
