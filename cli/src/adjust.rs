//! A block of photographs adjusted, with its protocol.

use std::fmt::Write;
use std::ops::ControlFlow;

use anyhow::{Result, anyhow, bail};
use collinear::Error;
use collinear::adjust::bundle::{
    Adjusted, BundleOptions, BundleReport, BundleReportOptions, CheckPoints, Datum, Exclusion,
    OutsideRule,
};
use collinear::adjust::{CRITICAL_VALUE, ObservationReport};
use collinear::camera::BrownCamera;
use collinear::nalgebra::Point2;
use collinear::numeric::least_squares::{Convergence, Progress};
use collinear::numeric::robust_loss::RobustLoss;
use serde_json::{Value, json};

use crate::block::{Block, Idle};
use crate::given_report::{self, Component};
use crate::protocol::{Table, decimals_for, fixed, number, rows};
use crate::reason::reason;
use crate::resect::Estimated;
use crate::residuals::Vector;

/// How to adjust.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// What is estimated beside poses and points.
    pub estimate: Vec<Estimated>,
    /// How an image point's residual enters.
    pub loss: RobustLoss,
    /// Whether points behind their cameras keep a residual, by the bare formula.
    pub formula: bool,
    /// Whether the stated precision is believed, instead of σ₀ from the residuals.
    pub trust: bool,
    /// Linearisations allowed.
    pub max_iterations: u32,
    /// Whether standard deviations and tests are computed, whose time grows with the cube of the number of photographs.
    pub quality: bool,
    /// Whether the precision of each kind of observations is estimated; the quality is then always judged.
    pub variances: bool,
}

/// An adjusted block with all that is told of it.
#[derive(Debug)]
pub struct Outcome {
    /// The adjusted numbers.
    pub adjusted: Adjusted<BrownCamera>,
    /// For each observation its residual, pixels; none where it took no part.
    pub residuals: Vec<Option<[f64; 2]>>,
    /// Standard deviations and tests, where they were asked for.
    pub quality: Option<BundleReport>,
    /// Check points against their known places, where there are any.
    pub check: Option<CheckPoints>,
    /// How good each kind of observations is, where it was asked for.
    pub components: Option<Vec<Component>>,
    /// How the adjustment with the stated precisions ended.
    pub convergence: Convergence,
    /// Adjustments that the precisions took, where they were estimated.
    pub adjustments: Option<usize>,
    estimate: Vec<Estimated>,
}

/// Adjusts a block.
///
/// # Errors
/// As [`Bundle::adjust`](collinear::adjust::bundle::Bundle::adjust) and [`Bundle::report`](collinear::adjust::bundle::Bundle::report); with
/// variances, a kind of observations whose precision nothing tells.
pub fn run(block: &Block, options: &Options, progress: &dyn Fn(usize, usize)) -> Result<Outcome> {
    let mut how = BundleOptions {
        loss: options.loss,
        outside: if options.formula { OutsideRule::Formula } else { OutsideRule::Exclude },
        ..BundleOptions::default()
    };
    how.least_squares.max_iterations = options.max_iterations;
    let total = options.max_iterations as usize;
    let adjusted = block.bundle.adjust_watched(&how, |step: &Progress| {
        progress(step.iterations as usize, total);
        ControlFlow::Continue(())
    });
    let mut adjusted = adjusted.map_err(|e| anyhow!(reason(&e)))?;
    let convergence = adjusted.convergence;
    let end = &convergence;
    if !end.converged && !(end.final_cost < end.initial_cost) {
        bail!(
            "no step from the start lowers the cost of {:.6}: a greater scale for --loss may find one",
            end.initial_cost
        );
    }
    let datum = if block.known.places() { Datum::Given } else { Datum::Free };
    let mut judged = BundleReportOptions { datum, estimate_sigma: !options.trust };
    let (mut quality, mut components, mut adjustments) = (None, None, None);
    if options.variances {
        let group = |of| given_report::group(block, of);
        judged.estimate_sigma = false;
        let found = block.bundle.estimate_variances(&how, &judged, group);
        let found = found.map_err(|error| match error {
            Error::UnknownPrecision { group, factor, .. } => {
                anyhow!(given_report::unknown_precision(group, factor))
            }
            _ => anyhow!("--variances: {}", reason(&error)),
        })?;
        let left = found.report.variance_components(group).into_iter();
        let left = left.zip(&found.factors);
        components = Some(
            left.map(|(component, (_, factor))| Component { component, factor: *factor }).collect(),
        );
        (adjusted, quality) = (found.adjusted, Some(found.report));
        adjustments = Some(found.adjustments);
    } else if options.quality {
        let report = block.bundle.report(&adjusted, &how, &judged);
        quality = Some(report.map_err(|e| anyhow!(reason(&e)))?);
    }
    let check = given_report::check(block, &adjusted)?;
    let mut taken = vec![true; block.observations.len()];
    for (observation, _) in &adjusted.excluded {
        taken[*observation] = false;
    }
    let residuals = taken
        .iter()
        .enumerate()
        .map(|(i, taken)| {
            taken.then(|| block.bundle.residual(&adjusted, i, how.outside).ok()).flatten()
        })
        .collect();
    let estimate = options.estimate.clone();
    Ok(Outcome {
        adjusted,
        residuals,
        quality,
        check,
        components,
        convergence,
        adjustments,
        estimate,
    })
}

