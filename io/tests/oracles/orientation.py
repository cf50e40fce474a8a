"""The rotation of omega, phi, kappa and pixels of a camera, by Pix4D's published functions.

    python3 orientation.py      (numpy) writes orientation.json beside itself

Rx(omega) Ry(phi) Rz(kappa) turns photo axes (right, top, back) into the world's: make_basis_change_matrix_from_opk_in_degrees
and project_point of examples/compute_reprojection_error.py in Pix4D/pyopf.
"""

import json
from pathlib import Path

import numpy as np

o, p, q = np.radians([11.0, -23.0, 147.0])
rx = np.array([[1, 0, 0], [0, np.cos(o), -np.sin(o)], [0, np.sin(o), np.cos(o)]])
ry = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
rz = np.array([[np.cos(q), -np.sin(q), 0], [np.sin(q), np.cos(q), 0], [0, 0, 1]])
world_from_photo = rx @ ry @ rz
center = np.array([1000.0, 2000.0, 300.0])
k = np.array([[1200.0, 0, 650], [0, 1200, 470], [0, 0, 1]])
world_from_camera = world_from_photo @ np.diag([1, -1, -1])
seen = []
for right, down, forward in [(0, 0, 250), (60, -40, 260), (-90, 70, 240)]:
    world = np.round(center + world_from_camera @ [right, down, forward], 3)
    x, y, z = k @ world_from_camera.T @ (world - center)
    seen.append((world.tolist(), [x / z, y / z]))
expected = {"matrix": world_from_photo.ravel().tolist(), "seen": seen}
Path(__file__).with_suffix(".json").write_text(json.dumps(expected) + "\n")
