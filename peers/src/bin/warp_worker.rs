//! Warping as a row of a comparison: reads one request a line, answers one line.
//!
//! ```text
//! {"filter": …, "dtype": "u8", "u16" or "f32", "ch": 1 to 4, "sw", "sh", "dw", "dh": sides, "m": [9 numbers, source from output, whole numbers
//!  at the pixels' centres], "threads", "src": file of raw samples, "out": file to write or "", "min_ms"}
//! {"ns": wall time a call, "cpu_ns": processor time a call, "n": calls}   or   {"skip": reason}
//! ```
//!
//! Filters are nearest, bilinear, bicubic (OpenCV's, a = −0.75), catmull_rom, lanczos2, lanczos3 and lanczos4; on a pyramid that
//! is made before the clock runs nearest_level, trilinear, and ewa or aniso16, with axes up to 16 : 1. The border is 0.

use std::io::{BufRead, Write};
use std::time::Instant;

use collinear::mapping::FractionalLinear;
use collinear::nalgebra::Matrix3;
use collinear::resample::{
    AreaFilter, Border, Cubic, Filter, ImageView, ImageViewMut, Pyramid, Sample, warp, warp_area,
};
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let request: Value = serde_json::from_str(&line?)?;
        let answer = answer(&request).unwrap_or_else(|e| json!({ "skip": e.to_string() }));
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

/// A sample in a file.
trait Raw: Sample {
    fn read(bytes: &[u8]) -> Vec<Self>;
    fn write(samples: &[Self]) -> Vec<u8>;
}

macro_rules! raw {
    ($($type:ty)*) => {$(
        impl Raw for $type {
            fn read(bytes: &[u8]) -> Vec<Self> {
                let whole = bytes.chunks_exact(size_of::<Self>());
                whole.filter_map(|b| b.try_into().ok()).map(Self::from_ne_bytes).collect()
            }
            fn write(samples: &[Self]) -> Vec<u8> {
                samples.iter().flat_map(|s| s.to_ne_bytes()).collect()
            }
        }
    )*};
}
raw!(u8 u16 f32);

fn answer(request: &Value) -> Result<Value, Failure> {
    match (request["dtype"].as_str(), request["ch"].as_u64()) {
        (Some("u8"), Some(1)) => run::<u8, 1>(request),
        (Some("u8"), Some(2)) => run::<u8, 2>(request),
        (Some("u8"), Some(3)) => run::<u8, 3>(request),
        (Some("u8"), Some(4)) => run::<u8, 4>(request),
        (Some("u16"), Some(1)) => run::<u16, 1>(request),
        (Some("u16"), Some(3)) => run::<u16, 3>(request),
        (Some("u16"), Some(4)) => run::<u16, 4>(request),
        (Some("f32"), Some(1)) => run::<f32, 1>(request),
        (Some("f32"), Some(3)) => run::<f32, 3>(request),
        (Some("f32"), Some(4)) => run::<f32, 4>(request),
        _ => Err("no such samples".into()),
    }
}

fn run<T: Raw, const C: usize>(request: &Value) -> Result<Value, Failure> {
    let name = request["filter"].as_str().unwrap_or_default();
    let area = match name {
        "nearest_level" => Some(AreaFilter::NearestLevel),
        "trilinear" => Some(AreaFilter::Trilinear),
        "ewa" | "aniso16" => Some(AreaFilter::Ewa { anisotropy: 16 }),
        _ => None,
    };
    let filter = match name {
        _ if area.is_some() => Filter::default(),
        "nearest" => Filter::Nearest,
        "bilinear" => Filter::Bilinear,
        "bicubic" => Filter::Bicubic(Cubic::keys(-0.75)),
        "catmull_rom" => Filter::Bicubic(Cubic::CATMULL_ROM),
        "lanczos2" => Filter::Lanczos2,
        "lanczos3" => Filter::Lanczos3,
        "lanczos4" => Filter::Lanczos4,
        _ => return Err("no such filter".into()),
    };
    let side = |name: &str| {
        request[name].as_u64().map(|n| n as usize).ok_or_else(|| format!("{name} is missing"))
    };
    let source = T::read(&std::fs::read(request["src"].as_str().ok_or("src is missing")?)?);
    let view = ImageView::<T, C>::new(&source, side("sw")?, side("sh")?)?;
    let [width, height] = [side("dw")?, side("dh")?];
    let map = map(&request["m"])?;
    let threads = request["threads"].as_u64().ok_or("threads is missing")? as usize;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let area = match area {
        Some(filter) => Some((Pyramid::new(view)?, filter)),
        None => None,
    };
    let mut pixels = vec![T::default(); width * height * C];
    let mut call = || -> Result<(), Failure> {
        let mut target = ImageViewMut::<T, C>::new(&mut pixels, width, height)?;
        let border = Border::Constant([0.0; 4]);
        pool.install(|| match &area {
            Some((pyramid, filter)) => warp_area(pyramid, &map, *filter, border, &mut target),
            None => warp(view, &map, filter, border, &mut target),
        });
        Ok(())
    };
    call()?;
    let least = request["min_ms"].as_f64().unwrap_or(20.0) * 1e-3;
    let (wall, cpu) = (Instant::now(), processor());
    let mut calls = 0;
    while calls == 0 || wall.elapsed().as_secs_f64() < least {
        call()?;
        calls += 1;
    }
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), processor() - cpu);
    let each = |seconds: f64| seconds * 1e9 / f64::from(calls);
    if let Some(out) = request["out"].as_str().filter(|out| !out.is_empty()) {
        std::fs::write(out, T::write(&pixels))?;
    }
    Ok(json!({ "ns": each(wall), "cpu_ns": each(cpu), "n": calls }))
}

/// The map between pixels counted from their corners, from the matrix between pixels counted at their centres.
fn map(matrix: &Value) -> Result<FractionalLinear, Failure> {
    let numbers: Vec<f64> =
        matrix.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    if numbers.len() != 9 {
        return Err(format!("a matrix of {} numbers", numbers.len()).into());
    }
    let half = |h: f64| Matrix3::new(1.0, 0.0, h, 0.0, 1.0, h, 0.0, 0.0, 1.0);
    let m = half(0.5) * Matrix3::from_row_slice(&numbers) * half(-0.5);
    let row = |i: usize| [m[(i, 2)], m[(i, 0)], m[(i, 1)]];
    Ok(FractionalLinear::from_coefficients(row(0), row(1), row(2), [1.0, 0.0, 0.0])?)
}

/// The processor time of this process, seconds.
fn processor() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
