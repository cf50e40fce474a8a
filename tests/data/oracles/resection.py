# Python 3.11.7, numpy 2.4.6, scipy 1.17.1, mpmath 1.4.1, gmpy2 2.3.2: python resection.py > resection.json
"""Space resections: textbook cases and scenes, their optimum in 50 digits and what the theory of adjustment says of it.

Minima are sought by scipy from many starts and polished by Gauss-Newton in mpmath. The design matrix is the central difference
of the collinearity equations in 50 digits; Qvv = P^-1 - A Q A^T is formed whole.
"""
import json
import sys

import mpmath as mp
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

mp.mp.dps = 50
H = mp.mpf(10) ** -18
CRITICAL = mp.sqrt(2) * mp.erfinv(mp.mpf("0.999"))
DELTA0 = CRITICAL + mp.sqrt(2) * mp.erfinv(mp.mpf("0.6"))


# --- the collinearity equations, for any numbers ----------------------------------------------------------------------
def project(camera, extra, d, m):
    """The image of a direction in camera axes (x right, y down, z forward); m: the functions atan2, hypot."""
    fx = extra.get("f", camera["f"])
    fy = fx * camera["fy"] / camera["f"]
    kind = camera["kind"]
    if kind == "brown":
        x, y = d[0] / d[2], d[1] / d[2]
        k1 = extra.get("k1", camera["k1"])
        r2 = x * x + y * y
        x, y = x * (1 + k1 * r2), y * (1 + k1 * r2)
    elif kind == "fisheye":
        level = m.hypot(d[0], d[1])
        angle = m.atan2(level, d[2])
        x, y = angle * d[0] / level, angle * d[1] / level
    elif kind == "panorama":
        x, y = m.atan2(d[0], d[2]), m.atan2(d[1], m.hypot(d[0], d[2]))
    else:
        x, y = d[0] / d[2], d[1] / d[2]
    return fx * x + camera["x0"], fy * y + camera["y0"]


class Plain:
    hypot, atan2 = np.hypot, np.arctan2


class Fifty:
    hypot, atan2 = mp.hypot, mp.atan2


def turn(d):
    """exp([d]x) by Rodrigues, in 50 digits; to the third order where d is a step of a difference."""
    a = mp.sqrt(sum(v * v for v in d))
    k = mp.matrix([[0, -d[2], d[1]], [d[2], 0, -d[0]], [-d[1], d[0], 0]])
    s, c = (mp.sin(a) / a, (1 - mp.cos(a)) / a**2) if a > mp.mpf(10) ** -10 else (1 - a * a / 6, mp.mpf(1) / 2)
    return mp.eye(3) + s * k + c * k * k


def mpf(v):
    return mp.mpf(float(v))


