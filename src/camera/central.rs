//! The camera of one centre: projection, distortion, interior orientation.

use nalgebra::{Matrix2, Matrix2x3, Point2, Point3, Vector2, Vector3};

use super::interior::INTERIOR;
use super::{
    Adjustable, Brown, CentralModel, CentralProjection, Distortion, EvenRadial, Fisheye, Gnomonic,
    InteriorOrientation, NoDistortion, ParameterGroup, UndistortedMany, collinearity, no_group,
    parameters,
};
use crate::error::{Error, ProjectionError};

/// A camera with one projection centre.
///
/// ```text
/// direction  →  projection P  →  plane  →  distortion D  →  plane  →  interior orientation  →  pixel
/// ```
///
/// Every model of the field is such a chain:
///
/// | model | P | D |
/// | --- | --- | --- |
/// | pinhole | [`Gnomonic`] | [`NoDistortion`] |
/// | Brown; Pix4D | [`Gnomonic`] | [`Brown`] |
/// | OpenCV 4, 5, 8, 12, 14 | [`Gnomonic`] | [`Rational`](super::Rational) |
/// | Metashape | [`Gnomonic`] | [`Metashape`](super::Metashape) |
/// | Fraser, calibration reports in mm | [`Gnomonic`] | [`Fraser`](super::Fraser) |
/// | Kannala–Brandt, OpenCV `fisheye` | [`Fisheye::Equidistant`] | [`EvenRadial`] |
/// | thin-prism fisheye, Fisheye624 | [`Fisheye::Equidistant`] | [`ThinPrism`](super::ThinPrism), [`RadialTangentialThinPrism`](super::RadialTangentialThinPrism) |
/// | classical fisheyes | [`Fisheye`] | [`NoDistortion`] |
/// | field of view, division, EUCM, double sphere | [`FieldOfView`](super::FieldOfView), [`Division`](super::Division), [`EnhancedUnified`](super::EnhancedUnified), [`DoubleSphere`](super::DoubleSphere) | [`NoDistortion`] |
/// | Mei, OpenCV `omnidir` | [`UnifiedSphere`](super::UnifiedSphere) | [`Brown`] |
/// | panoramas | [`Panorama`](super::Panorama) | [`NoDistortion`] |
///
/// # Parameters
/// Group 0 is the interior orientation (fx, fy, x₀, y₀, s) in pixels; then the projection's parameters and the distortion's, each
/// where there are any.
///
/// # Example
/// OpenCV 5.0.0, `projectPoints` with fx = fy = 1000, cx = 319.5, cy = 239.5, whose pixel centres are integers:
///
/// ```
/// use collinear::camera::{Brown, BrownCamera, CentralModel, InteriorOrientation};
/// use nalgebra::{Point2, Vector2, Vector3};
///
/// let interior = InteriorOrientation::from_opencv(1000.0, 1000.0, 319.5, 239.5)?;
/// let camera = BrownCamera::new(interior, Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4])?);
/// let p = camera.project_direction(&Vector3::new(0.31, -0.22, 1.0))?;
/// let opencv = Point2::new(617.1076220865975, 28.38781658370502);
/// assert!((p - Vector2::new(0.5, 0.5) - opencv).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("camera model", "intrinsics"))]
pub struct CentralCamera<P, D> {
    interior: InteriorOrientation,
    projection: P,
    distortion: D,
}

/// A camera with Brown's lens distortion.
#[doc(alias("OPENCV", "RADIAL", "SIMPLE_RADIAL", "Pix4D"))]
pub type BrownCamera = CentralCamera<Gnomonic, Brown>;

/// The fisheye of Kannala and Brandt: [`Fisheye::Equidistant`] and [`EvenRadial`].
#[doc(alias("OPENCV_FISHEYE", "RADIAL_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "Kannala-Brandt"))]
pub type FisheyeCamera = CentralCamera<Fisheye, EvenRadial>;

impl CentralCamera<Gnomonic, Brown> {
    /// A lens before an interior orientation.
    #[must_use]
    pub fn new(interior: InteriorOrientation, distortion: Brown) -> Self {
        Self { interior, projection: Gnomonic, distortion }
    }
}

