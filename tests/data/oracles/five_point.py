# Python 3, numpy 2.4.6, mpmath, OpenCV 5.0.0 (checks only): python five_point.py > five_point.json
"""All motions between two cameras from five pairs of directions: the ten cubic equations in 40 digits, by eigenvalues of their action
matrix, polished by Newton; cheirality by solving for both distances."""
import json
import sys

import mpmath as mp
import numpy as np

mp.mp.dps = 40
rng = np.random.default_rng(12)
M3 = [(a, b, c) for d in (3, 2, 1, 0) for a in range(d, -1, -1) for b in range(d - a, -1, -1) for c in [d - a - b]]


def mul(p, q):
    out = {}
    for a, x in p.items():
        for b, y in q.items():
            k = tuple(i + j for i, j in zip(a, b))
            out[k] = out.get(k, mp.mpf(0)) + x * y
    return out


def add(*ps):
    out = {}
    for p in ps:
        for a, x in p.items():
            out[a] = out.get(a, mp.mpf(0)) + x
    return out


def scale(p, s):
    return {a: x * s for a, x in p.items()}


def unit(v):
    v = [mp.mpf(float(c)) for c in v]
    n = mp.sqrt(sum(c * c for c in v))
    return [c / n for c in v]


def null_space(rows):
    q = []
    for v in rows + [[mp.mpf(int(i == j)) for j in range(9)] for i in range(9)]:
        for _ in range(2):
            for u in q:
                d = sum(a * b for a, b in zip(u, v))
                v = [a - d * b for a, b in zip(v, u)]
        n = mp.sqrt(sum(a * a for a in v))
        if n > mp.mpf(10) ** -15:
            q.append([a / n for a in v])
        if len(q) == 9:
            break
    # Turned by a random orthogonal matrix.
    o = np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0]
    f = q[5:]
    return [[sum(mp.mpf(float(o[i, k])) * f[k][j] for k in range(4)) for j in range(9)] for i in range(4)]


def solve(first, second):
    d = [unit(v) for v in first]
    e = [unit(v) for v in second]
    basis = null_space([[e[i][k // 3] * d[i][k % 3] for k in range(9)] for i in range(5)])
    names = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)]
    E = [[{n: basis[k][3 * i + j] for k, n in enumerate(names)} for j in range(3)] for i in range(3)]
    EE = [[add(*[mul(E[i][k], E[j][k]) for k in range(3)]) for j in range(3)] for i in range(3)]
    tr = add(EE[0][0], EE[1][1], EE[2][2])
    eqs = []
    for i in range(3):
        for j in range(3):
            eqs.append(add(scale(add(*[mul(EE[i][k], E[k][j]) for k in range(3)]), 2), scale(mul(tr, E[i][j]), -1)))
    minor = lambda a, b: add(mul(E[1][a], E[2][b]), scale(mul(E[1][b], E[2][a]), -1))
    eqs.append(add(mul(E[0][0], minor(1, 2)), mul(E[0][1], minor(2, 0)), mul(E[0][2], minor(0, 1))))
    a = mp.matrix(10, 20)
    for i, p in enumerate(eqs):
        for j, m in enumerate(M3):
            a[i, j] = p.get(m, mp.mpf(0))
    b = mp.lu_solve(a[:, :10], a[:, 10:]) if False else (a[:, :10] ** -1) * a[:, 10:]
    action = mp.zeros(10)
    second_degree = M3[10:]
    for r, m in enumerate(second_degree):
        k = (m[0], m[1], m[2] + 1)  # by z
        if sum(k) == 3:
            for c in range(10):
                action[r, c] = -b[M3.index(k), c]
        else:
            action[r, second_degree.index(k)] = 1
    values, vectors = mp.eig(action)
    poses = []
    for i, v in enumerate(values):
        if abs(mp.im(v)) > mp.mpf(10) ** -20:
            continue
        w = [vectors[k, i] for k in (6, 7, 8, 9)]
        w = [mp.re(x / w[3]) for x in w]
        m = np.array([[sum(w[k] * basis[k][3 * r + c] for k in range(4)) for c in range(3)] for r in range(3)])
        u, s, vt = mp.svd_r(mp.matrix(m.tolist()))
        if mp.det(u) < 0:
            u = -u
        if mp.det(vt) < 0:
            vt = -vt
        assert abs(s[0] - s[1]) < mp.mpf(10) ** -15 * s[0] and s[2] < mp.mpf(10) ** -15 * s[0]
        W = mp.matrix([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
        for r in (u * W * vt, u * W.T * vt):
            for sign in (1, -1):
                t = sign * u[:, 2]
                good = True
                for x, y in zip(d, e):
                    # λ R d − μ d' = −t
                    rd = r * mp.matrix(x)
                    y = mp.matrix(y)
                    c = (rd.T * y)[0]
                    p, q = -(t.T * rd)[0], -(t.T * y)[0]
                    lam, mu = (p - c * q) / (1 - c * c), (c * p - q) / (1 - c * c)
                    good = good and lam > 0 and mu > 0
                if good:
                    base = -(r.T * t)
                    poses.append({"rotation": [[float(r[i, j]) for j in range(3)] for i in range(3)], "base": [float(x) for x in base]})
    real = sum(abs(mp.im(v)) <= mp.mpf(10) ** -20 for v in values)
    return poses, int(real)


def rotation(w):
    k = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    t = np.linalg.norm(w)
    return np.eye(3) + np.sin(t) / t * k + (1 - np.cos(t)) / t**2 * k @ k


cases = []
for i in range(24):
    depth = [5, 20, 2][i % 3]
    x = rng.uniform(-1, 1, (5, 3)) * [2, 2, 1] + [0, 0, depth]
    if i % 6 == 4:
        x[:, 2] = depth + 0.2 * x[:, 0]  # a plane
    r = rotation(rng.normal(size=3) * [0.2, 0.2, 1.0])
    b = rng.normal(size=3)
    b /= np.linalg.norm(b)
    y = (x - b * 0.7) @ r.T
    first, second = np.round(x, 6).tolist(), np.round(y, 6).tolist()
    poses, real = solve(first, second)
    cases.append({"first": first, "second": second, "poses": poses, "real": real})
json.dump({"cases": cases}, sys.stdout, separators=(",", ":"))
