//! Area filters over 64 neighbouring pixels at once.
//!
//! The stages are loops without branches that compilers turn into vector instructions; only texels are loaded one by one. Each
//! pixel has a level of its own. Pixels whose texels are not all within their level are looked up alone, with the same
//! formulas in the same order, so that both give the same bits.

use alloc::boxed::Box;

use super::filter::AreaFilter;
use super::lookup::{Lookup, Place, in_first_period};
use super::pyramid::Pyramid;
use super::spread::{Derivatives, Ellipse, floor, integer, mix, nearest};
use super::texel::Group;
use super::warp::Paint;
use crate::mapping::FootprintBlock;
use crate::mapping::span::BLOCK;
use crate::numeric::vectorised;
use crate::resample::border::Border;
use crate::resample::image::Sample;
use crate::resample::kernel::bilinear;
use crate::resample::position::{LARGEST, split_near, whole_block};

/// A number for each pixel of a block.
type Each<V> = [V; BLOCK];

/// The levels of a block's pixels.
#[repr(align(64))]
struct Levels {
    number: Each<u32>,
    scale: [Each<f64>; 2],
    start: Each<u32>,
    /// Texels along each axis.
    size: [Each<u32>; 2],
    own: Each<f32>,
}

impl Levels {
    const EMPTY: Self = Self {
        number: [0; BLOCK],
        scale: [[0.0; BLOCK]; 2],
        start: [0; BLOCK],
        size: [[0; BLOCK]; 2],
        own: [0.0; BLOCK],
    };

    /// Looks up where the levels of these numbers are.
    #[inline(always)]
    fn place(&mut self, places: &[Place]) {
        let first = self.number[0];
        let mut other = 0;
        for i in 0..BLOCK {
            other |= self.number[i] ^ first;
        }
        if other == 0 {
            // Neighbours mostly share a level.
            let place = places[first as usize % places.len()];
            for axis in 0..2 {
                self.scale[axis] = [place.scale[axis]; BLOCK];
                self.size[axis] = [place.size[axis] as u32; BLOCK];
            }
            self.start = [place.start as u32; BLOCK];
            self.own = [place.own; BLOCK];
            return;
        }
        for i in 0..BLOCK {
            let place = &places[self.number[i] as usize % places.len()];
            for axis in 0..2 {
                self.scale[axis][i] = place.scale[axis];
                self.size[axis][i] = place.size[axis] as u32;
            }
            self.start[i] = place.start as u32;
            self.own[i] = place.own;
        }
    }
}

/// What is known of a block's pixels.
#[repr(align(64))]
struct Scratch {
    position: [Each<f64>; 2],
    derivatives: [Each<f32>; 4],
    levels: Levels,
    /// One where all texels are within the level, zero elsewhere.
    inside: Each<u32>,
    /// One where all are beyond it.
    outside: Each<u32>,
    fraction: [Each<f32>; 2],
    offsets: Each<u32>,
    below: Each<u32>,
    group: Group,
    lower: Group,
    ellipse: Rows,
    values: [Each<f32>; 4],
    coarse: [Each<f32>; 4],
}

/// The ellipses of a block's pixels.
#[repr(align(64))]
struct Rows {
    slope: Each<f32>,
    down: Each<f32>,
    across: Each<f32>,
    width: Each<f32>,
    first: Each<f32>,
    rows: Each<i32>,
    groups: Each<i32>,
    /// The offset of the texel centre before the position.
    anchor: Each<u32>,
    /// From a row of texels to the next.
    stride: Each<u32>,
    /// Of the row in work: its middle, its share of r², its first texel, and that one's offset.
    middle: Each<f32>,
    apart: Each<f32>,
    left: Each<f32>,
    offset: Each<u32>,
    total: Each<f32>,
}

const NONE: Each<f32> = [0.0; BLOCK];

