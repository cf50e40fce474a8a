"""A reconstruction with a camera of each of OpenSfM's types, and the images of world points by OpenSfM's own equations.

    python3 opensfm.py FOLDER       (mpmath 1.3, 40 digits) writes FOLDER/reconstruction.json and FOLDER/expected.json
    python3 opensfm.py --read FILE  prints the images of the same points through the shots of another reconstruction

The equations are those of mapillary/OpenSfM on GitHub, opensfm/src/geometry: camera_projections_functions.h at 45a1b15d,
camera_distortions_functions.h at 07af453c, transformations_functions.h at 43eed6c2, and the fields those of opensfm/io.py at
023d0573. OpenSfM itself is in no package index.
"""

import json
import sys
from pathlib import Path

from mpmath import atan2, cos, mp, mpf, pi, sin, sqrt

mp.dps = 40
WORLD = [[0.3, -0.2, 0.5], [-1.1, 0.7, 0.25], [0.9, 1.2, -0.4], [2.5, -1.75, 0.125]]


def rotate(r, p):
    """Rodrigues: the axis-angle r applied to p."""
    angle = sqrt(sum(mpf(c) ** 2 for c in r))
    if angle == 0:
        return list(p)
    a = [mpf(c) / angle for c in r]
    cross = [a[1] * p[2] - a[2] * p[1], a[2] * p[0] - a[0] * p[2], a[0] * p[1] - a[1] * p[0]]
    dot = sum(x * y for x, y in zip(a, p))
    return [p[i] * cos(angle) + cross[i] * sin(angle) + a[i] * dot * (1 - cos(angle)) for i in range(3)]


def perspective(p):
    return p[0] / p[2], p[1] / p[2]


def fisheye(p):
    r = sqrt(p[0] ** 2 + p[1] ** 2)
    theta = atan2(r, p[2])
    return theta / r * p[0], theta / r * p[1]


def distort(x, y, k, p1=0, p2=0, s=(0, 0, 0, 0)):
    r2 = x * x + y * y
    radial = 1 + sum(mpf(c) * r2 ** (i + 1) for i, c in enumerate(k))
    tx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    ty = 2 * p2 * x * y + p1 * (r2 + 2 * y * y)
    return x * radial + tx + s[0] * r2 + s[1] * r2 * r2, y * radial + ty + s[2] * r2 + s[3] * r2 * r2


def normalised(c, p):
    get = lambda *names: [mpf(c.get(n, 0)) for n in names]
    kind = c["projection_type"]
    if kind in ("spherical", "equirectangular"):
        longitude = atan2(p[0], p[2])
        latitude = atan2(-p[1], sqrt(p[0] ** 2 + p[2] ** 2))
        return longitude / (2 * pi), -latitude / (2 * pi)
    if kind in ("perspective", "fisheye", "dual"):
        if kind == "dual":
            t = mpf(c["transition"])
            (a, b), (d, e) = perspective(p), fisheye(p)
            x, y = t * a + (1 - t) * d, t * b + (1 - t) * e
        else:
            x, y = perspective(p) if kind == "perspective" else fisheye(p)
        x, y = distort(x, y, get("k1", "k2"))
        return mpf(c["focal"]) * x, mpf(c["focal"]) * y
    x, y = fisheye(p) if kind.startswith("fisheye") else perspective(p)
    count = {"simple_radial": 1, "radial": 2, "brown": 3, "fisheye_opencv": 4, "fisheye62": 6, "fisheye624": 6}[kind]
    k = get(*(f"k{i + 1}" for i in range(count)))
    p1, p2 = get("p1", "p2") if kind in ("brown", "fisheye62", "fisheye624") else (0, 0)
    s = get("s0", "s1", "s2", "s3") if kind == "fisheye624" else (0, 0, 0, 0)
    x, y = distort(x, y, k, p1, p2, s)
    cx, cy = get("c_x", "c_y")
    return mpf(c["focal_x"]) * x + cx, mpf(c["focal_y"]) * y + cy


