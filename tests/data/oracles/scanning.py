"""Scanning cameras with mpmath: images of world points and their derivatives, to 60 digits.

The image (x, y) is found as the root of two equations in two unknowns: the camera that stands where the platform is at the time
of (x, y) must see the point at the exposed place. Derivatives are differences of such roots with steps of 1e-25.

    python3 scanning.py > scanning.json     (mpmath 1.3.0)
"""

import json
import random

import mpmath as mp

mp.mp.dps = 60
STEP = mp.mpf(10) ** -25
random.seed(1967)


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turned(w, v):
    """Rodrigues' formula: v turned by the vector w."""
    angle = mp.sqrt(sum(c * c for c in w))
    if angle == 0:
        return list(v)
    u = [c / angle for c in w]
    along = sum(a * b for a, b in zip(u, v)) * (1 - mp.cos(angle))
    uv = cross(u, v)
    return [v[i] * mp.cos(angle) + uv[i] * mp.sin(angle) + u[i] * along for i in range(3)]


def by_quaternion(q, v):
    """q v q* / |q|^2, scalar first."""
    w, u = q[0], q[1:]
    t = [2 * c for c in cross(u, v)]
    n = sum(c * c for c in q)
    ut = cross(u, t)
    # |q|^2 v + w t + u x t for a quaternion of any length
    return [(n * v[i] + w * t[i] + ut[i]) / n for i in range(3)]


