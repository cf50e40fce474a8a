# OpenCV 5.0.0 (projectPoints), mpmath 1.3.0 (60 digits), numpy 2.4.6, Python 3.11: Brown's lens forward, back and its fold.
import json

import cv2
import mpmath as mp
import numpy as np

mp.mp.dps = 60
rng = np.random.default_rng(20)

# Forward through a whole camera by OpenCV; image points get +1/2, our pixel origin being the corner.
cameras = []
for _ in range(6):
    k = [rng.uniform(-0.3, 0.2), rng.uniform(-0.05, 0.1), rng.uniform(-0.01, 0.01)]
    p = [rng.uniform(-2e-3, 2e-3), rng.uniform(-2e-3, 2e-3)]
    f = rng.uniform(800, 3000)
    K = np.array([[f, 0, rng.uniform(400, 900)], [0, f * rng.uniform(0.98, 1.02), rng.uniform(300, 700)], [0, 0, 1.0]])
    rvec = rng.normal(size=3)
    R, _ = cv2.Rodrigues(rvec)
    t = rng.normal(size=3)
    inside = np.column_stack([rng.uniform(-0.45, 0.45, (8, 2)), np.ones(8)]) * rng.uniform(2, 50, (8, 1))
    world = (inside - t) @ R
    dist = np.array([k[0], k[1], p[0], p[1], k[2]])
    image, _ = cv2.projectPoints(world.reshape(-1, 1, 3), rvec, t, K, dist)
    cameras.append(dict(k=k, p=p, fx=K[0, 0], fy=K[1, 1], cx=K[0, 2], cy=K[1, 2], rotation=R.ravel().tolist(), translation=t.tolist(),
                        world=world.tolist(), image=(image.reshape(-1, 2)).tolist()))


def distort(x, y, k, p):
    r2 = x * x + y * y
    radial = 1 + k[0] * r2 + k[1] * r2**2 + k[2] * r2**3
    return (x * radial + 2 * p[0] * x * y + p[1] * (r2 + 2 * x * x), y * radial + p[0] * (r2 + 2 * y * y) + 2 * p[1] * x * y)


# Folds by the smallest positive root of the Jacobian's determinant along the worst direction, and points out to it.
folds = []
for k, p in [([-0.3, 0.0, 0.0], [0.0, 0.0]), ([-0.28, 0.01, 0.002], [1e-3, -5e-4]), ([-0.2, -0.1, 0.03], [-2e-3, 1e-3]), ([0.09, -0.23, 0.0], [0.0, 0.0])]:
    k, p = [mp.mpf(repr(c)) for c in k], [mp.mpf(repr(c)) for c in p]
    q = mp.sqrt(p[0]**2 + p[1]**2)
    direction = (-p[1] / q, -p[0] / q) if q else (mp.mpf(1), mp.mpf(0))

    def det(r):
        # The determinant by a 60-digit difference quotient of the formula itself.
        x, y, h = direction[0] * r, direction[1] * r, mp.mpf(10) ** -25
        a, b = distort(x + h, y, k, p), distort(x - h, y, k, p)
        c, d = distort(x, y + h, k, p), distort(x, y - h, k, p)
        return ((a[0] - b[0]) * (d[1] - c[1]) * -1 - (a[1] - b[1]) * (d[0] - c[0]) * -1) / (4 * h * h)

    r, step = mp.mpf("0.01"), mp.mpf("0.01")
    while det(r) > 0 and r < 5:
        r += step
    low, high = r - step, r
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if det(middle) > 0 else (low, middle)
    fold = low
    points = []
    for share in ["0.1", "0.5", "0.9", "0.99", "0.9999"]:
        for angle in [0.3, 1.9, 4.0]:
            x, y = fold * mp.mpf(share) * mp.cos(angle), fold * mp.mpf(share) * mp.sin(angle)
            x, y = mp.mpf(float(x)), mp.mpf(float(y))
            u, v = distort(x, y, k, p)
            points.append([float(x), float(y), float(u), float(v)])
    folds.append(dict(k=[float(c) for c in k], p=[float(c) for c in p], fold_radius=float(fold), points=points))

print(json.dumps(dict(opencv=cv2.__version__, mpmath=mp.__version__, cameras=cameras, folds=folds)))
