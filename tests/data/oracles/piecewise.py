# Python 3, numpy 2.4.6, scipy 1.17.1. Prints tests/data/oracles/piecewise.json.
"""Oracles for maps through control points piece by piece.

triangles: scipy.spatial.Delaunay (Qhull). affine: LinearNDInterpolator. cubic: CloughTocher2DInterpolator with its
gradients by _interpnd.estimate_gradients_2d_global iterated to 1e-15. grid: RegularGridInterpolator, method linear.
Versions are printed into the file.
"""
import json

import numpy as np
import scipy
from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator, RegularGridInterpolator
from scipy.interpolate._interpnd import estimate_gradients_2d_global
from scipy.spatial import Delaunay


def case(seed, n, queries):
    rng = np.random.default_rng(seed)
    screen = np.round(rng.uniform((0, 0), (640, 480), (n, 2)), 3)
    x, y = screen.T
    texture = np.stack([
        1.1 * x - 0.1 * y + 20 * np.sin(x / 90) * np.cos(y / 70),
        0.05 * x + 0.9 * y + 3e-4 * (x - 300) * (y - 200) + rng.normal(0, 2, n),
    ], 1).round(4)
    tri = Delaunay(screen)
    gradients = estimate_gradients_2d_global(tri, texture, 100000, 1e-15)
    linear = LinearNDInterpolator(tri, texture)
    cubic = CloughTocher2DInterpolator(tri, texture, tol=1e-15, maxiter=100000)
    points = np.round(rng.uniform((0, 0), (640, 480), (queries, 2)), 2)
    checks = []
    for p in points:
        a, c = linear(p)[0], cubic(p)[0]
        checks.append({
            "screen": p.tolist(),
            "affine": None if np.isnan(a).any() else a.tolist(),
            "cubic": None if np.isnan(c).any() else c.tolist(),
        })
    return {
        "screen": screen.tolist(), "texture": texture.tolist(),
        "triangles": sorted(sorted(int(i) for i in t) for t in tri.simplices),
        # row major: du/dS, du/dL, dv/dS, dv/dL
        "gradients": gradients.reshape(n, 4).tolist(),
        "checks": checks,
    }


def grid():
    rng = np.random.default_rng(9)
    xs, ys = -3.5 + 12.25 * np.arange(5), 100.0 + 7.5 * np.arange(4)
    nodes = np.round(rng.uniform(0, 900, (4, 5, 2)), 3)
    f = RegularGridInterpolator((ys, xs), nodes, method="linear")
    points = np.round(rng.uniform((xs[0], ys[0]), (xs[-1], ys[-1]), (12, 2)), 3)
    return {
        "origin": [xs[0], ys[0]], "spacing": [12.25, 7.5], "columns": 5, "nodes": nodes.reshape(-1, 2).tolist(),
        "checks": [{"screen": p.tolist(), "texture": f(p[::-1])[0].tolist()} for p in points],
    }


print(json.dumps({
    "versions": {"numpy": np.__version__, "scipy": scipy.__version__},
    "cases": [case(1, 12, 30), case(2, 60, 40)],
    "grid": grid(),
}, indent=1))
