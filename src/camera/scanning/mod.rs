//! Scanning cameras: not one pose but one for each line, column or pixel.

mod ephemeris;
mod interpolation;
mod polynomial;
mod search;
mod timing;
mod trajectory;

use nalgebra::{Matrix2, Matrix2x3, Point2, Point3, Vector2, Vector6};

pub use ephemeris::{Ephemeris, Interpolation};
pub use polynomial::PolynomialTrajectory;
pub use timing::ScanTime;
pub use trajectory::{PlatformState, Trajectory};

use super::{
    Adjustable, CentralCamera, CentralModel, ImageMotionCompensation, InteriorOrientation,
    NoDistortion, Panorama, ParameterGroup, SensorModel, collinearity,
};
use crate::error::{Error, ProjectionError};
use crate::geometry::rotation::RotationVector;
use crate::geometry::{Locus, Ray};
use search::Miss;

/// A camera that is moved while its picture is exposed.
///
#[doc = include_str!("../../../docs/figures/lenses/scanning.svg")]
///
/// A field of squares in the pictures of five scanning cameras, made by `examples/lens_grids.rs`.
///
/// At the time t of a pixel the platform is at C(t), R(t), and the pixel is that of a [`CentralModel`]:
///
/// ```text
/// X = C(t) + λ R(t)ᵀ d(q),   λ > 0                                   [WD] eq. 4b with a pose for each time
/// t = start + x · per_column + y · per_line
/// ```
///
/// where q, the point of the camera that is exposed, is
///
/// | sensor | constructor | q | t of |
/// | --- | --- | --- | --- |
/// | line scan, pushbroom | [`line_scan`](Self::line_scan) | (x, row) | the line |
/// | strip (moving slit) | [`line_scan`](Self::line_scan) | (x, row) | the film's advance, y |
/// | whiskbroom (mirror) | [`whiskbroom`](Scanner::whiskbroom) | (x, row) on a cylinder: x is the mirror's angle | the pixel |
/// | panoramic (rotating slit) | [`panoramic`](Scanner::panoramic) | (x, y) on a cylinder | the column |
/// | rolling shutter | [`frame_scan`](Self::frame_scan) | (x, y) | the line |
///
/// J. B. Case 1967, *The analytical reduction of panoramic and strip photography*, is the survey's reference for the panoramic and
/// strip cases; the equations here are derived from \[WD\] eq. 4 and hold for any trajectory and any lens.
///
/// # Ground to image
/// The time solves one equation: for a line of detectors y_camera(t) = row, else t = start + q(t) · per_pixel. It is
/// bracketed and solved by Newton's steps with the derivative of the trajectory, to 10⁻¹⁰ lines, or to 10⁻⁹ where the
/// digits end before, and so that the last step moves the camera's point by no more than 10⁻⁶ pixels. A point that is seen more
/// than once, as when the platform pitches back, gets one of its images, always the same. A point that no time of the scan
/// sees is [`ProjectionError::OutsideScan`], with the time that the nearer end's slope leads to, NaN where that is within; an
/// equation that does not come so far is [`ProjectionError::NotConverged`], with its residual in lines.
///
/// Where the ends of the scan do not enclose the moment it is looked for in 64 pieces. Missed is a point with an even number of images, all
/// in one piece within which the platform turns back more than once.
///
/// # Parameters
/// The groups of the trajectory, then those of the camera. Their partial derivatives include that the moment moves:
/// with q_t = ∂q/∂t, ∂(x, y)/∂p = M ∂q/∂p and
///
/// ```text
/// M = ⎛ 1               −q_tx/q_ty            ⎞    a line of detectors; a = per_column, b = per_line
///     ⎝ −a/b   (a q_tx/q_ty − 1/q_ty)/b ⎠
///
/// M = I + q_t (a, b) / (1 − (a, b) · q_t)               a frame
/// ```
///
/// # Example
/// A pushbroom scanner 600 up, c = 1000, a line each 0.2 along y: ground 60 to the right is 100 pixels right of the middle;
/// y = 12 is 60 lines later than y = 0.
///
/// ```
/// use collinear::camera::{ExteriorOrientation, InteriorOrientation, PolynomialTrajectory, ScanTime, Scanner, SensorModel};
/// use nalgebra::{Point2, Point3, Vector3};
///
/// // Camera y, down in the picture, is along the flight.
/// let start = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 600.0), Point3::origin(), -Vector3::y())?;
/// let flight = PolynomialTrajectory::constant_velocity(start, 0.0, Vector3::new(0.0, 0.2, 0.0), Vector3::zeros())?;
/// let camera = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 0.5), 0.0)?;
/// let lines = ScanTime::by_line(0.0, 1.0, [0.0, 2000.0])?;
/// let scanner = Scanner::line_scan(camera, flight, 0.5, lines)?;
/// let p = scanner.project(&Point3::new(-60.0, 12.0, 0.0))?;
/// assert!((p - Point2::new(600.0, 60.0)).norm() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias(
    "pushbroom",
    "linescan",
    "line scanner",
    "strip camera",
    "panoramic camera",
    "optical bar",
    "whiskbroom",
    "rolling shutter"
))]
pub struct Scanner<C, T> {
    camera: C,
    trajectory: T,
    detector: Detector,
    timing: ScanTime,
}

