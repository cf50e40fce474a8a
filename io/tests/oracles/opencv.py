"""Calibrations written by OpenCV's FileStorage, with the images of world points.

    python3 opencv.py FOLDER       (opencv-python-headless 5.0.0) writes FOLDER/*.yml, *.json, *.xml and expected.json
    python3 opencv.py --read FILE  prints the images of the same points through a calibration with rvec and tvec
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np

WORLD = np.array([[0.3, -0.2, 0.5], [-1.1, 0.7, 0.25], [0.9, 1.2, -0.4], [1 / 3, 2 / 7, 0.1]])
K = np.array([[1203.5, 0, 639.25], [0, 1187.25, 481.75], [0, 0, 1]])
POSE = [0.1, -0.2, 0.3, 0.4, -0.3, 6.0]
D = [-0.281, 0.0713, 1.1e-3, -6.2e-4, 0.0131, 0.0172, -0.0214, 0.0036, 8.3e-4, -4.1e-4, -7.7e-4, 2.9e-4, 0.031, -0.047]
CASES = {
    "brown.yml": (D[:5], False),
    "rational.json": (D[:8], False),
    "tilted.yml": (D, False),
    "fisheye.yml": ([0.031, -0.015, 0.0063, -0.0011], True),
    "tilted.xml": (D, False),
    "brown.xml": (D[:5], False),
    "fisheye.xml": ([0.031, -0.015, 0.0063, -0.0011], True),
}


def project(k, d, fisheye, pose):
    r, t = np.array(pose[:3]), np.array(pose[3:])
    points = WORLD.reshape(-1, 1, 3)
    if fisheye:
        image, _ = cv2.fisheye.projectPoints(points, r.reshape(3, 1), t.reshape(3, 1), k, np.array(d))
    else:
        image, _ = cv2.projectPoints(points, r, t, k, np.array(d))
    return image.reshape(-1, 2).tolist()


if sys.argv[1] == "--read":
    f = cv2.FileStorage(sys.argv[2], cv2.FILE_STORAGE_READ)
    get = lambda name: f.getNode(name).mat()
    fisheye = f.getNode("fisheye_model").real() == 1
    pose = np.concatenate([get("rvec").ravel(), get("tvec").ravel()])
    print(json.dumps(project(get("camera_matrix"), get("distortion_coefficients"), fisheye, pose)))
    sys.exit()

folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
expected = {"program": f"OpenCV {cv2.__version__}", "world": WORLD.tolist(), "images": {}}
for name, (d, fisheye) in CASES.items():
    f = cv2.FileStorage(str(folder / name), cv2.FILE_STORAGE_WRITE)
    f.write("image_width", 1280)
    f.write("image_height", 960)
    f.write("fisheye_model", int(fisheye))
    f.write("camera_matrix", K)
    f.write("distortion_coefficients", np.array(d).reshape(1, -1))
    second = [c + 0.01 for c in POSE]
    f.write("extrinsic_parameters", np.array([POSE, second]))
    f.write("avg_reprojection_error", 0.31)
    f.release()
    expected["images"][name] = [project(K, d, fisheye, pose) for pose in (POSE, second)]
(folder / "expected.json").write_text(json.dumps(expected) + "\n")