impl Scratch {
    fn new() -> Box<Self> {
        Box::new(Self {
            position: [[0.0; BLOCK]; 2],
            derivatives: [NONE; 4],
            levels: Levels::EMPTY,
            inside: [0; BLOCK],
            outside: [0; BLOCK],
            fraction: [NONE; 2],
            offsets: [0; BLOCK],
            below: [0; BLOCK],
            group: Group::EMPTY,
            lower: Group::EMPTY,
            ellipse: Rows {
                slope: NONE,
                down: NONE,
                across: NONE,
                width: NONE,
                first: NONE,
                rows: [0; BLOCK],
                groups: [0; BLOCK],
                anchor: [0; BLOCK],
                stride: [0; BLOCK],
                middle: NONE,
                apart: NONE,
                left: NONE,
                offset: [0; BLOCK],
                total: NONE,
            },
            values: [NONE; 4],
            coarse: [NONE; 4],
        })
    }

    #[inline(always)]
    fn derivatives(&self, i: usize) -> Derivatives {
        Derivatives(self.derivatives.each_ref().map(|d| d[i]))
    }

    /// Bilinear lookups of all pixels in their levels, into the values or the coarse ones.
    ///
    /// Pixels stay inside or outside only where they are so in every level asked.
    #[inline(always)]
    fn bilinear<T: Sample, const C: usize>(&mut self, samples: &[T], coarse: bool) {
        let Self { position, levels, inside, outside, fraction, offsets, below, .. } = self;
        for i in 0..BLOCK {
            let [w, h] = [levels.size[0][i], levels.size[1][i]];
            let (x, fu) = split_near(position[0][i] * levels.scale[0][i], 0.5);
            let (y, fv) = split_near(position[1][i] * levels.scale[1][i], 0.5);
            fraction[0][i] = fu;
            fraction[1][i] = fv;
            // Two texels a row and two rows.
            let within = (x.wrapping_add(1) < w) & (x < w) & (y.wrapping_add(1) < h) & (y < h);
            inside[i] &= u32::from(within);
            let beyond = (x.wrapping_add(1) > w) | (y.wrapping_add(1) > h);
            outside[i] &= u32::from(beyond);
            offsets[i] = y.wrapping_mul(w).wrapping_add(x).wrapping_mul(C as u32);
            offsets[i] = offsets[i].wrapping_add(levels.start[i]);
            below[i] = offsets[i].wrapping_add(w.wrapping_mul(C as u32));
        }
        self.group.load::<T, C, 2>(samples, &self.offsets);
        self.lower.load::<T, C, 2>(samples, &self.below);
        let to = if coarse { &mut self.coarse } else { &mut self.values };
        let (upper, lower) = (&self.group, &self.lower);
        for k in 0..C {
            for i in 0..BLOCK {
                let tap = |group: &Group, t| group.sample::<T, C>(t, k, i);
                let taps = [tap(upper, 0), tap(upper, 1), tap(lower, 0), tap(lower, 1)];
                to[k][i] = bilinear(taps, self.fraction[0][i], self.fraction[1][i]);
            }
        }
    }
}

/// A pyramid that rows of pixels are looked up in.
pub(super) struct PyramidPainter<'a, T, const C: usize> {
    single: Lookup<'a, T, C>,
    scratch: Box<Scratch>,
    /// Whether blocks can be counted in 32 bits.
    blocks: bool,
}

impl<'a, T: Sample, const C: usize> PyramidPainter<'a, T, C> {
    /// `None` for a pyramid without levels.
    pub(super) fn new(
        pyramid: &'a Pyramid<T, C>,
        filter: AreaFilter,
        border: Border,
    ) -> Option<Self> {
        let single = Lookup::new(pyramid, filter, border)?;
        let [w, h] = single.places[0].size;
        let countable = u32::try_from(single.samples.len()).is_ok();
        let blocks = countable && f64::from(w.max(h)) < LARGEST;
        Some(Self { single, scratch: Scratch::new(), blocks })
    }

