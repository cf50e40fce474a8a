"""A block with control points, antenna positions, attitudes and a distance, adjusted by numpy alone.

Writes the files of cli/tests/data/given: the block in a frame of its own (BAL), what was given in map coordinates, and
expected.json, the minimum of the same sum of squares by Gauss-Newton with numerical partials, its redundancies, and the variance
components by repeated adjustment. Nothing of collinear takes part. numpy 2, Python 3.
"""

import json
from pathlib import Path

import numpy as np

OUT = Path(__file__).parent.parent / "data" / "given"
rng = np.random.default_rng(20)
ORIGIN = np.array([389400.0, 5819700.0, 40.0])
F = 1000.0
FLIP = np.diag([1.0, -1.0, -1.0])
LEVER = np.array([0.3, -0.2, 0.9])


def rotation(o, p, k):
    """M = R3(k) R2(p) R1(o): photo (x right, y up, z back) from world."""
    c, s = np.cos, np.sin
    r1 = np.array([[1, 0, 0], [0, c(o), s(o)], [0, -s(o), c(o)]])
    r2 = np.array([[c(p), 0, -s(p)], [0, 1, 0], [s(p), 0, c(p)]])
    r3 = np.array([[c(k), s(k), 0], [-s(k), c(k), 0], [0, 0, 1]])
    return r3 @ r2 @ r1


def exp(v):
    t = np.linalg.norm(v)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    if t < 1e-12:
        return np.eye(3) + k
    return np.eye(3) + np.sin(t) / t * k + (1 - np.cos(t)) / t**2 * k @ k


def log(r):
    """Of a small rotation."""
    v = 0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    s = np.linalg.norm(v)
    return v if s < 1e-12 else v * np.arcsin(s) / s


angles = np.radians(np.array([[2, -1, 5], [-1, 3, -4], [1, 1, 93], [-3, 0, 88], [2, 2, -6], [0, -2, 2.0]]))
centers = np.array([[-30, -15, 100], [0, -17, 103], [31, -14, 98], [-29, 16, 101], [1, 15, 99], [30, 17, 102.0]])
ties = np.column_stack([rng.uniform(-45, 45, 20), rng.uniform(-30, 30, 20), rng.uniform(-8, 8, 20)])
control = np.array([[-38, -24, 1], [36, -22, -4], [-35, 25, 5], [39, 23, 2], [2, 1, -6.0]])
checks = np.array([[-12, 14, 2], [15, -11, -3.0]])
points = np.vstack([ties, control, checks])
n_tie, n_control = len(ties), len(control)
PX, CLICK = 0.5, 0.4
S_CONTROL, S_POSITION = np.array([0.02, 0.02, 0.03]), np.array([0.04, 0.05, 0.06])
S_ATTITUDE = np.radians(np.array([0.02, 0.03, 0.05]))
S_DISTANCE = 0.01


def image(m, c, x):
    d = m @ (x - c)
    return F * np.array([-d[0] / d[2], -d[1] / d[2]])


seen = []
for j, x in enumerate(points):
    for i, (a, c) in enumerate(zip(angles, centers)):
        at = image(rotation(*a), c, x)
        if np.abs(at).max() < 480:
            # Worse than stated, the clicks better.
            sigma = 0.7 if j < n_tie else 0.3
            seen.append((i, j, *np.round(at + rng.normal(0, sigma, 2), 2)))
given_control = np.round(control + rng.normal(0, 1, control.shape) * S_CONTROL, 3)
given_positions = np.array(
    [c + (FLIP @ rotation(*a)).T @ LEVER + rng.normal(0, 1, 3) * 1.5 * S_POSITION for a, c in zip(angles, centers)]
).round(3)
given_angles = np.degrees(angles + rng.normal(0, 1, angles.shape) * S_ATTITUDE).round(4)
ends = (n_tie, n_tie + n_control + 1)
length = round(float(np.linalg.norm(points[ends[0]] - points[ends[1]])) + 0.006, 3)

# Attitudes: the covariance of a turn about camera axes by numerical partials.
attitudes = []
for a in np.radians(given_angles):
    r = FLIP @ rotation(*a)
    h = 1e-6
    turn = np.column_stack(
        [(log(FLIP @ rotation(*(a + h * e)) @ r.T) - log(FLIP @ rotation(*(a - h * e)) @ r.T)) / (2 * h) for e in np.eye(3)]
    )
    covariance = turn @ np.diag(S_ATTITUDE**2) @ turn.T
    attitudes.append((r, np.linalg.inv(np.linalg.cholesky(covariance))))


def apply(state, d):
    rotations, places = state
    n = len(rotations)
    d = d.reshape(-1, 3)
    return (
        [exp(d[2 * i + 1]) @ r for i, r in enumerate(rotations)],
        np.vstack([places[:n] + d[0 : 2 * n : 2], places[n:] + d[2 * n :]]),
    )


def residuals(state, factors):
    """Observed less computed, in standard deviations; the group of each."""
    rotations, places = state
    n = len(rotations)
    c, x = places[:n], places[n:]
    v, g = [], []

    def add(group, values):
        v.extend(np.atleast_1d(values) / factors[group])
        g.extend([group] * np.size(values))

    for i, j, a, b in seen:
        group = 0 if j < n_tie else 1
        at = image(FLIP @ rotations[i], c[i], x[j])
        add(group, (np.array([a, b]) - at) / (PX if group == 0 else CLICK))
    for k in range(n_control):
        add(2, (given_control[k] - x[n_tie + k]) / S_CONTROL)
    for i in range(n):
        add(3, (given_positions[i] - (c[i] + rotations[i].T @ LEVER)) / S_POSITION)
    for i, (observed, whiten) in enumerate(attitudes):
        add(4, -whiten @ log(rotations[i] @ observed.T))
    add(5, (length - np.linalg.norm(x[ends[0]] - x[ends[1]])) / S_DISTANCE)
    return np.array(v), np.array(g)