class Scene:
    def __init__(self, name, camera, objects, images, cov=None, ocov=None, extra=(), loss=None, believe=False):
        self.name, self.camera = name, camera
        self.objects, self.images = np.asarray(objects, float), np.asarray(images, float)
        n = len(self.objects)
        self.cov = [np.eye(2)] * n if cov is None else [np.asarray(c, float) for c in cov]
        self.ocov = [None] * n if ocov is None else [None if c is None else np.asarray(c, float) for c in ocov]
        self.extra, self.loss, self.believe = list(extra), loss, believe  # extra: (name, start, sigma or None)

    # --- doubles: the starts ---
    def cost_rows(self, p, center, size):
        rotation = Rotation.from_rotvec(p[:3]).as_matrix()
        extra = {e[0]: v for e, v in zip(self.extra, p[6:])}
        d = ((self.objects - center) / size) @ rotation.T + p[3:6]
        xy = np.array(project(self.camera, extra, d.T, Plain)).T
        rows = []
        for v, c in zip(self.images - xy, self.cov):
            v = np.linalg.solve(np.linalg.cholesky(c), v)
            if self.loss:
                kind, k = self.loss
                s = v @ v / k**2
                rho = np.log1p(s) if kind == "cauchy" else (s if s <= 1 else 2 * np.sqrt(s) - 1)
                v = v * np.sqrt(rho / max(s, 1e-300))
            rows += list(v)
        for e, v in zip(self.extra, p[6:]):
            if e[2] is not None:
                rows.append((e[1] - v) / e[2])
        return np.array(rows)

    def minima(self, starts, rng):
        """Local minima with all points in front, best first: (cost, R, t about the centre)."""
        center = self.objects.mean(axis=0)
        size = np.sqrt(((self.objects - center) ** 2).sum(axis=1).mean())
        spread = np.sqrt(((self.images - self.images.mean(axis=0)) ** 2).sum(axis=1).mean())
        ray = (self.images.mean(axis=0) - [self.camera["x0"], self.camera["y0"]]) / self.camera["f"]
        found = []
        wide = self.camera["kind"] in ("fisheye", "panorama")
        for k in range(starts):
            vec = Rotation.random(random_state=rng).as_rotvec()
            if wide:
                t = rng.normal(0, 0.5, 3)
            else:
                z = self.camera["f"] / spread * rng.uniform(0.7, 1.6)
                t = np.array([ray[0] * z, ray[1] * z, z])
            p = np.r_[vec, t, [e[1] for e in self.extra]]
            try:
                with np.errstate(all="ignore"):
                    r = least_squares(lambda p: self.cost_rows(p, center, size), p, method="lm", x_scale="jac", xtol=1e-12, ftol=1e-14, max_nfev=600)
            except ValueError:
                continue
            rotation = Rotation.from_rotvec(r.x[:3]).as_matrix()
            depth = ((self.objects - center) / size) @ rotation[2] + r.x[5]
            if not wide and depth.min() <= 0:
                continue
            if np.abs(r.grad).max() > 1e-3 * max(1.0, r.cost):
                continue
            if not any(np.linalg.norm(rotation - f[1]) < 1e-3 for f in found):
                found.append((r.cost, rotation, r.x[3:6], r.x[6:]))
        found.sort(key=lambda f: f[0])
        return [(c, rot, center - size * rot.T @ t, e) for c, rot, t, e in found]

    # --- 50 digits ---
    def observe(self, center, rotation, extra, objects):
        out = []
        for x in objects:
            out += list(project(self.camera, extra, rotation * (mp.matrix(x) - center), Fifty))
        return out

    def names(self):
        return [e[0] for e in self.extra]

    def linearised(self, state):
        """v (observed minus computed), A, P with robust weights, in the order image, object for each point, then priors."""
        center, rotation, extra, objects = state
        n, u = len(objects), 6 + len(self.extra)
        base = self.observe(center, rotation, extra, objects)

        def at(k, h):
            c, r, e = center.copy(), rotation, dict(extra)
            if k < 3:
                c[k] += h
            elif k < 6:
                r = turn([h if i == k - 3 else mp.mpf(0) for i in range(3)]) * rotation
            else:
                e[self.extra[k - 6][0]] += h
            return self.observe(c, r, e, objects)

        columns = [[(a - b) / (2 * H) for a, b in zip(at(k, H), at(k, -H))] for k in range(u)]
        moved = [i for i in range(n) if self.ocov[i] is not None]
        total = u + 3 * len(moved)
        rows, v, blocks, s = [], [], [], []
        for i in range(n):
            p = mp.matrix(self.cov[i].tolist()) ** -1
            here = mp.matrix([mpf(self.images[i][j]) - base[2 * i + j] for j in range(2)])
            for j in range(2):
                rows.append([columns[k][2 * i + j] for k in range(u)] + [mp.mpf(0)] * (total - u))
                v.append(here[j])
            squared = (here.T * p * here)[0]
            if i in moved:  # a loss is of the whole point
                off = mp.matrix([mpf(a) - b for a, b in zip(self.objects[i], objects[i])])
                squared += (off.T * mp.matrix(self.ocov[i].tolist()) ** -1 * off)[0]
            weight = mp.mpf(1)
            if self.loss:
                kind, k = self.loss
                q = squared / mpf(k) ** 2
                weight = 1 / (1 + q) if kind == "cauchy" else (mp.mpf(1) if q <= 1 else 1 / mp.sqrt(q))
            blocks.append(p * weight)
            s.append((squared, weight))
            if i in moved:
                first = u + 3 * moved.index(i)
                for k in range(3):
                    x = list(objects[i])
                    sides = []
                    for h in (H, -H):
                        y = list(x)
                        y[k] += h
                        sides.append(self.observe(center, rotation, extra, [y]))
                    for j in range(2):
                        rows[-2 + j][first + k] = (sides[0][j] - sides[1][j]) / (2 * H)
                for k in range(3):
                    row = [mp.mpf(0)] * total
                    row[first + k] = mp.mpf(1)
                    rows.append(row)
                    v.append(mpf(self.objects[i][k]) - objects[i][k])
                blocks.append(mp.matrix(self.ocov[i].tolist()) ** -1 * weight)
        for k, (name, start, sigma) in enumerate(self.extra):
            if sigma is not None:
                row = [mp.mpf(0)] * total
                row[6 + k] = mp.mpf(1)
                rows.append(row)
                v.append(mpf(start) - extra[name])
                blocks.append(mp.matrix([[1 / mpf(sigma) ** 2]]))
        return v, rows, blocks, s

    @staticmethod
    def times(blocks, rows):
        """P times a list of rows."""
        out, at = [], 0
        for b in blocks:
            for i in range(b.rows):
                out.append([sum(b[i, j] * rows[at + j][k] for j in range(b.rows)) for k in range(len(rows[0]))])
            at += b.rows
        return out

    def solve(self, rotation, center, extra):
        rotation = mp.matrix(rotation.tolist())
        for _ in range(6):  # orthonormal to 50 digits (Newton for the polar factor)
            rotation = (rotation + (rotation.T) ** -1) / 2
        state = [mp.matrix([mpf(c) for c in center]), rotation, {n: mpf(v) for n, v in zip(self.names(), extra)}, [[mpf(c) for c in x] for x in self.objects]]
        moved = [i for i in range(len(self.objects)) if self.ocov[i] is not None]
        u = 6 + len(self.extra)
        for _ in range(400):
            v, rows, blocks, _ = self.linearised(state)
            pa = self.times(blocks, rows)
            total = len(rows[0])
            normal = mp.matrix(total, total)
            right = mp.matrix(total, 1)
            for i in range(total):
                right[i] = sum(pr[i] * x for pr, x in zip(pa, v))
                for j in range(i + 1):
                    normal[i, j] = normal[j, i] = sum(pr[i] * r[j] for pr, r in zip(pa, rows) if r[j] != 0)
            step = mp.lu_solve(normal, right)
            state[0] = state[0] + step[0:3]
            state[1] = turn(list(step[3:6])) * state[1]
            for k, n in enumerate(self.names()):
                state[2][n] += step[6 + k]
            for k, i in enumerate(moved):
                for c in range(3):
                    state[3][i][c] += step[u + 3 * k + c]
            decrease = (step.T * normal * step)[0]
            if decrease < mp.mpf(10) ** -44:
                break
        else:
            raise RuntimeError(f"{self.name}: {mp.nstr(decrease, 5)}")
        return state

    def result(self, minimum):
        _, rotation, center, extra = minimum
        state = self.solve(rotation, center, extra)
        v, rows, blocks, s = self.linearised(state)
        u, total, m = 6 + len(self.extra), len(rows[0]), len(rows)
        pa = self.times(blocks, rows)
        normal = mp.matrix(total, total)
        for i in range(total):
            for j in range(total):
                normal[i, j] = sum(pr[i] * r[j] for pr, r in zip(pa, rows))
        q = normal**-1
        pv = [r[0] for r in self.times(blocks, [[x] for x in v])]
        squares = sum(a * b for a, b in zip(v, pv))
        redundancy = m - total
        sigma0 = mp.sqrt(squares / redundancy) if redundancy else None
        sigma = mp.mpf(1) if self.believe or not redundancy else sigma0
        cost = squares
        if self.loss:
            kind, k = self.loss
            k2 = mpf(k) ** 2
            cost += sum((k2 * mp.log(1 + q2 / k2) if kind == "cauchy" else (q2 if q2 <= k2 else k2 * (2 * mp.sqrt(q2 / k2) - 1))) - q2 * w for q2, w in s)
        # T = P Qvv P = P - P A Q A^T P, a column at a time; only the diagonals of Qvv P and T are wanted.
        values, at = [], 0
        aq = [[sum(r[i] * q[i, j] for i in range(total) if r[i] != 0) for j in range(total)] for r in rows]
        for b in blocks:
            size = b.rows
            qvv = b**-1 - mp.matrix([[sum(aq[at + i][k] * rows[at + j][k] for k in range(total)) for j in range(size)] for i in range(size)])
            # Rows of Qvv outside the block count in T: (P Qvv P) of a block-diagonal P needs only the block.
            r, t = qvv * b, b * qvv * b
            for i in range(size):
                g = r[i, i]
                values.append([v[at + i], g, pv[at + i] / (sigma * mp.sqrt(t[i, i])), sigma * DELTA0 / mp.sqrt(t[i, i]), DELTA0 * mp.sqrt(max(0, (1 - g) / g))])
            at += size
        assert abs(sum(x[1] for x in values) - redundancy) < mp.mpf(10) ** -20
        sd = [sigma * mp.sqrt(q[i, i]) for i in range(u)]
        corr = [q[i, j] / mp.sqrt(q[i, i] * q[j, j]) for i in range(u) for j in range(i)]
        reduced = q[0:u, 0:u] ** -1
        unit = mp.matrix(u, u)
        for i in range(u):
            for j in range(u):
                unit[i, j] = reduced[i, j] / mp.sqrt(reduced[i, i] * reduced[j, j])
        condition = mp.mnorm(unit, 1) * mp.mnorm(unit**-1, 1)

        def f(x, digits=17):
            return float(mp.nstr(x, digits)) if x is not None else None

        return dict(
            center=[f(x) for x in state[0]], rotation=[f(state[1][i, j]) for i in range(3) for j in range(3)],
            extra=[f(state[2][n]) for n in self.names()], redundancy=redundancy, cost=f(cost / 2), squares=f(squares), sigma0=f(sigma0),
            sd=[f(x, 12) for x in sd], corr=[f(x, 12) for x in corr], condition=f(condition, 12), values=[[f(y, 12) for y in x] for x in values])

    def document(self, starts=60, others=0, values=True):
        rng = np.random.default_rng(sum(map(ord, self.name)))
        minima = self.minima(starts, rng)
        out = dict(name=self.name, camera=self.camera, objects=self.objects.tolist(), images=self.images.tolist())
        if any((c != np.eye(2)).any() for c in self.cov):
            out["cov"] = [c.ravel().tolist() for c in self.cov]
        if any(c is not None for c in self.ocov):
            out["ocov"] = [None if c is None else c.ravel().tolist() for c in self.ocov]
        if self.extra:
            out["unknowns"] = [list(e) for e in self.extra]
        if self.loss:
            out["loss"] = list(self.loss)
        if self.believe:
            out["believe"] = True
        best = self.result(minima[0])
        if not values:
            best["values"] = []
        out["best"] = best
        if others:
            second = self.result(minima[1])
            out["other"] = {k: second[k] for k in ("center", "rotation", "cost")}
        print(self.name, [float(f"{m[0]:.6g}") for m in minima[:4]], f"condition {best['condition']:.2g} sigma0 {best['sigma0']}", file=sys.stderr)
        return out