def lagrange(times, values, count, t):
    i = max(k for k in range(len(times)) if times[k] <= t)
    i = min(i, len(times) - 2)
    first = min(max(i + 1 - count // 2, 0), len(times) - count)
    total = [mp.mpf(0)] * len(values[0])
    for j in range(first, first + count):
        share = mp.mpf(1)
        for k in range(first, first + count):
            if k != j:
                share *= (t - times[k]) / (times[j] - times[k])
        total = [a + share * b for a, b in zip(total, values[j])]
    return total


def slerp(times, values, t):
    i = min(max(k for k in range(len(times)) if times[k] <= t), len(times) - 2)
    s = (t - times[i]) / (times[i + 1] - times[i])
    a, b = ([c / mp.sqrt(sum(d * d for d in q)) for c in q] for q in (values[i], values[i + 1]))
    product = sum(x * y for x, y in zip(a, b))
    if product < 0:
        b, product = [-c for c in b], -product
    angle = mp.acos(product)
    return [(x * mp.sin((1 - s) * angle) + y * mp.sin(s * angle)) / mp.sin(angle) for x, y in zip(a, b)]


def state(trajectory, parameters, t):
    """Projection centre, and a function that turns world vectors into camera axes."""
    base = trajectory["base"]
    if "quaternion" in base:
        center, q = base["center"], base["quaternion"]
    else:
        times, positions = base["position_times"], base["positions"]
        if base["positions_between"] == "linear":
            center = lagrange(times, positions, 2, t)
        else:
            center = lagrange(times, positions, base["positions_between"], t)
        times, attitudes = base["attitude_times"], base["attitudes"]
        if base["attitudes_between"] == "linear":
            q = slerp(times, attitudes, t)
        else:
            q = lagrange(times, attitudes, base["attitudes_between"], t)
    s = (t - trajectory["origin"]) / trajectory["unit"]
    polynomial = lambda c: [sum(c[3 * k + i] * s**k for k in range(len(c) // 3)) for i in range(3)]
    moved, w = polynomial(parameters["position"]), polynomial(parameters["attitude"])
    center = [a + b for a, b in zip(center, moved)]
    return center, lambda v: turned(w, by_quaternion(q, v))


def camera(kind, parameters, d):
    fx, fy, x0, y0, skew = parameters["interior"]
    lens = parameters["lens"]
    if kind == "brown":
        x, y = d[0] / d[2], d[1] / d[2]
        k1, k2, k3, p1, p2 = lens
        r2 = x * x + y * y
        radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
        x, y = (
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        )
    else:
        angle = mp.atan2(d[0], d[2])
        x, y = angle, d[1] / mp.sqrt(d[0] ** 2 + d[2] ** 2)
        if lens:
            y += lens[0] * mp.sin(angle)
    return fx * x + skew * y + x0, fy * y + y0


def image(case, parameters, world, start):
    def equations(x, y):
        t = case["start"] + x * case["per_column"] + y * case["per_line"]
        center, rotate = state(case["trajectory"], parameters, t)
        u, v = camera(case["camera"], parameters, rotate([a - b for a, b in zip(world, center)]))
        if case["row"] is None:
            return u - x, v - y
        return u - x, v - case["row"]

    root = mp.findroot(equations, start, tol=mp.mpf(10) ** -100, maxsteps=60)
    return root[0], root[1]


def point(case, pixel, depth):
    """A world point, rounded, near the ray of a pixel."""
    parameters = exact(case["parameters"])
    t = case["start"] + pixel[0] * case["per_column"] + pixel[1] * case["per_line"]
    center, rotate = state(case["trajectory"], parameters, mp.mpf(t))
    seen = (pixel[0], pixel[1] if case["row"] is None else case["row"])

    def equations(a, b):
        if case["camera"] == "brown":
            d = [a, b, mp.mpf(1)]
        else:
            d = [mp.sin(a), b, mp.cos(a)]
        u, v = camera(case["camera"], parameters, d)
        return u - seen[0], v - seen[1]

    fx, fy, x0, y0, _ = parameters["interior"]
    a, b = mp.findroot(equations, ((seen[0] - x0) / fx, (seen[1] - y0) / fy), tol=mp.mpf(10) ** -60)
    d = [a, b, mp.mpf(1)] if case["camera"] == "brown" else [mp.sin(a), b, mp.cos(a)]
    # World from camera: the columns are the images of the axes.
    rows = [rotate([mp.mpf(i == k) for k in range(3)]) for i in range(3)]
    return [float(center[i] + depth * sum(rows[i][k] * d[k] for k in range(3))) for i in range(3)]


def exact(parameters):
    return {k: [mp.mpf(c) for c in v] for k, v in parameters.items()}


def build(case, pixels, depth):
    points = []
    for pixel in pixels:
        world = point(case, pixel, depth * (1 + 0.02 * random.uniform(-1, 1)))
        parameters = exact(case["parameters"])
        X = [mp.mpf(c) for c in world]
        x, y = image(case, parameters, X, pixel)
        columns = {}
        by_world = []
        for i in range(3):
            h = STEP * depth
            moved = [c + (h if k == i else 0) for k, c in enumerate(X)]
            back = [c - (h if k == i else 0) for k, c in enumerate(X)]
            a, b = image(case, parameters, moved, (x, y)), image(case, parameters, back, (x, y))
            by_world.append([float((a[k] - b[k]) / (2 * h)) for k in range(2)])
        for name, values in parameters.items():
            columns[name] = []
            for i in range(len(values)):
                h = STEP * max(abs(values[i]), mp.mpf(10) ** -3)
                ends = []
                for sign in (1, -1):
                    moved = dict(parameters)
                    moved[name] = [c + (sign * h if k == i else 0) for k, c in enumerate(values)]
                    ends.append(image(case, moved, X, (x, y)))
                columns[name].append([float((ends[0][k] - ends[1][k]) / (2 * h)) for k in range(2)])
        points.append({"world": world, "image": [float(x), float(y)], "by_world": by_world, "by": columns})
    case["points"] = points
    return case


def quaternion(w):
    """Of a rotation vector, in floats."""
    angle = mp.sqrt(sum(mp.mpf(c) ** 2 for c in w))
    s = mp.sin(angle / 2) / angle
    return [float(mp.cos(angle / 2))] + [float(s * c) for c in w]


# Camera axes x right, y down, z forward; half a turn about x looks down with y along world -y, about (1, 1, 0) along x.
DOWN = [mp.pi - 0.02, 0.03, -0.01]
BROWN = [-0.11, 0.023, -0.004, 7e-4, -4e-4]


def still(center, w):
    return {"center": center, "quaternion": quaternion(w)}


def satellite():
    """A circular orbit of 7078 km in Earth-fixed axes, nodes each 2 s and 0.25 s, looking down with y along the flight."""
    rate, radius = mp.mpf("1.06e-3"), mp.mpf(7078000)

    def at(t):
        a = mp.mpf("0.7") + rate * t
        tilt = mp.mpf("0.4")
        up = [mp.cos(a), mp.sin(a) * mp.cos(tilt), mp.sin(a) * mp.sin(tilt)]
        along = [-mp.sin(a), mp.cos(a) * mp.cos(tilt), mp.cos(a) * mp.sin(tilt)]
        z = [-c for c in up]
        x = cross(along, z)
        wobble = [mp.mpf("3e-5") * mp.sin(3 * t), mp.mpf("-2e-5") * mp.cos(2 * t), mp.mpf("4e-5") * mp.sin(t)]
        rows = [x, along, z]
        columns = [turned(wobble, [rows[i][k] for i in range(3)]) for k in range(3)]
        m = [[columns[k][i] for k in range(3)] for i in range(3)]
        w = mp.sqrt(1 + m[0][0] + m[1][1] + m[2][2]) / 2
        if abs(w) > mp.mpf("0.1"):
            q = [w, (m[2][1] - m[1][2]) / (4 * w), (m[0][2] - m[2][0]) / (4 * w), (m[1][0] - m[0][1]) / (4 * w)]
        else:
            x = mp.sqrt(1 + m[0][0] - m[1][1] - m[2][2]) / 2
            q = [(m[2][1] - m[1][2]) / (4 * x), x, (m[0][1] + m[1][0]) / (4 * x), (m[0][2] + m[2][0]) / (4 * x)]
        return [float(radius * c) for c in up], [float(c) for c in q]

    position_times = [2.0 * k - 12 for k in range(13)]
    attitude_times = [0.25 * k - 3 for k in range(25)]
    return {
        "position_times": position_times,
        "positions": [at(mp.mpf(t))[0] for t in position_times],
        "positions_between": 8,
        "attitude_times": attitude_times,
        "attitudes": [at(mp.mpf(t))[1] for t in attitude_times],
        "attitudes_between": 8,
    }


def aircraft():
    """A bumpy flight: a node each 25 lines."""
    times = [0.05 * k for k in range(41)]
    shake = lambda a: random.uniform(-a, a)
    down = [mp.pi / mp.sqrt(2), mp.pi / mp.sqrt(2), 0]
    attitudes = [quaternion([c + shake(0.004) for c in down]) for _ in times]
    # The other of the two quaternions of a rotation now and then.
    attitudes = [[-c for c in q] if k % 7 == 3 else q for k, q in enumerate(attitudes)]
    return {
        "position_times": times,
        "positions": [[500000 + 60 * t + shake(0.2), 5400000 + shake(0.3), 900 + shake(0.2)] for t in times],
        "positions_between": "linear",
        "attitude_times": times,
        "attitudes": attitudes,
        "attitudes_between": "linear",
    }


NONE = {"position": [], "attitude": []}
FIELD = [(3.5, 20.0), (1000.25, 400.0), (1990.0, 777.7), (700.0, 990.0)]
CASES = [
    (
        {
            "name": "pushbroom, constant velocity",
            "camera": "brown",
            "row": 31.5,
            "start": -2.0,
            "per_column": 0.0,
            "per_line": 0.004,
            "extent": [[0, 2000], [0, 1000]],
            "trajectory": {"base": still([400.0, -300.0, 1500.0], DOWN), "origin": 0.5, "unit": 1.0},
            "parameters": {
                "position": [0.0, 0.0, 0.0, 3.0, -71.0, 0.7],
                "attitude": [0.0, 0.0, 0.0, 0.004, -0.003, 0.006],
                "interior": [2500.0, 2490.0, 1003.0, -4.0, 0.7],
                "lens": BROWN,
            },
        },
        FIELD,
        1500,
    ),
    (
        {
            "name": "strip, polynomials of second and third degree",
            "camera": "brown",
            "row": -80.0,
            "start": 10.0,
            "per_column": 0.0,
            "per_line": -0.004,
            "extent": [[0, 2000], [0, 1000]],
            "trajectory": {"base": still([400.0, -300.0, 1500.0], DOWN), "origin": 8.0, "unit": 2.0},
            "parameters": {
                "position": [1.0, -2.0, 0.5, 5.0, 142.0, 1.5, 0.8, -0.6, 0.4],
                "attitude": [0.01, -0.02, 0.03, 0.004, -0.003, 0.006, -0.002, 0.001, 0.003, 0.0007, -0.0009, 0.001],
                "interior": [2500.0, 2490.0, 1003.0, -4.0, 0.7],
                "lens": BROWN,
            },
        },
        FIELD,
        1500,
    ),
    (
        {
            "name": "pushbroom, satellite, eight nodes, corrected",
            "camera": "brown",
            "row": 2000.0,
            "start": -1.5,
            "per_column": 0.0,
            "per_line": 1e-4,
            "extent": [[0, 30000], [0, 30000]],
            "trajectory": {"base": satellite(), "origin": 0.0, "unit": 1.5},
            "parameters": {
                "position": [3.0, -2.0, 5.0, 0.4, 0.3, -0.2],
                "attitude": [2e-5, -3e-5, 1e-5, 4e-6, 2e-6, -5e-6],
                "interior": [1e6, 1e6, 15000.0, 0.0, 2.0],
                "lens": [-0.3, 2.0, 0.0, 1e-3, -2e-3],
            },
        },
        [(10.0, 15.0), (14000.5, 12345.6), (29990.0, 22222.2), (7000.0, 29980.0)],
        707000,
    ),
    (
        {
            "name": "pushbroom, aircraft, straight lines and great circles",
            "camera": "brown",
            "row": 10.0,
            "start": 0.0,
            "per_column": 0.0,
            "per_line": 0.002,
            "extent": [[0, 2000], [0, 1000]],
            "trajectory": {"base": aircraft(), "origin": 1.0, "unit": 1.0},
            "parameters": {
                "position": [0.1, 0.2, -0.3],
                "attitude": [0.001, -0.002, 0.0005],
                "interior": [4000.0, 4000.0, 1000.0, 0.0, 0.5],
                "lens": BROWN,
            },
        },
        FIELD,
        900,
    ),
    (
        {
            "name": "panoramic, moving, compensated",
            "camera": "cylinder",
            "row": None,
            "start": -0.6,
            "per_column": 0.0003,
            "per_line": 0.0,
            "extent": [[0, 4000], [0, 400]],
            "trajectory": {"base": still([400.0, -300.0, 6000.0], DOWN), "origin": 0.0, "unit": 1.0},
            "parameters": {
                "position": [0.0, 0.0, 0.0, 10.0, -210.0, 2.0],
                "attitude": [0.0, 0.0, 0.0, 0.02, -0.015, 0.03],
                "interior": [1900.0, 1890.0, 2000.0, 200.0, 0.0],
                "lens": [0.06],
            },
        },
        [(100.0, 30.0), (2000.5, 210.0), (3900.0, 380.0), (3000.0, 5.0)],
        6000,
    ),
    (
        {
            "name": "whiskbroom",
            "camera": "cylinder",
            "row": 6.0,
            "start": 0.0,
            "per_column": 2e-6,
            "per_line": 0.012,
            "extent": [[0, 3000], [0, 1000]],
            "trajectory": {"base": still([400.0, -300.0, 20000.0], DOWN), "origin": 6.0, "unit": 6.0},
            "parameters": {
                "position": [0.0, 0.0, 0.0, 60.0, -1280.0, 4.0, 1.0, 2.0, 3.0],
                "attitude": [0.0, 0.0, 0.0, 0.012, -0.009, 0.008],
                "interior": [2000.0, 2000.0, 1500.0, 0.0, 0.2],
                "lens": [],
            },
        },
        [(30.0, 3.0), (1500.5, 500.0), (2990.0, 777.7), (700.0, 990.0)],
        20000,
    ),
    (
        {
            "name": "rolling shutter",
            "camera": "brown",
            "row": None,
            "start": 0.0,
            "per_column": 0.0,
            "per_line": 3e-5,
            "extent": [[0, 1280], [0, 960]],
            "trajectory": {"base": still([4.0, -3.0, 15.0], DOWN), "origin": 0.0144, "unit": 1.0},
            "parameters": {
                "position": [0.0, 0.0, 0.0, 8.0, -6.0, 2.0],
                "attitude": [0.0, 0.0, 0.0, 0.5, -0.8, 1.1],
                "interior": [800.0, 790.0, 643.0, 477.0, 0.7],
                "lens": BROWN,
            },
        },
        [(30.0, 3.0), (640.5, 500.0), (1270.0, 777.7), (300.0, 955.0)],
        15,
    ),
]

print(json.dumps({"program": "mpmath " + mp.__version__, "cases": [build(*c) for c in CASES]}))
