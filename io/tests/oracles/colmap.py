"""A reconstruction written by pycolmap, text and binary, with the images of world points.

    python3 colmap.py FOLDER       (pycolmap 4.2.1) writes FOLDER/text, FOLDER/binary and FOLDER/expected.json
    python3 colmap.py --read A B   says whether pycolmap reads the same from the folders A and B
"""

import json
import sys
from pathlib import Path

import numpy as np
import pycolmap

K = [0.031, -0.015, 0.0063, -0.0011]
CAMERAS = [
    ("SIMPLE_RADIAL", [611.3, 513.4, 391.9, -0.11]),
    ("OPENCV", [611.3, 598.7, 513.4, 391.9, -0.11, 0.023, 1.1e-3, -6e-4]),
    ("FULL_OPENCV", [611.3, 598.7, 513.4, 391.9, -0.281, 0.0713, 1.1e-3, -6.2e-4, 0.0131, 0.0172, -0.0214, 0.0036]),
    ("THIN_PRISM_FISHEYE", [611.3, 598.7, 513.4, 391.9, K[0], K[1], 1.2e-3, -7e-4, K[2], K[3], 9e-4, -5e-4]),
    ("EUCM", [611.3, 598.7, 513.4, 391.9, 0.57, 1.13]),
    ("EQUIRECTANGULAR", [1024.0, 768.0]),
]
WORLD = [[0.3, -0.2, 5.0], [-1.1, 0.7, 6.5], [0.9, 1.2, 4.75], [1 / 3, 2 / 7, 5.9]]


def build():
    model = pycolmap.Reconstruction()
    for i, (name, parameters) in enumerate(CAMERAS):
        camera = pycolmap.Camera(camera_id=2 * i + 1, model=name, width=1024, height=768, params=parameters)
        model.add_camera_with_trivial_rig(camera)
        quaternion = np.array([0.02 * i, -0.03 + 0.01 * i, 0.05, 1.0])  # x, y, z, w
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(quaternion / np.linalg.norm(quaternion)), [0.1 * i, -0.2, 1.0 / (i + 3)])
        observations = [camera.img_from_cam(pose * np.array(X)) for X in WORLD] if i < 4 else []
        image = pycolmap.Image(
            image_id=i + 4, name=f"photo_{i}.jpg", camera_id=camera.camera_id,
            points2D=pycolmap.Point2DList([pycolmap.Point2D(p) for p in observations]),
        )
        model.add_image_with_trivial_frame(image, pose)
    for k, X in enumerate(WORLD[:3]):
        track = pycolmap.Track([pycolmap.TrackElement(i + 4, k) for i in range(4)])
        model.add_point3D(np.array(X), track, np.array([10 * k, 20, 255], dtype=np.uint8))
    return model


def summary(folder):
    model = pycolmap.Reconstruction(folder)
    images = {
        i.name: [i.camera_id, i.cam_from_world().matrix().tolist(), [[*p.xy, p.point3D_id] for p in i.points2D]]
        for i in model.images.values()
    }
    cameras = {k: [c.model.name, c.width, c.height, c.params.tolist()] for k, c in model.cameras.items()}
    points = {
        k: [p.xyz.tolist(), p.color.tolist(), p.error, sorted((e.image_id, e.point2D_idx) for e in p.track.elements)]
        for k, p in model.points3D.items()
    }
    return [cameras, images, points]


if sys.argv[1] == "--read":
    a, b = (summary(f) for f in sys.argv[2:4])
    close = json.dumps(a) == json.dumps(b)
    print("the same" if close else f"different\n{json.dumps(a)}\n{json.dumps(b)}")
else:
    folder = Path(sys.argv[1])
    model = build()
    for name, write in (("text", model.write_text), ("binary", model.write_binary)):
        (folder / name).mkdir(parents=True, exist_ok=True)
        write(folder / name)
    expected = {
        image.name: [[X, model.cameras[image.camera_id].img_from_cam(image.cam_from_world() * np.array(X)).tolist()] for X in WORLD]
        for image in model.images.values()
    }
    (folder / "expected.json").write_text(json.dumps({"program": f"pycolmap {pycolmap.__version__}", "images": expected}) + "\n")
