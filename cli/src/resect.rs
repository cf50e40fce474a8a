//! A camera from control points, with its protocol.

use std::fmt::Write;

use anyhow::{Result, anyhow, bail};
use collinear::Error;
use collinear::adjust::{
    CRITICAL_VALUE, ControlPoint, ObservationReport, Precision, Report, Resection,
    ResectionOptions, Unknown, resect, resect_robust,
};
use collinear::camera::{Adjustable, Brown, BrownCamera, CentralModel, Frame, Held};
use collinear::error::Brief;
use collinear::nalgebra::{Point2, Point3};
use collinear::numeric::consensus::ConsensusOptions;
use collinear_io::camera::{CameraFile, Exterior, Interior};
use collinear_io::control::ControlRow;
use collinear_io::convert::Camera;
use serde_json::{Value, json};

use crate::protocol::{Table, decimals_for, fixed, number, rows};
use crate::reason::reason;
use crate::residuals::Vector;

/// What is estimated beside the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimated {
    /// The principal distance, one factor for both axes.
    PrincipalDistance,
    /// The principal point.
    PrincipalPoint,
    /// The radial distortion of this power of r², from 0 for k₁.
    Radial(usize),
    /// The decentring distortion.
    Decentering,
}

impl Estimated {
    /// The word for it on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::PrincipalDistance => "distance",
            Self::PrincipalPoint => "point",
            Self::Radial(0) => "k1",
            Self::Radial(1) => "k2",
            Self::Radial(_) => "k3",
            Self::Decentering => "p",
        }
    }

    /// The first that a list chooses twice.
    #[must_use]
    pub fn twice(list: &[Self]) -> Option<Self> {
        (1..list.len()).find(|i| list[..*i].contains(&list[*i])).map(|i| list[i])
    }

    /// The unknowns, for a model whose interior orientation is the group of this number.
    #[must_use]
    pub fn unknowns(self, interior: usize) -> Vec<Unknown> {
        match self {
            Self::PrincipalDistance => vec![Unknown::together(interior, &[0, 1])],
            Self::PrincipalPoint => {
                vec![Unknown::parameter(interior, 2), Unknown::parameter(interior, 3)]
            }
            Self::Radial(power) => vec![Unknown::parameter(interior + 1, power)],
            Self::Decentering => {
                vec![Unknown::parameter(interior + 1, 3), Unknown::parameter(interior + 1, 4)]
            }
        }
    }

    /// Their names and units.
    #[must_use]
    pub fn names(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::PrincipalDistance => &[("fx", "px")],
            Self::PrincipalPoint => &[("x0", "px"), ("y0", "px")],
            Self::Radial(0) => &[("k1", "")],
            Self::Radial(1) => &[("k2", "")],
            Self::Radial(_) => &[("k3", "")],
            Self::Decentering => &[("p1", ""), ("p2", "")],
        }
    }

    /// The present value of a parameter of this name.
    #[must_use]
    pub fn value(name: &str, camera: &impl Adjustable, interior: usize) -> f64 {
        let place = |names: &[&str]| names.iter().position(|n| *n == name);
        let (group, index) = match (place(&["fx", "fy", "x0", "y0"]), place(&LENS)) {
            (Some(index), _) => (interior, index),
            (_, Some(index)) => (interior + 1, index),
            _ => return f64::NAN,
        };
        let mut values = [f64::NAN; 8];
        if let Some(len) = camera.parameter_group(group).map(|g| g.len.min(8)) {
            camera.parameters(group, &mut values[..len]);
        }
        values[index]
    }
}

/// The parameters of Brown's lens in their order.
const LENS: [&str; 5] = ["k1", "k2", "k3", "p1", "p2"];

/// How to resect.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The standard deviation of image coordinates for which the list states none, pixels.
    pub sigma: f64,
    /// What is estimated beside the pose.
    pub estimate: Vec<Estimated>,
    /// Search for wrong points, with this largest residual in standard deviations.
    pub robust: Option<f64>,
    /// Start of the search's random sequence.
    pub seed: u64,
    /// Whether the stated precisions are believed, instead of σ₀ from the residuals.
    pub trust: bool,
}

/// A control point with what the adjustment says of it.
#[derive(Clone, Debug)]
pub struct PointResult {
    /// Its name, or its number from 1.
    pub id: String,
    /// The measured image, pixels.
    pub image: [f64; 2],
    /// Whether it was used.
    pub used: bool,
    /// Observed minus computed of x and y, pixels.
    pub residual: [f64; 2],
    /// The tests of x and y; none for a point that was left out.
    pub image_report: Option<[ObservationReport; 2]>,
    /// The tests of X, Y, Z where the place had a precision.
    pub world_report: Option<[ObservationReport; 3]>,
}

