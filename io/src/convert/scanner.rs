//! Scanning cameras from their files.

use std::sync::Arc;

use collinear::camera::{
    CentralModel, Ephemeris, ImageMotionCompensation, Interpolation, PolynomialTrajectory,
    ScanTime, Scanner, SensorModel, Trajectory,
};
use collinear::geometry::rotation::Quaternion;
use collinear::nalgebra::{Point3, Vector3};

use super::{Central, Model, in_field, panorama};
use crate::camera::Interior;
use crate::error::Error;
use crate::json::Document;
use crate::scanner::{EphemerisFile, Scan, ScanKind, ScannerFile, TrajectoryBase, TrajectoryFile};

impl ScannerFile {
    /// The library's sensor.
    ///
    /// # Errors
    /// [`ErrorKind::Field`](crate::ErrorKind::Field) and [`ErrorKind::Library`](crate::ErrorKind::Library) for values outside their domain.
    pub fn sensor(&self) -> Result<Box<dyn SensorModel>, Error> {
        self.check()?;
        match &self.trajectory.base {
            TrajectoryBase::Exterior(exterior) => self.along(exterior.orientation()?),
            TrajectoryBase::Ephemeris(table) => self.along(table.ephemeris()?),
        }
    }

    fn along<B: Trajectory + 'static>(&self, base: B) -> Result<Box<dyn SensorModel>, Error> {
        let trajectory = self.trajectory.moved(base)?;
        let timing = self.scan.timing([self.width, self.height])?;
        let refused = in_field("scan");
        let size = [self.width, self.height];
        Ok(match (self.scan.kind, &self.interior) {
            (
                ScanKind::Panoramic { compensation, .. },
                Interior::Panorama { projection, principal_distance, principal_point },
            ) => {
                let film = panorama(*projection, *principal_distance, *principal_point, size)?;
                let compensation = ImageMotionCompensation::new(compensation)
                    .map_err(in_field("scan.compensation"))?;
                let camera = Scanner::panoramic(film, compensation, trajectory, timing);
                Box::new(camera.map_err(refused)?)
            }
            (ScanKind::Line { row, .. } | ScanKind::Whiskbroom { row, .. }, interior) => {
                let camera = interior.central(size)?;
                Box::new(Scanner::line_scan(camera, trajectory, row, timing).map_err(refused)?)
            }
            (ScanKind::RollingShutter { .. } | ScanKind::Panoramic { .. }, interior) => {
                let camera = interior.central(size)?;
                Box::new(Scanner::frame_scan(camera, trajectory, timing).map_err(refused)?)
            }
        })
    }
}

impl Interior {
    fn central(&self, size: [u32; 2]) -> Result<Central, Error> {
        let model: Arc<dyn CentralModel> = match self.model_of(size)? {
            Model::Pinhole(interior) => Arc::new(interior),
            Model::Brown(camera) => Arc::new(camera),
            Model::Central(camera) => return Ok(camera),
            Model::Orthographic(_) => {
                let found = self.model().into();
                let expected = "a model with a projection centre";
                let problem = crate::FieldProblem::Unsupported { found, expected };
                return Err(crate::FieldError::new("interior.model", problem).into());
            }
        };
        Ok(model)
    }
}

impl Scan {
    fn timing(&self, size: [u32; 2]) -> Result<ScanTime, Error> {
        let margin = self.margin;
        let [columns, lines] = size.map(|n| [-margin, f64::from(n) + margin]);
        let whole = [0.0, f64::from(size[0])];
        let timing = match self.kind {
            ScanKind::Line { per_line, .. } | ScanKind::RollingShutter { per_line } => {
                ScanTime::by_line(self.start, per_line, lines)
            }
            ScanKind::Whiskbroom { per_column, per_line, .. } => {
                ScanTime::by_pixel(self.start, per_column, per_line, [whole, lines])
            }
            ScanKind::Panoramic { per_column, .. } => {
                ScanTime::by_column(self.start, per_column, columns)
            }
        };
        timing.map_err(in_field("scan"))
    }
}

impl TrajectoryFile {
    fn moved<B: Trajectory>(&self, base: B) -> Result<PolynomialTrajectory<B>, Error> {
        let vectors = |list: &[[f64; 3]]| list.iter().map(|v| Vector3::from(*v)).collect();
        let (position, attitude) =
            (vectors(&self.position_polynomial), vectors(&self.attitude_polynomial));
        PolynomialTrajectory::new(base, self.reference_time, self.time_unit, position, attitude)
            .map_err(in_field("trajectory"))
    }
}

impl EphemerisFile {
    /// The library's table.
    ///
    /// # Errors
    /// [`ErrorKind::Library`](crate::ErrorKind::Library) for times that do not ascend, too few nodes, attitudes too far apart.
    pub fn ephemeris(&self) -> Result<Ephemeris, Error> {
        let field = "trajectory.ephemeris";
        let between = |nodes: Option<u32>| {
            nodes.map_or(Interpolation::Linear, |n| Interpolation::Lagrange(n as usize))
        };
        let positions: Vec<_> = self.positions.iter().map(|p| Point3::from(*p)).collect();
        let mut attitudes = Vec::with_capacity(self.quaternions_wxyz.len());
        for [w, x, y, z] in self.quaternions_wxyz.iter().copied() {
            attitudes.push(Quaternion { w, x, y, z }.rotation().map_err(in_field(field))?);
        }
        Ephemeris::new(
            (&self.position_times, &positions, between(self.position_nodes)),
            (&self.attitude_times, &attitudes, between(self.attitude_nodes)),
        )
        .map_err(in_field(field))
    }
}
