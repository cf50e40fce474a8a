//! Every filter on pictures that alias: a zone plate, lines of text, and a landscape of noise, on a plane that runs to its horizon.
//!
//! `cargo run --release --features simd --example filters -- [FOLDER]` writes the pictures to FOLDER, or to `target/filters`, and
//! prints how far each filter is from the mean of 256 lookups a pixel: the PSNR over all pixels whose areas are within the
//! picture, and over those of them where it is minified four times or more, with the time of a call. `filters.png` among them is
//! docs/pictures/filters.png.

use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use collinear::mapping::{FractionalLinear, Map};
use collinear::nalgebra::Point2;
use collinear::resample::{
    AreaFilter, Border, Cubic, Filter, Footprint, ImageView, ImageViewMut, Pyramid,
    RepeatedIntegral, SummedAreaTable, Supersampling, TableFilter, warp, warp_area,
    warp_supersampled,
};

type Failure = Box<dyn Error>;

/// Sides of the pictures and of what is painted.
const SIZE: [usize; 2] = [960, 540];

fn main() -> Result<(), Failure> {
    let folder = std::env::args_os().nth(1).map_or_else(|| "target/filters".into(), PathBuf::from);
    fs::create_dir_all(&folder)?;
    let mut out = std::io::stdout().lock();
    let map = to_the_horizon()?;
    let mut sheet = Sheet::new();
    for (column, (name, texels)) in
        [("zone", zone_plate()), ("text", text()), ("landscape", landscape())]
            .into_iter()
            .enumerate()
    {
        write(&folder.join(name), &texels)?;
        let view = ImageView::<u8, 1>::new(&texels, SIZE[0], SIZE[1])?;
        let reference = painted(|target| {
            let grid = Supersampling::Grid(16);
            warp_supersampled(view, &map, grid, Filter::Bilinear, Border::Clamp, target);
        })?;
        write(&folder.join(format!("{name}-reference")), &reference)?;
        sheet.add(column, SHOWN.len(), &reference);
        writeln!(out, "{name:<42}    all    far        ms")?;
        for (filter, pixels, milliseconds) in every_filter(view, &map)? {
            write(
                &folder.join(format!("{name}-{}", filter.replace([' ', ',', '.'], "-"))),
                &pixels,
            )?;
            if let Some(row) = SHOWN.iter().position(|shown| *shown == filter) {
                sheet.add(column, row, &pixels);
            }
            let [all, far] = psnr(&map, &pixels, &reference);
            writeln!(out, "    {filter:<38} {all:6.2} {far:6.2} {milliseconds:9.1}")?;
        }
    }
    write_sized(&folder.join("filters"), &sheet.pixels, Sheet::SIZE)
}

/// The filters of docs/pictures/filters.png, from above; below them stands the reference.
const SHOWN: [&str; 5] =
    ["nearest", "bilinear", "Lanczos 3", "trilinear", "elliptical, axes up to 16"];

/// What some filters make of the first two pictures just below the horizon, on one sheet.
struct Sheet {
    pixels: Vec<u8>,
}

impl Sheet {
    const PART: [usize; 2] = [440, 80];
    const GAP: usize = 6;
    const SIZE: [usize; 2] = [2 * Self::PART[0] + Self::GAP, 6 * (Self::PART[1] + Self::GAP)];

    fn new() -> Self {
        Self { pixels: vec![255; Self::SIZE[0] * Self::SIZE[1]] }
    }

    fn add(&mut self, column: usize, row: usize, pixels: &[u8]) {
        let [w, h] = Self::PART;
        if column > 1 {
            return;
        }
        for y in 0..h {
            let from = (SIZE[1] / 4 + 12 + y) * SIZE[0] + (SIZE[0] - w) / 2;
            let to = (row * (h + Self::GAP) + y) * Self::SIZE[0] + column * (w + Self::GAP);
            self.pixels[to..to + w].copy_from_slice(&pixels[from..from + w]);
        }
    }
}

