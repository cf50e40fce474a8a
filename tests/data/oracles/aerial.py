# Python 3, mpmath 1.3.0 with 50 digits and NumPy: refraction and earth curvature of aerial photographs.
#
# "traces": rays through the U.S. Standard Atmosphere 1976 (its seven layers; n - 1 = 277e-6 at sea level, proportional to the
# density) about a sphere of 6371 km: Snellius's invariant n r sin(i), the angle at the Earth's centre by Gauss-Legendre
# quadrature with 400 nodes, the straight line by Cartesian coordinates. No formula of a refraction constant is used.
# "flat" of a trace: the quadrature of the law for a flat Earth, 1/(H - h) int (n - n(H)) dz.
#
# "refraction": the law alpha - K tan(alpha) by turning the ray about the horizontal axis with Rodrigues's formula, in 50 digits.
# "curvature": the ray met with the sphere by bisection of its height, the arc by acos of the scalar product, in 50 digits.
# Photographs: y down, pixels; the rotation is the product of three axis rotations.
import json

import numpy as np
from mpmath import mp, mpf, matrix, sin, cos, tan, acos, sqrt, atan2
from numpy.polynomial.legendre import leggauss

mp.dps = 50

# The atmosphere: geopotential km, K, K/km.
LAYERS = [(0, 288.15, -6.5), (11, 216.65, 0), (20, 216.65, 1.0), (32, 228.65, 2.8), (47, 270.65, 0), (51, 270.65, -2.8),
          (71, 214.65, -2.0), (84.852, 186.946, 0)]
G, GAS = 9.80665, 287.05287
NODES, WEIGHTS = leggauss(400)


def layer_pressure(i, p, height):
    h0, t0, lapse = LAYERS[i]
    if lapse == 0:
        return p * np.exp(-G * (height - h0) * 1000 / (GAS * t0))
    return p * ((t0 + lapse * (height - h0)) / t0) ** (-G * 1000 / (GAS * lapse))


BASES = [101325.0]
for i in range(len(LAYERS) - 1):
    BASES.append(layer_pressure(i, BASES[i], LAYERS[i + 1][0]))


def density(z):
    height = 6356.766 * z / (6356.766 + z)
    i = max([j for j in range(len(LAYERS)) if LAYERS[j][0] <= height], default=0)
    h0, t0, lapse = LAYERS[i]
    return layer_pressure(i, BASES[i], height) / (GAS * (t0 + lapse * (height - h0)))


def n(z):
    return 1 + 277e-6 * density(z) / density(0.0)


def quadrature(f, a, b):
    return (b - a) / 2 * sum(w * f(a + (b - a) * (x + 1) / 2) for x, w in zip(NODES, WEIGHTS))


def traced(camera, ground, alpha, radius=6371.0):
    invariant = n(camera) * (radius + camera) * np.sin(alpha)

    def turn(z):
        sine = invariant / (n(z) * (radius + z))
        return sine / np.sqrt(1 - sine * sine) / (radius + z)

    theta = quadrature(turn, ground, camera)
    straight = np.arctan2((radius + ground) * np.sin(theta), radius + camera - (radius + ground) * np.cos(theta))
    return alpha - straight


traces = []
for camera, ground in [(1, 0), (2, 0), (3.5, 0.12), (5, 0), (5, 2), (7, 4.5), (9, 0), (10.9, 0), (12, 0), (15, 0), (15, 3), (20, 0), (30, 0)]:
    flat = quadrature(lambda z: n(z) - n(camera), ground, camera) / (camera - ground)
    bending = [[a, traced(camera, ground, np.radians(a))] for a in (10, 30, 45, 60, 75)]
    traces.append(dict(camera=camera * 1000, ground=ground * 1000, flat=flat, bending=bending))


def about(axis, t):
    c, s = cos(t), sin(t)
    return matrix({"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
                   "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis])


# A camera of 1000 x 1000 pixels in four attitudes: level, tilted 12 and 35 and 55 degrees from the nadir, turned.
C, X0, Y0 = mpf(1000), mpf(500), mpf(480)
ATTITUDES = [(180, 0, 0), (168, 5, 30), (145, -3, -100), (125, 10, 200)]


def camera_from_world(angles):
    a, b, c = [mpf(v) * mp.pi / 180 for v in angles]
    return about("z", c) * about("y", b) * about("x", a)


def ray(rotation, image):
    d = rotation.T * matrix([(mpf(image[0]) - X0) / C, (mpf(image[1]) - Y0) / C, 1])
    return d / sqrt((d.T * d)[0])


def seen(rotation, d):
    p = rotation * d
    return [mp.nstr(X0 + C * p[0] / p[2], 25), mp.nstr(Y0 + C * p[1] / p[2], 25)]


def turned_to(d, alpha):
    """The ray in the vertical plane of d at alpha from the nadir, by turning d about the horizontal axis."""
    z = matrix([0, 0, 1])
    axis = matrix([d[1] * z[2] - d[2] * z[1], d[2] * z[0] - d[0] * z[2], d[0] * z[1] - d[1] * z[0]])
    axis = axis / sqrt((axis.T * axis)[0])
    # Turning from d towards the zenith makes alpha grow.
    t = alpha - acos(-d[2])
    cross = matrix([axis[1] * d[2] - axis[2] * d[1], axis[2] * d[0] - axis[0] * d[2], axis[0] * d[1] - axis[1] * d[0]])
    return d * cos(t) + cross * sin(t) + axis * (axis.T * d)[0] * (1 - cos(t))


def arc(d, radius, camera, ground):
    """The angle at the Earth's centre of the first point of a ray on the sphere of the ground."""
    center = matrix([0, 0, radius + camera])

    def height(t):
        p = center + d * t
        return sqrt((p.T * p)[0]) - radius - ground

    # From the centre to the point of the ray nearest to the Earth's centre.
    low, high = mpf(0), -(center.T * d)[0]
    if height(high) >= 0:
        return None
    for _ in range(190):
        middle = (low + high) / 2
        low, high = (middle, high) if height(middle) > 0 else (low, middle)
    p = center + d * low
    return acos(p[2] / sqrt((p.T * p)[0]))


refraction, curvature = [], []
for angles in ATTITUDES:
    rotation = camera_from_world(angles)
    for image in [(10, 20), (480, 990), (700, 333), (990, 15)]:
        d = ray(rotation, image)
        if d[2] > -mpf("0.05"):
            continue
        alpha = acos(-d[2])
        for k in ["1e-4", "3.7e-5"]:
            straight = turned_to(d, alpha - mpf(float(k)) * tan(alpha))
            refraction.append(dict(rotation=[float(v) for v in rotation], image=image, constant=float(k),
                                   angle=float(alpha), corrected=seen(rotation, straight)))
        for radius, camera, ground, lengths in [(6371000, 3000, 0, 0), (6371000, 9000, 1500, 1500), (6356752.5, 9000, 1500, 0), (1000, 300, -20, 5)]:
            theta = arc(d, mpf(radius), mpf(camera), mpf(ground))
            if theta is None:
                continue
            flat = turned_to(d, atan2((mpf(radius) + lengths) * theta, mpf(camera) - ground))
            if (rotation * flat)[2] < mpf("0.01"):
                continue
            curvature.append(dict(rotation=[float(v) for v in rotation], image=image, radius=radius, camera=camera, ground=ground,
                                  lengths=lengths, angle=float(alpha), corrected=seen(rotation, flat)))

with open("aerial.json", "w") as f:
    json.dump(dict(traces=traces, refraction=refraction, curvature=curvature), f, indent=0)
print(len(traces), len(refraction), len(curvature))
