"""Pixels between two others by light and opacity, with 30 digits. python3 light.py > light.json (mpmath 1.4.1).

sRGB's curve as IEC 61966-2-1:1999 states it. A case is two pixels, the place between them, and what is expected there: of each
channel the value before it is rounded, in samples. The formulas stand here by themselves."""
import json
import random

import mpmath as mp

mp.mp.dps = 30
random.seed(7)


def light(s):
    return s / mp.mpf("12.92") if s <= mp.mpf("0.04045") else ((s + mp.mpf("0.055")) / mp.mpf("1.055")) ** mp.mpf("2.4")


def sample(l):
    return l * mp.mpf("12.92") if l <= mp.mpf("0.04045") / mp.mpf("12.92") else mp.mpf("1.055") * l ** (1 / mp.mpf("2.4")) - mp.mpf("0.055")


def between(a, b, f, full, curved, alpha):
    into, back = (light, sample) if curved else ((lambda x: x),) * 2

    def decode(p):
        p = [mp.mpf(x) / full for x in p]
        if alpha == "none":
            return [into(x) for x in p]
        o = p[-1]
        if alpha == "straight":
            return [into(x) * o for x in p[:-1]] + [o]
        return [into(x / o) * o if o > 0 else mp.mpf(0) for x in p[:-1]] + [o]

    mixed = [x + f * (y - x) for x, y in zip(decode(a), decode(b))]
    if alpha == "none":
        return [back(x) * full for x in mixed]
    o = mixed[-1]
    colours = [x / o if o > 0 else mp.mpf(0) for x in mixed[:-1]]
    made = [back(x) if alpha == "straight" else back(x) * o for x in colours]
    return [x * full for x in made + [o]]


cases = []
for full in (255, 65535):
    for curved in (True, False):
        for alpha in ("none", "straight", "premultiplied"):
            for k in range(40):
                pixels = [[random.randint(0, full) for _ in range(4)] for _ in range(2)]
                if k % 8 == 3:
                    pixels[0][3] = 0
                if k % 8 == 5:
                    pixels[1] = [random.randint(0, full // 40) for _ in range(3)] + [full]
                if alpha == "premultiplied":
                    pixels = [[x * p[3] // full for x in p[:3]] + [p[3]] for p in pixels]
                f = mp.mpf(random.randint(0, 1024)) / 1024
                expected = between(*pixels, f, full, curved, alpha)
                cases.append({"full": full, "srgb": curved, "alpha": alpha, "pixels": pixels, "fraction": float(f), "expected": [float(x) for x in expected]})
print(json.dumps({"program": "mpmath " + mp.__version__, "cases": cases}))
