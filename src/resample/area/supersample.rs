//! Many lookups a pixel.

use nalgebra::Point2;

use crate::mapping::Map;
use crate::resample::border::Border;
use crate::resample::filter::Filter;
use crate::resample::image::{ImageView, ImageViewMut, Sample};
use crate::resample::sampler::Sampler;

/// Where in a pixel a picture is looked up.
///
/// The mean of the lookups is the pixel's value: with each a box over the pixel, which reproduces a constant (and a ramp where the
/// map is affine, on a grid). What is finer than the lookups lie apart aliases, on a grid as patterns, jittered as noise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Supersampling {
    /// At the centres of n × n equal squares. *Cost.* n² lookups.
    Grid(u8),
    /// At random in each of n × n equal squares (Cook 1986; Dippé & Wold 1985). The numbers come from the seed and the pixel's x
    /// and y alone, so a picture is the same however it is cut. *Cost.* n² lookups and as many random pairs.
    Jittered {
        /// Squares along a side.
        side: u8,
        /// Which random numbers.
        seed: u64,
    },
    /// At the centres of four squares; where these lookups differ by more than the tolerance, each square is looked up the same way
    /// (after Painter & Sloane 1989 and Whitted 1980). *Cost.* 4 to 4 + 4² + … + 4ᵈ lookups. What lies between lookups
    /// that agree by chance is missed.
    Adaptive {
        /// d, how often a square may be divided: 1 to 8.
        depth: u8,
        /// The difference, of the largest and the smallest lookup in any channel, in sample values.
        tolerance: f32,
    },
}

/// 64 well mixed bits (Steele, Lea & Flood 2014, SplitMix's finaliser).
fn mixed(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Two numbers of [0, 1) for lookup `k` of a pixel.
fn random(seed: u64, x: i32, y: i32, k: usize) -> [f64; 2] {
    let pixel = (u64::from(x as u32) << 32) | u64::from(y as u32);
    let bits = mixed(mixed(mixed(seed) ^ pixel).wrapping_add(k as u64));
    [bits >> 32, bits & 0xffff_ffff].map(|b| b as f64 / 4_294_967_296.0)
}

/// Lookups that found something, added up.
#[derive(Clone, Copy)]
struct Sum<const C: usize> {
    values: [f64; C],
    weight: f64,
}

impl<const C: usize> Sum<C> {
    const NONE: Self = Self { values: [0.0; C], weight: 0.0 };

    fn add(&mut self, other: &Self, share: f64) {
        self.weight += share * other.weight;
        for k in 0..C {
            self.values[k] += share * other.values[k];
        }
    }
}

/// What a pixel's lookups share.
struct Pixel<'a, T, const C: usize> {
    sampler: &'a Sampler<'a, T, C>,
    map: &'a dyn Map,
}

impl<T: Sample, const C: usize> Pixel<'_, T, C> {
    fn lookup(&self, x: f64, y: f64) -> Sum<C> {
        let found = self.map.at(&Point2::new(x, y)).ok().and_then(|p| self.sampler.at(p.x, p.y));
        let constant = match self.sampler.border {
            Border::Constant(_) => Some(self.sampler.constant),
            _ => None,
        };
        found.or(constant).map_or(Sum::NONE, |value| Sum {
            values: value.map(|s| f64::from(s.to_f32())),
            weight: 1.0,
        })
    }

    /// The mean over n × n squares of a pixel, each looked up at a place of it.
    fn squares(&self, [left, top]: [f64; 2], n: u8, place: impl Fn(usize) -> [f64; 2]) -> Sum<C> {
        let n = usize::from(n.max(1));
        let mut sum = Sum::NONE;
        for k in 0..n * n {
            let [a, b] = place(k);
            let (x, y) = ((k % n) as f64 + a, (k / n) as f64 + b);
            sum.add(&self.lookup(left + x / n as f64, top + y / n as f64), 1.0);
        }
        sum
    }

    /// The mean over a square, divided where its lookups differ.
    fn divide(&self, x: f64, y: f64, side: f64, depth: u8, tolerance: f32) -> Sum<C> {
        let half = 0.5 * side;
        let corners = [[0.0, 0.0], [half, 0.0], [0.0, half], [half, half]];
        let found = corners.map(|[dx, dy]| self.lookup(x + dx + 0.5 * half, y + dy + 0.5 * half));
        let differ = (0..C).any(|k| {
            let of = |s: &Sum<C>| s.values[k];
            let least = found.iter().map(of).fold(f64::INFINITY, f64::min);
            let most = found.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
            most - least > f64::from(tolerance)
        });
        let uneven = found.iter().any(|s| s.weight != found[0].weight);
        let mut sum = Sum::NONE;
        for ([dx, dy], at_centre) in corners.into_iter().zip(found) {
            if depth > 1 && (differ || uneven) {
                sum.add(&self.divide(x + dx, y + dy, half, depth - 1, tolerance), 0.25);
            } else {
                sum.add(&at_centre, 0.25);
            }
        }
        sum
    }
}

/// Paints `target` with the means of several lookups a pixel, each at a place of its own under `map`.
///
/// As [`warp`](crate::resample::warp), with the map asked at each place: near a horizon or a fold, where derivatives say little
/// of a pixel, this still is the mean over it. Lookups without a value count as the border's constant, and not at all where it
/// has none. Each lookup is rounded to a sample before it is averaged.
///
/// *Cost.* Some 40 ns a lookup.
///
/// ```
/// use collinear::geometry::Affine2;
/// use collinear::resample::{Border, Filter, ImageView, ImageViewMut, Supersampling, warp_supersampled};
///
/// // Four columns a pixel, of 0, 0, 0 and 200.
/// let columns: Vec<u8> = (0..64).map(|i| if i % 4 == 3 { 200 } else { 0 }).collect();
/// let view = ImageView::<u8, 1>::new(&columns, 64, 1)?;
/// let quarter = Affine2::from_coefficients([0.0, 4.0, 0.0], [0.0, 0.0, 1.0]);
/// let mut small = [0; 16];
/// let mut target = ImageViewMut::new(&mut small, 16, 1)?;
/// let grid = Supersampling::Grid(4);
/// warp_supersampled(view, &quarter, grid, Filter::Nearest, Border::Clamp, &mut target);
/// assert_eq!(small, [50; 16]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("SSAA", "antialias", "oversampling"))]
pub fn warp_supersampled<T: Sample, const C: usize>(
    source: ImageView<'_, T, C>,
    map: &dyn Map,
    places: Supersampling,
    filter: Filter,
    border: Border,
    target: &mut ImageViewMut<'_, T, C>,
) {
    let Some(sampler) = Sampler::new(source, filter, border) else { return };
    let of = Pixel { sampler: &sampler, map };
    for line in 0..target.height() {
        let y = line as i32;
        for (x, pixel) in (0..).zip(target.row_mut(line).as_chunks_mut::<C>().0) {
            let (left, top) = (f64::from(x), f64::from(y));
            let sum = match places {
                Supersampling::Grid(side) => of.squares([left, top], side, |_| [0.5; 2]),
                Supersampling::Jittered { side, seed } => {
                    of.squares([left, top], side, |k| random(seed, x, y, k))
                }
                Supersampling::Adaptive { depth, tolerance } => {
                    of.divide(left, top, 1.0, depth.clamp(1, 8), tolerance)
                }
            };
            if sum.weight > 0.0 {
                *pixel = core::array::from_fn(|k| T::from_f32((sum.values[k] / sum.weight) as f32));
            }
        }
    }
}