def images(reconstruction):
    """Pixels from the top-left corner: features.py subtracts ½ from a pixel whose centre is an integer."""
    found = {}
    for name, shot in reconstruction["shots"].items():
        c = reconstruction["cameras"][shot["camera"]]
        longer = max(c["width"], c["height"])
        found[name] = []
        for world in WORLD:
            p = rotate(shot["rotation"], [mpf(v) for v in world])
            p = [a + mpf(b) for a, b in zip(p, shot["translation"])]
            x, y = normalised(c, p)
            found[name].append([float(x * longer + mpf(c["width"]) / 2), float(y * longer + mpf(c["height"]) / 2)])
    return found


if sys.argv[1] == "--read":
    print(json.dumps(images(json.loads(Path(sys.argv[2]).read_text())[0])))
    sys.exit()

size = {"width": 1280, "height": 960}
tall = {"width": 960, "height": 1280}
free = {"focal_x": 0.91, "focal_y": 0.88, "c_x": 0.013, "c_y": -0.021}
k = {"k1": -0.11, "k2": 0.021, "k3": -0.0043}
thin = {"k1": 0.031, "k2": -0.015, "k3": 0.0063, "k4": -0.0011}
p = {"p1": 1.1e-3, "p2": -6.2e-4}
s = {"s0": 8.3e-4, "s1": -4.1e-4, "s2": -7.7e-4, "s3": 2.9e-4}
six = {"k5": 2.1e-4, "k6": -3.3e-5}
two = lambda d: {n: d[n] for n in ("k1", "k2")}
cameras = {
    "perspective": {"projection_type": "perspective", **size, "focal": 0.87, **two(k)},
    "tall": {"projection_type": "perspective", **tall, "focal": 0.87, **two(k)},
    "simple": {"projection_type": "simple_radial", **size, **free, "k1": -0.11},
    "radial": {"projection_type": "radial", **tall, **free, **two(k)},
    "brown": {"projection_type": "brown", **size, **free, **k, **p},
    "fisheye": {"projection_type": "fisheye", **size, "focal": 0.46, **two(thin)},
    "opencv": {"projection_type": "fisheye_opencv", **tall, **free, **thin},
    "62": {"projection_type": "fisheye62", **size, **free, **thin, "k5": 0.0, "k6": 0.0, **p},
    "62 radial": {"projection_type": "fisheye62", **size, **free, **thin, **six, "p1": 0.0, "p2": 0.0},
    "624": {"projection_type": "fisheye624", **size, **free, **thin, **p, "s0": s["s0"], "s2": s["s2"]},
    "624 prism": {"projection_type": "fisheye624", **size, **free, **p, **s},
    "dual 1": {"projection_type": "dual", **size, "focal": 0.87, **two(k), "transition": 1.0},
    "dual 0": {"projection_type": "dual", **size, "focal": 0.46, **two(thin), "transition": 0.0},
    "spherical": {"projection_type": "spherical", "width": 2000, "height": 1000},
    "cut": {"projection_type": "equirectangular", "width": 2000, "height": 700},
}
rig, instance = {}, {}
reconstruction = {"cameras": cameras, "shots": {}, "points": {}, "biases": {}, "rig_cameras": rig, "rig_instances": instance}
for i, name in enumerate(cameras):
    # Newer files have rigs too; a shot carries its own pose all the same, here that of a rig of one camera.
    r, t = [0.1 + 0.01 * i, -0.2, 0.3], [0.4, -0.3 + 0.02 * i, 6.0]
    rig[name] = {"rotation": [0.0, 0.0, 0.0], "translation": [0.0, 0.0, 0.0]}
    instance[str(i)] = {"rotation": r, "translation": t, "rig_camera_ids": {f"{name}.jpg": name}}
    shot = {"rotation": r, "translation": t, "camera": name, "orientation": 1, "capture_time": 0.0, "gps_dop": 15.0}
    reconstruction["shots"][f"{name}.jpg"] = {**shot, "vertices": [], "faces": [], "scale": 1.0, "covariance": [], "merge_cc": 0}
folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
(folder / "reconstruction.json").write_text(json.dumps([reconstruction], indent=1) + "\n")
expected = {"world": WORLD, "images": images(reconstruction)}
(folder / "expected.json").write_text(json.dumps(expected) + "\n")