# --- textbook cases: photo millimetres, y up; with fy = -f the camera axes' y turns over -------------------------------
def photo(c):
    return dict(kind="frame", f=c, fy=-c, x0=0.0, y0=0.0)


def textbook():
    wuhan = Scene(
        "Wuhan", photo(153.24),
        [[36589.41, 25273.32, 2195.17], [37631.08, 31324.51, 728.69], [39100.97, 24934.98, 2386.50], [40426.54, 30319.81, 757.31]],
        [[-86.15, -68.99], [-53.40, 82.21], [-14.78, -76.63], [10.46, 64.43]])
    mikhail = Scene(
        "Mikhail", photo(152.222),
        [[913928.64, 575198.44, 189.64], [914270.77, 575432.35, 191.26], [914684.64, 575022.09, 186.72], [914662.47, 575738.30, 191.94], [914137.97, 575435.45, 190.69]],
        [[56.515, -78.969], [1.242, 1.134], [95.576, 97.171], [-70.988, 92.733], [0.651, -30.068]])
    five = [[1268.1022, 1455.0274, -14.3939], [732.1811, 545.3437, -14.7009], [1454.5532, 731.6659, -14.3509], [545.2449, 1268.2324, -14.6639], [1000.0, 1000.0, -14.4540]]
    dewitt = Scene("Dewitt", photo(152.916), five, [[86.421, -83.977], [-100.916, 92.582], [-98.322, -89.161], [78.812, 98.123], [-8.641, 5.630]])
    wolf = Scene(
        "Wolf", photo(152.916), [[1268.102, 1455.027, 22.606], [732.181, 545.344, 22.299], [1454.553, 731.666, 22.649], [545.245, 1268.232, 22.336]],
        [[86.421, -83.977], [-100.916, 92.582], [-98.322, -89.161], [78.812, 98.123]])
    # Sample file of otakusaikou's SpaceResection: a plane, its points known to 0.0028; the images taken as good to 0.01 mm.
    board = Scene(
        "board", photo(15.0),
        [[1.4839210, 1.6207980, 0.0], [0.9469633, 0.9694654, 0.0], [1.8043183, 0.3585923, 0.0], [2.1413433, 0.8994293, 0.0], [3.1066432, 0.4066430, 0.0], [2.8368213, 1.4303908, 0.0]],
        [[-3.8706, 4.656], [-7.8978, -0.229], [-1.4676, -4.8106], [1.0601, -0.7543], [8.2998, -4.4502], [6.2762, 3.2279]],
        cov=[np.eye(2) * 1e-4] * 6, ocov=[np.eye(3) * 0.0028**2] * 6)
    documents = []
    for s in (wuhan, mikhail, dewitt, wolf, board):
        documents.append(s.document())
        documents[-1]["best"]["angles"] = angles(documents[-1]["best"])
    return documents