/// Why an observation takes no part, for machines.
fn word(exclusion: Exclusion) -> &'static str {
    match exclusion {
        Exclusion::BehindCamera => "behind_camera",
        Exclusion::OutsideDomain => "outside_domain",
        Exclusion::SingleRay => "single_ray",
        _ => "other",
    }
}

/// So many of the observations with the largest |w| are listed.
pub(crate) const LISTED: usize = 20;

impl Outcome {
    /// The protocol, for people.
    #[must_use]
    pub fn to_text(&self, block: &Block) -> String {
        let mut text = String::from("Bundle adjustment\n\n");
        let convergence = &self.convergence;
        let seen = self.residuals.iter().flatten().count();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "photographs      {}, cameras {}, points {}, image points {}",
            block.photographs.len(),
            block.cameras.len(),
            block.points.len(),
            block.observations.len()
        );
        for Idle { name, image_points } in &block.idle {
            let _ = writeln!(
                text,
                "left out         photograph {name}: {image_points} image points that can take part, 3 needed"
            );
        }
        self.write_placed(block, &mut text);
        for (exclusion, why) in [
            (Exclusion::BehindCamera, "behind their cameras"),
            (Exclusion::OutsideDomain, "outside their cameras' domain"),
            (Exclusion::SingleRay, "of points without a second ray"),
        ] {
            let count = self.adjusted.excluded.iter().filter(|(_, e)| *e == exclusion).count();
            if count > 0 {
                let _ = writeln!(text, "left out         {count} image points {why}");
            }
        }
        let _ = writeln!(
            text,
            "cost             {:.6} to {:.6} in {} iterations, {}",
            convergence.initial_cost,
            convergence.final_cost,
            convergence.iterations,
            if convergence.converged { "converged" } else { "NOT converged" }
        );
        if let Some(adjustments) = self.adjustments {
            let _ = writeln!(
                text,
                "precisions       found in {adjustments} adjustments; with them the cost is {:.6}",
                self.adjusted.convergence.final_cost
            );
        }
        let _ = writeln!(text, "rms              {:.4} px a coordinate", self.rms(seen));
        if let Some(q) = &self.quality {
            let sigma0 = q.sigma0.map_or("not determined".to_owned(), |s| format!("{s:.4}"));
            let _ = writeln!(
                text,
                "observations     {}, unknowns {}, conditions {}, redundancy {}\n\
                 sigma 0          {sigma0} (1 if the stated precisions are right)",
                q.observations, q.unknowns, q.conditions, q.redundancy
            );
        }
        self.write_cameras(block, &mut text);
        self.write_photographs(block, &mut text);
        self.write_given(block, &mut text);
        self.write_suspects(block, &mut text);
        self.write_given_suspects(block, &mut text);
        text
    }

    fn rms(&self, seen: usize) -> f64 {
        let sum: f64 = self.residuals.iter().flatten().map(|[x, y]| x * x + y * y).sum();
        (sum / (2 * seen) as f64).sqrt()
    }

    /// The estimated parameters of each camera: name, value, standard deviation, unit.
    fn parameters(
        &self,
        block: &Block,
        camera: usize,
    ) -> Vec<(&'static str, f64, f64, &'static str)> {
        let Some((_, id)) = block.images.iter().find(|(_, c)| c.number() == camera) else {
            return vec![];
        };
        let Some(model) = self.adjusted.camera(*id) else { return vec![] };
        let covariance = self.quality.as_ref().and_then(|q| q.camera_covariance(*id));
        let names = self.estimate.iter().flat_map(|e| e.names());
        names
            .enumerate()
            .map(|(k, (name, unit))| {
                let variance = covariance.as_ref().and_then(|c| c.get((k, k)).copied());
                let deviation = variance.map_or(f64::NAN, f64::sqrt);
                (*name, Estimated::value(name, model, 0), deviation, *unit)
            })
            .collect()
    }

    fn write_cameras(&self, block: &Block, text: &mut String) {
        if self.estimate.is_empty() {
            return;
        }
        text.push_str("\ncameras\n");
        let mut header = vec!["camera"];
        let names: Vec<(&str, &str)> =
            self.estimate.iter().flat_map(|e| e.names()).copied().collect();
        for (name, _) in &names {
            header.extend([*name, "st. dev."]);
        }
        let mut table = Table::new(&header);
        for (i, name) in block.cameras.iter().enumerate() {
            let mut cells = vec![name.clone()];
            for (_, value, deviation, _) in self.parameters(block, i) {
                let decimals = decimals_for(deviation).max(2);
                cells.extend([fixed(value, decimals), fixed(deviation, decimals)]);
            }
            table.row(cells);
        }
        table.write(text);
    }

    /// For each photograph the number of its image points and their root mean square.
    fn of_photographs(&self, block: &Block) -> Vec<(usize, f64)> {
        self.sums(block, block.photographs.len(), |(photograph, _, _)| *photograph)
    }

    /// The number of image points that take part and their root mean square, pixels, of each of `count` places that they belong to.
    pub(crate) fn sums(
        &self,
        block: &Block,
        count: usize,
        place: impl Fn(&(usize, usize, Point2<f64>)) -> usize,
    ) -> Vec<(usize, f64)> {
        let mut sums = vec![(0, 0.0); count];
        for (observation, residual) in block.observations.iter().zip(&self.residuals) {
            if let Some([x, y]) = residual {
                let (count, sum) = &mut sums[place(observation)];
                (*count, *sum) = (*count + 1, *sum + x * x + y * y);
            }
        }
        sums.into_iter().map(|(n, s)| (n, (s / (2 * n) as f64).sqrt())).collect()
    }

    fn write_photographs(&self, block: &Block, text: &mut String) {
        let title = if self.quality.is_some() && block.known.places() {
            "\nphotographs (centre in world units, turns about the camera's axes in degrees; standard deviations in the frame of what was given)\n"
        } else if self.quality.is_some() {
            "\nphotographs (centre in world units, turns about the camera's axes in degrees; standard deviations of a free network)\n"
        } else {
            "\nphotographs (centre in world units)\n"
        };
        text.push_str(title);
        let mut header = vec!["photograph", "points", "rms px", "X", "Y", "Z"];
        if self.quality.is_some() {
            header.extend(["s X", "s Y", "s Z", "s x", "s y", "s z"]);
        }
        let mut table = Table::new(&header);
        let sums = self.of_photographs(block);
        for (i, name) in block.photographs.iter().enumerate() {
            let id = block.images[i].0;
            let Some(exterior) = self.adjusted.exterior(id) else { continue };
            let (count, rms) = sums[i];
            let deviations =
                self.quality.as_ref().and_then(|q| q.image_covariance(id)).map(|c| {
                    [0, 1, 2, 3, 4, 5].map(|k| c.get((k, k)).map_or(f64::NAN, |v| v.sqrt()))
                });
            let decimals = deviations.map_or(4, |d| decimals_for(d[0].min(d[1]).min(d[2])));
            let mut cells = vec![name.clone(), count.to_string(), fixed(rms, 3)];
            cells.extend(exterior.projection_center().iter().map(|c| fixed(*c, decimals)));
            if let Some(d) = deviations {
                cells.extend(d[..3].iter().map(|d| fixed(*d, decimals)));
                cells.extend(d[3..].iter().map(|d| fixed(d.to_degrees(), 5)));
            }
            table.row(cells);
        }
        table.write(text);
    }

    /// The observations to look at first.
    fn suspects(&self) -> Vec<(usize, [ObservationReport; 2])> {
        let Some(quality) = &self.quality else { return vec![] };
        let largest = |r: &[ObservationReport; 2]| {
            r.iter().map(|r| r.w.abs()).filter(|w| w.is_finite()).fold(0.0, f64::max)
        };
        let mut list: Vec<(usize, [ObservationReport; 2])> = quality
            .image_points
            .iter()
            .copied()
            .enumerate()
            .filter(|(_, r)| largest(r) > CRITICAL_VALUE)
            .collect();
        list.sort_by(|a, b| largest(&b.1).total_cmp(&largest(&a.1)).then(a.0.cmp(&b.0)));
        list
    }

    fn write_suspects(&self, block: &Block, text: &mut String) {
        if self.quality.is_none() {
            return;
        }
        let suspects = self.suspects();
        let _ = writeln!(
            text,
            "\nimage points with a test beyond {CRITICAL_VALUE:.2}: {} of {}{}",
            suspects.len(),
            self.residuals.iter().flatten().count(),
            if suspects.len() > LISTED { ", the largest" } else { "" }
        );
        if suspects.is_empty() {
            return;
        }
        let mut table = Table::new(&[
            "photograph",
            "point",
            "x",
            "y",
            "v x",
            "v y",
            "r x",
            "r y",
            "w x",
            "w y",
        ]);
        for (i, r) in suspects.iter().take(LISTED) {
            let (photograph, point, at) = &block.observations[*i];
            let mut cells =
                vec![block.photographs[*photograph].clone(), block.points[*point].clone()];
            cells.extend([fixed(at.x, 2), fixed(at.y, 2)]);
            cells.extend(r.map(|r| fixed(r.residual, 3)));
            cells.extend(r.map(|r| fixed(r.redundancy, 3)));
            cells.extend(r.map(|r| fixed(r.w, 2)));
            table.row(cells);
        }
        table.write(text);
    }

    /// The same for machines.
    ///
    /// # Errors
    /// None that is known: the numbers that are not finite become null.
    pub fn to_json(&self, block: &Block) -> Result<String> {
        let sums = self.of_photographs(block);
        let photographs: Vec<Value> = block
            .images
            .iter()
            .enumerate()
            .filter_map(|(i, (id, _))| {
                let exterior = self.adjusted.exterior(*id)?;
                let covariance = self.quality.as_ref().and_then(|q| q.image_covariance(*id));
                let covariance = covariance.as_ref().map(rows);
                let rotation = exterior.camera_from_world();
                Some(json!({
                    "name": block.photographs[i], "points": sums[i].0, "rms": number(sums[i].1),
                    "projection_center": exterior.projection_center().coords.as_slice(),
                    "camera_from_world": rotation.matrix().transpose().as_slice(),
                    "covariance": covariance,
                }))
            })
            .collect();
        let cameras: Vec<Value> = (0..block.cameras.len())
            .map(|i| {
                let parameters: Vec<Value> = self
                    .parameters(block, i)
                    .into_iter()
                    .map(|(name, value, deviation, unit)| {
                        json!({ "name": name, "value": value, "standard_deviation": number(deviation), "unit": unit })
                    })
                    .collect();
                json!({ "name": block.cameras[i], "parameters": parameters })
            })
            .collect();
        let convergence = &self.convergence;
        let suspects: Vec<Value> = self
            .suspects()
            .into_iter()
            .map(|(i, r)| {
                let (photograph, point, _) = &block.observations[i];
                json!({
                    "photograph": block.photographs[*photograph], "point": block.points[*point],
                    "residual": r.map(|r| number(r.residual)), "w": r.map(|r| number(r.w)),
                    "redundancy": r.map(|r| number(r.redundancy)),
                })
            })
            .collect();
        let left_out: Vec<Value> = self
            .adjusted
            .excluded
            .iter()
            .filter_map(|(i, exclusion)| {
                let (photograph, point, at) = block.observations.get(*i)?;
                Some(json!({
                    "photograph": block.photographs[*photograph], "point": block.points[*point],
                    "image": [at.x, at.y], "reason": word(*exclusion),
                }))
            })
            .collect();
        let idle: Vec<Value> = block
            .idle
            .iter()
            .map(|idle| json!({ "name": idle.name, "image_points": idle.image_points }))
            .collect();
        let quality = self.quality.as_ref();
        let mut value = json!({
            "initial_cost": convergence.initial_cost, "final_cost": convergence.final_cost,
            "iterations": convergence.iterations, "converged": convergence.converged,
            "image_points": block.observations.len(), "left_out": self.adjusted.excluded.len(),
            "left_out_image_points": left_out, "left_out_photographs": idle,
            "rms": number(self.rms(self.residuals.iter().flatten().count())),
            "observations": quality.map(|q| q.observations), "unknowns": quality.map(|q| q.unknowns),
            "conditions": quality.map(|q| q.conditions),
            "redundancy": quality.map(|q| q.redundancy), "sigma0": quality.and_then(|q| q.sigma0),
            "cameras": cameras, "photographs": photographs, "suspects": suspects,
        });
        if let Some(adjustments) = self.adjustments {
            let cost = self.adjusted.convergence.final_cost;
            value["precisions"] = json!({ "adjustments": adjustments, "cost": cost });
        }
        for (name, field) in self.given_json(block) {
            value[name] = field;
        }
        serde_json::to_string_pretty(&value).map_err(|e| anyhow!(e))
    }

    /// The residuals of the photographs of one camera, or of one photograph, as vectors.
    #[must_use]
    pub fn vectors(&self, block: &Block, photograph: Option<usize>, camera: usize) -> Vec<Vector> {
        let of_these = |place: usize| match photograph {
            Some(wanted) => place == wanted,
            None => block.images[place].1.number() == camera,
        };
        block
            .observations
            .iter()
            .zip(&self.residuals)
            .filter(|((place, _, _), _)| of_these(*place))
            .map(|((_, point, at), residual)| Vector {
                name: block.points[*point].clone(),
                at: [at.x, at.y],
                residual: *residual,
            })
            .collect()
    }
}