    #[inline(always)]
    fn paint_block(&mut self, block: &FootprintBlock<'_>, pixels: &mut [T]) {
        let count = block.u.len();
        let scratch = &mut *self.scratch;
        let [us, vs] = block.by_sample;
        let [ul, vl] = block.by_line;
        for (to, from) in scratch.position.iter_mut().zip([block.u, block.v]) {
            *to = whole_block(from);
        }
        if self.single.border == Border::Repeat {
            // So that every repetition but its edges is within the picture.
            for (positions, n) in scratch.position.iter_mut().zip(self.single.places[0].size) {
                for x in positions {
                    *x = in_first_period(*x, f64::from(n));
                }
            }
        }
        let [us, vs, ul, vl] = [us, vs, ul, vl].map(whole_block);
        for i in 0..BLOCK {
            let Derivatives(d) = Derivatives::new([us[i], vs[i], ul[i], vl[i]]);
            for k in 0..4 {
                scratch.derivatives[k][i] = d[k];
            }
        }
        scratch.inside = [1; BLOCK];
        scratch.outside = [1; BLOCK];
        match self.single.filter {
            AreaFilter::NearestLevel | AreaFilter::Trilinear => self.weigh_levels(),
            AreaFilter::Ewa { .. } => self.weigh_ellipses(),
        }
        if !self.store(count, pixels) {
            self.mend(block, pixels);
        }
    }

    /// Bilinear in one level or in two.
    #[inline(always)]
    fn weigh_levels(&mut self) {
        let Self { single, scratch, .. } = self;
        let linear = single.filter == AreaFilter::Trilinear;
        // A copy, which stays in registers.
        let limits = single.limits;
        let (mut number, mut shares) = ([0; BLOCK], NONE);
        if linear {
            for i in 0..BLOCK {
                let (level, share) = limits.between(scratch.derivatives(i));
                number[i] = integer(level) as u32;
                shares[i] = share;
            }
        } else {
            for i in 0..BLOCK {
                number[i] = integer(limits.level_of_detail(scratch.derivatives(i))) as u32;
            }
        }
        scratch.levels.number = number;
        scratch.levels.place(&single.places);
        scratch.bilinear::<T, C>(single.samples, false);
        let mut between = 0;
        for share in shares {
            between |= share.to_bits();
        }
        if between == 0 {
            // One level, as where all of the block is magnified.
            return;
        }
        let last = single.places.len() as u32 - 1;
        for number in &mut scratch.levels.number {
            *number = (*number + 1).min(last);
        }
        scratch.levels.place(&single.places);
        scratch.bilinear::<T, C>(single.samples, true);
        for k in 0..C {
            for i in 0..BLOCK {
                let (fine, coarse) = (scratch.values[k][i], scratch.coarse[k][i]);
                scratch.values[k][i] = mix(fine, coarse, shares[i]);
            }
        }
    }

