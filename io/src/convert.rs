//! From files to the library's types, and back.

mod scanner;

use std::sync::Arc;

use collinear::camera::{
    Brown, BrownCamera, CentralCamera, CentralModel, ExteriorOrientation, Frame,
    InteriorOrientation, Orthographic, Panorama, SensorModel, brown_from_colmap, from_colmap,
};
use collinear::geometry::geodetic::GeoidGrid;
use collinear::geometry::rotation::{OmegaPhiKappa, Quaternion, orthonormalised};
use collinear::geometry::{Affine2, Dome, Homography, Plane};
use collinear::mapping::polynomial::{Bilinear, Cubic, Quadratic};
use collinear::mapping::{FractionalLinear, Map};
use collinear::nalgebra::{Matrix3, Point2, Point3, Vector3};

use crate::camera::{CameraFile, Exterior, Interior, Rotation};
use crate::dome::DomeFile;
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::gtx::GtxFile;
use crate::json::Document;
use crate::map::MapFile;
use crate::plane::PlaneFile;

/// The camera of a file, as the library has it.
#[derive(Clone, Debug)]
pub enum Camera {
    /// Without a lens.
    Pinhole(Frame<InteriorOrientation>),
    /// With Brown's lens, which may do nothing.
    Brown(Frame<BrownCamera>),
    /// With any other model that has one projection centre.
    Central(Frame<Central>),
    /// A parallel projection.
    Orthographic(Orthographic),
}

impl Camera {
    /// The camera as a sensor, whichever it is.
    #[must_use]
    pub fn sensor(&self) -> &dyn SensorModel {
        match self {
            Self::Pinhole(camera) => camera,
            Self::Brown(camera) => camera,
            Self::Central(camera) => camera,
            Self::Orthographic(camera) => camera,
        }
    }

    /// The camera as a sensor of its own.
    #[must_use]
    pub fn into_sensor(self) -> Box<dyn SensorModel> {
        match self {
            Self::Pinhole(camera) => Box::new(camera),
            Self::Brown(camera) => Box::new(camera),
            Self::Central(camera) => Box::new(camera),
            Self::Orthographic(camera) => Box::new(camera),
        }
    }
}

/// A camera of one projection centre, of whichever model.
pub type Central = Arc<dyn CentralModel>;

impl CameraFile {
    /// The library's camera.
    ///
    /// ```
    /// use collinear::nalgebra::{Point2, Point3};
    /// use collinear_io::Document;
    /// use collinear_io::camera::CameraFile;
    ///
    /// // A vertical photograph from 10 above: what lies 1 to the north is 50 pixels up.
    /// let file = CameraFile::parse(
    ///     r#"{ "collinear": "camera", "version": 1, "width": 640, "height": 480,
    ///     "interior": { "model": "pinhole", "principal_distance": [500, 500], "principal_point": [320, 240] },
    ///     "exterior": { "projection_center": [0, 0, 10], "omega_phi_kappa": [0, 0, 0] } }"#,
    /// )?;
    /// let image = file.camera()?.sensor().project(&Point3::new(0.0, 1.0, 0.0))?;
    /// assert_eq!(image, Point2::new(320.0, 190.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::Field`] and [`ErrorKind::Library`] for values outside their domain.
    pub fn camera(&self) -> Result<Camera, Error> {
        self.check()?;
        let exterior = self.exterior.orientation()?;
        Ok(match self.interior.model_of([self.width, self.height])? {
            Model::Pinhole(interior) => Camera::Pinhole(Frame::new(exterior, interior)),
            Model::Brown(camera) => Camera::Brown(Frame::new(exterior, camera)),
            Model::Central(camera) => Camera::Central(Frame::new(exterior, camera)),
            Model::Orthographic(scale) => {
                let camera = Orthographic::new(exterior, scale)
                    .map_err(in_field("interior.pixels_per_unit"))?;
                Camera::Orthographic(camera)
            }
        })
    }

    /// The library's camera with Brown's lens; a pinhole has a lens without distortion. COLMAP's pinholes and `SIMPLE_RADIAL`,
    /// `RADIAL` and `OPENCV` are such cameras, and every lens whose other terms are zero.
    ///
    /// # Errors
    /// As [`camera`](Self::camera), and [`FieldProblem::Unsupported`] for every other model.
    pub fn frame(&self) -> Result<Frame<BrownCamera>, Error> {
        let interior = self.interior.plain([self.width, self.height]);
        match (Self { interior, ..self.clone() }).camera()? {
            Camera::Pinhole(Frame { exterior, camera }) => {
                Ok(Frame::new(exterior, BrownCamera::new(camera, Brown::none())))
            }
            Camera::Brown(frame) => Ok(frame),
            Camera::Central(_) | Camera::Orthographic(_) => {
                let expected =
                    "a camera `pinhole` or `brown` is needed, or a `colmap` one that is either";
                let found = self.interior.model().into();
                let problem = FieldProblem::Unsupported { found, expected };
                Err(FieldError::new("interior.model", problem).into())
            }
        }
    }

