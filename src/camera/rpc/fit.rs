//! Rational polynomials in place of any other sensor.

use alloc::vec::Vec;

use nalgebra::Point2;

use super::cubic::{TERMS, terms};
use super::model::Rpc;
use super::record::Rpc00b;
use crate::camera::SensorModel;
use crate::error::{Error, ProjectionError};
use crate::geometry::geodetic::{EarthFrame, EllipsoidalHeight, Geodetic};
use crate::numeric::float;
use crate::numeric::triangular::Triangular;

/// What a sensor images at a point (pixels), at a height above WGS84.
pub type GroundAtHeight<'a> =
    dyn Fn(&Point2<f64>, EllipsoidalHeight) -> Result<Geodetic, ProjectionError> + 'a;

/// Where a sensor is asked: nodes over its image, on layers of height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitGrid {
    /// The first and the last corner of the image, in pixels.
    pub corners: [Point2<f64>; 2],
    /// The lowest and the highest layer.
    pub heights: [EllipsoidalHeight; 2],
    /// Nodes along x, along y, and layers: two at least, at most 10⁶ in all.
    pub nodes: [usize; 3],
}

/// What line and sample are divided by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Denominators {
    /// A cubic each: 39 coefficients for the line and 39 for the sample.
    #[default]
    Separate,
    /// The same cubic: 59 coefficients.
    Shared,
    /// One: 20 coefficients each, a polynomial model.
    One,
}

/// How to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// What line and sample are divided by.
    pub denominators: Denominators,
    /// The weight at which each coefficient is drawn to zero (Tikhonov), relative to the observations: from 0, which leaves
    /// coefficients undetermined that the data do not determine, to 1. A frame camera's polynomials are not unique.
    pub regularisation: f64,
    /// Rounds of reweighting allowed, one at least.
    pub max_iterations: u32,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { denominators: Denominators::default(), regularisation: 1e-12, max_iterations: 10 }
    }
}

/// How far the fitted polynomials are from the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FitResiduals {
    /// The largest distance, in pixels.
    pub max: f64,
    /// √(Σ ‖v‖²/n), in pixels.
    pub rms: f64,
    /// n, the number of points.
    pub points: usize,
}

/// Fitted polynomials with their report.
#[derive(Clone, Copy, Debug)]
pub struct RpcFit {
    /// The camera.
    pub rpc: Rpc,
    /// At the nodes of the grid.
    pub fit: FitResiduals,
    /// At the middles of the grid's cells, which the fit has not seen.
    pub check: FitResiduals,
    /// Rounds of reweighting done.
    pub iterations: u32,
}

/// A node: the ground, normalised later, and the image.
struct Node {
    ground: Geodetic,
    image: Point2<f64>,
}

