# Python 3, numpy 2.4.6, scipy 1.17.1, mpmath 1.3.0. Prints tests/data/oracles/thin_plate.json.
"""Oracles for the thin-plate spline.

values: scipy.interpolate.RBFInterpolator, kernel thin_plate_spline, for several smoothings; and the dense system of
n + 3 equations solved by mpmath in 40 digits in raw coordinates (no centring, no scaling), with its slopes by mpmath.diff.
far: the same points 4 million pixels away, by mpmath.
"""
import json

import mpmath as mp
import numpy as np
import scipy
from scipy.interpolate import RBFInterpolator

mp.mp.dps = 40


def solve(screen, texture, smoothing):
    n = len(screen)
    s = [[mp.mpf(c) for c in p] for p in screen]

    def phi(r2):
        return r2 * mp.log(r2) / 2 if r2 else mp.mpf(0)

    a = mp.zeros(n + 3)
    for i in range(n):
        for j in range(n):
            a[i, j] = phi((s[i][0] - s[j][0]) ** 2 + (s[i][1] - s[j][1]) ** 2)
        a[i, i] += mp.mpf(smoothing)
        for k, c in enumerate((mp.mpf(1), s[i][0], s[i][1])):
            a[i, n + k] = a[n + k, i] = c
    w = [mp.lu_solve(a, mp.matrix([mp.mpf(t[c]) for t in texture] + [0, 0, 0])) for c in (0, 1)]

    def f(c, x, y):
        total = w[c][n] + w[c][n + 1] * x + w[c][n + 2] * y
        return total + sum(w[c][i] * phi((x - s[i][0]) ** 2 + (y - s[i][1]) ** 2) for i in range(n))

    return f


def case(seed, n, smoothing, shift):
    rng = np.random.default_rng(seed)
    screen = rng.uniform((0, 0), (640, 480), (n, 2)).round(3) + shift
    x, y = (screen - shift).T
    texture = np.stack([
        1.1 * x - 0.1 * y + 20 * np.sin(x / 90) * np.cos(y / 70),
        0.05 * x + 0.9 * y + 3e-4 * (x - 300) * (y - 200) + rng.normal(0, 2, n),
    ], 1).round(4)
    f = solve(screen, texture, smoothing)
    scipy_f = RBFInterpolator(screen, texture, kernel="thin_plate_spline", smoothing=smoothing)
    checks = []
    for p in rng.uniform((-200, -200), (840, 680), (8, 2)).round(2) + shift:
        q = [mp.mpf(c) for c in p]
        value = [f(c, *q) for c in (0, 1)]
        slope = [[mp.diff(lambda a, b: f(c, a, b), tuple(q), n) for n in ((1, 0), (0, 1))] for c in (0, 1)]
        checks.append({
            "screen": p.tolist(), "texture": [float(v) for v in value],
            "scipy": scipy_f(p[None])[0].tolist(),
            "jacobian": [float(v) for r in slope for v in r],
        })
    return {"screen": screen.tolist(), "texture": texture.tolist(), "smoothing": smoothing, "checks": checks}


def square():
    s = [(0, 1), (-1, 0), (0, -1), (1, 0)]
    f = solve(s, [(0, 0.75), (-1, 0.25), (0, -1.25), (1, 0.25)], 0)
    return {"screen": [0.5, 0.25], "texture": [float(f(c, mp.mpf(0.5), mp.mpf(0.25))) for c in (0, 1)]}


print(json.dumps({
    "versions": {"numpy": np.__version__, "scipy": scipy.__version__, "mpmath": mp.__version__},
    "square": square(),
    "cases": [case(1, 5, 0.0, 0), case(2, 25, 0.0, 0), case(3, 25, 400.0, 0), case(4, 20, 3e4, 0),
              case(5, 15, 10.0, 4194304.0)],
}, indent=1))