    /// The file of a camera and its picture's size.
    #[must_use]
    pub fn from_frame(frame: &Frame<BrownCamera>, width: u32, height: u32) -> Self {
        let (interior, lens) = (frame.camera.interior(), frame.camera.distortion());
        Self {
            width,
            height,
            interior: Interior::Brown {
                principal_distance: interior.principal_distance(),
                principal_point: interior.principal_point().into(),
                skew: interior.skew(),
                k: lens.radial(),
                p: lens.decentering(),
            },
            exterior: Exterior::from_orientation(&frame.exterior),
        }
    }
}

/// An interior orientation as the library has it.
enum Model {
    Pinhole(InteriorOrientation),
    Brown(BrownCamera),
    Central(Central),
    /// Pixels from the plane across the line of sight.
    Orthographic(Affine2),
}

impl Interior {
    /// The library's model, for a picture of this size.
    fn model_of(&self, size: [u32; 2]) -> Result<Model, Error> {
        Ok(match self {
            Self::Pinhole { principal_distance, principal_point, skew } => {
                Model::Pinhole(interior(*principal_distance, *principal_point, *skew)?)
            }
            Self::Brown { principal_distance, principal_point, skew, k, p } => {
                let interior = interior(*principal_distance, *principal_point, *skew)?;
                let lens = Brown::new(*k, *p).map_err(in_field("interior.k"))?;
                Model::Brown(BrownCamera::new(interior, lens))
            }
            Self::Lens { principal_distance, principal_point, skew, lens } => {
                let interior = interior(*principal_distance, *principal_point, *skew)?;
                let model = lens.central(interior).map_err(|(field, source)| {
                    Error::from(ErrorKind::Library { field: format!("interior.{field}"), source })
                })?;
                Model::Central(model)
            }
            Self::Panorama { projection, principal_distance, principal_point } => {
                let interior = panorama(*projection, *principal_distance, *principal_point, size)?;
                Model::Central(Arc::new(CentralCamera::ideal(interior, *projection)))
            }
            Self::Film { principal_distance_mm, principal_point_mm, fiducials } => {
                let film: Vec<_> =
                    fiducials.iter().map(|[x, y, _, _]| Point2::new(*x, *y)).collect();
                let scan: Vec<_> =
                    fiducials.iter().map(|[_, _, x, y]| Point2::new(*x, *y)).collect();
                let fit = Affine2::fit(&film, &scan).map_err(in_field("interior.fiducials"))?;
                let interior = InteriorOrientation::from_photogrammetric(
                    *principal_distance_mm,
                    Point2::from(*principal_point_mm),
                    &fit.map,
                );
                Model::Pinhole(interior.map_err(in_field("interior.fiducials"))?)
            }
            Self::Colmap { model, parameters } => {
                let refused = in_field("interior.parameters");
                match brown_from_colmap(model, parameters).map_err(&refused)? {
                    Some(camera) => Model::Brown(camera),
                    None => {
                        let model = from_colmap(model, parameters).map_err(refused)?;
                        Model::Central(Arc::from(model))
                    }
                }
            }
            Self::Orthographic { pixels_per_unit: [sx, sy], principal_point: [x, y] } => {
                Model::Orthographic(Affine2::from_coefficients([*x, *sx, 0.0], [*y, 0.0, *sy]))
            }
        })
    }
}

/// The interior orientation of a panorama, whole where the file leaves its scale open.
fn panorama(
    projection: Panorama,
    principal_distance: Option<[f64; 2]>,
    principal_point: Option<[f64; 2]>,
    size: [u32; 2],
) -> Result<InteriorOrientation, Error> {
    let [width, height] = size.map(f64::from);
    let distance =
        principal_distance.unwrap_or_else(|| projection.principal_distance(width, height));
    interior(distance, principal_point.unwrap_or([0.5 * width, 0.5 * height]), 0.0)
}

