# Python 3, mpmath 1.3.0: the models that neither OpenCV 5.0.0 nor pycolmap 4.2.1 has, from their papers' formulas with 50 digits.
import json
import mpmath as mp

mp.mp.dps = 50
FX, FY, X0, Y0, S = map(mp.mpf, ("611.3", "598.7", "513.4", "391.9", "0.7"))
DIRECTIONS = [("0.31", "-0.22", "1"), ("-0.4", "0.17", "0.9"), ("0.05", "0.45", "1.3"), ("-0.2", "-0.3", "0.8")]


def vec(*texts):
    return [mp.mpf(t) for t in texts]


def radial(k, r2):
    return 1 + sum(c * r2 ** (i + 1) for i, c in enumerate(k))


def brown(x, y, k, p):
    r2 = x * x + y * y
    f = radial(k, r2)
    return x * f + 2 * p[0] * x * y + p[1] * (r2 + 2 * x * x), y * f + p[0] * (r2 + 2 * y * y) + 2 * p[1] * x * y


def metashape(X, Y, Z):  # manual, appendix "Camera models"
    k, p = vec("-0.11", "0.017", "0.004", "-0.0006"), vec("0.0012", "-0.0007", "0.03", "-0.02")
    x, y = X / Z, Y / Z
    r2 = x * x + y * y
    f, m = radial(k, r2), 1 + p[2] * r2 + p[3] * r2**2
    return (x * f + (p[0] * (r2 + 2 * x * x) + 2 * p[1] * x * y) * m,
            y * f + (p[1] * (r2 + 2 * y * y) + 2 * p[0] * x * y) * m)


def fraser(c, k, p, b):  # Fraser 1997: measured + corrections = ideal, y up, in the unit of c
    def image(X, Y, Z):
        ideal = c * X / Z, -c * Y / Z

        def residual(x, y):
            r2 = x * x + y * y
            f = radial(k, r2)
            return (x * f + p[0] * (r2 + 2 * x * x) + 2 * p[1] * x * y + b[0] * x + b[1] * y - ideal[0],
                    y * f + 2 * p[0] * x * y + p[1] * (r2 + 2 * y * y) - ideal[1])

        x, y = mp.findroot(residual, ideal, tol=mp.mpf(10) ** -60)
        return x / c, -y / c

    return image


def by_angle(radius):  # Kannala & Brandt 2006, eq. 2 to 5
    def image(X, Y, Z):
        rho = mp.hypot(X, Y)
        r = radius(mp.atan2(rho, Z))
        r *= radial(vec("0.02", "-0.004", "0.001", "0"), r * r)
        return r * X / rho, r * Y / rho

    return image


def unified(X, Y, Z):  # Mei & Rives 2007
    R = mp.sqrt(X * X + Y * Y + Z * Z)
    d = Z + mp.mpf("1.21") * R
    return brown(X / d, Y / d, vec("-0.11", "0.017", "0.004"), vec("0.0012", "-0.0007"))


def double_sphere(X, Y, Z):  # Usenko, Demmel & Cremers 2018, eq. 40
    xi, alpha = vec("-0.2", "0.59")
    w = xi * mp.sqrt(X * X + Y * Y + Z * Z) + Z
    d = alpha * mp.sqrt(X * X + Y * Y + w * w) + (1 - alpha) * w
    return X / d, Y / d


def cylindrical(X, Y, Z):
    return mp.atan2(X, Z), Y / mp.hypot(X, Z)


FRASER_MM = fraser(mp.mpf("28.5"), vec("1.2e-4", "-1.1e-7", "2e-11"), vec("1.3e-5", "-2.1e-5"), vec("-1e-4", "2e-4"))
FRASER = fraser(mp.mpf(1), vec("0.0974", "-0.0725", "0.011"), vec("0.00037", "-0.0006"), vec("-1e-4", "2e-4"))
CASES = [
    ('"model": "metashape", "k": [-0.11, 0.017, 0.004, -0.0006], "p": [0.0012, -0.0007, 0.03, -0.02]', metashape),
    ('"model": "fraser", "principal_distance_mm": 28.5, "k": [1.2e-4, -1.1e-7, 2e-11], "p": [1.3e-5, -2.1e-5], '
     '"b": [-1e-4, 2e-4]', FRASER_MM),
    ('"model": "fraser", "k": [0.0974, -0.0725, 0.011], "p": [0.00037, -0.0006], "b": [-1e-4, 2e-4]', FRASER),
    ('"model": "unified", "xi": 1.21, "k": [-0.11, 0.017, 0.004], "p": [0.0012, -0.0007]', unified),
    ('"model": "double_sphere", "xi": -0.2, "alpha": 0.59', double_sphere),
    ('"model": "cylindrical"', cylindrical),
] + [
    ('"model": "fisheye", "projection": "%s", "k": [0.02, -0.004, 0.001, 0]' % name, by_angle(radius))
    for name, radius in [("equidistant", lambda t: t), ("stereographic", lambda t: 2 * mp.tan(t / 2)),
                         ("equisolid", lambda t: 2 * mp.sin(t / 2)), ("orthographic", mp.sin)]
]

out = []
for fields, plane in CASES:
    skew = mp.mpf(0) if "cylindrical" in fields else S
    points = []
    for direction in DIRECTIONS:
        x, y = plane(*vec(*direction))
        image = [float(FX * x + skew * y + X0), float(FY * y + Y0)]
        points.append({"direction": [float(c) for c in direction], "image": image})
    size = '"principal_distance": [611.3, 598.7], "principal_point": [513.4, 391.9]'
    out.append({"interior": f"{fields}, {size}" + (', "skew": 0.7' if skew else ""), "points": points})
print("[\n" + ",\n".join(map(json.dumps, out)) + "\n]")
