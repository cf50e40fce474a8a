"""Cameras made, projected, exported and imported by Blender.

    python3 blender.py --record FOLDER     (bpy 5.0.1) writes FOLDER/cameras.json and FOLDER/exported.gltf, exported.glb with
                                           exported.json: cameras of every fit, and the pixels of world points
    python3 blender.py --script FILE POINTS    runs a script of collinear's and prints the pixels of the points in POINTS, {"points", "size"}, in its cameras
    python3 blender.py --import FILE POINTS    imports a glTF file and prints the same

Pixels are bpy_extras.object_utils.world_to_camera_view (x, 1 - y) times the resolution, checked against
Object.calc_matrix_camera. Blender turns glTF's y up into its z up: (x, y, z) of the file is (x, -z, y) in Blender.
"""

import json
import sys
from pathlib import Path

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Euler, Matrix, Vector


def pixels(scene, thing, points):
    scene.view_layers[0].update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    w, h = scene.render.resolution_x, scene.render.resolution_y
    matrix = thing.calc_matrix_camera(
        depsgraph, x=w, y=h, scale_x=scene.render.pixel_aspect_x, scale_y=scene.render.pixel_aspect_y
    ) @ thing.matrix_world.normalized().inverted()
    found = []
    for p in points:
        x, y, _ = world_to_camera_view(scene, thing, Vector(p))
        clip = matrix @ Vector((*p, 1))
        other = ((clip.x / clip.w + 1) / 2 * w, (1 - clip.y / clip.w) / 2 * h)
        assert abs(other[0] - x * w) < 2e-2 and abs(other[1] - (1 - y) * h) < 2e-2, (other, x * w, (1 - y) * h)
        found.append([x * w, (1 - y) * h])
    return found


def in_front(thing):
    """World points before the camera, rounded so that single precision holds them."""
    m = thing.matrix_world
    return [[round(c * 64) / 64 for c in m @ Vector(p)] for p in [(0, 0, -8), (1.5, -1, -7), (-2, 1.25, -9), (0.5, 1.75, -6)]]


def clear():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


def camera(name, place=(1, -2, 3), turn=(1.1, 0.2, -0.7), **settings):
    data = bpy.data.cameras.new(name)
    for key, value in settings.items():
        setattr(data, key, value)
    thing = bpy.data.objects.new(name, data)
    thing.matrix_world = Matrix.LocRotScale(Vector(place), Euler(turn), None)
    bpy.context.scene.collection.objects.link(thing)
    return thing


CASES = [
    ((1920, 1080), (1, 1), dict(lens=35, shift_x=0.125, shift_y=-0.0625)),
    ((1080, 1920), (1, 1), dict(lens=35, shift_x=0.125, shift_y=-0.0625)),
    ((1920, 1080), (1, 1), dict(lens=28, sensor_fit="HORIZONTAL", sensor_width=23.5, shift_y=0.25)),
    ((1080, 1920), (1, 1), dict(lens=28, sensor_fit="HORIZONTAL", sensor_width=23.5, shift_y=0.25)),
    ((1920, 1080), (1, 1), dict(lens=50, sensor_fit="VERTICAL", sensor_height=15.5, shift_x=-0.25)),
    ((1000, 800), (1, 1.5), dict(lens=50, shift_x=0.25, shift_y=0.125)),
    ((1000, 800), (1.25, 1), dict(lens=50, shift_x=0.25, shift_y=0.125)),
    ((1000, 800), (1, 1.5), dict(lens=50, sensor_fit="VERTICAL", sensor_height=22, shift_x=0.25, shift_y=0.125)),
    ((640, 480), (1, 1), dict(type="ORTHO", ortho_scale=12, shift_x=0.125, shift_y=0.0625)),
    ((480, 640), (1, 2), dict(type="ORTHO", ortho_scale=12, shift_x=0.125, shift_y=0.0625)),
]

mode = sys.argv[1]
if mode == "--record":
    folder = Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    recorded = []
    for (w, h), aspect, settings in CASES:
        scene = clear()
        thing = camera("c", **settings)
        scene.render.resolution_x, scene.render.resolution_y = w, h
        scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = aspect
        bpy.context.view_layer.update()
        d = thing.data
        lens = {"ortho_scale": d.ortho_scale} if d.type == "ORTHO" else {"lens_mm": d.lens}
        points = in_front(thing)
        recorded.append({
            "camera": {
                **lens, "sensor_width_mm": d.sensor_width, "sensor_height_mm": d.sensor_height,
                "sensor_fit": d.sensor_fit, "shift": [d.shift_x, d.shift_y], "resolution": [w, h],
                "pixel_aspect": list(aspect), "matrix_world": [list(r) for r in thing.matrix_world],
            },
            "pixels": [[p, i] for p, i in zip(points, pixels(scene, thing, points))],
        })
    program = f"Blender {bpy.app.version_string}"
    (folder / "cameras.json").write_text(json.dumps({"program": program, "cases": recorded}) + "\n")
    # A camera in a turned and scaled hierarchy, one beside it, and a parallel projection.
    scene = clear()
    scene.render.resolution_x, scene.render.resolution_y = 1600, 900
    parent = bpy.data.objects.new("parent", None)
    parent.matrix_world = Matrix.LocRotScale(Vector((4, 5, 6)), Euler((0.3, -0.4, 0.5)), Vector((2, 2, 2)))
    scene.collection.objects.link(parent)
    child = camera("child", lens=30)
    child.parent = parent
    camera("alone", place=(0.5, 0.25, -2), turn=(0.1, 0.9, 2.2), lens=45)
    camera("parallel", type="ORTHO", ortho_scale=10)
    bpy.context.view_layer.update()
    expected = {"program": program, "size": [1600, 900], "cameras": {}}
    for name in ["child", "alone", "parallel"]:
        thing = bpy.data.objects[name]
        points = in_front(thing)
        # In the file's own axes, y up.
        expected["cameras"][name] = [[[x, z, -y], i] for (x, y, z), i in zip(points, pixels(scene, thing, points))]
    for form, end in [("GLTF_EMBEDDED", "gltf"), ("GLB", "glb"), ("GLTF_SEPARATE", "gltf")]:
        try:
            bpy.ops.export_scene.gltf(filepath=str(folder / f"exported.{end}"), export_format=form, export_cameras=True)
        except TypeError:
            continue
    for left in folder.glob("*.bin"):
        left.unlink()
    (folder / "exported.json").write_text(json.dumps(expected) + "\n")
    sys.exit()

points = json.loads(Path(sys.argv[3]).read_text())
scene = clear()
if mode == "--script":
    exec(compile(Path(sys.argv[2]).read_text(), sys.argv[2], "exec"), {"__name__": "__main__"})
else:
    bpy.ops.import_scene.gltf(filepath=sys.argv[2])
found = {}
for scene in bpy.data.scenes:
    for thing in scene.objects:
        if thing.type != "CAMERA":
            continue
        if mode == "--import":
            size = points["size"]
            scene.render.resolution_x, scene.render.resolution_y = size
            scene.view_layers[0].update()
        w, h = scene.render.resolution_x, scene.render.resolution_y
        turned = points["points"]
        if mode == "--import":
            turned = [[x, -z, y] for x, y, z in turned]
        found[thing.name] = {"size": [w, h], "pixels": pixels(scene, thing, turned)}
print(json.dumps({"program": f"Blender {bpy.app.version_string}", "points": points["points"], **found}))
