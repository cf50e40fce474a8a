"""Exported cameras as Agisoft Metashape lays them out, and the images of points by the manual's equations.

    python3 metashape.py FOLDER       (mpmath 1.3, 40 digits) writes FOLDER/cameras.xml, chunk.xml, calibration.xml, expected.json
    python3 metashape.py --read FILE  prints the images of the local points through the cameras of another document

Equations: Agisoft, Metashape User Manual, Professional Edition, appendix "Camera models". The frame's were compared with the manual as a
post of 5 August 2022 on Agisoft's forum quotes it. The others were written down without the manual's text at hand: that the
fisheye is equidistant is confirmed by photogrammetrycommunity.github.io/metashape-expert-manual, "Fisheye and spherical sensors"; how it is
decentred, and the two panoramas, still are to be compared. Metashape itself cannot be installed here. Layout: the exports printed in
the tests of geograypher (document version 2.0.0, components with `rotation`, `translation` and `scale`, groups) and of EasyIDP
(sensors without a calibration), and the calibration file printed in libvideoio's UndistorterPhotoscanXML, all on GitHub.
Frames: nerfstudio, process_data/metashape_utils.py at
027afabe, turns y and z of the 16 numbers, row by row, to get a camera that looks along -z with y up.
"""

import json
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from mpmath import atan, atan2, cos, matrix, mp, mpf, pi, sin, sqrt

mp.dps = 40
LOCAL = [[0.3, -0.2, 0.5], [-1.1, 0.7, 0.25], [0.9, 1.2, -0.4], [2.5, -1.75, 0.125]]