impl Rpc {
    /// The polynomials that fit a sensor best on a grid of image points and heights, whatever the terrain.
    ///
    /// `ground` gives the position that the sensor images at a point (pixels), at a height above WGS84.
    ///
    /// ```text
    /// minimise Σ ((N(g) − r D(g)) / D₀(g))² + regularisation      D₀: the denominator of the round before
    /// ```
    /// (Tao & Hu 2001, eq. 9 to 13), solved through orthogonal rotations, never by normal equations. The round with the
    /// smallest residual at the nodes is returned.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] and [`Error::NotFinite`] for the grid and the options; [`Error::TooFewPoints`] for fewer nodes
    /// than coefficients; [`Error::Projection`] where the sensor has no ground point at a node, or the fitted denominators
    /// vanish between the nodes; those of [`from_rpc00b`](Self::from_rpc00b) where the grid has no extent on the ground.
    pub fn fit(
        ground: &GroundAtHeight<'_>,
        grid: &FitGrid,
        options: &FitOptions,
    ) -> Result<RpcFit, Error> {
        grid.check()?;
        let nodes = grid.points(ground, false)?;
        let between = grid.points(ground, true)?;
        let (per_ratio, ratios) = match options.denominators {
            Denominators::Separate => (2 * TERMS - 1, 1),
            Denominators::Shared => (3 * TERMS - 1, 2),
            Denominators::One => (TERMS, 1),
        };
        let needed = per_ratio.div_ceil(ratios);
        if nodes.len() < needed {
            return Err(Error::TooFewPoints { needed, got: nodes.len() });
        }
        for (what, value, range, expected) in [
            ("regularisation of a fit", options.regularisation, 0.0..=1.0, "from 0 to 1"),
            ("rounds of a fit", options.max_iterations.into(), 1.0..=1000.0, "from 1 to 1000"),
        ] {
            if !range.contains(&value) {
                return Err(Error::OutOfRange { what, value, expected });
            }
        }
        let mut record = frame_of(&nodes, grid);
        let samples = normalise(&nodes, &record);
        let mut best: Option<(Self, FitResiduals)> = None;
        let mut iterations = 0;
        while iterations < options.max_iterations {
            iterations += 1;
            let solved = match options.denominators {
                Denominators::Separate => separate(&mut record, &samples, options.regularisation),
                Denominators::Shared => shared(&mut record, &samples, options.regularisation),
                Denominators::One => polynomial(&mut record, &samples, options.regularisation),
            };
            if solved.is_none() {
                break;
            }
            let tried = Self::from_rpc00b(&record).and_then(|rpc| Ok((rpc, rpc.off(&nodes)?)));
            let before = best.as_ref().map_or(f64::INFINITY, |(_, r)| r.rms);
            match tried {
                Ok((rpc, residuals)) if residuals.rms < before => best = Some((rpc, residuals)),
                Ok(_) => break,
                Err(e) if iterations == options.max_iterations && best.is_none() => return Err(e),
                Err(_) => {}
            }
            if options.denominators == Denominators::One {
                break;
            }
            let after = best.as_ref().map_or(f64::INFINITY, |(_, r)| r.rms);
            // A round that brings less than a percent is the last.
            if after.is_finite() && after > 0.99 * before {
                break;
            }
        }
        let what = "system of a rational fit";
        let singular = Error::Degenerate { what, measure: 0.0, limit: 0.0 };
        let (rpc, fit) = best.ok_or(singular)?;
        Ok(RpcFit { rpc, fit, check: rpc.off(&between)?, iterations })
    }

    /// As [`fit`](Self::fit), for a sensor whose world is a frame on WGS84.
    ///
    /// # Errors
    /// As [`fit`](Self::fit).
    ///
    /// # Example
    /// A frame camera 5 km above the plain, as polynomials:
    ///
    /// ```
    /// use collinear::camera::rpc::{FitGrid, FitOptions, Rpc};
    /// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation};
    /// use collinear::geometry::geodetic::{EarthFrame, Ellipsoid, EllipsoidalHeight, Geodetic, LocalFrame};
    /// use nalgebra::{Point2, Point3, Vector3};
    ///
    /// let origin = Geodetic::from_degrees(44.0, 5.0, EllipsoidalHeight(0.0))?;
    /// let frame = EarthFrame::Local(LocalFrame::east_north_up(Ellipsoid::WGS84, origin));
    /// let pose = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 5000.0), Point3::origin(), Vector3::y())?;
    /// let camera = Frame::new(pose, InteriorOrientation::new([8000.0; 2], Point2::new(2000.0, 1500.0), 0.0)?);
    /// let grid = FitGrid {
    ///     corners: [Point2::new(0.0, 0.0), Point2::new(4000.0, 3000.0)],
    ///     heights: [EllipsoidalHeight(0.0), EllipsoidalHeight(800.0)],
    ///     nodes: [8, 8, 5],
    /// };
    /// let fit = Rpc::fit_sensor(&camera, &frame, &grid, &FitOptions::default())?;
    /// assert!(fit.check.max < 1e-7);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fit_sensor(
        sensor: &dyn SensorModel,
        frame: &EarthFrame,
        grid: &FitGrid,
        options: &FitOptions,
    ) -> Result<RpcFit, Error> {
        let ground = |image: &Point2<f64>, height: EllipsoidalHeight| {
            let surface = frame.at_height(height).map_err(|_| ProjectionError::NotFinite)?;
            frame.geodetic_from_world(&sensor.ground(image, &surface)?)
        };
        Self::fit(&ground, grid, options)
    }

    /// How far the model is from nodes.
    fn off(&self, nodes: &[Node]) -> Result<FitResiduals, Error> {
        let (mut max, mut sum) = (0.0_f64, 0.0);
        for node in nodes {
            let off = self.project(&node.ground)? - node.image;
            max = max.max(off.norm());
            sum += off.norm_squared();
        }
        let points = nodes.len();
        Ok(FitResiduals { max, rms: float::sqrt(sum / points as f64), points })
    }
}

