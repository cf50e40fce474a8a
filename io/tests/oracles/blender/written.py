# Cameras for Blender: blender --python THIS_FILE
import json

import bpy
from mathutils import Matrix

CAMERAS = [
    json.loads("{\"name\":\"first\",\"lens_mm\":30.9375,\"sensor_width_mm\":36.0,\"sensor_height_mm\":27.0,\"sensor_fit\":\"HORIZONTAL\",\"shift\":[0.03125,0.0171875],\"resolution\":[1280,960],\"pixel_aspect\":[1.0,1.1],\"matrix_world\":[[0.7999999999999998,2.2482016248659418e-17,-0.6,-4.879999999999999],[-0.36000000000000004,-0.7999999999999998,-0.48,-3.6439999999999992],[-0.48,0.6,-0.6399999999999999,-5.191999999999999],[0.0,0.0,0.0,1.0]]}"),
    json.loads("{\"name\":\"second\",\"lens_mm\":30.0,\"sensor_width_mm\":36.0,\"sensor_height_mm\":48.0,\"sensor_fit\":\"HORIZONTAL\",\"shift\":[-0.016666666666666666,-0.02666666666666667],\"resolution\":[600,800],\"pixel_aspect\":[1.25,1.0],\"matrix_world\":[[0.0,0.0,-1.0,-9.0],[-1.0,0.0,0.0,0.5],[0.0,1.0,0.0,0.3],[0.0,0.0,0.0,1.0]]}"),
    json.loads("{\"name\":\"\\\"third\\\"\",\"lens_mm\":1.0,\"sensor_width_mm\":64.0,\"sensor_height_mm\":48.0,\"sensor_fit\":\"HORIZONTAL\",\"shift\":[0.0,0.0],\"resolution\":[1280,960],\"pixel_aspect\":[1.0,1.0],\"matrix_world\":[[-1.0030171138097901e-16,0.9600000000000001,0.28,1.4000000000000004],[-1.0,-1.1730200144555173e-16,-2.720046410331634e-17,-0.0],[2.720046410331634e-17,-0.28,0.9600000000000001,4.800000000000001],[0.0,0.0,0.0,1.0]]}"),
]

# Size and aspect of pixels belong to a scene: cameras of others get a scene of their own with the same objects.
home = bpy.context.scene
children, objects = list(home.collection.children), list(home.collection.objects)
scenes = {}
for data in CAMERAS:
    key = (*data["resolution"], *data["pixel_aspect"])
    if key not in scenes:
        scene = home
        if scenes:
            scene = bpy.data.scenes.new("{} x {}".format(*key))
            scene.world = home.world
            for child in children:
                scene.collection.children.link(child)
            for thing in objects:
                scene.collection.objects.link(thing)
        scenes[key] = scene
        render = scene.render
        render.resolution_x, render.resolution_y, render.pixel_aspect_x, render.pixel_aspect_y = key
        render.resolution_percentage = 100
        scene.camera = None
    scene = scenes[key]
    camera = bpy.data.cameras.new(data["name"])
    if "lens_mm" in data:
        camera.lens = data["lens_mm"]
    else:
        camera.type = "ORTHO"
        camera.ortho_scale = data["ortho_scale"]
    camera.sensor_width = data["sensor_width_mm"]
    camera.sensor_height = data["sensor_height_mm"]
    camera.sensor_fit = data["sensor_fit"]
    camera.shift_x, camera.shift_y = data["shift"]
    thing = bpy.data.objects.new(data["name"], camera)
    thing.matrix_world = Matrix(data["matrix_world"])
    scene.collection.objects.link(thing)
    scene.camera = scene.camera or thing