/// Which points of the camera become pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Detector {
    /// Those of one row.
    Line { row: f64 },
    /// All.
    Frame,
}

impl<T: Trajectory> Scanner<CentralCamera<Panorama, ImageMotionCompensation>, T> {
    /// A panoramic camera: a slit that turns about the camera's y axis and exposes a cylinder of film, its lens or film shifted
    /// along the axis by the image motion compensation.
    ///
    /// x − x₀ is fx times the scan angle from the z axis, y − y₀ is fy times the tangent of the angle across the slit, plus
    /// the compensation. `timing` is [`ScanTime::by_column`]; with a scan rate of ω radians a second a column takes
    /// 1/(ω fx). A trajectory that is an [`ExteriorOrientation`](super::ExteriorOrientation) makes it the panorama of one centre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where the scan lies outside the trajectory.
    ///
    /// # Example
    /// From 1000 up at 100 a second, swept at 1 radian a second: what lies 45° to the right is exposed π/4 seconds after the
    /// middle, when the camera is 78.54 further along.
    ///
    /// ```
    /// use collinear::camera::{
    ///     ExteriorOrientation, ImageMotionCompensation, InteriorOrientation, PolynomialTrajectory, ScanTime, Scanner, SensorModel,
    /// };
    /// use nalgebra::{Point2, Point3, Vector3};
    ///
    /// let middle = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 1000.0), Point3::origin(), -Vector3::y())?;
    /// let flight = PolynomialTrajectory::constant_velocity(middle, 0.0, Vector3::new(0.0, 100.0, 0.0), Vector3::zeros())?;
    /// let film = InteriorOrientation::new([600.0; 2], Point2::new(800.0, 60.0), 0.0)?;
    /// let sweep = ScanTime::by_column(-800.0 / 600.0, 1.0 / 600.0, [0.0, 1600.0])?;
    /// let compensation = ImageMotionCompensation::new(100.0 / (1000.0 * 1.0))?;
    /// let camera = Scanner::panoramic(film, compensation, flight, sweep)?;
    /// let p = camera.project(&Point3::new(-1000.0, 78.53981633974483, 0.0))?;
    /// // Straight across: only the compensation, 600 · 0.1 sin 45°, is left of y.
    /// assert!((p - Point2::new(800.0 + 600.0 * std::f64::consts::FRAC_PI_4, 60.0 + 42.42640687119285)).norm() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias("OpticalBar"))]
    pub fn panoramic(
        film: InteriorOrientation,
        compensation: ImageMotionCompensation,
        trajectory: T,
        timing: ScanTime,
    ) -> Result<Self, Error> {
        let camera = CentralCamera::from_parts(film, Panorama::Cylindrical, compensation);
        Self::frame_scan(camera, trajectory, timing)
    }
}