def angles(best):
    """omega, phi, kappa of M = Mk Mp Mo, each with its standard deviation, from that of the turn: M(angles + d) = exp(J d) M."""
    m = mp.diag([1, -1, -1]) * mp.matrix(3, 3)
    for i in range(3):
        for j in range(3):
            m[i, j] = mpf(best["rotation"][3 * i + j]) * (1 if i == 0 else -1)
    omega, phi, kappa = mp.atan2(-m[2, 1], m[2, 2]), mp.asin(m[2, 0]), mp.atan2(-m[1, 0], m[0, 0])

    def axis(k, a):
        return turn([-a if i == k else mp.mpf(0) for i in range(3)])

    def at(o, p, k):
        return mp.diag([1, -1, -1]) * axis(2, k) * axis(1, p) * axis(0, o)

    base = at(omega, phi, kappa)
    j = mp.matrix(3, 3)
    for k in range(3):
        d = [H if i == k else mp.mpf(0) for i in range(3)]
        slope = (at(omega + d[0], phi + d[1], kappa + d[2]) - at(omega - d[0], phi - d[1], kappa - d[2])) / (2 * H) * base.T
        j[0, k], j[1, k], j[2, k] = slope[2, 1], slope[0, 2], slope[1, 0]
    sd, corr = best["sd"], best["corr"]
    c = mp.matrix(3, 3)
    for a in range(3, 6):
        for b in range(3, 6):
            r = 1 if a == b else corr[max(a, b) * (max(a, b) - 1) // 2 + min(a, b)]
            c[a - 3, b - 3] = mpf(sd[a]) * mpf(sd[b]) * r
    c = j**-1 * c * (j**-1).T
    out = []
    for k, angle in enumerate((omega, phi, kappa)):
        out += [float(mp.nstr(angle, 17)), float(mp.nstr(mp.sqrt(c[k, k]), 12))]
    return out


# --- scenes -----------------------------------------------------------------------------------------------------------
FRAME = dict(kind="frame", f=1000.0, fy=1000.0, x0=640.5, y0=480.25)


def look(center, target, roll):
    z = target - center
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.1, 0.2, 1.0])
    x /= np.linalg.norm(x)
    m = np.array([x, np.cross(z, x), z])
    return Rotation.from_rotvec([0, 0, roll]).as_matrix() @ m


