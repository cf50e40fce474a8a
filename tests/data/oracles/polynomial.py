# Python 3, mpmath 1.3.0 (50 digits). Prints tests/data/oracles/polynomial.json.
"""Oracles for the polynomial maps and for the bilinear map seen in perspective.

fits: least squares by mpmath's QR at 50 digits on raw map coordinates of 10^6 (no centring, no scaling).
patches: (s, t) found by mpmath.findroot on the two bilinear equations of a pixel; the Jacobian by mpmath.diff of them.
"""
import json
import random

from mpmath import findroot, matrix, mp, mpf, qr_solve, sqrt

mp.dps = 50
random.seed(20)
TERMS = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (0, 3)]


def basis(n, x, y):
    return [mpf(x) ** i * mpf(y) ** j for i, j in TERMS[:n]]


def fit(n, points, seed):
    rng = random.Random(seed)
    east, north = 532_000.0, 5_271_000.0
    obj, img = [], []
    for _ in range(points):
        x, y = rng.uniform(0, 4000), rng.uniform(0, 3000)
        obj.append((round(east + x, 3), round(north + y, 3)))
        bend = 1e-5 * (x - 2000) * (y - 1500) + 2e-6 * (x - 1500) ** 2 - 1e-9 * (y - 1500) ** 3
        img.append((
            round(0.25 * x - 0.02 * y + bend + rng.gauss(0, 0.3), 4),
            round(700 - 0.24 * y + 0.01 * x + 0.5 * bend + rng.gauss(0, 0.3), 4),
        ))
    a = matrix([basis(n, *o) for o in obj])
    solutions, square = [], mpf(0)
    for c in (0, 1):
        x, _ = qr_solve(a, matrix([mpf(i[c]) for i in img]))
        solutions.append(x)
        square += sum((mpf(i[c]) - sum(b * k for b, k in zip(basis(n, *o), x))) ** 2 for o, i in zip(obj, img))
    checks = []
    for _ in range(4):
        p = (round(east + rng.uniform(0, 4000), 3), round(north + rng.uniform(0, 3000), 3))
        q = [float(sum(b * k for b, k in zip(basis(n, *p), s))) for s in solutions]
        checks.append({"object": p, "image": q})
    sigma0 = float(sqrt(square / (2 * points - 2 * n))) if points > n else None
    return {"terms": n, "object": obj, "image": img, "sigma0": sigma0, "checks": checks}


def patch(seed):
    rng = random.Random(seed)
    shift = 60_000.0 if seed % 2 else 0.0
    corners = []
    for x, y in ((0, 0), (300, 10), (320, 240), (-20, 200)):
        w = rng.uniform(0.7, 3.0)
        corners.append([(shift + x + rng.uniform(-30, 30)) * w, (y + rng.uniform(-30, 30)) * w, w])
    size = (64.0, 48.0)
    h = [[mpf(v) for v in c] for c in corners]

    def surface(s, t):
        return [
            (1 - s) * (1 - t) * h[0][i] + s * (1 - t) * h[1][i] + s * t * h[2][i] + (1 - s) * t * h[3][i]
            for i in range(3)
        ]

    checks = []
    for _ in range(5):
        s0, t0 = mpf(rng.uniform(0.05, 0.95)), mpf(rng.uniform(0.05, 0.95))
        x, y, w = surface(s0, t0)
        px, py = float(x / w), float(y / w)

        def solve(px, py):
            def f(s, t):
                x, y, w = surface(s, t)
                return x - px * w, y - py * w

            return findroot(f, (s0, t0), tol=mpf(10) ** -80)

        st = solve(mpf(px), mpf(py))
        e = mpf(10) ** -15
        jac = []
        for d in ((e, 0), (0, e)):
            p, m = solve(px + d[0], py + d[1]), solve(px - d[0], py - d[1])
            jac.append([float((p[0] - m[0]) / (2 * e) * size[0]), float((p[1] - m[1]) / (2 * e) * size[1])])
        checks.append({
            "screen": [px, py],
            "texture": [float(st[0] * size[0]), float(st[1] * size[1])],
            # rows u, v; columns x, y
            "jacobian": [[jac[0][0], jac[1][0]], [jac[0][1], jac[1][1]]],
        })
    return {"corners": corners, "size": size, "checks": checks}


print(json.dumps({
    "fits": [fit(4, 4, 1), fit(4, 9, 2), fit(6, 12, 3), fit(10, 24, 4)],
    "patches": [patch(s) for s in range(4)],
}, indent=1))
