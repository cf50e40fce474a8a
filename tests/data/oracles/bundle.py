"""Bundle adjustments solved whole, with all unknowns in one matrix: Gauss-Newton with partial derivatives by complex steps.

Writes bundle.json. Run with numpy 2.x. Axes: x right, y down, z forward; pixel = f (1 + k1 s + k2 s^2) (X/Z, Y/Z) + (x0, y0)
with s = (X/Z)^2 + (Y/Z)^2; unknowns of a photograph: its centre and a left rotation vector.
"""
import json
import os

import numpy as np

rng = np.random.default_rng(4711)
here = os.path.dirname(os.path.abspath(__file__))


def exp(w):
    """Rotation of a vector, by its series: complex steps pass through."""
    k = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    out, term = np.eye(3, dtype=k.dtype), np.eye(3, dtype=k.dtype)
    for i in range(1, 30):
        term = term @ k / i
        out = out + term
    return out


def log(rot):
    """Rotation vector of a real rotation, from its skew part and its trace."""
    axis = 0.5 * np.array([rot[2, 1] - rot[1, 2], rot[0, 2] - rot[2, 0], rot[1, 0] - rot[0, 1]])
    sine = np.linalg.norm(axis)
    return axis if sine == 0 else axis * np.arctan2(sine, 0.5 * (np.trace(rot) - 1)) / sine


def log_near(rot, start):
    """Rotation vector of a complex-stepped rotation: Newton on exp(w) = rot from that of its real part."""
    w = start.astype(complex)
    for _ in range(6):
        off = exp(-w) @ rot
        w = w + 0.5 * np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]])
    return w


def look(centre, target):
    f = (target - centre) / np.linalg.norm(target - centre)
    r = np.cross(f, [0, 0, 1.0])
    r /= np.linalg.norm(r)
    return np.array([r, np.cross(f, r), f])


def project(rot, centre, cam, x):
    p = rot @ (x - centre)
    u = p[:2] / p[2]
    s = u @ u
    f, x0, y0, k1, k2 = cam
    return f * (1 + k1 * s + k2 * s * s) * u + np.array([x0, y0])


centres = [np.array([10 * np.cos(a), 10 * np.sin(a), 3 + 2 * np.sin(3 * a)]) for a in np.arange(6) * 1.047 + 0.2]
rots = [exp(rng.normal(0, 0.3, 1) * np.array([0, 0, 1.0])) @ look(c, rng.normal(0, 0.3, 3)) for c in centres]
points = rng.uniform(-2, 2, (24, 3))


