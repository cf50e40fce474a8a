# Python 3, numpy 2.4.6, scipy 1.17.1, mpmath 1.3.0, OpenCV 5.0.0: python homography.py > homography.json
"""Homographies: forward images in 50 digits, least-squares optima, plane poses and decompositions."""
import json

import cv2
import mpmath as mp
import numpy as np
from scipy.optimize import least_squares

mp.mp.dps = 50
rng = np.random.default_rng(20)


def rounded(a, digits):
    return np.round(np.asarray(a, float), digits)


# --- four points in 50 digits -------------------------------------------------------------------------------------
def forward():
    cases = []
    for offset in (0.0, 1000.0):
        for _ in range(6):
            base = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
            source = rounded(offset + 100 * (base + rng.uniform(-0.3, 0.3, (4, 2))), 3)
            target = rounded(100 * (base + rng.uniform(-0.3, 0.3, (4, 2))), 3)
            a, b = mp.zeros(8, 8), mp.zeros(8, 1)
            for i in range(4):
                x, y, u, v = (mp.mpf(float(c)) for c in (*source[i], *target[i]))
                a[2 * i, :] = mp.matrix([[1, x, y, 0, 0, 0, -x * u, -y * u]])
                a[2 * i + 1, :] = mp.matrix([[0, 0, 0, 1, x, y, -x * v, -y * v]])
                b[2 * i], b[2 * i + 1] = u, v
            h = mp.lu_solve(a, b)
            points, images = [], []
            for _ in range(4):
                w = rng.dirichlet(np.ones(4))
                p = [float(c) for c in rounded(w @ source, 3)]
                x, y = mp.mpf(p[0]), mp.mpf(p[1])
                d = 1 + h[6] * x + h[7] * y
                points.append(p)
                images.append([float((h[0] + h[1] * x + h[2] * y) / d), float((h[3] + h[4] * x + h[5] * y) / d)])
            cases.append(dict(source=source.tolist(), target=target.tolist(), points=points, images=images))
    return cases


# --- least squares ------------------------------------------------------------------------------------------------
def apply(h, p):
    q = np.c_[p, np.ones(len(p))] @ np.asarray(h).reshape(3, 3).T
    return q[:, :2] / q[:, 2:]


