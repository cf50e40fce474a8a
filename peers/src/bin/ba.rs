//! One bundle adjustment problem of *Bundle Adjustment in the Large*, adjusted and timed.
//!
//! ```text
//! ba FILE [--threads N] [--json] [--solver dense|sparse|iterative] [--camera own|shared|held] [--steps N] [--perturb SEED] [--save OUT]
//! ```
//! Each photograph has a camera of its own with f, k₁ and k₂ unknown; `shared` gives all of them the first camera, `held` leaves the
//! cameras as they are.
//!
//! Prints one line of JSON: initial and final cost (half the sum of squared pixels, all observations), seconds, peak memory in MB, and
//! for each step its number, cost, wall seconds and the process's CPU seconds from the start of the adjustment.

use std::error::Error;
use std::io::Write as _;
use std::ops::ControlFlow;
use std::time::Instant;

use collinear::ExteriorOrientation;
use collinear::adjust::bundle::{Bundle, BundleOptions, OutsideRule, Solver};
use collinear::adjust::{Precision, Unknown};
use collinear::nalgebra::{Point3, Rotation3, Vector3};
use collinear_io::bal::{Bal, BalCamera, Camera};

/// Seconds of CPU time of this process, of all its threads.
fn cpu() -> f64 {
    // utime and stime, fields 14 and 15, have only 10 ms; schedstat of each thread has nanoseconds.
    let mut sum = 0.0;
    for task in std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten() {
        let text = std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
        sum += text.split_whitespace().next().and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    }
    sum * 1e-9
}

/// The peak of the resident memory, in MB.
fn peak() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse::<f64>().ok()).unwrap_or(0.0) / 1024.0
}

/// Numbers between −1 and 1 from a seed (xorshift64*).
fn random(state: &mut u64) -> f64 {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    let bits = state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
    bits as f64 / (1u64 << 52) as f64 - 1.0
}

/// For the machine to spread the threads over its cores.
const WARMING: std::time::Duration = std::time::Duration::from_millis(300);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (mut file, mut save) = (None, None);
    let (mut threads, mut steps, mut perturb) = (1, 200, None);
    let mut solver = Solver::Automatic;
    let mut kind = Kind::Own;
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--json" => {}
            "--threads" => threads = value()?.parse()?,
            "--steps" => steps = value()?.parse()?,
            "--perturb" => perturb = Some(value()?.parse::<u64>()?),
            "--save" => save = Some(value()?),
            "--camera" => {
                kind = match value()?.as_str() {
                    "own" => Kind::Own,
                    "shared" => Kind::Shared,
                    "held" => Kind::Held,
                    other => return Err(format!("no camera is {other}").into()),
                }
            }
            "--solver" => {
                solver = match value()?.as_str() {
                    "dense" => Solver::Dense,
                    "sparse" => Solver::Sparse,
                    "iterative" => Solver::Iterative,
                    other => return Err(format!("no solver is named {other}").into()),
                }
            }
            _ => file = Some(argument),
        }
    }
    let file = file.ok_or("name a file")?;
    let bal = Bal::read(file.as_ref())?;
    let bundle = block(&bal, kind, perturb)?;
    let observations = bal.observations.len();
    let points = bal.points.len();
    let cameras = bal.cameras.len();
    let rest = save.is_some().then_some(bal);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    // Threads that have slept share a core for their first tenth of a second: they are woken before the clock starts.
    pool.broadcast(|_| {
        let woken = Instant::now();
        while woken.elapsed() < WARMING {
            std::hint::spin_loop();
        }
    });
    let mut options =
        BundleOptions { outside: OutsideRule::Formula, solver, ..BundleOptions::default() };
    options.least_squares.max_iterations = steps;
    let (begin, cpu_begin) = (Instant::now(), cpu());
    let mut trace = vec![];
    let adjusted = pool.install(|| {
        bundle.adjust_watched(&options, |progress| {
            trace.push((
                progress.iterations,
                progress.cost,
                begin.elapsed().as_secs_f64(),
                cpu() - cpu_begin,
            ));
            ControlFlow::Continue(())
        })
    })?;
    let (total, cpu_total) = (begin.elapsed().as_secs_f64(), cpu() - cpu_begin);
    let report = adjusted.convergence;
    if let (Some(path), Some(mut bal)) = (save, rest) {
        for ((to, exterior), camera) in
            bal.cameras.iter_mut().zip(adjusted.exteriors()).zip(adjusted.cameras().iter().cycle())
        {
            *to = Camera::from_parts(exterior, camera)?;
        }
        for (to, point) in bal.points.iter_mut().zip(adjusted.points()) {
            *to = (*point).into();
        }
        bal.write(path.as_ref())?;
    }
    let mut lines = vec![format!("[0,{:.12e},0,0]", report.initial_cost)];
    lines.extend(trace.iter().map(|(i, c, w, t)| format!("[{i},{c:.12e},{w:.6},{t:.6}]")));
    let line = format!(
        "{{\"file\":\"{file}\",\"solver\":\"collinear\",\"threads\":{threads},\"cams\":{cameras},\"points\":{points},\"obs\":{observations},\
         \"initial\":{:.17e},\"final\":{:.17e},\"steps\":{},\"total_s\":{total:.6},\"cpu_s\":{cpu_total:.6},\"rss_mb\":{:.1},\
         \"term\":\"{}\",\"trace\":[{}]}}",
        report.initial_cost,
        report.final_cost,
        report.iterations,
        peak(),
        if report.converged { "CONVERGENCE" } else { "NO_CONVERGENCE" },
        lines.join(",")
    );
    writeln!(std::io::stdout(), "{line}")?;
    Ok(())
}

/// Which cameras a block has.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Own,
    Shared,
    Held,
}

/// The problem as a block.
fn block(bal: &Bal, kind: Kind, perturb: Option<u64>) -> Result<Bundle<BalCamera>, Box<dyn Error>> {
    let mut seed = perturb.map_or(0, |s| s.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut noise = |size: f64| if seed == 0 { 0.0 } else { size * random(&mut seed) };
    let unknowns =
        [Unknown::together(0, &[0, 1]), Unknown::parameter(1, 0), Unknown::parameter(1, 1)];
    let unknowns = if kind == Kind::Held { &[] } else { &unknowns[..] };
    let mut bundle = Bundle::new();
    let (mut images, mut first) = (vec![], None);
    for camera in &bal.cameras {
        let exterior = camera.exterior()?;
        let turn = Rotation3::from_scaled_axis(Vector3::from_fn(|_, _| noise(1e-3)));
        let centre = exterior.projection_center() + Vector3::from_fn(|_, _| noise(1e-3));
        let exterior = ExteriorOrientation::new(centre, turn * exterior.camera_from_world());
        let id = match first.filter(|_| kind == Kind::Shared) {
            Some(id) => id,
            None => bundle.add_camera(camera.model()?, unknowns)?,
        };
        first = Some(id);
        images.push(bundle.add_image(exterior, id)?);
    }
    let mut points = vec![];
    for point in &bal.points {
        points.push(bundle.add_point(Point3::from(*point) + Vector3::from_fn(|_, _| noise(1e-3)))?);
    }
    for o in &bal.observations {
        let (image, point) = (images[o.camera as usize], points[o.point as usize]);
        bundle.observe(image, point, o.pixel(), Precision::Sigma(1.0))?;
    }
    Ok(bundle)
}
