//! A picture drawn by looking up each of its pixels in another.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Error, Result, anyhow, bail};
use collinear::ProjectionError;
use collinear::error::Brief;
use collinear::mapping::span::Span;
use collinear::mapping::{BlockSink, FootprintSink, Map};
use collinear::nalgebra::{Matrix2, Point2};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut, warp};
use collinear_io::picture::Picture;

/// Rows drawn between two reports of progress.
pub(crate) const STEP: usize = 256;

/// A picture that was drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// The picture.
    pub picture: Picture,
    /// Its pixels that lie in the photograph; at least one.
    pub seen: u64,
}

/// A picture to draw, and where in a photograph its pixels look.
#[derive(Clone, Copy, Debug)]
pub struct Lookup<'a> {
    /// Width of the new picture, pixels.
    pub width: u32,
    /// Height of the new picture, pixels.
    pub height: u32,
    /// Photograph from new picture.
    pub map: &'a dyn Map,
}

impl Lookup<'_> {
    /// Draws the picture.
    ///
    /// Grey stays grey unless the border has a colour; the photograph's opacity is passed over. With
    /// [`Border::Transparent`] the picture has a channel of opacity, 0 where the photograph shows nothing. `progress` is
    /// called with the rows done and all rows.
    ///
    /// Nothing but the new picture is allocated, apart from a few rows: photographs are large.
    ///
    /// # Errors
    /// A photograph whose samples do not fill it; a picture none of whose pixels lies in the photograph, whatever the
    /// border.
    pub fn draw(
        &self,
        photograph: &Picture,
        filter: Filter,
        border: Border,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Drawn> {
        let colored = match border {
            Border::Constant([r, g, b, _]) => r != g || g != b,
            _ => false,
        };
        let colors = if photograph.channels > 2 || colored { 3 } else { 1 };
        let job = Job { lookup: *self, photograph, colors, filter, border };
        let (data, seen) = match photograph.channels {
            1 => job.run::<1>(progress),
            2 => job.run::<2>(progress),
            3 => job.run::<3>(progress),
            4 => job.run::<4>(progress),
            other => bail!("has {other} channels, 1 to 4 are read"),
        }?;
        if seen == 0 {
            return Err(self.unseen(photograph));
        }
        let (width, height, channels) = (self.width, self.height, job.channels() as u8);
        let picture = Picture { width, height, channels, data, orientation: 1 };
        Ok(Drawn { picture, seen })
    }

    /// Why nothing is seen, from the picture's corners and middle.
    fn unseen(&self, photograph: &Picture) -> Error {
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        let mut reason = String::new();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (x, y) in [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h), (w / 2.0, h / 2.0)] {
            match self.map.at(&Point2::new(x, y)) {
                Ok(p) => {
                    for (k, c) in [p.x, p.y].into_iter().enumerate() {
                        (low[k], high[k]) = (low[k].min(c), high[k].max(c));
                    }
                }
                Err(e) => reason = e.to_string(),
            }
        }
        if low[0] <= high[0] {
            let [left, top] = low.map(Brief);
            let [right, bottom] = high.map(Brief);
            reason = format!(
                "they lie at x from {left} to {right}, y from {top} to {bottom}, and the photograph has {} × {} pixels",
                photograph.width, photograph.height
            );
        }
        anyhow!(
            "none of the {} × {} pixels lies in the photograph: {reason}",
            self.width,
            self.height
        )
    }
}

/// What all rows are drawn with.
struct Job<'a> {
    lookup: Lookup<'a>,
    photograph: &'a Picture,
    /// Samples of a new pixel, without its opacity.
    colors: usize,
    filter: Filter,
    border: Border,
}