/// A plane seen from above its near edge, with the horizon at a quarter of the height: 4 times magnified below, minified 7.5 and 41
/// times where the picture ends.
fn to_the_horizon() -> Result<FractionalLinear, collinear::Error> {
    let [w, h] = SIZE.map(|n| n as f64);
    let step = 1.0 / (0.75 * h);
    let depth = [-0.25 * h * step, 0.0, step];
    let u = [0.5 * w * depth[0] - 0.125 * w, 0.25, 0.5 * w * depth[2]];
    let v = [h * 30.0 / 29.0 * depth[0] - h / 29.0, 0.0, h * 30.0 / 29.0 * depth[2]];
    FractionalLinear::from_coefficients(u, v, depth, [1.0, 0.0, 0.0])
}

fn painted(paint: impl FnOnce(&mut ImageViewMut<'_, u8, 1>)) -> Result<Vec<u8>, collinear::Error> {
    let mut pixels = vec![0; SIZE[0] * SIZE[1]];
    paint(&mut ImageViewMut::new(&mut pixels, SIZE[0], SIZE[1])?);
    Ok(pixels)
}

type Painted = (&'static str, Vec<u8>, f64);

fn every_filter(
    view: ImageView<'_, u8, 1>,
    map: &FractionalLinear,
) -> Result<Vec<Painted>, Failure> {
    let mut all = Vec::new();
    let mut add = |name, paint: &dyn Fn(&mut ImageViewMut<'_, u8, 1>)| -> Result<(), Failure> {
        let start = Instant::now();
        let pixels = painted(paint)?;
        all.push((name, pixels, start.elapsed().as_secs_f64() * 1e3));
        Ok(())
    };
    let border = Border::Clamp;
    for (name, filter) in [
        ("nearest", Filter::Nearest),
        ("bilinear", Filter::Bilinear),
        ("cubic, Catmull-Rom", Filter::Bicubic(Cubic::CATMULL_ROM)),
        ("Lanczos 3", Filter::Lanczos3),
    ] {
        add(name, &|target| warp(view, map, filter, border, target))?;
    }
    for (name, places) in [
        ("supersampled, 2 x 2", Supersampling::Grid(2)),
        ("supersampled, 4 x 4", Supersampling::Grid(4)),
        ("jittered, 4 x 4", Supersampling::Jittered { side: 4, seed: 1 }),
        ("adaptive, depth 4", Supersampling::Adaptive { depth: 4, tolerance: 8.0 }),
    ] {
        add(name, &|target| {
            warp_supersampled(view, map, places, Filter::Bilinear, border, target);
        })?;
    }
    let halves = Pyramid::new(view)?;
    let fine = Pyramid::with_ratio(view, 1.12)?;
    for (name, pyramid, filter) in [
        ("nearest level", &halves, AreaFilter::NearestLevel),
        ("nearest level, ratio 1.12", &fine, AreaFilter::NearestLevel),
        ("trilinear", &halves, AreaFilter::Trilinear),
        ("trilinear, ratio 1.12", &fine, AreaFilter::Trilinear),
        ("elliptical, axes up to 2", &halves, AreaFilter::Ewa { anisotropy: 2 }),
        ("elliptical, axes up to 16", &halves, AreaFilter::Ewa { anisotropy: 16 }),
    ] {
        add(name, &|target| warp_area(pyramid, map, filter, border, target))?;
    }
    let table = SummedAreaTable::new(view)?;
    for (name, filter) in [
        ("summed-area table", TableFilter::Rectangle),
        ("summed-area table, 8 strips", TableFilter::Strips(8)),
    ] {
        add(name, &|target| warp_area(&table, map, filter, border, target))?;
    }
    for (name, order) in
        [("repeated integral, 1", 1), ("repeated integral, 2", 2), ("repeated integral, 3", 3)]
    {
        let integral = RepeatedIntegral::new(view, order)?;
        add(name, &|target| warp_area(&integral, map, (), border, target))?;
    }
    Ok(all)
}

/// The PSNR over pixels whose areas lie well within the picture, and over the minified ones of them.
fn psnr(map: &FractionalLinear, pixels: &[u8], reference: &[u8]) -> [f64; 2] {
    let mut sums = [[0.0; 2]; 2];
    for (i, (pixel, expected)) in pixels.iter().zip(reference).enumerate() {
        let centre = Point2::new((i % SIZE[0]) as f64 + 0.5, (i / SIZE[0]) as f64 + 0.5);
        let Ok(footprint) = Footprint::of(map as &dyn Map, &centre) else { continue };
        let [longest, _] = footprint.axes();
        let room = 1.5 * longest + 2.0;
        let inside = (0..2).all(|k| (room..SIZE[k] as f64 - room).contains(&footprint.position[k]));
        if inside {
            let error = f64::from(*pixel) - f64::from(*expected);
            for (sum, counts) in sums.iter_mut().zip([true, longest >= 4.0]) {
                if counts {
                    sum[0] += error * error;
                    sum[1] += 1.0;
                }
            }
        }
    }
    sums.map(|[squares, n]| 10.0 * (255.0 * 255.0 * n / squares).log10())
}

/// Rings whose frequency grows to ½ cycle a texel at the corners.
fn zone_plate() -> Vec<u8> {
    let [w, h] = SIZE.map(|n| n as f64);
    let radius = (w * w + h * h).sqrt() / 2.0;
    texels(|x, y| {
        let (x, y) = (x + 0.5 - w / 2.0, y + 0.5 - h / 2.0);
        127.5 + 127.5 * (core::f64::consts::PI * (x * x + y * y) / (2.0 * radius)).cos()
    })
}

/// Lines of dark letters of 5 × 7 strokes on white.
fn text() -> Vec<u8> {
    texels(|x, y| {
        let (column, row) = ((x / 8.0) as u64, (y / 12.0) as u64);
        let (i, j) = ((x % 8.0) as u64, (y % 12.0) as u64);
        let letter = random(column * 7919 + row);
        let blank = letter.is_multiple_of(6) || i >= 5 || j >= 7;
        // A stroke down one side, two across, and one more of either kind.
        let stroke = i == letter / 8 % 2 * 4
            || j == letter / 16 % 3 * 3
            || j == letter / 64 % 3 * 3
            || ((letter / 256).is_multiple_of(2) && i == 4);
        if !blank && stroke { 20.0 } else { 235.0 }
    })
}

/// Noise of seven octaves, in steps like fields: edges and fine grain at once.
fn landscape() -> Vec<u8> {
    texels(|x, y| {
        let octave = |k: u32| {
            let size = f64::from(1 << (8 - k));
            let (x, y) = (x / size, y / size);
            let (i, j) = (x.floor(), y.floor());
            let (fx, fy) = (x - i, y - j);
            let corner = |dx: f64, dy: f64| {
                let seed = u64::from(k) << 40 | ((i + dx) as u64) << 20 | (j + dy) as u64;
                random(seed) as f64 / 65_536.0 - 0.5
            };
            let upper = corner(0.0, 0.0) * (1.0 - fx) + corner(1.0, 0.0) * fx;
            let lower = corner(0.0, 1.0) * (1.0 - fx) + corner(1.0, 1.0) * fx;
            upper * (1.0 - fy) + lower * fy
        };
        let height: f64 = (0..8).map(|k| octave(k) * 0.62f64.powi(k as i32)).sum();
        let field = (6.0 * height).floor() * 28.0;
        128.0 + field + 60.0 * octave(7)
    })
}

fn texels(value: impl Fn(f64, f64) -> f64) -> Vec<u8> {
    let at = |i: usize| value((i % SIZE[0]) as f64, (i / SIZE[0]) as f64);
    (0..SIZE[0] * SIZE[1]).map(|i| at(i).round().clamp(0.0, 255.0) as u8).collect()
}

/// 16 bits that look like chance.
fn random(seed: u64) -> u64 {
    let x = (seed ^ 0x9e37_79b9).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ (x >> 32)) & 0xffff
}

fn write(path: &Path, pixels: &[u8]) -> Result<(), Failure> {
    write_sized(path, pixels, SIZE)
}

fn write_sized(path: &Path, pixels: &[u8], [width, height]: [usize; 2]) -> Result<(), Failure> {
    let file = fs::File::create(path.with_extension("png"))?;
    let mut encoder = png::Encoder::new(file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(())
}
