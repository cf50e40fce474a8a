# Python 3.11, mpmath 1.3.0, 50 digits. Prints tests/data/oracles/output_models.json.
"""Pixels of one sensor through a surface into another's picture, with slopes by differences of 50-digit numbers.

Every camera here is written from its definition: a rotation by a quaternion w, x, y, z (camera from world), a projection centre,
a projection, a lens, an affine map to pixels. The line of sight of a lens is found by mpmath's root finder.
"""
import json

from mpmath import acos, asin, atan, atan2, cos, findroot, matrix, mp, mpf, norm, pi, sin, sqrt, tan

mp.dps = 50


def m(v):
    return [mpf(repr(c)) if isinstance(c, float) else mpf(c) for c in v]


def rotation(q):
    w, x, y, z = m(q)
    n = w * w + x * x + y * y + z * z
    return [[(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n],
            [2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n],
            [2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n]]


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def apply(rows, v):
    return [dot(r, v) for r in rows]


def transposed(rows):
    return [list(c) for c in zip(*rows)]


def unit(v):
    n = sqrt(dot(v, v))
    return [c / n for c in v]


def brown(k, p, x, y):
    k1, k2, k3 = m(k)
    p1, p2 = m(p)
    r = x * x + y * y
    f = 1 + r * (k1 + r * (k2 + r * k3))
    return (x * f + 2 * p1 * x * y + p2 * (r + 2 * x * x), y * f + p1 * (r + 2 * y * y) + 2 * p2 * x * y)


class Camera:
    def __init__(self, c):
        self.c = c
        self.rows = rotation(c["quaternion"])
        self.center = m(c["center"])
        self.f, self.pp = m(c["principal_distance"]), m(c["principal_point"])

    def plane(self, d):
        x, y, z = d
        kind = self.c["projection"]
        if kind == "perspective":
            assert z > 0
            return brown(self.c["k"], self.c["p"], x / z, y / z)
        if kind == "equirectangular":
            return atan2(x, z), atan2(y, sqrt(x * x + z * z))
        if kind == "cylindrical":
            return atan2(x, z), y / sqrt(x * x + z * z)
        across = sqrt(x * x + y * y)
        theta = atan2(across, z)
        r = {"equidistant": theta, "stereographic": 2 * tan(theta / 2), "equisolid": 2 * sin(theta / 2)}[kind]
        return r * x / across, r * y / across

    def direction(self, x, y):
        kind = self.c["projection"]
        if kind == "perspective":
            k, p = self.c["k"], self.c["p"]
            root = findroot(lambda a, b: [u - v for u, v in zip(brown(k, p, a, b), (x, y))], (x, y))
            return unit([root[0], root[1], mpf(1)])
        if kind == "equirectangular":
            return [cos(y) * sin(x), sin(y), cos(y) * cos(x)]
        if kind == "cylindrical":
            return unit([sin(x), y, cos(x)])
        r = sqrt(x * x + y * y)
        theta = {"equidistant": r, "stereographic": 2 * atan(r / 2), "equisolid": 2 * asin(r / 2)}[kind]
        return [sin(theta) * x / r, sin(theta) * y / r, cos(theta)]

    def project(self, world):
        d = apply(self.rows, [a - b for a, b in zip(world, self.center)])
        x, y = self.plane(d)
        return [self.f[0] * x + self.pp[0], self.f[1] * y + self.pp[1]]

    def ray(self, pixel):
        d = self.direction((pixel[0] - self.pp[0]) / self.f[0], (pixel[1] - self.pp[1]) / self.f[1])
        return self.center, apply(transposed(self.rows), d)


def meet(surface, origin, d):
    if surface["kind"] == "plane":
        n, p = m(surface["normal"]), m(surface["point"])
        t = -dot(n, [a - b for a, b in zip(origin, p)]) / dot(n, d)
        return [a + t * b for a, b in zip(origin, d)] if t >= 0 else None
    if surface["kind"] == "infinity":
        return [10 ** mpf(40) * c for c in d]
    center, r = m(surface["center"]), mpf(repr(surface["radius"]))
    o = [a - b for a, b in zip(origin, center)]
    b, c = dot(o, d), dot(o, o) - r * r
    if b * b < c:
        return None
    axis, limit = unit(m(surface["axis"])), cos(mpf(repr(surface["half_angle_deg"])) * pi / 180)
    for t in (-b - sqrt(b * b - c), -b + sqrt(b * b - c)):
        x = [p + t * q for p, q in zip(o, d)]
        if t >= 0 and dot(axis, x) / r >= limit:
            return [p + q for p, q in zip(x, center)]
    return None


def through(case, pixel):
    screen, texture = Camera(case["screen"]), Camera(case["texture"])
    if case["surface"]["kind"] == "infinity":
        screen.center = texture.center = m([0, 0, 0])
    world = meet(case["surface"], *screen.ray(pixel))
    return None if world is None else (texture.project(world), world)


def camera(projection, center, quaternion, distance, point, k=(0.0, 0.0, 0.0), p=(0.0, 0.0)):
    return {"projection": projection, "center": list(center), "quaternion": list(quaternion),
            "principal_distance": list(distance), "principal_point": list(point), "k": list(k), "p": list(p)}


dome = {"kind": "dome", "center": [512.25, -80.5, 31.0], "radius": 9.25, "axis": [0.2, 0.35, 1.0], "half_angle_deg": 81.0}
master = camera("equidistant", [512.75, -81.25, 29.5], [0.98, 0.1, -0.12, 0.05], [640.5, 639.25], [1024.5, 1023.75])
projector = camera("perspective", [511.0, -88.5, 28.25], [0.94, 0.33, -0.04, 0.06], [1480.0, 1475.0], [955.0, 700.0],
                   [-0.11, 0.024, -0.003], [1.2e-3, -7e-4])
outside = dict(projector, center=[514.0, -103.0, 23.0], quaternion=[0.84, 0.54, 0.02, -0.04])
pano = camera("equirectangular", [0.0, 0.0, 0.0], [0.5, 0.52, -0.48, 0.49], [2048 / 3.25, 1024 / 1.5], [2000.0, 1000.0])
stereo = camera("stereographic", [3.0, 1.0, 2.0], [0.3, 0.2, 0.9, -0.1], [410.0, 400.0], [500.0, 505.0])
cylinder = camera("cylindrical", [1000020.0, 2000010.0, 152.0], [0.7, 0.68, 0.03, -0.02], [900.0, 905.0], [1500.0, 640.0])
photograph = camera("perspective", [1000000.5, 2000003.0, 890.0], [0.02, 0.999, 0.03, -0.05], [3100.0, 3110.0],
                    [2020.0, 1490.0], [-0.09, 0.03, 0.001], [4e-4, -3e-4])
ground = {"kind": "plane", "point": [1000000.0, 2000000.0, 120.0], "normal": [0.02, -0.05, 1.0]}
solid = camera("equisolid", [512.5, -80.0, 31.5], [0.95, -0.2, 0.1, 0.3], [600.0, 600.0], [900.0, 900.0])

cases = [
    ("projector below the rim, dome, dome master", projector, dome, master,
     [(955.5, 700.5), (200.25, 150.5), (1700.5, 200.5), (1000.5, 1300.5), (60.5, 1100.5)]),
    ("projector outside shines under the rim", outside, dome, master,
     [(955.5, 700.5), (700.5, 500.5), (1200.5, 300.5), (900.5, 120.5), (955.5, 1390.5)]),
    ("fisheye to fisheye by the dome between", solid, dome, master, [(905.5, 880.5), (300.5, 640.5), (1400.5, 1200.5)]),
    ("whole panorama of a stereographic picture, far away", pano, {"kind": "infinity"}, stereo,
     [(100.5, 300.5), (1500.5, 1000.5), (2600.5, 1500.5), (3700.5, 250.5)]),
    ("dome master of a panorama, far away", master, {"kind": "infinity"}, pano, [(400.5, 900.5), (1200.5, 300.5), (1024.5, 1800.5)]),
    ("cylinder over sloping ground, an air photograph", cylinder, ground, photograph,
     [(1500.5, 900.5), (700.5, 760.5), (2600.5, 1200.5), (3900.5, 1000.5), (1500.5, 300.5)]),
]
out = []
for name, screen, surface, texture, pixels in cases:
    case = {"name": name, "screen": screen, "surface": surface, "texture": texture, "points": []}
    for pixel in pixels:
        at = through(case, m(pixel))
        point = {"pixel": list(pixel), "texture": None}
        if at is not None:
            h = mpf(10) ** -20
            slopes = []
            for i in range(2):
                step = [h if i == j else mpf(0) for j in range(2)]
                ahead = through(case, [a + b for a, b in zip(m(pixel), step)])[0]
                back = through(case, [a - b for a, b in zip(m(pixel), step)])[0]
                slopes.append([(a - b) / (2 * h) for a, b in zip(ahead, back)])
            point["texture"] = [float(c) for c in at[0]]
            point["world"] = [float(c) for c in at[1]] if surface["kind"] != "infinity" else None
            point["jacobian"] = [[float(slopes[j][i]) for j in range(2)] for i in range(2)]
        case["points"].append(point)
    out.append(case)
print(json.dumps({"mpmath": "1.3.0", "digits": mp.dps, "cases": out}, indent=1))
