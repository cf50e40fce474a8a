//! Space resection as a row of a comparison: reads one problem a line, answers one line.
//!
//! ```text
//! {"X": [[X, Y, Z], …], "x": [[x, y], …] in pixels, "K": [fx, fy, cx, cy], "start": null or {"R": [9], "t": [3]}}
//! {"ok": true, "R": [9, row by row, camera from world], "t": [3], "sigma0": …, "cost": …, "us": …}   or
//! {"ok": false, "error": …}
//! ```
//!
//! cx and cy are in the frame of the x given, whatever that calls the first pixel's centre; σ₀ is null where nothing is redundant. The
//! time is that of the resection with its whole report, the mean of the repetitions asked for with `"reps"`.
//! With `"robust": threshold` in pixels wrong points are searched for first.

use std::io::{BufRead, Write};
use std::time::Instant;

use collinear::adjust::{ControlPoint, ResectionOptions, resect, resect_robust};
use collinear::nalgebra::{Matrix3, Point2, Point3, Vector3};
use collinear::numeric::consensus::ConsensusOptions;
use collinear::{ExteriorOrientation, InteriorOrientation, Pose};
use serde_json::{Value, json};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        if line.trim().is_empty() {
            continue;
        }
        let answer = answer(&line)
            .unwrap_or_else(|error| json!({ "ok": false, "error": error.to_string() }));
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(line: &str) -> Result<Value, Failure> {
    let request: Value = serde_json::from_str(line)?;
    let objects = rows::<3>(&request["X"])?;
    let images = rows::<2>(&request["x"])?;
    if objects.len() != images.len() {
        return Err(
            format!("{} object points, {} image points", objects.len(), images.len()).into()
        );
    }
    let [fx, fy, cx, cy] = numbers(&request["K"])?;
    let camera = InteriorOrientation::new([fx, fy], Point2::new(cx, cy), 0.0)?;
    let control: Vec<ControlPoint> = objects
        .iter()
        .zip(&images)
        .map(|(o, i)| ControlPoint::new(Point3::from(*o), Point2::from(*i)))
        .collect();
    let start = match &request["start"] {
        Value::Null => None,
        start => Some(exterior(numbers(&start["R"])?, numbers(&start["t"])?)?),
    };
    let options = ResectionOptions { start, ..ResectionOptions::default() };
    let reps = request["reps"].as_u64().unwrap_or(1).max(1);
    let consensus = request["robust"].as_f64().map(|threshold| ConsensusOptions {
        threshold,
        seed: request["seed"].as_u64().unwrap_or(0),
        ..ConsensusOptions::default()
    });
    let once = || match &consensus {
        None => resect(&camera, &control, &options),
        Some(c) => resect_robust(&camera, &control, c, &options).map(|found| found.resection),
    };
    let clock = Instant::now();
    let mut found = once()?;
    for _ in 1..reps {
        found = once()?;
    }
    let us = clock.elapsed().as_secs_f64() * 1e6 / reps as f64;
    let pose = found.sensor.exterior.pose();
    let rotation: Vec<f64> = pose.rotation.matrix().transpose().iter().copied().collect();
    Ok(json!({
        "ok": true,
        "R": rotation,
        "t": pose.translation().as_slice(),
        "C": pose.origin.coords.as_slice(),
        "sigma0": found.report.sigma0,
        "cost": found.report.convergence.final_cost,
        "iterations": found.report.convergence.iterations,
        "us": us,
    }))
}

fn exterior(rotation: [f64; 9], translation: [f64; 3]) -> Result<ExteriorOrientation, Failure> {
    let matrix = Matrix3::from_row_slice(&rotation);
    let rotation = collinear::geometry::rotation::orthonormalised(&matrix)?;
    let pose = Pose::from_rotation_translation(rotation, Vector3::from(translation));
    Ok(ExteriorOrientation::new(pose.origin, pose.rotation))
}

fn rows<const N: usize>(value: &Value) -> Result<Vec<[f64; N]>, Failure> {
    value.as_array().ok_or("points are no array")?.iter().map(numbers).collect()
}

fn numbers<const N: usize>(value: &Value) -> Result<[f64; N], Failure> {
    let array = value.as_array().ok_or("numbers are no array")?;
    let values =
        array.iter().map(|v| v.as_f64().ok_or("not a number")).collect::<Result<Vec<_>, _>>()?;
    values.try_into().map_err(|v: Vec<f64>| format!("{} numbers, expected {N}", v.len()).into())
}