class Block:
    """Unknowns: photographs (6 each), cameras' chosen parameters, points that are not fixed."""

    def __init__(self, name, chosen, shared, fixed=(), control=(), positions=(), distances=(), prior=None, attitudes=(), datum=None, groups=None):
        self.name, self.chosen, self.shared, self.fixed = name, chosen, shared, list(fixed)
        ncam = 1 if shared else len(centres)
        base = np.array([1000.0, 12.0, -7.0, -0.1, 0.02])
        truth = np.array([base + (0 if shared else i) * np.array([3.0, 0, 0, 0.002, -0.001]) for i in range(ncam)])
        self.of = [0] * 6 if shared else list(range(6))
        self.obs = []
        covs = [np.diag([0.25, 0.25]), np.array([[0.3, 0.1], [0.1, 0.4]])]
        for j, x in enumerate(points):
            for i in range(6):
                if (i * 7 + j * 3) % 5 == 0:
                    continue
                c = covs[1] if j % 4 == 1 else covs[0]
                noise = np.linalg.cholesky(c) @ rng.normal(size=2)
                self.obs.append((i, j, project(rots[i], centres[i], truth[self.of[i]], x) + noise, c))
        # Approximate values.
        self.centres = [c + rng.normal(0, 0.05, 3) for c in centres]
        self.rots = [exp(rng.normal(0, 0.01, 3)) @ r for r in rots]
        self.cams = truth.copy()
        step = np.array([4.0, 1.0, 1.0, 0.01, 0.005])
        for c in self.cams:
            for k in chosen:
                c[k] += step[k] * rng.normal()
        self.points = points + rng.normal(0, 0.03, points.shape)
        for j in self.fixed:
            self.points[j] = points[j]
        self.control = []
        for j in control:
            c = np.diag([1e-4, 1e-4, 4e-4])
            if j == 0:
                c = np.array([[1e-4, 3e-5, 0], [3e-5, 2e-4, -2e-5], [0, -2e-5, 1e-4]])
            given = points[j] + np.linalg.cholesky(c) @ rng.normal(size=3)
            self.points[j] = given
            self.control.append((j, given, c))
        self.positions = []
        for i in positions:
            lever = np.array([0.1, -0.2, 0.3])
            given = centres[i] + rots[i].T @ lever + rng.normal(0, 0.02, 3)
            self.positions.append((i, given, lever, 0.02))
        self.attitudes = []
        for i in attitudes:
            c = np.diag([1e-6, 1e-6, 4e-6])
            turn = np.linalg.cholesky(c) @ rng.normal(size=3) * (40 if i == 2 else 1)
            self.attitudes.append((i, exp(turn) @ rots[i], c))
        self.datum, self.groups, self.factors = datum, groups, np.ones(6)
        self.distances = [(a, b, np.linalg.norm(points[a] - points[b]) + rng.normal() * 0.002, 0.002) for a, b in distances]
        self.prior = prior
        self.start_f = self.cams[0][0]
        self.start = dict(
            centres=[c.tolist() for c in self.centres], rotations=[r.ravel().tolist() for r in self.rots],
            cameras=self.cams.tolist(), points=self.points.tolist())
        self.free = [j for j in range(len(points)) if j not in self.fixed]
        self.nc = 36 + len(chosen) * ncam
        self.n = self.nc + 3 * len(self.free)

    def moved(self, d):
        cams = self.cams.astype(d.dtype)
        for c in range(len(cams)):
            for k, p in enumerate(self.chosen):
                cams[c, p] = cams[c, p] + d[36 + c * len(self.chosen) + k]
        pts = self.points.astype(d.dtype)
        for k, j in enumerate(self.free):
            pts[j] = pts[j] + d[self.nc + 3 * k:self.nc + 3 * k + 3]
        cen = [c + d[6 * i:6 * i + 3] for i, c in enumerate(self.centres)]
        rot = [exp(d[6 * i + 3:6 * i + 6]) @ r for i, r in enumerate(self.rots)]
        return cen, rot, cams, pts

    def residuals(self, d):
        """Unweighted residuals, computed less observed, in order, with the covariances of each group."""
        cen, rot, cams, pts = self.moved(d)
        out = [project(rot[i], cen[i], cams[self.of[i]], pts[j]) - x for i, j, x, _ in self.obs]
        out += [pts[j] - g for j, g, _ in self.control]
        out += [cen[i] + rot[i].T @ lever - g for i, g, lever, _ in self.positions]
        for i, given, _ in self.attitudes:
            off = rot[i] @ given.T
            out.append(log_near(off, log(off.real)))
        out += [np.sqrt(np.sum((pts[a] - pts[b]) ** 2, keepdims=True)) - l for a, b, l, _ in self.distances]
        if self.prior:
            out.append(np.array([cams[0][0] - self.start_f]))
        return out

    def covariances(self):
        """Of each group of observed numbers, multiplied by the squared factor of its kind."""
        c = self.stated()
        return [v * self.factors[k] ** 2 for v, k in zip(c, self.kinds())]

    def kinds(self):
        """0 image points (the second half of the photographs 5 where kinds are told apart), 1 control points, 2 positions, 3 attitudes, 4 the rest."""
        k = [5 if self.groups and i >= 3 else 0 for i, *_ in self.obs] + [1] * len(self.control) + [2] * len(self.positions)
        k += [3] * len(self.attitudes) + [4] * len(self.distances)
        return k + [4] * bool(self.prior)

    def stated(self):
        c = [c for *_, c in self.obs] + [c for *_, c in self.control] + [s * s * np.eye(3) for *_, s in self.positions]
        c += [c for *_, c in self.attitudes]
        c += [np.array([[s * s]]) for *_, s in self.distances]
        if self.prior:
            c.append(np.array([[self.prior ** 2]]))
        return c

    def jacobian(self):
        h = 1e-30
        cols = []
        for k in range(self.n):
            d = np.zeros(self.n, complex)
            d[k] = 1j * h
            cols.append(np.concatenate(self.residuals(d)).imag / h)
        return np.array(cols).T

    def gauss_newton(self, most=50):
        """Residuals, design matrix and covariance matrix at the minimum."""
        covs = self.covariances()
        m = sum(len(c) for c in covs)
        sigma, at = np.zeros((m, m)), 0
        for c in covs:
            sigma[at:at + len(c), at:at + len(c)] = c
            at += len(c)
        white = np.linalg.inv(np.linalg.cholesky(sigma))
        for self.iterations in range(most):
            r = white @ np.concatenate(self.residuals(np.zeros(self.n))).real
            a = white @ self.jacobian()
            d = np.linalg.lstsq(a, -r, rcond=1e-9)[0]
            self.centres, self.rots, self.cams, self.points = self.moved(d)
            if np.abs(d).max() < 1e-12:
                break
        return np.concatenate(self.residuals(np.zeros(self.n))).real, self.jacobian(), sigma

    def reml(self):
        """Helmert's variance components by Fisher's scoring of the restricted likelihood, all unknowns in one matrix:
        S_gh = tr(W V_g W V_h), q_g = r' P V_g P r with W = P - P A (A'PA)^-1 A'P (Rao 1971, Koch 1986)."""
        for it in range(60):
            r, a, sigma = self.gauss_newton(3 if it else 50)
            p = np.linalg.inv(sigma)
            w = p - p @ a @ np.linalg.solve(a.T @ p @ a, a.T @ p)
            kinds = np.concatenate([[k] * len(c) for k, c in zip(self.kinds(), self.covariances())]).astype(int)
            used = sorted(set(kinds))
            v = [sigma * (kinds == g)[:, None] for g in used]
            s = np.array([[np.sum((w @ x) * (w @ y).T) for y in v] for x in v])
            q = np.array([(w @ r) @ x @ (w @ r) for x in v])
            step = np.linalg.solve(s, q)
            for g, f in zip(used, step):
                self.factors[g] *= np.sqrt(max(f, 0.05))
            if np.abs(step - 1).max() < 1e-9:
                return
        raise RuntimeError("variance components did not settle")

    def robust(self):
        """The least cost with a robust loss of the image points, by reweighted least squares from the minimum without: of Huber's and
        Cauchy's loss at one standard deviation."""
        keep = self.centres, self.rots, self.cams, self.points
        covs, out = self.covariances(), {}
        white = [np.linalg.inv(np.linalg.cholesky(c)) for c in covs]
        for name in ("huber", "cauchy"):
            self.centres, self.rots, self.cams, self.points = keep
            for it in range(400):
                rs = [w @ r.real for w, r in zip(white, self.residuals(np.zeros(self.n)))]
                s = np.array([r @ r for r in rs])
                weight = np.where(s <= 1, 1, 1 / np.sqrt(np.maximum(s, 1))) if name == "huber" else 1 / (1 + s)
                weight[len(self.obs):] = 1
                rho = np.where(s <= 1, s, 2 * np.sqrt(s) - 1) if name == "huber" else np.log1p(s)
                rho[len(self.obs):] = s[len(self.obs):]
                cost, at, a = 0.5 * rho.sum(), 0, self.jacobian()
                rows, right = [], []
                for w, r, c in zip(white, rs, weight):
                    rows.append(np.sqrt(c) * w @ a[at:at + len(w)])
                    right.append(np.sqrt(c) * r)
                    at += len(w)
                d = np.linalg.lstsq(np.concatenate(rows), -np.concatenate(right), rcond=1e-9)[0]
                self.centres, self.rots, self.cams, self.points = self.moved(d)
                if np.abs(d).max() < 1e-9:
                    break
            out[name] = cost
        self.centres, self.rots, self.cams, self.points = keep
        return out

    def solve(self):
        if self.groups:
            self.reml()
        r, a, sigma = self.gauss_newton()
        m = len(r)
        p = np.linalg.inv(sigma)
        cost = 0.5 * r @ p @ r
        normal = a.T @ p @ a
        given = bool(self.fixed or self.control or self.positions or self.attitudes)
        defect = 0 if given else (6 if self.distances else 7)
        if given:
            q = np.linalg.inv(normal)
        else:
            # Inner constraints over the points: the bordered system.
            b = np.zeros((self.n, defect))
            placing = self.free if self.datum is None else self.datum
            mid = self.points[placing].mean(axis=0)
            for k, j in enumerate(self.free):
                if j not in placing:
                    continue
                x, y, z = self.points[j] - mid
                g = np.array([[1, 0, 0, 0, z, -y, x], [0, 1, 0, -z, 0, x, y], [0, 0, 1, y, -x, 0, z]])
                b[self.nc + 3 * k:self.nc + 3 * k + 3] = g[:, :defect]
            whole = np.block([[normal, b], [b.T, np.zeros((defect, defect))]])
            # Two refinements: the border is poorly scaled.
            inv = np.linalg.inv(whole)
            inv = inv @ (2 * np.eye(len(inv)) - whole @ inv)
            inv = inv @ (2 * np.eye(len(inv)) - whole @ inv)
            q = inv[:self.n, :self.n]
        redundancy = m - self.n + defect
        s0 = np.sqrt(2 * cost / redundancy)
        qvv = sigma - a @ q @ a.T
        numbers = np.diag(qvv @ p)
        w = -(p @ r) / (s0 * np.sqrt(np.diag(p @ qvv @ p)))
        qs = q * s0 * s0
        print(self.name, self.iterations, cost, redundancy, s0, numbers.sum())
        k = len(self.chosen)
        return dict(
            name=self.name, chosen=self.chosen, shared=self.shared, start=self.start, fixed=self.fixed,
            observations=[[i, j, *x.tolist(), *c.ravel().tolist()] for i, j, x, c in self.obs],
            control=[[j, *g.tolist(), *c.ravel().tolist()] for j, g, c in self.control],
            positions=[[i, *g.tolist(), *lever.tolist(), s] for i, g, lever, s in self.positions],
            attitudes=[[i, *g.ravel().tolist(), *c.ravel().tolist()] for i, g, c in self.attitudes],
            robust=self.robust() if self.name == "given" else None, datum=self.datum, groups=self.groups, factors=self.factors.tolist(),
            distances=[list(map(float, d)) for d in self.distances], prior=self.prior,
            cost=cost, redundancy=redundancy, unknowns=self.n, count=m, sigma0=s0,
            cameras=self.cams.tolist(), centres=[c.tolist() for c in self.centres], points=self.points.tolist(),
            redundancy_numbers=numbers.tolist(), w=w.tolist(),
            image_covariances=[qs[6 * i:6 * i + 6, 6 * i:6 * i + 6].ravel().tolist() for i in range(6)],
            camera_covariances=[qs[36 + c * k:36 + (c + 1) * k, 36 + c * k:36 + (c + 1) * k].ravel().tolist() for c in range(len(self.cams))],
            point_covariances=[qs[self.nc + 3 * i:self.nc + 3 * i + 3, self.nc + 3 * i:self.nc + 3 * i + 3].ravel().tolist() for i in range(len(self.free))])


cases = [
    Block("given", [0, 1, 2, 3], True, control=[0, 1, 2, 3], positions=[0, 1], distances=[(4, 5), (2, 7)], prior=3.0),
    Block("free with a distance", [0, 1, 2, 3], True, distances=[(4, 5)]),
    Block("free", [], True),
    Block("own cameras", [0, 3, 4], False, fixed=[0, 1, 2, 3]),
    Block("own cameras, four unknowns", [0, 1, 2, 3], False, control=[0, 1, 2, 3, 4]),
    Block("attitudes", [0, 3], True, control=[0, 5], positions=[0, 3, 4], attitudes=[0, 1, 2, 5]),
    Block("free, placed by points", [0, 3], True, datum=[3, 7, 8, 20]),
    Block("variances", [0], True, control=range(12), positions=range(6), attitudes=range(6), groups=True),
]
with open(os.path.join(here, "bundle.json"), "w") as f:
    json.dump([c.solve() for c in cases], f)
    f.write("\n")