/// A resection with all that is told of it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The camera, in its place.
    pub camera: CameraFile,
    /// The names of the unknowns.
    pub unknowns: Vec<String>,
    /// Their values.
    pub values: Vec<f64>,
    /// Their standard deviations.
    pub deviations: Vec<f64>,
    /// How many decimals of a value are told, by its deviation.
    units: Vec<&'static str>,
    /// What the adjustment says of itself.
    pub report: Report,
    /// The control points that were measured.
    pub points: Vec<PointResult>,
    /// How many were not measured.
    pub unmeasured: usize,
    /// The projection centre and cost of the second solution.
    pub other: Option<([f64; 3], f64)>,
}

/// Resects the camera of a file, whose exterior orientation is not looked at.
///
/// # Errors
/// As [`resect`]; a camera that has not what is to be estimated; a parallel projection.
pub fn run(file: &CameraFile, rows: &[ControlRow], options: &Options) -> Result<Outcome> {
    let brown =
        options.estimate.iter().any(|e| matches!(e, Estimated::Radial(_) | Estimated::Decentering));
    if matches!(file.interior, Interior::Film { .. }) && !options.estimate.is_empty() {
        bail!(
            "the interior orientation of a film is that of its fiducial marks: it is not estimated"
        );
    }
    match file.camera()? {
        Camera::Pinhole(frame) if brown => {
            let camera = BrownCamera::new(frame.camera, Brown::none());
            adjusted(file, &camera, rows, options, as_brown(file))
        }
        Camera::Pinhole(frame) => adjusted(file, &frame.camera, rows, options, |frame| {
            let camera = &frame.camera;
            Interior::Pinhole {
                principal_distance: camera.principal_distance(),
                principal_point: camera.principal_point().into(),
                skew: camera.skew(),
            }
        }),
        Camera::Brown(frame) => adjusted(file, &frame.camera, rows, options, as_brown(file)),
        Camera::Central(frame) => {
            if !options.estimate.is_empty() {
                bail!(
                    "the parameters of a camera `{}` are not estimated: only those of `pinhole` and `brown`",
                    file.interior.model()
                );
            }
            let interior = file.interior.clone();
            adjusted(file, &Held(frame.camera), rows, options, |_| interior.clone())
        }
        Camera::Orthographic(_) => {
            bail!("a parallel projection has no projection centre to resect")
        }
    }
}

/// Why no pose was found among wrong points; where the bound is so wide that chance explains any agreement, that too.
fn no_consensus(error: &Error, threshold: f64, options: &Options, file: &CameraFile) -> String {
    let text = reason(error);
    let pixels = threshold * options.sigma;
    let wide = pixels > 0.05 * f64::from(file.width.max(file.height));
    if wide && matches!(error, Error::NoConsensus { .. }) {
        return format!(
            "{text}: within {} px, {threshold} standard deviations, points agree by chance",
            Brief(pixels)
        );
    }
    text
}

/// Back to the interior orientation of a file: as it was, or as Brown's where it was estimated.
fn as_brown(file: &CameraFile) -> impl Fn(&Frame<BrownCamera>) -> Interior {
    let [width, height] = [file.width, file.height];
    move |frame| CameraFile::from_frame(frame, width, height).interior
}

/// The names and units of the six of the pose.
const POSE: [(&str, &str); 6] =
    [("X", ""), ("Y", ""), ("Z", ""), ("omega", "°"), ("phi", "°"), ("kappa", "°")];