impl Job<'_> {
    /// Whether a new pixel has an opacity.
    fn opacity(&self) -> bool {
        self.border == Border::Transparent
    }

    fn channels(&self) -> usize {
        self.colors + usize::from(self.opacity())
    }

    /// The new picture's samples, and how many of its pixels lie in the photograph.
    ///
    /// The photograph is looked up as it is, with all of its channels, and the rows then get what they need of them: no
    /// copy of the photograph with other channels is made.
    fn run<const C: usize>(&self, progress: &dyn Fn(usize, usize)) -> Result<(Vec<u8>, u64)> {
        let row = self.lookup.width as usize * self.channels();
        let height = self.lookup.height as usize;
        let mut data = vec![0; row * height];
        let (mut seen, mut done) = (0, 0);
        progress(0, height);
        for rows in data.chunks_mut(row * STEP) {
            seen += self.rows::<C>(done, rows)?;
            done += rows.len() / row;
            progress(done, height);
        }
        Ok((data, seen))
    }

    /// Draws the rows from `first` on, and counts their pixels that lie in the photograph.
    fn rows<const C: usize>(&self, first: usize, rows: &mut [u8]) -> Result<u64> {
        let (width, channels) = (self.lookup.width as usize, self.channels());
        let size = [self.photograph.width, self.photograph.height];
        let [w, h] = size.map(|s| s as usize);
        let source = ImageView::<u8, C>::new(&self.photograph.data, w, h)?;
        let count = rows.len() / (width * channels);
        let mut found = vec![0; width * count * C];
        let map = Below { map: self.lookup.map, first: first as i32 };
        let inside = (0..width * count).map(|_| AtomicBool::new(false)).collect();
        let marked = Marked { map, width, size, inside };
        for (target, border) in self.passes::<C>() {
            found.fill(0);
            let mut view = ImageViewMut::<u8, C>::new(&mut found, width, count)?;
            warp(source, &marked, self.filter, border, &mut view);
            match target.len() {
                3 => copy_samples::<3, C>(rows, channels, target.start, &found),
                _ => copy_samples::<1, C>(rows, channels, target.start, &found),
            }
        }
        let inside: Vec<bool> = marked.inside.into_iter().map(AtomicBool::into_inner).collect();
        let seen = inside.iter().filter(|i| **i).count() as u64;
        if self.opacity() {
            for (new, inside) in rows.chunks_exact_mut(channels).zip(inside) {
                if let Some(last) = new.last_mut().filter(|_| inside) {
                    *last = u8::MAX;
                }
            }
        }
        Ok(seen)
    }

    /// The new samples that each lookup fills, and its border. A grey photograph before a border with a colour is looked up
    /// once for each of the three.
    fn passes<const C: usize>(&self) -> Vec<(Range<usize>, Border)> {
        match self.border {
            Border::Constant(color) if C < self.colors => {
                let pass = |(k, c)| (k..k + 1, Border::Constant([c; 4]));
                color.into_iter().take(self.colors).enumerate().map(pass).collect()
            }
            border => vec![(0..self.colors, border)],
        }
    }
}

/// The first N samples of each pixel of C, to pixels of another number of channels, from sample `start` on.
fn copy_samples<const N: usize, const C: usize>(
    to: &mut [u8],
    channels: usize,
    start: usize,
    from: &[u8],
) {
    for (new, old) in to.chunks_exact_mut(channels).zip(from.chunks_exact(C)) {
        let new = new.get_mut(start..).and_then(<[u8]>::first_chunk_mut::<N>);
        if let (Some(new), Some(old)) = (new, old.first_chunk::<N>()) {
            *new = *old;
        }
    }
}

/// The rows of a map from one on.
#[derive(Debug)]
pub(crate) struct Below<'a> {
    pub(crate) map: &'a dyn Map,
    pub(crate) first: i32,
}

impl Below<'_> {
    fn whole(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::new(p.x, p.y + f64::from(self.first))
    }
}

impl Map for Below<'_> {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.map.at(&self.whole(screen))
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.map.jacobian(&self.whole(screen))
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        self.map.blocks(line + self.first, samples, emit);
    }

    fn footprints(&self, line: i32, samples: Range<i32>, emit: &mut FootprintSink<'_>) {
        self.map.footprints(line + self.first, samples, emit);
    }

    fn span(&self, line: i32, samples: Range<i32>) -> Option<(Span<2>, Range<i32>)> {
        self.map.span(line + self.first, samples)
    }
}

/// A map that marks the pixels that lie in the photograph. It hands out no spans, whose pixels it would not see.
#[derive(Debug)]
struct Marked<'a> {
    map: Below<'a>,
    width: usize,
    /// The photograph's.
    size: [u32; 2],
    inside: Vec<AtomicBool>,
}

impl Map for Marked<'_> {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.map.at(screen)
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.map.jacobian(screen)
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        let start = line as usize * self.width;
        let [w, h] = self.size.map(f64::from);
        self.map.blocks(line, samples, &mut |x, u, v| {
            // As a lookup with a transparent border decides: by the texel that contains the point.
            for (x, (u, v)) in (x..).zip(u.iter().zip(v)) {
                if let Some(mark) = self.inside.get(start + x as usize) {
                    let within = (0.0..w).contains(u) && (0.0..h).contains(v);
                    mark.store(within, Ordering::Relaxed);
                }
            }
            emit(x, u, v);
        });
    }
}
