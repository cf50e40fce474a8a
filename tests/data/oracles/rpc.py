# mpmath 1.3.0 (60 digits), GDAL 3.10.3 through rasterio 1.4.4, numpy 2.4.6, Python 3.11: a rational polynomial camera whose eighty
# coefficients are all different from zero. Its numbers are made here; they are those of no satellite.
import json

import mpmath as mp
import numpy as np
from rasterio.rpc import RPC
from rasterio.transform import RPCTransformer

mp.mp.dps = 60
rng = np.random.default_rng(7)


def polynomial(constant, first, second, third):
    return [constant, *first, *(rng.uniform(0.4, 1, 6) * rng.choice([-1, 1], 6) * second), *(rng.uniform(0.4, 1, 10) * rng.choice([-1, 1], 10) * third)]


model = dict(
    line_offset=4213.25, sample_offset=6120.75, latitude_offset_deg=44.137, longitude_offset_deg=5.285, height_offset=1075.0,
    line_scale=4250.5, sample_scale=6199.5, latitude_scale_deg=0.0989, longitude_scale_deg=0.1287, height_scale=885.0,
    line_numerator=polynomial(0.0013, [0.061, -1.021, 0.0172], 0.004, 3e-4), line_denominator=polynomial(1.0, [3e-3, -2e-3, 1.5e-3], 7e-4, 8e-5),
    sample_numerator=polynomial(-0.0042, [1.013, 0.083, -0.0311], 0.005, 4e-4), sample_denominator=polynomial(1.0, [-2e-3, 4e-3, -1e-3], 6e-4, 9e-5),
    error_bias=0.64, error_random=0.12)

# The terms of RPC00B as STDI-0002 prints them, each as exponents of L, P, H.
TERMS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (2, 0, 0), (0, 2, 0), (0, 0, 2),
         (1, 1, 1), (3, 0, 0), (1, 2, 0), (1, 0, 2), (2, 1, 0), (0, 3, 0), (0, 1, 2), (2, 0, 1), (0, 2, 1), (0, 0, 3)]


def num(x):
    return mp.mpf(float(x))


def image(lon, lat, h, m=model):
    L, P, H = [(v - num(m[k + o])) / num(m[k + s]) for v, k, o, s in
               [(lon, "longitude", "_offset_deg", "_scale_deg"), (lat, "latitude", "_offset_deg", "_scale_deg"), (h, "height", "_offset", "_scale")]]
    at = lambda name: mp.fsum(num(c) * L**i * P**j * H**k for c, (i, j, k) in zip(m[name], TERMS))
    line = num(m["line_offset"]) + num(m["line_scale"]) * at("line_numerator") / at("line_denominator")
    sample = num(m["sample_offset"]) + num(m["sample_scale"]) * at("sample_numerator") / at("sample_denominator")
    # Pixels from the corner of the first one.
    return sample + mp.mpf("0.5"), line + mp.mpf("0.5")


points = []
for _ in range(40):
    lon = model["longitude_offset_deg"] + rng.uniform(-1.2, 1.2) * model["longitude_scale_deg"]
    lat = model["latitude_offset_deg"] + rng.uniform(-1.2, 1.2) * model["latitude_scale_deg"]
    h = model["height_offset"] + rng.uniform(-1.2, 1.2) * model["height_scale"]
    x, y = image(num(lon), num(lat), num(h))
    e = mp.mpf(10) ** -20
    rad = mp.pi / 180
    slope = lambda f: [(a - b) / (2 * e) for a, b in zip(f(e), f(-e))]
    # Slopes a radian and a metre, by 60-digit differences of the formula.
    by_lat = slope(lambda d: image(num(lon), num(lat) + d / rad, num(h)))
    by_lon = slope(lambda d: image(num(lon) + d / rad, num(lat), num(h)))
    by_h = slope(lambda d: image(num(lon), num(lat), num(h) + d))
    points.append(dict(longitude_deg=lon, latitude_deg=lat, height=h, image=[float(x), float(y)],
                       by_latitude=[float(v) for v in by_lat], by_longitude=[float(v) for v in by_lon], by_height=[float(v) for v in by_h]))

# The same points by GDAL, whose pixel coordinates are this crate's.
rpc = RPC(height_off=model["height_offset"], height_scale=model["height_scale"], lat_off=model["latitude_offset_deg"], lat_scale=model["latitude_scale_deg"],
          line_den_coeff=model["line_denominator"], line_num_coeff=model["line_numerator"], line_off=model["line_offset"], line_scale=model["line_scale"],
          long_off=model["longitude_offset_deg"], long_scale=model["longitude_scale_deg"], samp_den_coeff=model["sample_denominator"],
          samp_num_coeff=model["sample_numerator"], samp_off=model["sample_offset"], samp_scale=model["sample_scale"], err_bias=None, err_rand=None)
with RPCTransformer(rpc) as transformer:
    rows, cols = transformer.rowcol([p["longitude_deg"] for p in points], [p["latitude_deg"] for p in points], zs=[p["height"] for p in points], op=lambda v: v)
for p, r, c in zip(points, rows, cols):
    p["gdal"] = [float(c), float(r)]
print("largest difference between GDAL and 60 digits:", max(abs(a - b) for p in points for a, b in zip(p["gdal"], p["image"])))

# Corrections: the least-squares estimate by the normal equations in 60 digits.
ground, measured, sigma = [], [], []
for p in points[:9]:
    q = [num(v) for v in p["image"]]
    noise = rng.normal(0, 0.4, 2)
    u = [q[0] + 3 + 2e-4 * (q[1] - 4000) + num(noise[0]), q[1] - 5 + 1e-4 * (q[0] - 6000) + num(noise[1])]
    measured.append([float(v) for v in u])
    sigma.append([float(v) for v in rng.uniform(0.2, 0.7, 2)])
corrections = {}
cx, cy = num(model["sample_offset"]) + mp.mpf("0.5"), num(model["line_offset"]) + mp.mpf("0.5")
for name, unknowns in [("shift", 1), ("shift_and_drift", 2), ("affine", 3)]:
    values, cofactors, total, residuals = [], [], mp.mpf(0), []
    for axis in range(2):
        A, b, w = mp.zeros(9, unknowns), mp.zeros(9, 1), mp.zeros(9)
        for i, p in enumerate(points[:9]):
            x, y = image(num(p["longitude_deg"]), num(p["latitude_deg"]), num(p["height"]))
            for j, t in enumerate([mp.mpf(1), y - cy, x - cx][:unknowns]):
                A[i, j] = t
            b[i] = num(measured[i][axis]) - (x, y)[axis]
            w[i, i] = 1 / num(sigma[i][axis]) ** 2
        Q = (A.T * w * A) ** -1
        s = Q * (A.T * w * b)
        v = b - A * s
        total += (v.T * w * v)[0]
        values.append([float(k) for k in s])
        cofactors.append(Q)
        residuals.append([float(k) for k in v])
    redundancy = 18 - 2 * unknowns
    sigma0 = mp.sqrt(total / redundancy)
    corrections[name] = dict(x=values[0], y=values[1], sigma0=float(sigma0), redundancy=redundancy, residuals_x=residuals[0], residuals_y=residuals[1],
                             covariance_x=[float(sigma0**2 * cofactors[0][i, j]) for i in range(unknowns) for j in range(unknowns)],
                             covariance_y=[float(sigma0**2 * cofactors[1][i, j]) for i in range(unknowns) for j in range(unknowns)])

json.dump(dict(model=model, points=points, measured=measured, sigma=sigma, corrections=corrections), open("rpc.json", "w"), indent=0)