    /// Averages over ellipses.
    #[inline(always)]
    fn weigh_ellipses(&mut self) {
        let Self { single, scratch, .. } = self;
        let limits = single.limits;
        let mut number = [0; BLOCK];
        for i in 0..BLOCK {
            number[i] = integer(floor(limits.level(scratch.derivatives(i)))) as u32;
        }
        scratch.levels.number = number;
        scratch.levels.place(&single.places);
        let mut shape = [NONE; 5];
        for i in 0..BLOCK {
            let levels = &scratch.levels;
            let scale = [levels.scale[0][i] as f32, levels.scale[1][i] as f32];
            let ellipse = Ellipse::new(scratch.derivatives(i), scale, levels.own[i], &limits);
            let Ellipse { slope, down, across, height, width } = ellipse;
            shape[0][i] = slope;
            shape[1][i] = down;
            shape[2][i] = across;
            shape[3][i] = height;
            shape[4][i] = width;
        }
        let [slopes, downs, acrosses, heights, widths] = shape;
        let (mut corner, mut fractions) = ([[0; BLOCK]; 2], [NONE; 2]);
        for axis in 0..2 {
            for i in 0..BLOCK {
                let at = scratch.position[axis][i] * scratch.levels.scale[axis][i];
                let (whole, fraction) = split_near(at, 0.5);
                corner[axis][i] = whole as i32;
                fractions[axis][i] = fraction;
            }
        }
        let (mut inside, mut outside) = ([0; BLOCK], [0; BLOCK]);
        let (mut firsts, mut counts, mut groups) = (NONE, [0; BLOCK], [0; BLOCK]);
        for i in 0..BLOCK {
            let [height, width] = [heights[i], widths[i]];
            let ellipse =
                Ellipse { slope: slopes[i], down: downs[i], across: acrosses[i], height, width };
            let [fu, fv] = [fractions[0][i], fractions[1][i]];
            // A texel more on either side than `Lookup::ewa` has.
            let reach = ellipse.reach();
            let (left, right) = (integer(fu - reach) - 1, integer(fu + reach) + 1);
            let (top, bottom) = (integer(fv - height) - 1, integer(fv + height) + 1);
            let [w, h] = scratch.levels.size.each_ref().map(|n| n[i] as i32);
            let (x, y) = (corner[0][i], corner[1][i]);
            // Positions that cannot be split are far from any texel, and sums with them may wrap.
            let near = |k: i32| k.wrapping_add(LARGEST as i32) as u32 <= 2 * LARGEST as u32;
            let known = near(x) & near(y);
            let [x_left, x_right] = [x.wrapping_add(left), x.wrapping_add(right)];
            let [y_top, y_bottom] = [y.wrapping_add(top), y.wrapping_add(bottom)];
            let within = known & (x_left >= 0) & (x_right < w) & (y_top >= 0) & (y_bottom < h);
            let beyond = (x_right < 0) | (x_left >= w) | (y_bottom < 0) | (y_top >= h);
            inside[i] = u32::from(within);
            outside[i] = u32::from(known & beyond);
            let first = nearest(fv - height + 0.5);
            // Pixels that are looked up alone take no rows here.
            let mask = -i32::from(within);
            firsts[i] = first;
            counts[i] = (integer(fv + height - 0.5) - integer(first) + 1) & mask;
            groups[i] = ellipse.groups() & mask;
        }
        let (mut strides, mut anchors) = ([0; BLOCK], [0; BLOCK]);
        for i in 0..BLOCK {
            strides[i] = scratch.levels.size[0][i].wrapping_mul(C as u32);
            let down = (corner[1][i] as u32).wrapping_mul(strides[i]);
            let right = (corner[0][i] as u32).wrapping_mul(C as u32);
            anchors[i] = scratch.levels.start[i].wrapping_add(down).wrapping_add(right);
        }
        (scratch.inside, scratch.outside, scratch.fraction) = (inside, outside, fractions);
        let rows = &mut scratch.ellipse;
        (rows.slope, rows.down, rows.across, rows.width) = (slopes, downs, acrosses, widths);
        (rows.first, rows.rows, rows.groups) = (firsts, counts, groups);
        (rows.stride, rows.anchor, rows.total) = (strides, anchors, NONE);
        scratch.values = [NONE; 4];
        let (mut most_rows, mut most_groups) = (0, 0);
        for i in 0..BLOCK {
            most_rows = most_rows.max(scratch.ellipse.rows[i]);
            most_groups = most_groups.max(scratch.ellipse.groups[i]);
        }
        let limit = single.samples.len().saturating_sub(Group::reach::<T, C, 4>()) as u32;
        for row in 0..most_rows {
            let Scratch { fraction, ellipse, .. } = &mut **scratch;
            for i in 0..BLOCK {
                let line = ellipse.first[i] + row as f32;
                let dy = line - fraction[1][i];
                ellipse.middle[i] = fraction[0][i] + ellipse.slope[i] * dy;
                ellipse.apart[i] = dy * dy * ellipse.down[i];
                ellipse.left[i] = nearest(ellipse.middle[i] - ellipse.width[i] + 0.5);
                let down = (integer(line) as u32).wrapping_mul(ellipse.stride[i]);
                let right = (integer(ellipse.left[i]) as u32).wrapping_mul(C as u32);
                ellipse.offset[i] = ellipse.anchor[i].wrapping_add(down).wrapping_add(right);
            }
            for group in 0..most_groups {
                let Scratch { ellipse, offsets, .. } = &mut **scratch;
                for i in 0..BLOCK {
                    let offset = ellipse.offset[i].wrapping_add(group as u32 * 4 * C as u32);
                    // Only what has no weight lies beyond.
                    offsets[i] = offset.min(limit);
                }
                scratch.group.load::<T, C, 4>(single.samples, &scratch.offsets);
                scratch.add_group::<T, C>(row, group);
            }
        }
        for k in 0..C {
            for i in 0..BLOCK {
                scratch.values[k][i] /= scratch.ellipse.total[i];
            }
        }
    }

