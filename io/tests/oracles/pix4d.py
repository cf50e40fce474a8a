"""What Pix4D's files say, and the pixels that OpenCV and Pix4D's own formulas give for it.

    python3 pix4d.py FOLDER     (numpy, opencv-python-headless 5.0.0) writes FOLDER/*.txt, *.cam, offset.xyz, expected.json

The numbers of DSC_0157 and of DJI_0172 are Pix4Dmapper's, as its users published them:

- DSC_0157: its block of `_calibrated_camera_parameters.txt` and its line of `_calibrated_external_camera_parameters.txt`;
- DJI_0172 and the `.cam` of the same block of photographs: test files of EasyIDP (UTokyo-FieldPhenomics-Lab);
- DJI_0954: its block, its line of `_pmatrix.txt`, its place in the world and `_offset.xyz`, in EasyIDP's documentation; the
  `_pix4d_calibrated_internal_camera_parameters.cam` of the same photographs.

Pix4D's distortion and its angles are those of `examples/compute_reprojection_error.py` in Pix4D/pyopf. The principal point
counts from the top-left corner of the top-left pixel (Pix4D/opf-spec, input_cameras). OpenCV's projectPoints, given K as it
stands, therefore gives Pix4D's pixels without half a pixel added.
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np

HEADER = """fileName imageWidth imageHeight
camera matrix K [3x3]
radial distortion [3x1]
tangential distortion [2x1]
camera position t [3x1]
camera rotation R [3x3]
camera model m = K [R|-Rt] X

"""
BLOCKS = {
    "DSC_0157.JPG": """DSC_0157.JPG 7360 4912
7363.51850023951465118444 0 3686.33719996831450771424
0 7363.51850023951465118444 2439.04083412635009153746
0 0 1
-0.09005921067656787182 0.10773972435740564180 -0.01257054987797603419
-0.00029570539858373248 -0.00027422056492206067
114.12600004808672338186 378.81985574952466322429 -2.31159761431545440757
-0.49632901575943477734 0.86794436424468834890 -0.01816834310427051929
0.86649900151927328196 0.49400145706385401034 -0.07170802455019638366
-0.05326338781351704077 -0.05133362440616233424 -0.99726018196053234366
""",
    "DJI_0172.JPG": """DJI_0172.JPG 5472 3648
4470.89710276625464757672 0 2806.80399985351095892838
0 4470.89710276625464757672 1694.57401670066087717714
0 0 1
0.02006588392682263564 0.01562937180085547523 -0.02095437643714216994
-0.00288771142181162843 0.00196521828681344877
15.94074806386806208991 -29.02692220459498173568 15.15422636680995438496
0.99231434331971635210 0.12374166789348504947 -0.00049362829998193054
0.12374265000928082181 -0.99230722461113951560 0.00375879677799056998
-0.00002471114576337372 -0.00379099083038331869 -0.99999281386312122155
""",
    "DJI_0954.JPG": """DJI_0954.JPG 4608 3456
3952.81247514184087776812 0 2233.46124792750424603582
0 3952.81247514184087776812 1667.92521335858214115433
0 0 1
0.03833474118270804865 -0.01750917966495743258 0.02049798716391852335
0.00240851666319534747 0.00292562392135245920
21.54872206687879199194 -29.58734160676452162875 30.85702810138878149360
0.78389904231994589345 -0.62058396220897726892 -0.01943803742353054573
-0.62086105345046738169 -0.78318706257080084043 -0.03390541741516269608
0.00581753884797473961 0.03864674463298682638 -0.99923600083815289352
""",
}
EXTERNAL = "imageName X Y Z Omega Phi Kappa\nDSC_0157.JPG 332081.126000 3488911.819856 4093.688402 -2.946680 3.053212 119.804001\n"
DSC_OFFSET = [331967.0, 3488533.0, 4096.0]
OFFSET = "368009.000 3955854.000 97.000"
PMATRIX = (
    "DJI_0954.JPG 3111.599161 -2366.736021 -2308.589802 -65840.192261 -2444.444098 -3031.331712 -1800.672677 "
    "18549.006987 0.005818 0.038647 -0.999236 31.851547 \n"
)
INPHO = """camera_calibration_file 0
#Focal Length (mm) assuming a sensor width of 12.82499999999999928946x8.55000000000000071054mm
#Image size 5472.00000000000000000000x3648.00000000000000000000 pixel
FOCAL 10.47866508460840861972

#Principal Point Offset xpoff ypoff in mm (Inpho)
XPOFF 0.16594687465666663195
YPOFF 0.30334214835782608022
#Principal Point Offset xpoff ypoff in mm 
XPOFF -0.16594687465666663195
YPOFF 0.30334214835782608022
#Principal Point Offset xpoff ypoff in pixel 
XPOFF -70.80399985351095892838
YPOFF 129.42598329933912282286

#How many fiducial pairs (max 8):
NUM_FIDS 4 

#Fiducials position
DATA_STRIP_SIDE left

#Fiducial x,y pairs in mm:
FID_PAIRS
    6.41249999999999964473 -4.27500000000000035527
    -6.41249999999999964473 -4.27500000000000035527
    -6.41249999999999964473 4.27500000000000035527
    6.41249999999999964473 4.27500000000000035527

#Symmetrical Lens Distortion Odd-order Poly Coeffs:K0,K1,K2,K3
SYM_DIST 0 0.00001743975647560381 0.00000012371197022698 -0.00000000151054275730

#Decentering Lens Coeffs p1,p2,p3
DEC_DIST -0.00002629915962131326 0.00001789776811673466 0

