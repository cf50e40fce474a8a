# Python 3, numpy 2.4.6, scipy 1.17.1. Prints tests/data/oracles/registration.json.
"""Oracles for registration: leave-one-out residuals of every model, each by a refit with numpy or scipy.

affine, bilinear, quadratic, cubic: numpy.linalg.lstsq in centred and scaled coordinates. projective: scipy.optimize.
least_squares on the distances in the texture. piecewise: LinearNDInterpolator, CloughTocher2DInterpolator (gradients to
1e-15). thin plates: RBFInterpolator. residual = texture point - prediction; null where the interpolator gives NaN.
"""
import json

import numpy as np
import scipy
from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator, RBFInterpolator
from scipy.optimize import least_squares

TERMS = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (0, 3)]
rng = np.random.default_rng(11)
N = 24
screen = rng.uniform((0, 0), (900, 700), (N, 2)).round(2)
x, y = screen.T
w = 1 + 2e-4 * x + 1e-4 * y
texture = np.stack([
    (1.2 * x + 0.1 * y + 30) / w + 3 * np.sin(x / 150) + rng.normal(0, 0.5, N),
    (0.9 * y - 0.05 * x + 10) / w + 3 * np.cos(y / 130) + rng.normal(0, 0.5, N),
], 1).round(3)


def polynomial(terms):
    def basis(p):
        q = (p - [450, 350]) / 450
        return np.stack([q[:, 0] ** i * q[:, 1] ** j for i, j in TERMS[:terms]], 1)

    def fit(s, t):
        c = np.linalg.lstsq(basis(s), t, rcond=None)[0]
        return lambda p: basis(p) @ c
    return fit


def projective(s, t):
    def apply(h, p):
        q = (p - [450, 350]) / 450
        d = 1 + q @ h[6:8]
        return np.stack([(h[0] + q @ h[1:3]) / d, (h[3] + q @ h[4:6]) / d], 1) * 450

    start = np.zeros(8)
    a = polynomial(3)(s, t)
    o = a(np.array([[450.0, 350.0]]))[0] / 450
    start[[0, 3]] = o
    start[[1, 4]] = (a(np.array([[900.0, 350.0]]))[0]) / 450 - o
    start[[2, 5]] = (a(np.array([[450.0, 800.0]]))[0]) / 450 - o
    r = least_squares(lambda h: (apply(h, s) - t).ravel(), start, xtol=1e-15, ftol=1e-15, gtol=1e-15, method="lm")
    return lambda p: apply(r.x, p)


MODELS = {
    "affine": polynomial(3), "projective": projective, "bilinear": polynomial(4), "quadratic": polynomial(6),
    "cubic": polynomial(10),
    "piecewise affine": lambda s, t: LinearNDInterpolator(s, t),
    "piecewise cubic": lambda s, t: CloughTocher2DInterpolator(s, t, tol=1e-15, maxiter=100000),
    "thin plate": lambda s, t: RBFInterpolator(s, t, kernel="thin_plate_spline"),
    "thin plate, λ = 20000": lambda s, t: RBFInterpolator(s, t, kernel="thin_plate_spline", smoothing=20000.0),
}


def listed(r):
    return [None if np.isnan(v).any() else v.tolist() for v in r]


def cross(fit, folds):
    out = np.full((N, 2), np.nan)
    for k in range(folds):
        left = np.arange(N) % folds == k
        out[left] = texture[left] - fit(screen[~left], texture[~left])(screen[left])
    return listed(out)


print(json.dumps({
    "versions": {"numpy": np.__version__, "scipy": scipy.__version__},
    "screen": screen.tolist(), "texture": texture.tolist(),
    "models": {n: {"fit": listed(texture - f(screen, texture)(screen)), "leave_one_out": cross(f, N), "five": cross(f, 5)}
               for n, f in MODELS.items()},
}))
