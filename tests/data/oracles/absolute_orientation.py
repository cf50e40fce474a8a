# Python 3, numpy 2.4.6, scipy 1.17.1, mpmath: python absolute_orientation.py > absolute_orientation.json
"""Similarities by nonlinear least squares over ω-φ-κ, not by the closed form: minima by scipy, brought to rounding by Gauss-Newton
in 40 digits with numerical derivatives, cofactors from the same Jacobian."""
import json
import sys

import mpmath as mp
import numpy as np
from scipy.optimize import least_squares

mp.mp.dps = 40
rng = np.random.default_rng(5)


def rotation(w, p, k, m=np):
    """M of the textbook: turns the control frame into the arbitrary one; its transpose is used."""
    so, co, sp, cp, sk, ck = m.sin(w), m.cos(w), m.sin(p), m.cos(p), m.sin(k), m.cos(k)
    return [
        [cp * ck, so * sp * ck + co * sk, -co * sp * ck + so * sk],
        [-cp * sk, -so * sp * sk + co * ck, co * sp * sk + so * ck],
        [sp, -so * cp, co * cp],
    ]


def predict(q, x, m=np):
    s, w, p, k, tx, ty, tz = q
    r = rotation(w, p, k, m)
    return [s * sum(r[i][j] * x[i] for i in range(3)) + t for j, t in enumerate((tx, ty, tz))]