impl<T: Trajectory> Scanner<CentralCamera<Panorama, NoDistortion>, T> {
    /// A whiskbroom scanner: one detector before a mirror that sweeps across the flight; each pixel has its own pose.
    ///
    /// x − x₀ is fx times the mirror's angle from the z axis towards x, so fx is one over the angle of a pixel; the detector
    /// looks along y₀ (and with any other `row` (row − y₀)/fy off it). `timing` is [`ScanTime::by_pixel`]. A mirror that turns unevenly is any
    /// other [`CentralModel`], in [`line_scan`](Self::line_scan).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where the scan lies outside the trajectory, or a line takes no time.
    #[doc(alias("scanning mirror", "multispectral scanner"))]
    pub fn whiskbroom(
        mirror: InteriorOrientation,
        row: f64,
        trajectory: T,
        timing: ScanTime,
    ) -> Result<Self, Error> {
        let camera = CentralCamera::ideal(mirror, Panorama::Cylindrical);
        Self::line_scan(camera, trajectory, row, timing)
    }
}

impl<C: CentralModel, T: Trajectory> Scanner<C, T> {
    /// A line of detectors at y = `row` of the camera, exposed once a line: a pushbroom scanner. With film that is drawn past
    /// a slit it is the strip camera, y in pixels of the film's advance.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] where the scan lies outside the trajectory, or a line takes no time.
    #[doc(alias("pushbroom", "strip camera", "continuous strip", "USGSAstroLineScanner"))]
    pub fn line_scan(camera: C, trajectory: T, row: f64, timing: ScanTime) -> Result<Self, Error> {
        if !row.is_finite() {
            return Err(Error::NotFinite { what: "row of the detectors" });
        }
        if timing.per_pixel().y == 0.0 {
            let expected = "other than zero";
            return Err(Error::OutOfRange { what: "time of a line", value: 0.0, expected });
        }
        Self::of(camera, trajectory, Detector::Line { row }, timing)
    }

    /// A frame whose pixels are exposed at different times: a rolling shutter, with [`ScanTime::by_line`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where the scan lies outside the trajectory.
    #[doc(alias("rolling shutter"))]
    pub fn frame_scan(camera: C, trajectory: T, timing: ScanTime) -> Result<Self, Error> {
        Self::of(camera, trajectory, Detector::Frame, timing)
    }

    fn of(camera: C, trajectory: T, detector: Detector, timing: ScanTime) -> Result<Self, Error> {
        let ([first, last], [from, to]) = (timing.interval(), trajectory.span());
        // A table that ends with the scan may end a rounding before it.
        let slack = LINES_BEYOND * timing.unit();
        for time in [first, last] {
            if !(time >= from - slack && time <= to + slack) {
                let expected = "a time of the trajectory";
                return Err(Error::OutOfRange { what: "time of the scan", value: time, expected });
            }
        }
        Ok(Self { camera, trajectory, detector, timing })
    }

    /// What is exposed.
    #[must_use]
    pub fn camera(&self) -> &C {
        &self.camera
    }

    /// What moves it.
    #[must_use]
    pub fn trajectory(&self) -> &T {
        &self.trajectory
    }

    /// When.
    #[must_use]
    pub fn timing(&self) -> &ScanTime {
        &self.timing
    }

    /// The row of a line of detectors.
    #[must_use]
    pub fn row(&self) -> Option<f64> {
        match self.detector {
            Detector::Line { row } => Some(row),
            Detector::Frame => None,
        }
    }

    /// The point of the camera that is exposed for a pixel.
    fn exposed(&self, image: &Point2<f64>) -> Point2<f64> {
        match self.detector {
            Detector::Line { row } => Point2::new(image.x, row),
            Detector::Frame => *image,
        }
    }