def cost(x, local, image, scale, weights, kind):
    """Half the sum of losses in 50 digits."""
    h = mp.matrix(3, 3)
    for i in range(9):
        h[i // 3, i % 3] = (x[i] if i < 8 else mp.mpf(1)) / (scale if i % 3 < 2 else 1)
    g = h**-1 if kind == "symmetric" else None

    def distance2(m, p, q):
        a, b = mp.mpf(float(p[0])), mp.mpf(float(p[1]))
        w = m[2, 0] * a + m[2, 1] * b + m[2, 2]
        du = (m[0, 0] * a + m[0, 1] * b + m[0, 2]) / w - mp.mpf(float(q[0]))
        dv = (m[1, 0] * a + m[1, 1] * b + m[1, 2]) / w - mp.mpf(float(q[1]))
        return du * du + dv * dv

    total = mp.mpf(0)
    for p, q, weight in zip(local, image, weights):
        d2 = distance2(h, p, q)
        if kind == "huber" and d2 > mp.mpf("0.25"):
            d2 = mp.sqrt(d2) - mp.mpf("0.25")  # k (2 d − k), k = 1/2
        total += mp.mpf(float(weight)) * d2
        if g is not None:
            total += distance2(g, q, p)
    return total / 2


def optimum(x, *data):
    """The minimum near x, by three Newton steps with central differences in 50 digits."""
    x, e = [mp.mpf(float(v)) for v in x], mp.mpf(10) ** -14

    def at(*moves):
        y = list(x)
        for i, d in moves:
            y[i] += d
        return cost(y, *data)

    for _ in range(3):
        n = len(x)
        size = [e * max(1, abs(v)) for v in x]
        centre = at()
        up, down = [at((i, size[i])) for i in range(n)], [at((i, -size[i])) for i in range(n)]
        gradient, hessian = mp.matrix(n, 1), mp.matrix(n, n)
        for i in range(n):
            gradient[i] = (up[i] - down[i]) / (2 * size[i])
            hessian[i, i] = (up[i] - 2 * centre + down[i]) / size[i] ** 2
            for j in range(i):
                both = at((i, size[i]), (j, size[j])) - up[i] - up[j] + 2 * centre - down[i] - down[j]
                both += at((i, -size[i]), (j, -size[j]))
                hessian[i, j] = hessian[j, i] = both / (2 * size[i] * size[j])
        step = mp.lu_solve(hessian, gradient)
        x = [v - s for v, s in zip(x, step)]
    assert max(abs(s) / max(1, abs(v)) for s, v in zip(step, x)) < mp.mpf(10) ** -9
    return float(at())


def fits():
    cases = []
    for n, offset in ((6, 0.0), (20, 0.0), (100, 0.0), (30, 1e6)):
        truth = np.array([[30.0, 4.0, 900.0], [-3.0, 26.0, 700.0], [0.004, -0.003, 1.0]])
        # Multiples of 2⁻¹⁰, so that adding the offset is exact.
        local = np.round(rng.uniform(-50, 50, (n, 2)) * 1024) / 1024
        image = rounded(apply(truth, local) + rng.normal(0, 0.7, (n, 2)), 3)
        obj = local + np.array([offset, 4 * offset])
        weights = rounded(rng.uniform(0.3, 3.0, n), 2)
        scale = np.abs(local).max()
        unit = truth @ np.diag([scale, scale, 1.0])

        def matrix(x):
            return np.append(x, 1.0).reshape(3, 3) @ np.diag([1 / scale, 1 / scale, 1.0])

        def image_residuals(x, w=np.ones(n)):
            return ((apply(matrix(x), local) - image) * np.sqrt(w)[:, None]).ravel()

        def symmetric(x):
            h = matrix(x)
            return np.r_[image_residuals(x), (apply(np.linalg.inv(h), image) - local).ravel()]

        def huber(x, k=0.5):
            r = image_residuals(x).reshape(-1, 2)
            d = np.hypot(*r.T)
            rho = np.where(d <= k, d * d, k * (2 * d - k))
            return (r * (np.sqrt(rho) / d)[:, None]).ravel()

        start = (unit / unit[2, 2]).ravel()[:8]

        def solve(f):
            x = start
            for _ in range(3):
                x = least_squares(f, x, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale="jac").x
            return x

        best = solve(image_residuals)
        weighted = solve(lambda x: image_residuals(x, weights))
        sym, rob = solve(symmetric), solve(huber)
        jac = least_squares(image_residuals, best, method="lm", xtol=1e-15, max_nfev=1).jac
        # Covariance of the image of the object point (10, −20), from the eight parameters by central differences.
        def at(x):
            return apply(matrix(x), np.array([[10.0, -20.0]]))[0]
        g = np.array([(at(best + e) - at(best - e)) / 2e-5 for e in 1e-5 * np.eye(8)]).T
        j = np.array([(image_residuals(best + e) - image_residuals(best - e)) / 2e-5 for e in 1e-5 * np.eye(8)]).T
        cofactor = g @ np.linalg.inv(j.T @ j) @ g.T
        ocv, _ = cv2.findHomography(local, image, 0)
        half = lambda r: 0.5 * float(r @ r)
        scipy_cost = half(image_residuals(best))
        one = np.ones(n)
        costs = [
            optimum(start, local, image, mp.mpf(float(scale)), w, kind)
            for start, w, kind in ((best, one, "image"), (weighted, weights, "image"), (sym, one, "symmetric"), (rob, one, "huber"))
        ]
        cases.append(
            dict(
                object=obj.tolist(), image=image.tolist(), weights=weights.tolist(),
                cost=costs[0], weighted_cost=costs[1], symmetric_cost=costs[2], huber_cost=costs[3],
                scipy_cost=scipy_cost,
                opencv_cost=half((apply(ocv, local) - image).ravel()),
                point=[10.0 + offset, -20.0 + 4 * offset], image_of_point=at(best).tolist(), cofactor=cofactor.tolist(),
            )
        )
    return cases


# --- poses and decompositions -------------------------------------------------------------------------------------
def rotation(v):
    return cv2.Rodrigues(np.asarray(v, float))[0]


def poses():
    cases = []
    for _ in range(8):
        k = np.array([[rng.uniform(500, 3000), rng.uniform(-5, 5), 640.0], [0, rng.uniform(500, 3000), 480.0], [0, 0, 1]])
        r = rotation(rng.uniform(-1, 1, 3))
        t = np.array([rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(5, 20)])
        h = k @ np.c_[r[:, :2], t] * rng.uniform(0.1, 3)
        # A plane picture that is no rotation's: the nearest one by the singular value decomposition.
        m = np.c_[r[:, :2], t] + rng.uniform(-0.1, 0.1, (3, 3))
        u, sigma, vt = np.linalg.svd(m[:, :2], full_matrices=False)
        near, size = u @ vt, sigma.mean()
        cases.append(
            dict(
                k=k.tolist(), h=h.tolist(), rotation=r.tolist(), translation=t.tolist(),
                noisy=(k @ m).tolist(), nearest=np.c_[near, np.cross(near[:, 0], near[:, 1])].tolist(),
                nearest_translation=(m[:, 2] / size).tolist(), residual=float((sigma[0] - sigma[1]) / sigma.sum()),
            )
        )
    return cases


def motions():
    cases = []
    for i in range(8):
        k = np.array([[1200.0 + 10 * i, 0, 640.0], [0, 1190.0, 480.0], [0, 0, 1]])
        r = rotation(rng.uniform(-0.6, 0.6, 3))
        t = rng.uniform(-0.5, 0.5, 3)
        n = np.array([*rng.uniform(-0.6, 0.6, 2), 1.0])
        n /= np.linalg.norm(n)
        h = k @ (r + np.outer(t, n)) @ np.linalg.inv(k)
        count, rs, ts, ns = cv2.decomposeHomographyMat(h, k)
        cases.append(
            dict(
                k=k.tolist(), h=h.tolist(), rotation=r.tolist(), translation=t.tolist(), normal=n.tolist(),
                opencv=[
                    dict(rotation=a.tolist(), translation=b.ravel().tolist(), normal=c.ravel().tolist())
                    for a, b, c in zip(rs, ts, ns)
                ],
            )
        )
    return cases


print(json.dumps(dict(four_points=forward(), fits=fits(), poses=poses(), motions=motions()), indent=None))