    /// The values to those pixels all of whose texels are within their levels; whether all pixels are such.
    #[inline(always)]
    fn store(&self, count: usize, pixels: &mut [T]) -> bool {
        let Scratch { inside, values, .. } = &*self.scratch;
        let mut all = 1;
        for within in inside {
            all &= within;
        }
        let mut samples = [[T::default(); BLOCK]; C];
        for (samples, values) in samples.iter_mut().zip(values) {
            for i in 0..BLOCK {
                samples[i] = T::from_f32(values[i]);
            }
        }
        let (pixels, _) = pixels.as_chunks_mut::<C>();
        match pixels.first_chunk_mut::<BLOCK>() {
            Some(pixels) if all == 1 => {
                for i in 0..BLOCK {
                    for k in 0..C {
                        pixels[i][k] = samples[k][i];
                    }
                }
            }
            _ => {
                for (i, pixel) in pixels.iter_mut().enumerate().take(count.min(BLOCK)) {
                    if inside[i] == 1 {
                        *pixel = core::array::from_fn(|k| samples[k][i]);
                    }
                }
            }
        }
        all == 1
    }

    /// The other pixels.
    #[inline(never)]
    fn mend(&self, block: &FootprintBlock<'_>, pixels: &mut [T]) {
        let Scratch { inside, outside, .. } = &*self.scratch;
        let constant = matches!(self.single.border, Border::Constant(_));
        for (i, pixel) in pixels.chunks_exact_mut(C).enumerate().take(block.u.len()) {
            if inside[i] == 1 {
                continue;
            }
            if constant && outside[i] == 1 {
                pixel.copy_from_slice(&self.single.constant);
            } else {
                let derivatives = self.scratch.derivatives(i);
                match self.single.at(block.u[i], block.v[i], derivatives) {
                    Some(value) => pixel.copy_from_slice(&value),
                    None if constant => pixel.copy_from_slice(&self.single.constant),
                    None => {}
                }
            }
        }
    }
}

impl Scratch {
    /// Adds a group of four texels a pixel, weighed.
    #[inline(always)]
    fn add_group<T: Sample, const C: usize>(&mut self, row: i32, group: i32) {
        let Self { ellipse, values, group: texels, .. } = self;
        for i in 0..BLOCK {
            let there = (row < ellipse.rows[i]) & (group < ellipse.groups[i]);
            let mut total = ellipse.total[i];
            let mut sums = [0.0; C];
            for k in 0..C {
                sums[k] = values[k][i];
            }
            for t in 0..4 {
                let dx = ellipse.left[i] + (4 * group + t as i32) as f32 - ellipse.middle[i];
                let near = 1.0 - (ellipse.apart[i] + dx * dx * ellipse.across[i]);
                let counts = there & (near > 0.0);
                let weight = if counts { near * near } else { 0.0 };
                total += weight;
                for k in 0..C {
                    // Floats may be infinite where they have no weight.
                    let texel = texels.sample::<T, C>(t, k, i);
                    let texel = if T::PER_WORD == 1 && !counts { 0.0 } else { texel };
                    sums[k] += weight * texel;
                }
            }
            ellipse.total[i] = total;
            for k in 0..C {
                values[k][i] = sums[k];
            }
        }
    }
}

impl<T: Sample, const C: usize> Paint<T> for PyramidPainter<'_, T, C> {
    fn paint(&mut self, block: &FootprintBlock<'_>, pixels: &mut [T]) {
        if self.blocks {
            vectorised(
                #[inline(always)]
                || self.paint_block(block, pixels),
            );
            return;
        }
        for (i, pixel) in pixels.chunks_exact_mut(C).enumerate().take(block.u.len()) {
            let [us, vs] = block.by_sample.map(|d| d[i]);
            let [ul, vl] = block.by_line.map(|d| d[i]);
            let derivatives = Derivatives::new([us, vs, ul, vl]);
            match self.single.at(block.u[i], block.v[i], derivatives) {
                Some(value) => pixel.copy_from_slice(&value),
                None => self.fill(pixel),
            }
        }
    }

    fn fill(&self, pixels: &mut [T]) {
        self.single.border.fill::<T, C>(pixels);
    }
}
