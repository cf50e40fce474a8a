# GDAL 3.10.3 through rasterio 1.4.4, Python 3.11: the camera of tests/data/oracles/rpc.json as GDAL writes it, and what GDAL makes of the
# cameras in ../shared/data/terrain/ventoux (numbers of points only; the files stay where they are).
import json
import pathlib
import shutil
import xml.etree.ElementTree as xml

import numpy as np
import rasterio
from rasterio.rpc import RPC
from rasterio.transform import RPCTransformer

here = pathlib.Path(__file__).parent
model = json.load(open(here / "../../../tests/data/oracles/rpc.json"))["model"]
rpc = RPC(height_off=model["height_offset"], height_scale=model["height_scale"], lat_off=model["latitude_offset_deg"], lat_scale=model["latitude_scale_deg"],
          line_den_coeff=model["line_denominator"], line_num_coeff=model["line_numerator"], line_off=model["line_offset"], line_scale=model["line_scale"],
          long_off=model["longitude_offset_deg"], long_scale=model["longitude_scale_deg"], samp_den_coeff=model["sample_denominator"],
          samp_num_coeff=model["sample_numerator"], samp_off=model["sample_offset"], samp_scale=model["sample_scale"],
          err_bias=model["error_bias"], err_rand=model["error_random"])
for name, options in [("little", dict(RPB="YES", RPCTXT="YES")), ("big", dict(ENDIANNESS="BIG", BIGTIFF="YES"))]:
    for old in here.glob(f"rpc/{name}*"):
        old.unlink()
    with rasterio.open(here / f"rpc/{name}.tif", "w", driver="GTiff", width=1, height=1, count=1, dtype="uint8", **options) as f:
        f.rpcs = rpc
with rasterio.open(here / "rpc/picture.png", "w", driver="PNG", width=1, height=1, count=1, dtype="uint8") as f:
    f.rpcs = rpc
(here / "rpc/picture.png").unlink()

shared = here / "../../../../shared/data/terrain/ventoux"


def of_geom(path):
    fields = dict((k.strip(), v.strip()) for k, _, v in (line.partition(":") for line in open(path)))
    take = lambda name: [float(fields[f"{name}_coeff_{i:02}"]) for i in range(20)]
    return RPC(**{f"{k}_{s}": float(fields[f"{f}_{t}"]) for k, f in [("height", "height"), ("lat", "lat"), ("line", "line"), ("long", "long"), ("samp", "samp")]
                  for s, t in [("off", "off"), ("scale", "scale")]},
               line_num_coeff=take("line_num"), line_den_coeff=take("line_den"), samp_num_coeff=take("samp_num"), samp_den_coeff=take("samp_den"), err_bias=None, err_rand=None)


def of_dimap(path):
    root = xml.parse(path).getroot()
    inverse, validity = next(root.iter("Inverse_Model")), next(root.iter("RFM_Validity"))
    take = lambda name: [float(inverse.find(f"{name}_COEFF_{i}").text) for i in range(1, 21)]
    number = lambda name: float(validity.find(name).text)
    # The first pixel is (1, 1) in DIMAP 2.
    return RPC(height_off=number("HEIGHT_OFF"), height_scale=number("HEIGHT_SCALE"), lat_off=number("LAT_OFF"), lat_scale=number("LAT_SCALE"),
               long_off=number("LONG_OFF"), long_scale=number("LONG_SCALE"), line_off=number("LINE_OFF") - 1, line_scale=number("LINE_SCALE"),
               samp_off=number("SAMP_OFF") - 1, samp_scale=number("SAMP_SCALE"), line_num_coeff=take("LINE_NUM"), line_den_coeff=take("LINE_DEN"),
               samp_num_coeff=take("SAMP_NUM"), samp_den_coeff=take("SAMP_DEN"), err_bias=None, err_rand=None)


rng = np.random.default_rng(11)
answers = {}
for name, camera in [("left_image.geom", of_geom), ("right_image.geom", of_geom), ("RPC_PHR1B_P_201308051042194_SEN_690908101-001.XML", of_dimap)]:
    c = camera(shared / name)
    lon, lat, h = (o + s * rng.uniform(-1, 1, 50) for o, s in [(c.long_off, c.long_scale), (c.lat_off, c.lat_scale), (c.height_off, c.height_scale)])
    with RPCTransformer(c) as transformer:
        rows, cols = transformer.rowcol(lon, lat, zs=h, op=lambda v: v)
    answers[name] = [dict(longitude_deg=a, latitude_deg=b, height=z, image=[x, y]) for a, b, z, x, y in zip(lon.tolist(), lat.tolist(), h.tolist(), map(float, cols), map(float, rows))]
json.dump(answers, open(here / "rpc_ventoux.json", "w"), indent=0)
