# Python 3, numpy 2.4.6, mpmath: python relative_orientation.py > relative_orientation.json
"""Relative orientations as bundle adjustments: all image coordinates observed, the model points unknowns, in 30 digits with numerical
derivatives. Camera axes x right, y down, z forward."""
import json
import sys

import mpmath as mp
import numpy as np

mp.mp.dps = 30
rng = np.random.default_rng(21)


def exp(w):
    t = mp.sqrt(sum(c * c for c in w))
    k = mp.matrix([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    if t == 0:
        return mp.eye(3)
    return mp.eye(3) + mp.sin(t) / t * k + (1 - mp.cos(t)) / t**2 * k * k


def project(cam, x):
    f, g, cx, cy = (mp.mpf(c) for c in cam)
    return [f * x[0] / x[2] + cx, g * x[1] / x[2] + cy]


def solve(cams, first, second, covariances, r, b, points):
    n = len(first)
    roots = []
    for c in covariances:
        u = np.linalg.cholesky(np.linalg.inv(np.array(c))).T
        roots.append([[mp.mpf(float(v)) for v in row] for row in u])
    r = mp.matrix(r.tolist())
    b = mp.matrix([mp.mpf(float(c)) for c in b])
    pts = [[mp.mpf(float(c)) for c in p] for p in points]

    def axes(b):
        k = min(range(3), key=lambda i: abs(b[i]))
        e = mp.matrix([mp.mpf(int(i == k)) for i in range(3)])
        cross = lambda p, q: mp.matrix([p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]])
        u = cross(b, e)
        u = u / mp.norm(u)
        return u, cross(b, u)

    def state(q):
        u, v = axes(b)
        bb = b + u * q[0] + v * q[1]
        bb = bb / mp.norm(bb)
        rr = exp(q[2:5]) * r
        pp = [[c + d for c, d in zip(p, q[5 + 3 * i : 8 + 3 * i])] for i, p in enumerate(pts)]
        return bb, rr, pp

    def pair(i, bb, rr, p):
        d = rr * (mp.matrix(p) - bb)
        out = []
        for side, (cam, x, t) in enumerate(((cams[0], p, first[i]), (cams[1], d, second[i]))):
            s = project(cam, x)
            v = [mp.mpf(float(a)) - c for a, c in zip(t, s)]
            w = roots[2 * i + side]
            out += [w[0][0] * v[0] + w[0][1] * v[1], w[1][0] * v[0] + w[1][1] * v[1]]
        return out

    h = mp.mpf(10) ** -12
    for _ in range(25):
        u0 = 5 + 3 * n
        j, res = mp.zeros(4 * n, u0), mp.zeros(4 * n, 1)
        zero = [mp.mpf(0)] * u0
        base = state(zero)
        for i in range(n):
            v = pair(i, base[0], base[1], base[2][i])
            for a in range(4):
                res[4 * i + a] = v[a]
        for k in range(u0):
            up, down = list(zero), list(zero)
            up[k], down[k] = h, -h
            su, sd = state(up), state(down)
            for i in range(n) if k < 5 else [(k - 5) // 3]:
                d = [(a - c) / (2 * h) for a, c in zip(pair(i, su[0], su[1], su[2][i]), pair(i, sd[0], sd[1], sd[2][i]))]
                for a in range(4):
                    j[4 * i + a, k] = d[a]
        normal = j.T * j
        step = mp.lu_solve(normal, -(j.T * res))
        last = max(abs(s) for s in step)
        # Halved until it helps.
        cost, factor = sum(v * v for v in res), mp.mpf(1)
        while factor > mp.mpf(10) ** -4:
            nxt = state([factor * s for s in step])
            c = sum(sum(v * v for v in pair(i, nxt[0], nxt[1], nxt[2][i])) for i in range(n))
            if c < cost or last < mp.mpf(10) ** -8:
                break
            factor /= 2
        b, r, pts = nxt
        if last < mp.mpf(10) ** -18:
            break
    assert last < mp.mpf(10) ** -13, last
    q = normal**-1
    u, v = axes(b)
    t = mp.zeros(3, 2)
    for i in range(3):
        t[i, 0], t[i, 1] = u[i], v[i]
    qb, qd, qbd = t * q[:2, :2] * t.T, q[2:5, 2:5], t * q[:2, 2:5]
    vpv = sum(x * x for x in res)
    m = lambda a: [[float(a[i, k]) for k in range(3)] for i in range(3)]
    return {"rotation": m(r), "base": [float(c) for c in b], "vpv": float(vpv), "sigma0": float(mp.sqrt(vpv / (n - 5))) if n > 5 else None,
            "base_cofactor": m(qb), "turn_cofactor": m(qd), "mixed_cofactor": m(qbd), "points": [[float(c) for c in p] for p in pts]}


def photo(f, pairs, scale):
    """Photo millimetres, y up, to camera axes."""
    l = np.array([[p[0], -p[1]] for p in pairs])
    r = np.array([[p[2], -p[3]] for p in pairs])
    points = [[a[0] / (a[0] - c[0]), a[1] / (a[0] - c[0]), f / (a[0] - c[0])] for a, c in zip(l, r)]
    one = [np.eye(2).tolist()] * (2 * len(pairs))
    cam = [f, f, 0.0, 0.0]
    # Uphill at first: the model from the parallax in x of a vertical pair.
    return {"cameras": [cam, cam], "first": l.tolist(), "second": r.tolist(), "covariances": one,
            "solution": solve([cam, cam], l.tolist(), r.tolist(), one, np.eye(3), np.array([1.0, 0, 0]), points)}


# The sample data file of relor.c (Dewitt 1998, public domain).
relor = photo(152.113, [(-4.878, 1.974, -97.920, -2.923), (89.307, 2.709, -1.507, -1.856), (0.261, 84.144, -90.917, 78.970), (90.334, 83.843, -1.571, 79.470), (-4.668, -86.821, -100.060, -95.748), (88.599, -85.274, -0.965, -94.319)], 1)
# A stereo pair of Wuhan university's exercise (AP-Project on GitHub); the left picture is the one farther along x.
wuhan = photo(153.84, [(5.45597, 5.11948, -83.37016, 5.26008), (-3.52725, -80.96330, -93.50881, -81.36958), (94.20260, -89.32610, 5.46940, -89.77844), (91.47099, 72.92113, 2.85409, 73.64957), (101.62147, -83.74249, 12.92799, -84.17112), (-4.53184, 72.22426, -94.22080, 73.01447), (36.28735, -70.16633, -52.66866, -70.52237)], 1)
cases = [relor, wuhan]
for n, noise, turn in [(8, 0.5, 0.3), (15, 2.0, 1.0), (12, 0.0, 0.4)]:
    cams = [[1000.0, 1010.0, 500.0, 400.0], [1200.0, 1190.0, 610.0, 390.0]]
    x = rng.uniform(-1, 1, (n, 3)) * [2, 1.5, 1.5] + [0, 0, 5]
    b = rng.normal(size=3) * [1, 1, 0.4]
    b /= np.linalg.norm(b)
    w = rng.normal(size=3) * turn * [0.2, 0.2, 1]
    r = np.array(exp([mp.mpf(float(c)) for c in w]).tolist(), float)
    first, second, covariances = [], [], []
    for p in x:
        d = r @ (p - b)
        s = [[float(c) for c in project(cams[0], p)], [float(c) for c in project(cams[1], d)]]
        for k, out in enumerate((first, second)):
            t = np.array(s[k]) + noise * rng.normal(size=2)
            out.append([round(float(c), 3) for c in t] if noise else [float(c) for c in t])
            covariances.append((np.diag(rng.uniform(0.3, 2, 2)) + 0.1).tolist())
    cases.append({"cameras": cams, "first": first, "second": second, "covariances": covariances, "solution": solve(cams, first, second, covariances, r, b, x)})
json.dump({"cases": cases}, sys.stdout, separators=(",", ":"))