#How many distortion pairs (max 20):
NUM_DIST_PAIRS 20

"""
MM = """Pix4D camera calibration file 0
#Focal Length mm assuming a sensor width of 17.49998592000000030566x13.12498944000000200560mm
F 15.01175404934517487732
#Principal Point mm
Px 8.48210511970419922534
Py 6.33434629978042273990
#Symmetrical Lens Distortion Coeffs
K1 0.03833474118270804865
K2 -0.01750917966495743258
K3 0.02049798716391852335
#Tangential Lens Distortion Coeffs
T1 0.00240851666319534747
T2 0.00292562392135245920
"""
# Right, down and forward of the camera.
SEEN = np.array([[0, 0, 50], [12, -7, 50], [-20, 14, 49], [18, 13.5, 51], [-11, -15, 47]], float)


def numbers(text):
    return np.array([float(w) for line in text.splitlines()[1:] for w in line.split()])


def pix4d(f, c, radial, tangential, camera):
    """pyopf: apply_distortion_model after the pinhole."""
    x, y = camera[0] / camera[2], camera[1] / camera[2]
    r = x * x + y * y
    k1, k2, k3 = radial
    t1, t2 = tangential
    dr = 1 + r * k1 + r**2 * k2 + r**3 * k3
    dx = 2 * t1 * x * y + t2 * (r + 2 * x * x)
    dy = 2 * t2 * x * y + t1 * (r + 2 * y * y)
    return [f * (dr * x + dx) + c[0], f * (dr * y + dy) + c[1]]


folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
(folder / "calibrated_camera_parameters.txt").write_text(HEADER + "".join(BLOCKS.values()))
(folder / "calibrated_external_camera_parameters.txt").write_text(EXTERNAL)
(folder / "pmatrix.txt").write_text(PMATRIX)
(folder / "offset.xyz").write_text(OFFSET)
(folder / "calibrated_internal_camera_parameters.cam").write_text(INPHO)
(folder / "pix4d_calibrated_internal_camera_parameters.cam").write_text(MM)
expected = {"program": f"OpenCV {cv2.__version__}", "dsc_offset": DSC_OFFSET, "images": {}}
for name, block in BLOCKS.items():
    v = numbers(block)
    k, radial, tangential, t, r = v[:9].reshape(3, 3), v[9:12], v[12:14], v[14:17], v[17:26].reshape(3, 3)
    world = t + SEEN @ r
    d = np.array([radial[0], radial[1], tangential[0], tangential[1], radial[2]])
    rvec, _ = cv2.Rodrigues(r)
    images, _ = cv2.projectPoints(world.reshape(-1, 1, 3), rvec, -r @ t, k, d)
    images = images.reshape(-1, 2)
    own = np.array([pix4d(k[0, 0], k[:2, 2], radial, tangential, r @ (w - t)) for w in world])
    assert np.abs(images - own).max() < 1e-8, np.abs(images - own).max()
    expected["images"][name] = [[w, i] for w, i in zip(world.tolist(), images.tolist())]
    if name == "DJI_0954.JPG":
        p = np.array([float(w) for w in PMATRIX.split()[1:]]).reshape(3, 4)
        m = np.c_[world, np.ones(len(world))] @ p.T
        expected["pmatrix"] = [[w, i] for w, i in zip(world.tolist(), (m[:, :2] / m[:, 2:]).tolist())]
        # P = K [R|-Rt], in the coordinates without the offset.
        assert np.abs(k @ np.c_[r, -r @ t] - p).max() < 1e-3 * 40
        # campos: 368030.548722, 3955824.412658, 127.857028 = t + offset.
        assert np.abs(t + [368009, 3955854, 97] - [368030.548722, 3955824.412658, 127.857028]).max() < 1e-6
    if name == "DSC_0157.JPG":
        # pyopf: world from photo is Rx Ry Rz; photo axes are right, top, back.
        x, y, z, *angles = [float(w) for w in EXTERNAL.split()[8:]]
        o, p, q = np.radians(angles)
        rx = np.array([[1, 0, 0], [0, np.cos(o), -np.sin(o)], [0, np.sin(o), np.cos(o)]])
        ry = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
        rz = np.array([[np.cos(q), -np.sin(q), 0], [np.sin(q), np.cos(q), 0], [0, 0, 1]])
        assert np.abs(np.diag([1, -1, -1]) @ (rx @ ry @ rz).T - r).max() < 2e-8
        assert np.abs(t + DSC_OFFSET - [x, y, z]).max() < 1e-6
    if name == "DJI_0172.JPG":
        # The .cam says the same in millimetres: K_i = R_i / f^(2i + 1), p_i = T_i / f^2.
        f = 10.47866508460840861972
        sym = np.array([0.00001743975647560381, 0.00000012371197022698, -0.00000000151054275730])
        assert np.abs(sym * f ** np.array([3, 5, 7]) - radial).max() < 1e-12
        assert np.abs(np.array([-0.00002629915962131326, 0.00001789776811673466]) * f**2 - tangential).max() < 1e-12
        assert abs(f * 5472 / 12.825 - k[0, 0]) < 1e-9
        assert np.abs(np.array([2736, 1824]) - [-70.80399985351095892838, 129.42598329933912282286] - k[:2, 2]).max() < 1e-9
    if name == "DJI_0954.JPG":
        pitch = 17.49998592000000030566 / 4608
        assert np.abs(np.array([15.01175404934517487732, 8.48210511970419922534, 6.33434629978042273990]) / pitch
                      - [k[0, 0], k[0, 2], k[1, 2]]).max() < 1e-8
(folder / "expected.json").write_text(json.dumps(expected) + "\n")