def shape(kind, n, rng):
    cube = rng.uniform(-1, 1, (n, 3))
    if kind == "coplanar":
        cube[:, 2] = 0.0
    elif kind == "nearly planar":
        cube[:, 2] *= 0.001
    elif kind == "nearly collinear":
        cube[:, 1:] *= 0.02
    if kind in ("nearly planar", "nearly collinear"):
        cube = cube @ Rotation.from_rotvec([0.4, -0.3, 0.2]).as_matrix().T
    if kind == "coplanar":  # a plane that doubles hold exactly: z = x/2 - y/4
        cube = np.round(cube * 1024) / 1024
        cube[:, 2] = cube[:, 0] / 2 - cube[:, 1] / 4
        return cube
    return np.round(cube, 6)


def scene(name, kind, n, seed, camera=FRAME, distance=5.0, noise=0.5, make=None, **options):
    rng = np.random.default_rng(seed)
    objects = shape(kind, n, rng)
    if make is not None:
        objects = make(rng)
    center = rng.normal(size=3)
    center = center / np.linalg.norm(center) * distance
    if kind in ("coplanar", "nearly planar"):
        center[2] = abs(center[2]) + 0.4 * distance
    rotation = look(center, np.zeros(3), rng.uniform(-3, 3))
    extra = {e[0]: e[1] for e in options.get("extra", ())}
    extra.update(options.pop("truth", {}))
    d = (objects - center) @ rotation.T
    images = np.array(project(camera, extra, d.T, Plain)).T + rng.normal(0, noise, (n, 2))
    images += np.array(options.pop("blunder", np.zeros((n, 2))))
    return Scene(name, camera, objects, np.round(images, 3), **options)