def adjust(state, factors):
    size = 6 * len(state[0]) + 3 * len(points)
    for _ in range(5):
        v, groups = residuals(state, factors)
        h = 1e-5
        j = np.column_stack(
            [(residuals(apply(state, h * e), factors)[0] - residuals(apply(state, -h * e), factors)[0]) / (2 * h) for e in np.eye(size)]
        )
        d = -np.linalg.solve(j.T @ j, j.T @ v)
        state = apply(state, d)
        if np.abs(d).max() < 1e-9:
            break
    v, groups = residuals(state, factors)
    redundancy = 1 - np.einsum("ij,ji->i", j, np.linalg.solve(j.T @ j, j.T))
    return state, v, groups, redundancy


def estimate(state):
    """Without the distance, whose one number nothing tells the precision of."""
    factors = np.array([1, 1, 1, 1, 1, 1e9])
    for _ in range(40):
        state, v, groups, r = adjust(state, factors)
        step = np.array([np.sqrt((v[groups == g] ** 2).sum() / r[groups == g].sum()) for g in range(5)])
        factors[:5] *= step
        if np.abs(step - 1).max() < 1e-6:
            break
    return factors[:5]


start = ([FLIP @ rotation(*a) for a in angles], np.vstack([centers, points]))
state, v, groups, r = adjust(start, np.ones(6))
n = len(angles)
place = lambda p: [float(q) for q in p + ORIGIN]
expected = {
    "observations": len(v),
    "unknowns": 6 * n + 3 * len(points),
    "cost": float(0.5 * v @ v),
    "centers": [place(c) for c in state[1][:n]],
    "control_residual": [[float(q) for q in v[groups == 2][3 * k : 3 * k + 3] * S_CONTROL] for k in range(n_control)],
    "control_redundancy": [[float(q) for q in r[groups == 2][3 * k : 3 * k + 3]] for k in range(n_control)],
    "position_residual": [[float(q) for q in v[groups == 3][3 * k : 3 * k + 3] * S_POSITION] for k in range(n)],
    "attitude_residual_deg": [
        [float(q) for q in np.degrees(-log(state[0][i] @ attitudes[i][0].T))] for i in range(n)
    ],
    "distance_residual": float(v[groups == 5][0] * S_DISTANCE),
    "check": [[float(q) for q in state[1][n + n_tie + n_control + k] - checks[k]] for k in range(len(checks))],
    "redundancies": [float(r[groups == g].sum()) for g in range(6)],
    "factors": [float(f) for f in estimate(state)],
}

# The block in its own frame: turned, a 20th of the size, with a rough start.
turn, scale = rotation(0.7, -0.4, 1.1), 0.05
rough = lambda p: scale * turn @ (p + rng.normal(0, 0.3, 3))
lines = [f"{n} {n_tie} {sum(1 for s in seen if s[1] < n_tie)}"]
lines += [f"{i} {j} {a:.2f} {b:.2f}" for i, j, a, b in seen if j < n_tie]
for a, c in zip(angles, centers):
    m = exp(rng.normal(0, 0.005, 3)) @ rotation(*a) @ turn.T
    axis = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    vector = axis / np.linalg.norm(axis) * np.arccos((np.trace(m) - 1) / 2)
    t = -m @ rough(c)
    lines.append(" ".join(f"{q:.9f}" for q in [*vector, *t, F, 0, 0]))
lines += [" ".join(f"{q:.9f}" for q in rough(x)) for x in ties]
OUT.mkdir(exist_ok=True)
write = lambda name, lines: (OUT / name).write_text("\n".join(lines) + "\n")
write("block.txt", lines)
names = [f"c{k}" for k in range(n_control)] + [f"k{k}" for k in range(len(checks))]
row = lambda *cells: ",".join(c if isinstance(c, str) else f"{c:.6f}".rstrip("0").rstrip(".") for c in cells)
write("control.csv", ["id,X,Y,Z,sigma_X,sigma_Y,sigma_Z"] + [row(names[k], *(given_control[k] + ORIGIN), *S_CONTROL) for k in range(n_control)])
write("check.csv", ["id,X,Y,Z"] + [row(names[n_control + k], *(checks[k] + ORIGIN)) for k in range(len(checks))])
# Pixels of the program: y down.
write("clicks.csv", ["photo,id,x,y,sigma"] + [row(str(i), names[j - n_tie], a, -b, CLICK) for i, j, a, b in seen if j >= n_tie])
write("positions.csv", ["photo,X,Y,Z,sigma_X,sigma_Y,sigma_Z"] + [row(str(i), *(p + ORIGIN), *S_POSITION) for i, p in enumerate(given_positions)])
write(
    "attitudes.csv",
    ["photo,omega,phi,kappa,sigma_omega,sigma_phi,sigma_kappa"]
    + [row(str(i), *a, *np.degrees(S_ATTITUDE)) for i, a in enumerate(given_angles)],
)
write("distances.csv", ["from,to,length,sigma", row(names[0], names[n_control + 1], length, S_DISTANCE)])
(OUT / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")
