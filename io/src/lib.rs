//! Files for [`collinear`]: what a camera, a plane, a map, a scene, a list of points or a picture looks like on disk.
//!
//! | what | module | format |
//! | --- | --- | --- |
//! | camera, scanner, plane, dome, map, scene | [`camera`], [`scanner`], [`plane`], [`dome`], [`map`], [`scene`] | JSON, `docs/formats.md` |
//! | a sensor of any kind | [`sensor`] | one of the above |
//! | cameras, poses, points and tracks of a reconstruction | [`opensfm`] | OpenSfM `reconstruction.json` of every camera type, `tracks.csv` |
//! | cameras, points and views | [`bundler`] | Bundler's `bundle.out` |
//! | a bundle adjustment problem | [`bal`] | text of *Bundle Adjustment in the Large*, plain or gzip |
//! | cameras of a calibration | [`opencv`] | OpenCV's YAML, JSON and XML, ROS's `camera_info` |
//! | cameras and poses, a calibration | [`metashape`] | Agisoft Metashape's XML |
//! | cameras, poses, points and tracks of a reconstruction | [`colmap`] | COLMAP's `cameras`, `images`, `points3D`, text and binary |
//! | cameras of Pix4D's folder `params` | [`pix4d`] | `_calibrated_camera_parameters.txt`, `.cam`, `_pmatrix.txt`, `_offset.xyz` |
//! | exterior orientations alone | [`orientation`] | tables of X, Y, Z, ω, φ, κ; PATB |
//! | cameras of a scene | [`gltf`] | glTF 2.0, text and GLB |
//! | cameras of Blender's | [`blender`] | a Python script, written only |
//! | cameras of radiance fields | [`nerf`] | `transforms.json` of nerfstudio and instant-ngp |
//! | photographs with cameras, out of any of these | [`photographs`] | the content says which |
//! | a photograph's matrices for a graphics interface | [`gpu`] | JSON, written only |
//! | world points, with or without their image points | [`points`] | CSV |
//! | control points with their images and precisions | [`control`] | CSV |
//! | which photograph shows which point where | [`observations`] | CSV |
//! | places, positions, attitudes and distances with their precisions | [`observed`] | CSV |
//! | pictures | [`picture`] | PNG, JPEG |
//! | rational polynomial cameras | [`rpc`] | JSON, RPB, `_RPC.TXT`, DIMAP XML, GDAL's XML, OSSIM `.geom`, GeoTIFF |
//! | geoid undulations | [`gtx`] | GTX |
//!
//! Readers give plain values and know no algorithm; [`convert`] turns them into the library's types. Every [`Error`]
//! names the file, and the field, line or column in it. Every output is written with [`write_atomically`]: after an
//! error the old file is still there.
//!
#![doc = include_str!("../docs/figures/io.svg")]
//!
//! # Example
//!
//! ```
//! use collinear_io::Document;
//! use collinear_io::camera::CameraFile;
//!
//! let text = r#"{
//!   "collinear": "camera", "version": 1, "width": 640, "height": 480,
//!   "interior": { "model": "pinhole", "principal_distance": [500, 500], "principal_point": [320, "240"] },
//!   "exterior": { "projection_center": [0, 0, 10], "omega_phi_kappa": [0, 0, 0] }
//! }"#;
//! let error = CameraFile::parse(text).unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "interior.principal_point[1]: expected a number, found the string \"240\" (line 3, column 100)"
//! );
//! ```

mod atomic;
mod check;
mod error;
mod eye;
mod fields;
mod json;
mod xml;

pub mod bal;
pub mod blender;
pub mod bundler;
pub mod camera;
pub mod colmap;
pub mod control;
pub mod convert;
pub mod dome;
pub mod gltf;
pub mod gpu;
pub mod gtx;
pub mod map;
pub mod metashape;
pub mod nerf;
pub mod observations;
pub mod observed;
pub mod opencv;
pub mod opensfm;
pub mod orientation;
pub mod photographs;
pub mod picture;
pub mod pix4d;
pub mod plane;
pub mod points;
pub mod rpc;
pub mod scanner;
pub mod scene;
pub mod sensor;

pub use atomic::{write_atomically, write_together};
pub use error::{
    BinaryProblem, Error, ErrorKind, FieldError, FieldProblem, GridProblem, LineProblem,
    PictureProblem, RpcProblem,
};
pub use json::Document;