impl FitGrid {
    fn check(&self) -> Result<(), Error> {
        let [first, last] = self.corners;
        let heights = self.heights.map(|h| h.0);
        let numbers = [first.x, first.y, last.x, last.y, heights[0], heights[1]];
        if !numbers.iter().all(|n| n.is_finite()) {
            return Err(Error::NotFinite { what: "grid of a fit" });
        }
        let all = self.nodes.iter().try_fold(1usize, |n, &k| n.checked_mul(k));
        let total = all.map_or(f64::INFINITY, |n| n as f64);
        for (what, value, valid, expected) in [
            ("width of a fit's grid", last.x - first.x, last.x > first.x, "positive"),
            ("height of a fit's grid", last.y - first.y, last.y > first.y, "positive"),
            ("depth of a fit's grid", heights[1] - heights[0], heights[1] > heights[0], "positive"),
            (
                "nodes of a fit's grid",
                total,
                total <= 1e6 && self.nodes.iter().all(|&n| n >= 2),
                "two at least each way, at most 10⁶ in all",
            ),
        ] {
            if !valid {
                return Err(Error::OutOfRange { what, value, expected });
            }
        }
        Ok(())
    }

    /// The nodes, or the middles of the cells between them.
    fn points(&self, ground: &GroundAtHeight<'_>, middles: bool) -> Result<Vec<Node>, Error> {
        let [first, last] = self.corners;
        let [low, high] = self.heights.map(|h| h.0);
        let (count, shift) =
            if middles { (self.nodes.map(|n| n - 1), 0.5) } else { (self.nodes, 0.0) };
        let share = |i: usize, axis: usize| (i as f64 + shift) / (self.nodes[axis] as f64 - 1.0);
        let mut nodes = Vec::with_capacity(count.iter().product());
        for layer in 0..count[2] {
            let height = EllipsoidalHeight(low + (high - low) * share(layer, 2));
            for row in 0..count[1] {
                for column in 0..count[0] {
                    let x = first.x + (last.x - first.x) * share(column, 0);
                    let image = Point2::new(x, first.y + (last.y - first.y) * share(row, 1));
                    nodes.push(Node { ground: ground(&image, height)?, image });
                }
            }
        }
        Ok(nodes)
    }
}

/// Offsets and scales that bring the nodes within ±1, and polynomials of nothing.
fn frame_of(nodes: &[Node], grid: &FitGrid) -> Rpc00b {
    let reference = nodes.first().map_or(0.0, |n| n.ground.longitude().to_degrees());
    let range = |value: &dyn Fn(&Node) -> f64| {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = nodes.iter().map(value).fold(ends, |(a, b), v| (a.min(v), b.max(v)));
        (0.5 * (low + high), 0.5 * (high - low))
    };
    let latitudes = range(&|n| n.ground.latitude().to_degrees());
    let longitudes = range(&|n| near(n.ground.longitude().to_degrees(), reference));
    let [first, last] = grid.corners;
    let [low, high] = grid.heights.map(|h| h.0);
    let mut one = [0.0; TERMS];
    one[0] = 1.0;
    Rpc00b {
        // The polynomials count from the centre of the first pixel.
        line_offset: 0.5 * (first.y + last.y) - 0.5,
        sample_offset: 0.5 * (first.x + last.x) - 0.5,
        latitude_offset_deg: latitudes.0,
        longitude_offset_deg: longitudes.0,
        height_offset: 0.5 * (low + high),
        line_scale: 0.5 * (last.y - first.y),
        sample_scale: 0.5 * (last.x - first.x),
        latitude_scale_deg: latitudes.1,
        longitude_scale_deg: longitudes.1,
        height_scale: 0.5 * (high - low),
        line_numerator: [0.0; TERMS],
        line_denominator: one,
        sample_numerator: [0.0; TERMS],
        sample_denominator: one,
        error_bias: None,
        error_random: None,
    }
}

/// A longitude in degrees, on the turn that is nearest to another.
fn near(longitude: f64, reference: f64) -> f64 {
    longitude - 360.0 * float::round((longitude - reference) / 360.0)
}

/// A node's twenty terms and its normalised line and sample.
struct Sample {
    terms: [f64; TERMS],
    image: [f64; 2],
}