    /// Where the platform is. What rounding takes a time beyond the trajectory's span, the platform moves on.
    fn state(&self, time: f64) -> Result<PlatformState, ProjectionError> {
        let [from, to] = self.trajectory.span();
        let held = time.max(from).min(to);
        let mut state = self.trajectory.state(held)?;
        if time != held {
            let beyond = time - held;
            state.center_rest += state.velocity * beyond;
            state.camera_from_world = RotationVector::new(state.angular_velocity * beyond)
                .rotation()
                * state.camera_from_world;
        }
        Ok(state)
    }

    /// The first and the last time at which a point is looked for: one of the first or the last line may be found just beyond it.
    fn searched(&self) -> [f64; 2] {
        let ([first, last], slack) = (self.timing.interval(), LINES_BEYOND * self.timing.unit());
        [first - slack, last + slack]
    }

    /// Where the camera sees a world point at a time.
    fn sight(&self, world: &Point3<f64>, time: f64) -> Result<Sight, ProjectionError> {
        let state = self.state(time)?;
        let in_camera = state.in_camera(world);
        let (point, by_direction) = self.camera.project_direction_jacobian(&in_camera)?;
        let by_time = by_direction * state.drift(&in_camera);
        Ok(Sight { state, in_camera, point, by_direction, by_time })
    }

    /// How far the point is from being exposed at a time.
    fn miss(&self, sight: &Sight, time: f64) -> Miss {
        let speed = sight.by_time.norm();
        match self.detector {
            Detector::Line { row } => {
                Miss { value: sight.point.y - row, slope: sight.by_time.y, speed }
            }
            Detector::Frame => {
                let slope = 1.0 - self.timing.per_pixel().dot(&sight.by_time);
                // The image's own time is off by the value, which is slope times step.
                let speed = speed * slope.abs().max(1.0);
                Miss { value: self.timing.lag(time, &sight.point), slope, speed }
            }
        }
    }

    /// The image, and how the camera sees the point at the moment of its exposure.
    fn expose(&self, world: &Point3<f64>) -> Result<(Point2<f64>, Sight), ProjectionError> {
        if !world.iter().all(|c| c.is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        let ahead = |time| {
            self.state(time).map_or(f64::NEG_INFINITY, |state| {
                let in_camera = state.in_camera(world);
                in_camera.z / in_camera.norm()
            })
        };
        let found = search::find(self.searched(), self.timing.unit(), ahead, |time| {
            let sight = self.sight(world, time)?;
            let miss = self.miss(&sight, time);
            if miss.value.is_finite() { Ok((miss, sight)) } else { Err(ProjectionError::NotFinite) }
        });
        let (time, sight) = found.map_err(|error| match error {
            ProjectionError::OutsideScan { time, .. } => {
                let [first, last] = self.timing.interval();
                ProjectionError::OutsideScan { time, first, last }
            }
            other => other,
        })?;
        let image = match self.detector {
            Detector::Line { .. } => {
                Point2::new(sight.point.x, self.timing.line(time, sight.point.x))
            }
            Detector::Frame => sight.point,
        };
        Ok((collinearity::finite(image)?, sight))
    }

    /// M: from partial derivatives of the camera's point at a fixed time to those of the image.
    fn image_from_point(&self, sight: &Sight) -> Result<Matrix2<f64>, ProjectionError> {
        let (by_time, per_pixel) = (&sight.by_time, self.timing.per_pixel());
        let m = match self.detector {
            Detector::Line { .. } => {
                let (slant, a, b) = (by_time.x / by_time.y, per_pixel.x, per_pixel.y);
                Matrix2::new(1.0, -slant, -a / b, (a * slant - 1.0 / by_time.y) / b)
            }
            Detector::Frame => {
                let rest = 1.0 - per_pixel.dot(by_time);
                Matrix2::identity() + by_time * per_pixel.transpose() / rest
            }
        };
        if m.iter().all(|e| e.is_finite()) { Ok(m) } else { Err(ProjectionError::NotFinite) }
    }
}

/// How far beyond its first and last line a scan is searched, in lines: what rounding may take.
const LINES_BEYOND: f64 = 1e-7;

/// A point as the camera sees it at one moment.
struct Sight {
    state: PlatformState,
    /// R (X − C).
    in_camera: nalgebra::Vector3<f64>,
    /// Its image in the camera, and that image's derivatives.
    point: Point2<f64>,
    by_direction: Matrix2x3<f64>,
    by_time: Vector2<f64>,
}

impl<C: CentralModel, T: Trajectory> SensorModel for Scanner<C, T> {
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.expose(world).map(|(image, _)| image)
    }

    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let (image, sight) = self.expose(world)?;
        let rotation = sight.state.camera_from_world.matrix();
        Ok((image, self.image_from_point(&sight)? * (sight.by_direction * rotation)))
    }

    /// The ray from where the platform is at the pixel's time.
    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        collinearity::finite(*image)?;
        let time = self.timing.at(image);
        let [from, to] = self.searched();
        if !(time >= from && time <= to) {
            let [first, last] = self.timing.interval();
            return Err(ProjectionError::OutsideScan { time, first, last });
        }
        let state = self.state(time)?;
        let direction = self.camera.direction(&self.exposed(image))?;
        Ray::new(state.center, state.camera_from_world.inverse() * direction)
            .map(Locus::Ray)
            .map_err(|_| ProjectionError::NotFinite)
    }
}

