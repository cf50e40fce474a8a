# mpmath 1.3.0 with 60 digits, Python 3.11: geodetic and geocentric coordinates, heights along rays.
#
# Geodetic -> geocentric is the closed form in 60 digits. Geocentric -> geodetic of the same floats, rounded first,
# is found by Newton's method on the latitude from the known answer, so it shares nothing with the crate's solver.
import json
from mpmath import mp, mpf, sin, cos, sqrt, atan2, findroot, pi, quad

mp.dps = 60
A, F = mpf(6378137), mpf(1) / mpf("298.257223563")


def forward(phi, lam, h, a=A, f=F):
    e2 = f * (2 - f)
    n = a / sqrt(1 - e2 * sin(phi) ** 2)
    return (n + h) * cos(phi) * cos(lam), (n + h) * cos(phi) * sin(lam), ((1 - e2) * n + h) * sin(phi)


def inverse(x, y, z, guess, a=A, f=F):
    e2 = f * (2 - f)
    p = sqrt(x * x + y * y)
    if p == 0:
        return (pi / 2 if z >= 0 else -pi / 2), mpf(0), abs(z) - a * (1 - f)

    # The normal at latitude t passes through (p, z).
    def miss(t):
        return p * sin(t) - z * cos(t) - a * e2 * sin(t) * cos(t) / sqrt(1 - e2 * sin(t) ** 2)

    t = findroot(miss, guess, tol=mpf(10) ** -100, maxsteps=200, verify=False)
    assert abs(miss(t)) < mpf(10) ** -45
    h = p * cos(t) + z * sin(t) - a * sqrt(1 - e2 * sin(t) ** 2)
    return t, atan2(y, x), h


def number(x):
    return mp.nstr(x, 25)


cases = []
for lat in ["-90", "-89.9999999", "-45", "-1e-9", "0", "1e-7", "17.41", "53.80939444444", "60.5", "89.999", "90"]:
    for lon in ["0", "2.12955", "-179.999999", "90"]:
        for h in ["-6000000", "-10000", "0", "73", "8848.86", "20200000", "1e9"]:
            phi, lam, hh = [mpf(float(v)) for v in (lat, lon, h)]
            # The floats that a program has after converting degrees.
            phi, lam = mpf(float(phi) * (3.141592653589793 / 180)), mpf(float(lam) * (3.141592653589793 / 180))
            phi = max(min(phi, mpf(1.5707963267948966)), mpf(-1.5707963267948966))
            exact = forward(phi, lam, hh)
            floats = [float(c) for c in exact]
            back = inverse(*[mpf(c) for c in floats], guess=phi)
            cases.append(dict(geodetic=[float(phi), float(lam), float(hh)], exact=[number(c) for c in exact],
                              geocentric=floats, back=[number(c) for c in back]))

# Every third case is enough for the file.
cases = cases[::3]

# Arc length of the meridian from M by quadrature: a quadrant of WGS 84.
e2 = F * (2 - F)
quadrant = quad(lambda t: A * (1 - e2) / (1 - e2 * sin(t) ** 2) ** mpf(1.5), [0, pi / 4, pi / 2])

# Rays against the surface of constant height, by secant search on the 60-digit height.
rays = []
for o, d, h in [
    ((7000000.0, 100000.0, 2000000.0), (-0.9, 0.1, -0.3), 1000.0),
    ((4200000.0, 172000.0, 4785000.0), (-0.4, 0.3, -0.7), 0.0),
    ((4200000.0, 172000.0, 4785000.0), (-0.4, 0.3, -0.7), -50000.0),
    ((5000000.0, 0.0, 5000000.0), (-0.7, 0.01, -0.7), 300000.0),
    ((1000.0, 2000.0, 300000.0), (0.3, 0.4, 0.5), 10000.0),
]:
    o, d = [mpf(c) for c in o], [mpf(c) for c in d]
    norm = sqrt(sum(c * c for c in d))
    d = [c / norm for c in d]

    def height(t):
        x, y, z = [a + t * b for a, b in zip(o, d)]
        return inverse(x, y, z, atan2(z, sqrt(x * x + y * y)))[2] - mpf(h)

    # March for the first sign change, then bisect.
    step, t = mpf(1000), mpf(0)
    s0 = height(t) > 0
    while (height(t + step) > 0) == s0:
        t += step
    lo, hi = t, t + step
    for _ in range(120):
        mid = (lo + hi) / 2
        if (height(mid) > 0) == s0:
            lo = mid
        else:
            hi = mid
    rays.append(dict(origin=[float(c) for c in o], direction=[float(c) for c in d], height=h, distance=number(lo)))

print(json.dumps(dict(cases=cases, quadrant=number(quadrant), rays=rays), indent=None, separators=(",", ":")))