fn normalise(nodes: &[Node], r: &Rpc00b) -> Vec<Sample> {
    let sample = |n: &Node| {
        let longitude = near(n.ground.longitude().to_degrees(), r.longitude_offset_deg);
        let latitude = n.ground.latitude().to_degrees();
        let ground = [
            (longitude - r.longitude_offset_deg) / r.longitude_scale_deg,
            (latitude - r.latitude_offset_deg) / r.latitude_scale_deg,
            (n.ground.height().0 - r.height_offset) / r.height_scale,
        ];
        let line = (n.image.y - 0.5 - r.line_offset) / r.line_scale;
        let sample = (n.image.x - 0.5 - r.sample_offset) / r.sample_scale;
        Sample { terms: terms(ground), image: [line, sample] }
    };
    nodes.iter().map(sample).collect()
}

fn value(polynomial: &[f64; TERMS], terms: &[f64; TERMS]) -> f64 {
    polynomial.iter().zip(terms).map(|(c, t)| c * t).sum()
}

/// The rows that draw every unknown to zero.
fn regularise<const N: usize>(system: &mut Triangular<N>, weight: f64, samples: usize) {
    if weight > 0.0 {
        for i in 0..N - 1 {
            let mut row = [0.0; N];
            row[i] = weight * float::sqrt(samples as f64);
            system.add_row(row);
        }
    }
}

fn split(solution: &[f64], numerator: &mut [f64; TERMS]) {
    for (c, s) in numerator.iter_mut().zip(solution) {
        *c = *s;
    }
}

/// A numerator and a denominator for the line, and for the sample.
fn separate(record: &mut Rpc00b, samples: &[Sample], weight: f64) -> Option<()> {
    const N: usize = 2 * TERMS;
    let one = |axis: usize, numerator: &mut [f64; TERMS], denominator: &mut [f64; TERMS]| {
        let mut system = Triangular::<N>::new();
        for sample in samples {
            let (r, t) = (sample.image[axis], &sample.terms);
            let w = 1.0 / value(denominator, t);
            system.add_row(core::array::from_fn(|i| match i {
                ..TERMS => w * t[i],
                _ if i < N - 1 => -w * r * t[i - TERMS + 1],
                _ => w * r,
            }));
        }
        regularise(&mut system, weight, samples.len());
        let solution = system.solve(0.0)?;
        split(&solution[..TERMS], numerator);
        denominator[1..].copy_from_slice(&solution[TERMS..N - 1]);
        Some(())
    };
    one(0, &mut record.line_numerator, &mut record.line_denominator)?;
    one(1, &mut record.sample_numerator, &mut record.sample_denominator)
}

/// Two numerators and one denominator.
fn shared(record: &mut Rpc00b, samples: &[Sample], weight: f64) -> Option<()> {
    const N: usize = 3 * TERMS;
    let mut system = Triangular::<N>::new();
    for sample in samples {
        let t = &sample.terms;
        let w = 1.0 / value(&record.line_denominator, t);
        for (axis, r) in sample.image.into_iter().enumerate() {
            let mut row = [0.0; N];
            for k in 0..TERMS {
                row[axis * TERMS + k] = w * t[k];
            }
            for k in 1..TERMS {
                row[2 * TERMS + k - 1] = -w * r * t[k];
            }
            row[N - 1] = w * r;
            system.add_row(row);
        }
    }
    regularise(&mut system, weight, samples.len());
    let solution = system.solve(0.0)?;
    split(&solution[..TERMS], &mut record.line_numerator);
    split(&solution[TERMS..2 * TERMS], &mut record.sample_numerator);
    record.line_denominator[1..].copy_from_slice(&solution[2 * TERMS..N - 1]);
    record.sample_denominator = record.line_denominator;
    Some(())
}

/// Numerators alone.
fn polynomial(record: &mut Rpc00b, samples: &[Sample], weight: f64) -> Option<()> {
    const N: usize = TERMS + 1;
    for (axis, numerator) in
        [&mut record.line_numerator, &mut record.sample_numerator].into_iter().enumerate()
    {
        let mut system = Triangular::<N>::new();
        for sample in samples {
            let row = |i| if i < TERMS { sample.terms[i] } else { sample.image[axis] };
            system.add_row(core::array::from_fn(row));
        }
        regularise(&mut system, weight, samples.len());
        split(&system.solve(0.0)?[..TERMS], numerator);
    }
    Some(())
}
