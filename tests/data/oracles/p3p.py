# Python 3, mpmath 1.3.0 or later, numpy: python p3p.py > p3p.json
"""All poses from three points, in 60 digits: Grunert's quartic in d2/d1, its real roots with positive distances."""
import json

import mpmath as mp
import numpy as np

mp.mp.dps = 60
rng = np.random.default_rng(3)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    n = mp.sqrt(dot(a, a))
    return [x / n for x in a]


def poly(*c):
    """Coefficients, highest first."""
    return [mp.mpf(x) for x in c]


def add(p, q):
    n = max(len(p), len(q))
    p, q = [mp.mpf(0)] * (n - len(p)) + p, [mp.mpf(0)] * (n - len(q)) + q
    return [a + b for a, b in zip(p, q)]


def mul(p, q):
    out = [mp.mpf(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] += a * b
    return out


def scale(p, s):
    return [a * s for a in p]


def axes(u, v):
    a = unit(u)
    n = unit(cross(u, v))
    return [a, cross(n, a), n]


def solve(objects, directions, double=False):
    x = [[mp.mpf(float(c)) for c in p] for p in objects]
    b = [unit([mp.mpf(float(c)) for c in p]) for p in directions]
    a12, a13, a23 = (dot(sub(x[i], x[j]), sub(x[i], x[j])) for i, j in ((0, 1), (0, 2), (1, 2)))
    c12, c13, c23 = dot(b[0], b[1]), dot(b[0], b[2]), dot(b[1], b[2])
    n = poly(1, -2 * c12, 1)
    p = add(scale(n, (a23 - a13) / a12), poly(-1, 0, 1))
    d = poly(-2 * c23, 2 * c13)
    rest = add(poly(1), scale(n, -a13 / a12))
    quartic = add(add(mul(p, p), scale(mul(p, d), -2 * c13)), mul(mul(d, d), rest))
    roots = mp.polyroots(quartic, maxsteps=2000, extraprec=600)
    found = []
    for u in roots:
        if abs(mp.im(u)) > mp.mpf(10) ** (-20 if double else -40) * max(1, abs(u)):
            continue
        u = mp.re(u)
        v = mp.polyval(p, u) / mp.polyval(d, u)
        d1 = mp.sqrt(a12 / mp.polyval(n, u))
        if u <= 0 or v <= 0:
            continue
        seen = [[c * k for c in bi] for bi, k in zip(b, (d1, u * d1, v * d1))]
        fo = axes(sub(x[1], x[0]), sub(x[2], x[0]))
        fc = axes(sub(seen[1], seen[0]), sub(seen[2], seen[0]))
        r = [[sum(fc[k][i] * fo[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
        c = [x[0][j] - sum(r[i][j] * seen[0][i] for i in range(3)) for j in range(3)]
        found.append({"rotation": [[float(e) for e in row] for row in r], "center": [float(e) for e in c]})
    return found


def rotation(w):
    k = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    t = np.linalg.norm(w)
    return np.eye(3) + np.sin(t) / t * k + (1 - np.cos(t)) / t**2 * k @ k


def case(name, extent, distance, offset, shape=(1, 1, 1)):
    objects = np.round(offset + extent * rng.uniform(-1, 1, (3, 3)) * shape, 6)
    center = objects.mean(0) + distance * (lambda d: d / np.linalg.norm(d))(rng.normal(size=3))
    r = rotation(rng.normal(size=3))
    # Towards the points, of any length: what the camera sees, rounded.
    directions = [list(map(float, np.round(r @ (o - center) * f, 9))) for o, f in zip(objects, (1, 7, 0.2))]
    objects = [list(map(float, o)) for o in objects]
    return {"name": name, "object": objects, "directions": directions, "poses": solve(objects, directions)}


cases = []
for i in range(12):
    cases.append(case(f"general {i}", 1, 2 + 0.3 * i, 0))
for i in range(6):
    cases.append(case(f"among the points {i}", 3, 1, 0))
for i in range(4):
    cases.append(case(f"long lens {i}", 1, 10.0 ** (2 + i), 0))
for i in range(3):
    cases.append(case(f"map coordinates {i}", 300, 1000, np.array([3.5e6, 5.8e6, 400])))
for i in range(3):
    cases.append(case(f"slender {i}", 1, 4, 0, (1, 1e-3, 1e-3)))
# On the danger cylinder, in integers: the circle of radius 5 about the axis z, the centre at (3, 4, 10) above it.
objects = [[5.0, 0, 0], [-3.0, 4, 0], [0.0, -5, 0]]
directions = [[p[0] - 3, p[1] - 4, p[2] - 10] for p in objects]
danger = {"name": "danger cylinder", "object": objects, "directions": directions, "poses": solve(objects, directions, True)}
json.dump({"cases": cases, "danger": danger}, __import__("sys").stdout, indent=None, separators=(",", ":"))