def turned(x, y, z):
    """Rotations about x, y, z, one after the other."""
    cx, sx, cy, sy, cz, sz = cos(x), sin(x), cos(y), sin(y), cos(z), sin(z)
    rx = matrix([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    ry = matrix([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    rz = matrix([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return rz * ry * rx


def image(kind, width, height, c, X, Y, Z):
    w, h = mpf(width), mpf(height)
    g = lambda name: mpf(c.get(name, "0"))
    if kind == "spherical":
        f = w / (2 * pi)
        return w / 2 + f * atan2(X, Z), h / 2 + f * atan(Y / sqrt(X**2 + Z**2))
    if kind == "cylindrical":
        f = w / (2 * pi)
        return w / 2 + f * atan2(X, Z), h / 2 + f * Y / sqrt(X**2 + Z**2)
    x, y = X / Z, Y / Z
    if kind in ("fisheye", "equidistant_fisheye"):
        r0 = sqrt(x**2 + y**2)
        x, y = x * atan(r0) / r0, y * atan(r0) / r0
    r = sqrt(x**2 + y**2)
    radial = 1 + g("k1") * r**2 + g("k2") * r**4 + g("k3") * r**6 + g("k4") * r**8
    more = 1 + g("p3") * r**2 + g("p4") * r**4
    xd = x * radial + (g("p1") * (r**2 + 2 * x**2) + 2 * g("p2") * x * y) * more
    yd = y * radial + (g("p2") * (r**2 + 2 * y**2) + 2 * g("p1") * x * y) * more
    return w / 2 + g("cx") + xd * g("f") + xd * g("b1") + yd * g("b2"), h / 2 + g("cy") + yd * g("f")


def similarity(node):
    found = None if node is None else node.find("transform")
    if found is None:
        return None
    n = lambda name: [mpf(v) for v in found.find(name).text.split()]
    r = n("rotation")
    return n("scale")[0], matrix([r[0:3], r[3:6], r[6:9]]), matrix(n("translation"))


def images(root, world):
    chunk = root.find("chunk")
    sensors = {s.get("id"): s for s in chunk.iter("sensor")}
    components = {c.get("id"): c for c in chunk.iter("component")}
    found = {}
    for camera in chunk.find("cameras").iter("camera"):
        if camera.find("transform") is None:
            continue
        sensor = sensors[camera.get("sensor_id")]
        calibration = sensor.find("calibration")
        for c in sensor.findall("calibration"):
            if c.get("class") == "adjusted":
                calibration = c
        values = {} if calibration is None else {e.tag: e.text for e in calibration}
        kind = sensor.get("type") if calibration is None else calibration.get("type")
        size = sensor.find("resolution")
        s, r, t = similarity(components.get(camera.get("component_id"))) or similarity(chunk) or (
            mpf(1), matrix([[1, 0, 0], [0, 1, 0], [0, 0, 1]]), matrix([0, 0, 0]))
        m = [mpf(v) for v in camera.find("transform").text.split()]
        rc, c = matrix([m[0:3], m[4:7], m[8:11]]), matrix([m[3], m[7], m[11]])
        found[camera.get("label")] = []
        for p in world:
            in_chunk = r.T * (matrix([mpf(v) for v in p]) - t) / s
            d = rc.T * (in_chunk - c)
            u, v = image(kind, int(size.get("width")), int(size.get("height")), values, *d)
            found[camera.get("label")].append([float(u), float(v)])
    return found


if sys.argv[1] == "--read":
    print(json.dumps(images(ET.parse(sys.argv[2]).getroot(), LOCAL)))
    sys.exit()

row = lambda values: " ".join(f"{float(v):.17g}" for v in values)
tags = lambda values: "".join(f"\n          <{k}>{v}</{k}>" for k, v in values.items())
base = {"f": 1105.25, "cx": 11.5, "cy": -27.75}
three = {"k1": -0.091, "k2": -0.076, "k3": 0.116}
SENSORS = {
    "frame": ("frame", 1280, 960, {**base, "b1": 0.53, "b2": -0.31, **three, "p1": -3.1e-3, "p2": 1.2e-3}),
    "four": ("frame", 1280, 960, {**base, "b1": 0.53, "b2": -0.31, **three, "k4": -0.076, "p1": -3.1e-3, "p2": 1.2e-3}),
    "eight": ("frame", 960, 1280, {**base, **three, "p1": -3.1e-3, "p2": 1.2e-3, "p3": 0.21, "p4": -0.13}),
    "pinhole": ("frame", 1280, 960, {"f": 1105.25}),
    "fisheye": ("fisheye", 1280, 960, {**base, "b1": 0.53, "b2": -0.31, "k1": 0.031, "k2": -0.015, "k3": 0.0063, "k4": -0.0011}),
    "decentred": ("equidistant_fisheye", 1280, 960, {**base, "k1": 0.031, "k2": -0.015, "p1": -3.1e-3, "p2": 1.2e-3}),
    "spherical": ("spherical", 2000, 1000, None),
    "cut": ("spherical", 2000, 700, {"f": float(2000 / (2 * pi))}),
    "cylindrical": ("cylindrical", 2000, 700, None),
}


def document(transform_of_component, transform_of_chunk):
    sensors, cameras = "", ""
    for i, (name, (kind, w, h, c)) in enumerate(SENSORS.items()):
        size = f'<resolution width="{w}" height="{h}"/>'
        calibration = "" if c is None else f"""
        <calibration type="{kind}" class="adjusted">
          {size}{tags(c)}
        </calibration>
        <covariance><params>f cx</params><coeffs>1 0 0 1</coeffs></covariance>"""
        # The values before the adjustment come first.
        initial = f'\n        <calibration type="{kind}" class="initial">\n          {size}{tags({"f": 999})}\n        </calibration>'
        sensors += f"""
      <sensor id="{i}" label="{name} (12mm)" type="{kind}">
        {size}
        <property name="layer_index" value="0"/>
        <bands><band label="Red"/><band label="Green"/></bands>{initial if name == "frame" else ""}{calibration}
      </sensor>"""
        r = turned(mpf("0.1") + i / mpf(100), mpf("-0.2"), mpf("0.3"))
        m = [r[0, 0], r[0, 1], r[0, 2], -0.4, r[1, 0], r[1, 1], r[1, 2], 0.3 + i / 50, r[2, 0], r[2, 1], r[2, 2], -6, 0, 0, 0, 1]
        camera = f"""
      <camera id="{i}" sensor_id="{i}" component_id="0" label="{name}.jpg"{' enabled="false"' if name == "four" else ""}>
        <transform>{row(m)}</transform>
        <orientation>1</orientation>
      </camera>"""
        cameras += f'\n      <group id="0" label="Group 1" type="folder">{camera}\n      </group>' if name == "four" else camera
    cameras += '\n      <camera id="90" sensor_id="0" label="unaligned.jpg"><orientation>1</orientation></camera>'
    part = lambda s: "" if s is None else f"""
        <transform>
          <rotation locked="true">{row(list(s[1]))}</rotation>
          <translation locked="true">{row(s[2])}</translation>
          <scale locked="true">{s[0]}</scale>
        </transform>"""
    component = part(transform_of_component)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<document version="2.0.0">
  <chunk label="Chunk 1" enabled="true">
    <sensors next_id="9">{sensors}
    </sensors>
    <components next_id="1" active_id="0">
      <component id="0" label="Component 1">{component}
      </component>
    </components>
    <cameras next_id="91" next_group_id="1">{cameras}
    </cameras>
    <reference>LOCAL_CS["Local Coordinates (m)",UNIT["metre",1]]</reference>{part(transform_of_chunk)}
  </chunk>
</document>
"""


folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
geocentric = (12.354192447331316, turned(mpf("0.9"), mpf("0.4"), mpf("-0.5")), [-2499366.429888, -4256836.520906, 4029217.965003])
near = (0.5, turned(mpf("-0.4"), mpf("0.7"), mpf("0.2")), [10.5, -20.25, 3.125])
expected = {}
for name, component, chunk in [("cameras.xml", geocentric, near), ("chunk.xml", None, near), ("local.xml", None, None)]:
    text = document(component, chunk)
    root = ET.fromstring(text)
    (folder / name).write_text(text)
    s, r, t = component or chunk or (1, turned(0, 0, 0), [0, 0, 0])
    world = [[float(v) for v in r * matrix(p) * s + matrix(t)] for p in LOCAL]
    expected[name] = {"world": world, "images": images(root, world)}
kind, w, h, c = SENSORS["four"]
body = tags(c).replace("          ", "  ")
text = f"""<?xml version="1.0" encoding="UTF-8"?>
<calibration>
  <projection>{kind}</projection>
  <width>{w}</width>
  <height>{h}</height>{body}
  <date>2022-05-26T08:27:27Z</date>
</calibration>
"""
(folder / "calibration.xml").write_text(text)
directions = [[0.3, -0.2, 1.0], [-0.41, 0.27, 1.0]]
found = [[float(v) for v in image(kind, w, h, c, *(mpf(v) for v in d))] for d in directions]
expected["calibration.xml"] = {"world": directions, "images": {"camera": found}}
(folder / "expected.json").write_text(json.dumps(expected) + "\n")