def solve(x, t, roots, held=None):
    """roots: for each point a 3x3 U with UᵀU = P."""
    n = len(x)
    center = x.mean(0)

    def residuals(q):
        q = np.insert(q, 0, held) if held else q
        return np.concatenate([u @ (b - np.array(predict(q, a - center))) for a, b, u in zip(x, t, roots)])

    best = None
    for start in range(24):
        s0 = [] if held else [np.linalg.norm(t - t.mean(0)) / np.linalg.norm(x - center)]
        q0 = np.concatenate([s0, rng.uniform(-3, 3, 3), t.mean(0)])
        scale = np.concatenate([[1.0] if not held else [], [1, 1, 1], [np.ptp(t)] * 3])
        f = least_squares(residuals, q0, x_scale=scale, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        if (held or f.x[0] > 0) and (best is None or f.cost < best.cost):
            best = f
    # In 40 digits.
    q = [mp.mpf(float(v)) for v in best.x]
    X = [[mp.mpf(float(c - m)) for c, m in zip(a, center)] for a in x]
    T = [[mp.mpf(float(c)) for c in b] for b in t]
    U = [[[mp.mpf(float(c)) for c in row] for row in u] for u in roots]

    def exact(q):
        q = ([mp.mpf(held)] if held else []) + list(q)
        out = []
        for a, b, u in zip(X, T, U):
            v = [bb - p for bb, p in zip(b, predict(q, a, mp))]
            out += [sum(u[i][j] * v[j] for j in range(3)) for i in range(3)]
        return mp.matrix(out)

    for _ in range(6):
        r = exact(q)
        j = mp.matrix(3 * n, len(q))
        for k in range(len(q)):
            h = mp.mpf(10) ** -18 * max(1, abs(q[k]))
            up, down = list(q), list(q)
            up[k] += h
            down[k] -= h
            d = (exact(up) - exact(down)) / (2 * h)
            for i in range(3 * n):
                j[i, k] = d[i]
        step = mp.lu_solve(j.T * j, -(j.T * r))
        q = [a + b for a, b in zip(q, step)]
    r = exact(q)
    cofactor = (j.T * j) ** -1
    full = ([mp.mpf(held)] if held else []) + q
    m = rotation(full[1], full[2], full[3], mp)
    skip = 0 if held else 1
    shift = cofactor[skip + 3, skip + 3]
    redundancy = 3 * n - len(q)
    vpv = sum(v * v for v in r)
    return {
        "scale": float(full[0]),
        "rotation": [[float(m[i][k]) for i in range(3)] for k in range(3)],
        "center": [float(v) for v in center],
        "to": [float(v) for v in full[4:]],
        "vpv": float(vpv),
        "sigma0": float(mp.sqrt(vpv / redundancy)) if redundancy else None,
        "scale_cofactor": None if held else float(cofactor[0, 0]),
        # Of the ground coordinates of the plain centroid.
        "center_cofactor": [[float(cofactor[skip + 3 + a, skip + 3 + b]) for b in range(3)] for a in range(3)],
        "angles_deg": [float(mp.degrees(v)) for v in full[1:4]],
        "origin": [float(v) for v in predict(full, [-mp.mpf(float(c)) for c in center], mp)],
    }


def case(name, x, t, sigmas, held=None, extra=(), covariances=None):
    x, t = np.array(x, float), np.array(t, float)
    if covariances is None:
        roots = [np.diag(1 / np.array(s)) for s in sigmas]
    else:
        roots = [np.linalg.cholesky(np.linalg.inv(c)).T for c in covariances]
    solution = solve(x, t, roots, held)
    out = {"name": name, "from": x.tolist(), "to": t.tolist(), "held": held, "solution": solution}
    if covariances is None:
        out["sigmas"] = [list(map(float, s)) for s in sigmas]
    else:
        out["covariances"] = [c.tolist() for c in covariances]
    q = [solution["scale"], *np.radians(solution["angles_deg"]), *solution["to"]]
    out["extra"] = [[list(map(float, e)), list(map(float, predict(q, np.array(e) - solution["center"])))] for e in extra]
    return out


one = lambda n, s=1.0: [[s] * 3] * n
cases = [
    # The sample data file of 3DCONF.c (Dewitt 1998, public domain), six common points and five to be transformed.
    case("3dconf", [[390.35, 499.63, 469.43], [371.68, 630.84, 81.25], [425.65, 419.07, 82.49], [410.50, 438.31, 81.13], [448.22, 295.83, 97.79], [414.60, 709.39, 101.77]],
         [[607.54, 501.63, 469.09], [589.98, 632.36, 82.81], [643.65, 421.28, 83.50], [628.58, 440.51, 82.27], [666.27, 298.16, 98.29], [632.59, 710.62, 103.01]],
         one(6), extra=[[611.37, 498.98, 470.45], [637.49, 323.67, 85.67], [573.32, 401.51, 84.48], [647.00, 373.97, 83.76], [533.51, 285.01, 87.13]]),
    # Ghilani, Adjustment Computations, example of the three-dimensional conformal transformation.
    case("ghilani", [[1094.883, 820.085, 109.821], [503.891, 1598.698, 117.685], [2349.343, 207.658, 151.387], [1395.320, 1348.853, 215.261]],
         [[10037.81, 5262.09, 772.04], [10956.68, 5128.17, 783.00], [8780.08, 4840.29, 782.62], [10185.80, 4700.21, 851.32]], one(4)),
    case("ghilani, scale held", [[1094.883, 820.085, 109.821], [503.891, 1598.698, 117.685], [2349.343, 207.658, 151.387], [1395.320, 1348.853, 215.261]],
         [[10037.81, 5262.09, 772.04], [10956.68, 5128.17, 783.00], [8780.08, 4840.29, 782.62], [10185.80, 4700.21, 851.32]], one(4), held=0.95),
    case("ghilani, weighted", [[1094.883, 820.085, 109.821], [503.891, 1598.698, 117.685], [2349.343, 207.658, 151.387], [1395.320, 1348.853, 215.261]],
         [[10037.81, 5262.09, 772.04], [10956.68, 5128.17, 783.00], [8780.08, 4840.29, 782.62], [10185.80, 4700.21, 851.32]],
         [[0.05, 0.06, 0.05], [0.04, 0.06, 0.09], [0.02, 0.04, 0.02], [0.03, 0.05, 0.03]]),
    # Wuhan: a model on ground control of millions of metres.
    case("map coordinates", [[-2.994926, 98.313214, -165.370335], [115.300090, 106.807568, -166.986144], [-10.104023, -76.494059, -165.102793], [116.937501, -79.779735, -162.042707], [-19.486363, 13.056943, -160.562998], [90.631173, 7.206584, -166.162713]],
         [[27313.512, 2700167.702, 103.95], [28500.938, 2700184.416, 97.35], [27141.968, 2698422.955, 101.994], [28409.856, 2698319.64, 155.804], [27102.439, 2699324.44, 163.29], [28197.742, 2699201.833, 100.0]],
         [[s] * 3 for s in (0.5, 1, 2, 0.3, 1, 1.5)]),
]
c = [np.diag([1.0, 2, 0.1]) + 0.2 * np.ones((3, 3)), np.diag([0.3, 0.5, 4.0]) - 0.1, np.diag([1.0, 1, 1]) + 0.5, np.diag([2.0, 0.2, 0.6])]
x = rng.uniform(-50, 50, (4, 3)).round(2)
r = np.array(rotation(2.0, -1.0, 0.5)).T
cases.append(case("covariances", x, (3.0 * x @ r.T + [10, 20, -30] + rng.normal(size=(4, 3))).round(2), None, covariances=c))
# Mirrored by noise: three points near a line, the fourth side of theirs seen from the other side.
x = np.array([[0, 0, 0], [10, 0, 0.0], [0, 10, 0], [10, 10, 0.02]])
cases.append(case("mirrored by noise", x, (x * [1, 1, -1] @ np.array(rotation(0.3, 0.2, 0.1)) + 5).round(6), one(4)))
json.dump({"cases": cases}, sys.stdout, separators=(",", ":"))