fn adjusted<C: CentralModel + Adjustable + Clone>(
    file: &CameraFile,
    camera: &C,
    rows: &[ControlRow],
    options: &Options,
    interior: impl Fn(&Frame<C>) -> Interior,
) -> Result<Outcome> {
    let mut control = Vec::new();
    let mut measured = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let Some(image) = row.image else { continue };
        let precision = match row.image_sigma {
            Some(sigmas) => Precision::Sigmas(sigmas),
            None => Precision::Sigma(options.sigma),
        };
        let mut point = ControlPoint::new(Point3::from(row.world), Point2::from(image))
            .with_precision(precision);
        if let Some(sigmas) = row.world_sigma {
            point = point.with_object_precision(Precision::Sigmas(sigmas));
        }
        control.push(point);
        measured.push((row.id.clone().unwrap_or_else(|| (i + 1).to_string()), image));
    }
    let mut unknowns = vec![Unknown::group(0)];
    let mut names: Vec<(String, &'static str)> =
        POSE.iter().map(|(name, unit)| ((*name).to_owned(), *unit)).collect();
    for estimated in &options.estimate {
        unknowns.extend(estimated.unknowns(1));
        names.extend(estimated.names().iter().map(|(name, unit)| ((*name).to_owned(), *unit)));
    }
    let how = ResectionOptions {
        unknowns,
        estimate_sigma: !options.trust,
        ..ResectionOptions::default()
    };
    let (found, used): (Resection<Frame<C>>, Vec<bool>) = match options.robust {
        None => {
            let found = resect(camera, &control, &how).map_err(|e| anyhow!(reason(&e)))?;
            (found, vec![true; control.len()])
        }
        Some(threshold) => {
            let seed = options.seed;
            let consensus = ConsensusOptions { threshold, seed, ..ConsensusOptions::default() };
            let found = resect_robust(camera, &control, &consensus, &how);
            let found = found.map_err(|e| anyhow!(no_consensus(&e, threshold, options, file)))?;
            (found.resection, found.inliers)
        }
    };
    let frame = &found.sensor;
    let mut next = 0;
    let points = control
        .iter()
        .zip(&used)
        .zip(measured)
        .map(|((point, used), (id, image))| {
            let computed = collinear::SensorModel::project(frame, &point.object);
            let residual = computed.map_or([f64::NAN; 2], |p| (point.image - p).into());
            let index = next;
            next += usize::from(*used);
            let image_report = used.then(|| found.image_report(index)).flatten();
            PointResult {
                id,
                image,
                used: *used,
                // Of a place with a precision what the adjustment left, which has moved the place too.
                residual: image_report.map_or(residual, |r| r.map(|r| r.residual)),
                image_report,
                world_report: used.then(|| found.object_report(index)).flatten(),
            }
        })
        .collect();
    let center = frame.exterior.projection_center();
    let angles = frame.exterior.omega_phi_kappa();
    let mut values = vec![center.x, center.y, center.z];
    values.extend([angles.omega, angles.phi, angles.kappa].map(f64::to_degrees));
    let mut deviations: Vec<f64> =
        (0..names.len()).map(|i| found.report.standard_deviation(i)).collect();
    let by_angle = found.omega_phi_kappa_covariance();
    for i in 0..3 {
        let variance = by_angle.map_or(f64::NAN, |c| c[(i, i)]);
        deviations[3 + i] = variance.sqrt().to_degrees();
    }
    for (name, _) in &names[POSE.len()..] {
        values.push(Estimated::value(name, frame, 1));
    }
    let camera = CameraFile {
        interior: if options.estimate.is_empty() { file.interior.clone() } else { interior(frame) },
        exterior: Exterior::from_orientation(&frame.exterior),
        ..file.clone()
    };
    let (unknowns, units) = names.into_iter().unzip();
    Ok(Outcome {
        camera,
        unknowns,
        values,
        deviations,
        units,
        points,
        unmeasured: rows.len() - control.len(),
        other: found.other.map(|o| (o.exterior.projection_center().into(), o.cost)),
        report: found.report,
    })
}

impl Outcome {
    /// The residuals at their places.
    #[must_use]
    pub fn vectors(&self) -> Vec<Vector> {
        self.points
            .iter()
            .map(|p| Vector {
                name: p.id.clone(),
                at: p.image,
                residual: p.used.then_some(p.residual),
            })
            .collect()
    }