impl Exterior {
    /// The library's exterior orientation.
    ///
    /// # Errors
    /// [`ErrorKind::Library`] for a rotation that is none; [`Document::check`] has refused those of a file.
    pub fn orientation(&self) -> Result<ExteriorOrientation, Error> {
        let center = Point3::from(self.projection_center);
        let camera_from_world = match self.rotation {
            Rotation::QuaternionWxyz([w, x, y, z]) => {
                let q = Quaternion { w, x, y, z };
                q.rotation().map_err(in_field("exterior.quaternion_wxyz"))?
            }
            Rotation::OmegaPhiKappa([omega, phi, kappa]) => {
                let angles = OmegaPhiKappa { omega, phi, kappa };
                return Ok(ExteriorOrientation::from_omega_phi_kappa(center, &angles));
            }
            Rotation::RotationMatrix(rows) => {
                let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
                orthonormalised(&matrix).map_err(in_field("exterior.rotation_matrix"))?
            }
        };
        Ok(ExteriorOrientation::new(center, camera_from_world))
    }

    /// The file's form of an exterior orientation, with a quaternion.
    #[must_use]
    pub fn from_orientation(exterior: &ExteriorOrientation) -> Self {
        let q = Quaternion::from_rotation(&exterior.camera_from_world());
        Self {
            projection_center: exterior.projection_center().into(),
            rotation: Rotation::QuaternionWxyz([q.w, q.x, q.y, q.z]),
        }
    }
}

impl DomeFile {
    /// The library's dome.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] and [`ErrorKind::Library`] for values outside their domain.
    pub fn dome(&self) -> Result<Dome, Error> {
        self.check()?;
        let axis = Vector3::from(self.axis);
        Dome::new(self.center.into(), self.radius, axis, self.half_angle_deg.to_radians())
            .map_err(in_field("dome"))
    }
}

impl PlaneFile {
    /// The library's plane.
    ///
    /// # Errors
    /// [`ErrorKind::Library`] for a normal without a direction.
    pub fn plane(&self) -> Result<Plane, Error> {
        Plane::from_point_and_normal(Point3::from(self.point), Vector3::from(self.normal))
            .map_err(in_field("normal"))
    }
}

impl MapFile {
    /// The library's map, from a point of the new picture to the point of the old one.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] and [`ErrorKind::Library`] for coefficients outside their domain.
    pub fn map(&self) -> Result<Box<dyn Map>, Error> {
        self.check()?;
        Ok(match self {
            Self::Homography { matrix } => {
                let homography = Homography::from_matrix(Matrix3::from_fn(|i, j| matrix[i][j]))
                    .map_err(in_field("matrix"))?;
                Box::new(FractionalLinear::from_homography(&homography))
            }
            Self::Affine { a, b } => Box::new(Affine2::from_coefficients(*a, *b)),
            Self::Bilinear { a, b } => {
                Box::new(Bilinear::from_coefficients(*a, *b).map_err(in_field("a"))?)
            }
            Self::Quadratic { a, b } => {
                Box::new(Quadratic::from_coefficients(*a, *b).map_err(in_field("a"))?)
            }
            Self::Cubic { a, b } => {
                Box::new(Cubic::from_coefficients(*a, *b).map_err(in_field("a"))?)
            }
        })
    }
}

impl From<&Homography> for MapFile {
    fn from(homography: &Homography) -> Self {
        let m = homography.matrix();
        Self::Homography { matrix: [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)])) }
    }
}

impl From<&Affine2> for MapFile {
    fn from(affine: &Affine2) -> Self {
        let (m, t) = (&affine.linear, &affine.translation);
        Self::Affine { a: [t.x, m[(0, 0)], m[(0, 1)]], b: [t.y, m[(1, 0)], m[(1, 1)]] }
    }
}

impl From<&Bilinear> for MapFile {
    fn from(map: &Bilinear) -> Self {
        let [a, b] = map.coefficients();
        Self::Bilinear { a, b }
    }
}

impl From<&Quadratic> for MapFile {
    fn from(map: &Quadratic) -> Self {
        let [a, b] = map.coefficients();
        Self::Quadratic { a, b }
    }
}

impl From<&Cubic> for MapFile {
    fn from(map: &Cubic) -> Self {
        let [a, b] = map.coefficients();
        Self::Cubic { a, b }
    }
}

impl GtxFile {
    /// The library's grid, which interpolates.
    ///
    /// # Errors
    /// [`ErrorKind::Library`] for a layout outside its domain.
    pub fn geoid_grid(self) -> Result<GeoidGrid, Error> {
        GeoidGrid::new(self.layout, self.undulations_m).map_err(in_field(""))
    }
}

fn interior(
    principal_distance: [f64; 2],
    principal_point: [f64; 2],
    skew: f64,
) -> Result<InteriorOrientation, Error> {
    InteriorOrientation::new(principal_distance, Point2::from(principal_point), skew)
        .map_err(in_field("interior.principal_distance"))
}

fn in_field(field: &'static str) -> impl Fn(collinear::Error) -> Error {
    move |source| ErrorKind::Library { field: field.to_owned(), source }.into()
}