impl<P: CentralProjection> CentralCamera<P, NoDistortion> {
    /// A projection without errors before an interior orientation.
    #[must_use]
    pub fn ideal(interior: InteriorOrientation, projection: P) -> Self {
        Self { interior, projection, distortion: NoDistortion }
    }
}

impl<P: CentralProjection, D: Distortion> CentralCamera<P, D> {
    /// From its three links.
    #[must_use]
    pub fn from_parts(interior: InteriorOrientation, projection: P, distortion: D) -> Self {
        Self { interior, projection, distortion }
    }

    /// The interior orientation.
    #[must_use]
    pub fn interior(&self) -> &InteriorOrientation {
        &self.interior
    }

    /// The projection.
    #[must_use]
    pub fn projection(&self) -> &P {
        &self.projection
    }

    /// The lens.
    #[must_use]
    pub fn distortion(&self) -> &D {
        &self.distortion
    }

    /// The ideal plane points of many pixels: X/Z and Y/Z after [`Gnomonic`]. A pixel that has none becomes NaN, and is counted.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`].
    ///
    /// # Example
    /// OpenCV 5.0.0's `projectPoints` puts (0.31, −0.22, 1) at this pixel, whose centre is half a pixel on:
    ///
    /// ```
    /// use collinear::camera::{Brown, BrownCamera, InteriorOrientation};
    /// use nalgebra::Point2;
    ///
    /// let interior = InteriorOrientation::from_opencv(1000.0, 1000.0, 319.5, 239.5)?;
    /// let camera = BrownCamera::new(interior, Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4])?);
    /// let pixels = vec![Point2::new(617.6076220865975, 28.88781658370502); 1000];
    /// let mut ideal = vec![Point2::origin(); 1000];
    /// let report = camera.undistort_points(&pixels, &mut ideal)?;
    /// assert_eq!((report.converged, report.failed), (1000, 0));
    /// assert!((ideal[999] - Point2::new(0.31, -0.22)).norm() < 1e-15);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[doc(alias("undistortPoints"))]
    pub fn undistort_points(
        &self,
        pixels: &[Point2<f64>],
        ideal: &mut [Point2<f64>],
    ) -> Result<UndistortedMany, Error> {
        if pixels.len() != ideal.len() {
            return Err(Error::LengthMismatch {
                what: "pixels and ideal points",
                left: pixels.len(),
                right: ideal.len(),
            });
        }
        let mut report = UndistortedMany::NONE;
        for (pixels, ideal) in pixels.chunks(MANY).zip(ideal.chunks_mut(MANY)) {
            for (pixel, point) in pixels.iter().zip(ideal.iter_mut()) {
                *point = self.interior.normalised_from_pixel(pixel);
            }
            report = report.and(self.distortion.undistort_many(ideal));
        }
        Ok(report)
    }

    /// What the group of this number is.
    fn part(group: usize) -> Option<Part> {
        let parts = [
            (Part::Interior, INTERIOR.len),
            (Part::Projection, P::PARAMETERS.len()),
            (Part::Distortion, D::PARAMETERS.len()),
        ];
        parts.into_iter().filter(|(_, len)| *len > 0).nth(group).map(|(part, _)| part)
    }

    /// The image with every derivative on the way.
    #[inline]
    fn trace(&self, direction: &Vector3<f64>) -> Result<Trace, ProjectionError> {
        let (plane, by_direction) = self.projection.plane_jacobian(direction)?;
        let distorted = self.distortion.distort_jacobian(&plane)?;
        self.traced(plane, by_direction, distorted)
    }

    /// The same by the bare formulas.
    #[inline]
    fn formula_trace(&self, direction: &Vector3<f64>) -> Result<Trace, ProjectionError> {
        let (plane, by_direction) = self.projection.plane_formula_jacobian(direction)?;
        let distorted = self.distortion.distort_formula_jacobian(&plane)?;
        self.traced(plane, by_direction, distorted)
    }