    /// The protocol, for people.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let report = &self.report;
        let used = self.points.iter().filter(|p| p.used).count();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "Space resection\n");
        let _ = write!(text, "control points   {used}");
        if used < self.points.len() {
            let _ = write!(text, ", {} left out as wrong", self.points.len() - used);
        }
        if self.unmeasured > 0 {
            let _ = write!(text, ", {} without an image", self.unmeasured);
        }
        let _ = writeln!(
            text,
            "\nobservations     {}, unknowns {}, redundancy {}",
            report.observations, report.unknowns, report.redundancy
        );
        let sigma0 = report.sigma0.map_or("not determined".to_owned(), |s| format!("{s:.4}"));
        let _ = writeln!(text, "sigma 0          {sigma0} (1 if the stated precisions are right)");
        let _ = writeln!(
            text,
            "condition        {:.1e}, {} iterations\n",
            report.condition, report.convergence.iterations
        );
        let mut table = Table::new(&["unknown", "value", "st. dev.", "unit"]);
        for (i, name) in self.unknowns.iter().enumerate() {
            let decimals = decimals_for(self.deviations[i]);
            table.row(vec![
                name.clone(),
                fixed(self.values[i], decimals),
                fixed(self.deviations[i], decimals),
                self.units[i].to_owned(),
            ]);
        }
        table.write(&mut text);
        self.write_correlations(&mut text);
        text.push_str("\nresiduals (observed minus computed, px), redundancy numbers r, tests w, detectable blunders (px)\n");
        let mut table = Table::new(&[
            "point",
            "v x",
            "v y",
            "r x",
            "r y",
            "w x",
            "w y",
            "blunder x",
            "blunder y",
            "",
        ]);
        for point in &self.points {
            let mut cells = vec![point.id.clone()];
            cells.extend(point.residual.map(|v| fixed(v, 3)));
            if let Some(r) = &point.image_report {
                cells.extend(r.map(|r| fixed(r.redundancy, 3)));
                cells.extend(r.map(|r| fixed(r.w, 2)));
                cells.extend(r.map(|r| fixed(r.detectable, 2)));
                cells.push(if r.iter().any(suspect) { "<- suspect" } else { "" }.to_owned());
            } else {
                cells.extend(["–"; 6].map(str::to_owned));
                cells.push("left out".to_owned());
            }
            table.row(cells);
        }
        table.write(&mut text);
        self.write_places(&mut text);
        if let Some((center, cost)) = self.other {
            let [x, y, z] = center.map(|c| format!("{c:.3}"));
            let (cost, best) = (2.0 * cost, 2.0 * report.convergence.final_cost);
            let _ =
                writeln!(text, "\na second solution at {x} {y} {z}: vPv {cost:.6}, here {best:.6}");
        }
        text
    }

    fn write_correlations(&self, text: &mut String) {
        let n = self.unknowns.len();
        let mut strong = Vec::new();
        for i in 0..n {
            for j in 0..i {
                // Rotations are correlated as rotation vectors; the angles' own are in the covariance.
                let correlation = self.report.correlation(i, j);
                if correlation.abs() > 0.9 {
                    let name = |k: usize| match k {
                        3..6 => format!("turn about {}", ["x", "y", "z"][k - 3]),
                        _ => self.unknowns[k].clone(),
                    };
                    strong.push(format!("{} and {} {correlation:.3}", name(j), name(i)));
                }
            }
        }
        if !strong.is_empty() {
            let _ = writeln!(text, "\ncorrelated beyond 0.9: {}", strong.join(", "));
        }
    }

    fn write_places(&self, text: &mut String) {
        if self.points.iter().all(|p| p.world_report.is_none()) {
            return;
        }
        text.push_str(
            "\nplaces that were adjusted (observed minus adjusted), redundancy numbers and tests\n",
        );
        let mut table =
            Table::new(&["point", "v X", "v Y", "v Z", "r X", "r Y", "r Z", "w X", "w Y", "w Z"]);
        for point in &self.points {
            let Some(r) = &point.world_report else { continue };
            let mut cells = vec![point.id.clone()];
            cells.extend(r.map(|r| fixed(r.residual, decimals_for(r.detectable / 100.0))));
            cells.extend(r.map(|r| fixed(r.redundancy, 3)));
            cells.extend(r.map(|r| fixed(r.w, 2)));
            table.row(cells);
        }
        table.write(text);
    }

    /// The same for machines.
    ///
    /// # Errors
    /// Those of writing the camera.
    pub fn to_json(&self) -> Result<String> {
        let tests = |r: &ObservationReport| {
            json!({
                "residual": number(r.residual), "redundancy": number(r.redundancy), "w": number(r.w),
                "detectable": number(r.detectable), "influence": number(r.influence),
            })
        };
        let points: Vec<Value> = self
            .points
            .iter()
            .map(|p| {
                json!({
                    "id": p.id, "used": p.used, "image": p.image,
                    "residual": p.residual.map(number),
                    "tests": p.image_report.as_ref().map(|r| r.each_ref().map(tests)),
                    "place": p.world_report.as_ref().map(|r| r.each_ref().map(tests)),
                })
            })
            .collect();
        let unknowns: Vec<Value> = (0..self.unknowns.len())
            .map(|i| {
                json!({
                    "name": self.unknowns[i], "value": self.values[i],
                    "standard_deviation": number(self.deviations[i]), "unit": self.units[i],
                })
            })
            .collect();
        let report = &self.report;
        let value = json!({
            "observations": report.observations,
            "unknown_count": report.unknowns,
            "redundancy": report.redundancy,
            "sigma0": report.sigma0,
            "condition": report.condition,
            "iterations": report.convergence.iterations,
            "unknowns": unknowns,
            "covariance": rows(&report.covariance),
            "points": points,
            "other": self.other.map(|(center, cost)| json!({
                "projection_center": center, "vPv": 2.0 * cost,
                "vPv_here": 2.0 * report.convergence.final_cost,
            })),
            "exterior": self.camera.exterior,
        });
        serde_json::to_string_pretty(&value).map_err(|e| anyhow!(e))
    }
}

/// Beyond Baarda's critical value.
fn suspect(report: &ObservationReport) -> bool {
    report.w.abs() > CRITICAL_VALUE
}