impl<C: CentralModel, T: Trajectory> Scanner<C, T> {
    /// The number of groups that the trajectory has.
    fn trajectory_groups(&self) -> usize {
        (0..).take_while(|g| self.trajectory.parameter_group(*g).is_some()).count()
    }
}

impl<C: CentralModel + Adjustable, T: Trajectory> Adjustable for Scanner<C, T> {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        let of_trajectory = self.trajectory.parameter_group(group);
        of_trajectory
            .or_else(|| self.camera.parameter_group(group.checked_sub(self.trajectory_groups())?))
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        match group.checked_sub(self.trajectory_groups()) {
            None => self.trajectory.parameters(group, values),
            Some(inner) => self.camera.parameters(inner, values),
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        match group.checked_sub(self.trajectory_groups()) {
            None => self.trajectory.adjust(group, step),
            Some(inner) => self.camera.adjust(inner, step),
        }
    }

    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let (image, sight) = self.expose(object)?;
        let m = self.image_from_point(&sight)?;
        let (moving, inner) = by_group.split_at_mut(self.trajectory_groups().min(by_group.len()));
        let mut by_direction = [0.0; 6];
        self.camera.partials(&Point3::from(sight.in_camera), &mut by_direction, inner)?;
        let by_world = m * (sight.by_direction * sight.state.camera_from_world.matrix());
        collinearity::write_rows(&by_world, by_object);
        for out in inner.iter_mut() {
            let len = out.len() / 2;
            for i in 0..len {
                let column = m * Vector2::new(out[i], out[len + i]);
                (out[i], out[len + i]) = (column.x, column.y);
            }
        }
        let by_rotation =
            m * (sight.by_direction * collinearity::rotation_partials(&sight.in_camera));
        let time = self.timing.at(&image);
        let mut columns = alloc::vec::Vec::new();
        for (group, out) in moving.iter_mut().enumerate().filter(|(_, out)| !out.is_empty()) {
            let len = out.len() / 2;
            columns.clear();
            columns.resize(len, Vector6::zeros());
            self.trajectory.partials(time, group, &mut columns)?;
            for (i, column) in columns.iter().enumerate() {
                let (by_center, turn) = (column.fixed_rows::<3>(0), column.fixed_rows::<3>(3));
                let column = by_rotation * turn - by_world * by_center;
                (out[i], out[len + i]) = (column.x, column.y);
            }
        }
        Ok(image)
    }
}