def spd(rng, k, scale):
    a = rng.normal(size=(k, k))
    c = a @ a.T + 0.3 * np.eye(k)
    return np.round(c * scale, 6 if scale > 1e-3 else 9)


def scenes():
    long = dict(FRAME, f=20000.0, fy=20000.0)
    for kind in ("general", "coplanar", "nearly planar", "nearly collinear", "long lens"):
        for n in (4, 6, 20):
            options = dict(camera=long, distance=100.0) if kind == "long lens" else {}
            yield scene(f"{kind} {n}", kind, n, 100 + n, **options).document(values=n < 20 or kind == "general")
    rng = np.random.default_rng(5)
    weights = [np.eye(2) * w for w in np.round(rng.uniform(0.2, 3.0, 7), 3)]
    yield scene("weights", "general", 7, 31, cov=weights).document()
    yield scene("weights believed", "general", 7, 31, cov=weights, believe=True).document()
    yield scene("covariances", "general", 6, 32, cov=[spd(rng, 2, 0.2) for _ in range(6)]).document()
    bounds = [spd(rng, 3, 1e-5) for _ in range(6)]
    yield scene("object covariances", "general", 6, 33, cov=[spd(rng, 2, 0.2) for _ in range(6)], ocov=bounds).document()
    yield scene("object covariances of some", "general", 7, 34, ocov=[None, bounds[0], None, bounds[1] * 100, None, None, bounds[2]], believe=True).document()
    brown = dict(FRAME, kind="brown", f=1000.0, fy=990.0, k1=-0.05)
    for name, extra in (
        ("self-calibrated", [("f", 1000.0, None), ("k1", -0.05, None)]),
        ("self-calibrated with priors", [("f", 1000.0, 2.0), ("k1", -0.05, 0.01)]),
    ):
        yield scene(name, "general", 12, 35, camera=brown, distance=3.5, extra=extra, truth=dict(f=1006.0, k1=-0.07)).document()
    blunder = np.zeros((10, 2))
    blunder[3], blunder[7] = [6.0, -3.0], [-4.0, 5.0]
    for kind in ("huber", "cauchy"):
        yield scene(kind, "general", 10, 36, loss=(kind, 1.25), blunder=blunder).document()
    yield scene("cauchy with covariances", "general", 9, 37, loss=("cauchy", 2.0), cov=[spd(rng, 2, 0.3) for _ in range(9)], blunder=blunder[:9]).document()
    around = dict(make=lambda r: np.round(r.uniform(-4, 4, (8, 3)), 6), distance=0.8)
    yield scene("fisheye", "general", 8, 38, camera=dict(FRAME, kind="fisheye", f=300.0, fy=300.0), **around).document()
    yield scene("panorama", "general", 8, 39, camera=dict(FRAME, kind="panorama", f=600.0, fy=610.0), **around).document()
    apart = np.random.default_rng(6)
    axes = [np.diag(v) for v in np.round(apart.uniform(0.1, 2.0, (7, 2)), 3)]
    bounds = [np.diag(v) for v in np.round(apart.uniform(1e-6, 9e-6, (7, 3)), 8)]
    yield scene("deviations of each axis", "general", 7, 44, cov=axes, ocov=bounds).document()
    spread = [spd(apart, 3, 1e-6) for _ in range(9)]
    yield scene("cauchy with object covariances", "general", 9, 45, loss=("cauchy", 2.0), ocov=spread, blunder=blunder[:9]).document()
    for seed in (40, 41, 43):
        yield scene(f"planar ambiguity {seed}", "coplanar", 6, seed, distance=16.0).document(others=1)


if __name__ == "__main__":
    out = dict(textbook=textbook(), scenes=list(scenes()))
    text = json.dumps(out, separators=(",", ":"))
    print(text.replace('{"name"', '\n{"name"'))
