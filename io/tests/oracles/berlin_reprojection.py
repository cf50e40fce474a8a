# Python 3, numpy 2.4.6: run beside the files of ../shared/data/berlin
import json
import numpy as np

r = json.load(open("reconstruction_example.json"))[0]
cam = next(iter(r["cameras"].values()))
longer = max(cam["width"], cam["height"])
errors = []
for line in open("tracks_example.csv").read().splitlines()[1:]:
    image, track, _, x, y = line.split("\t")[:5]
    if track not in r["points"]:
        continue
    v = np.array(r["shots"][image]["rotation"])
    angle = np.linalg.norm(v)
    a, b, c = v / angle
    k = np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    rotation = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    p = rotation @ r["points"][track]["coordinates"] + r["shots"][image]["translation"]
    n = p[:2] / p[2]
    r2 = n @ n
    seen = cam["focal"] * (1 + cam["k1"] * r2 + cam["k2"] * r2 * r2) * n
    errors.append(longer * np.linalg.norm(seen - [float(x), float(y)]))
e = np.array(errors)
print(json.dumps({"count": len(e), "median": np.median(e), "rms": np.sqrt(np.mean(e * e)), "max": e.max()}))