    #[inline]
    fn traced(
        &self,
        plane: Point2<f64>,
        by_direction: Matrix2x3<f64>,
        (distorted, by_plane): (Point2<f64>, Matrix2<f64>),
    ) -> Result<Trace, ProjectionError> {
        let image = collinearity::finite(self.interior.pixel_from_normalised(&distorted))?;
        let pixel_by_plane = self.interior.axes() * by_plane;
        let jacobian = pixel_by_plane * by_direction;
        if !jacobian.iter().all(|e| e.is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        Ok(Trace { plane, distorted, image, pixel_by_plane, jacobian })
    }
}

/// Points that stay in the cache between the two steps, and are worth a start of their own.
const MANY: usize = 8192;

#[derive(Clone, Copy)]
enum Part {
    Interior,
    Projection,
    Distortion,
}

struct Trace {
    plane: Point2<f64>,
    distorted: Point2<f64>,
    image: Point2<f64>,
    pixel_by_plane: Matrix2<f64>,
    jacobian: Matrix2x3<f64>,
}

impl<P: CentralProjection, D: Distortion> CentralModel for CentralCamera<P, D> {
    fn project_direction(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
        let plane = self.projection.plane(direction)?;
        let distorted = self.distortion.distort(&plane)?;
        collinearity::finite(self.interior.pixel_from_normalised(&distorted))
    }

    fn project_direction_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let trace = self.trace(direction)?;
        Ok((trace.image, trace.jacobian))
    }

    fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
        let distorted = self.interior.normalised_from_pixel(image);
        self.projection.direction(&self.distortion.undistort(&distorted)?.point)
    }
}

/// Writes columns, brought to pixels, as two rows, where the slice has their length.
fn write_columns(columns: &[Vector2<f64>], to_pixels: &Matrix2<f64>, out: &mut [f64]) {
    let len = columns.len();
    if out.len() == 2 * len {
        for (i, column) in columns.iter().enumerate() {
            let column = to_pixels * column;
            out[i] = column.x;
            out[len + i] = column.y;
        }
    }
}

impl<P: CentralProjection, D: Distortion> Adjustable for CentralCamera<P, D> {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        Self::part(group).map(|part| match part {
            Part::Interior => INTERIOR,
            Part::Projection => parameters::group::<P>(),
            Part::Distortion => parameters::group::<D>(),
        })
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        match Self::part(group) {
            Some(Part::Interior) => parameters::write(&self.interior.values(), values),
            Some(Part::Projection) => self.projection.values(values),
            Some(Part::Distortion) => self.distortion.values(values),
            None => {}
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        match Self::part(group).ok_or_else(|| no_group(group))? {
            Part::Interior => self.interior = self.interior.moved(step)?,
            Part::Projection => self.projection = parameters::moved(&self.projection, step)?,
            Part::Distortion => self.distortion = parameters::moved(&self.distortion, step)?,
        }
        Ok(())
    }

    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let trace = self.trace(&object.coords)?;
        self.write_trace(&trace, object, by_object, by_group);
        Ok(trace.image)
    }

    fn formula_partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let trace = self.formula_trace(&object.coords)?;
        self.write_trace(&trace, object, by_object, by_group);
        Ok(trace.image)
    }
}

impl<P: CentralProjection, D: Distortion> CentralCamera<P, D> {
    /// The partial derivatives of a traced image.
    #[inline]
    fn write_trace(
        &self,
        trace: &Trace,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) {
        collinearity::write_rows(&trace.jacobian, by_object);
        for (group, out) in by_group.iter_mut().enumerate().filter(|(_, out)| !out.is_empty()) {
            let mut columns = [Vector2::zeros(); parameters::MOST];
            let (columns, pixel_by_columns) = match Self::part(group) {
                Some(Part::Interior) => {
                    InteriorOrientation::write_partials(&trace.distorted, out);
                    continue;
                }
                Some(Part::Projection) => {
                    let columns = &mut columns[..P::PARAMETERS.len()];
                    self.projection.parameter_partials(&object.coords, columns);
                    (columns, trace.pixel_by_plane)
                }
                Some(Part::Distortion) => {
                    let columns = &mut columns[..D::PARAMETERS.len()];
                    self.distortion.parameter_partials(&trace.plane, columns);
                    (columns, self.interior.axes())
                }
                None => continue,
            };
            write_columns(columns, &pixel_by_columns, out);
        }
    }
}
