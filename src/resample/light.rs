//! Samples as light: sRGB's curve and opacity, so that filters mean what a lens would.

use alloc::vec::Vec;

use super::border::Border;
use super::filter::Filter;
use super::image::{ImageView, ImageViewMut, Sample};
use super::warp::warp;
use crate::error::Error;
use crate::mapping::Map;

/// How samples grow with light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Light {
    /// In proportion.
    #[default]
    Linear,
    /// By the curve of sRGB (IEC 61966-2-1:1999), as nearly all pictures of 8 bits.
    ///
    /// ```text
    /// linear = s / 12.92                       s ≤ 0.04045
    ///          ((s + 0.055) / 1.055)^2.4       else,      s = sample / full
    /// ```
    #[doc(alias("gamma", "sRGB"))]
    Srgb,
}

/// What the last of two or four channels says of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Alpha {
    /// It is a channel like others, or there is none.
    #[default]
    None,
    /// It is their opacity, by which they are not multiplied: as in PNG.
    #[doc(alias("unassociated", "unpremultiplied"))]
    Straight,
    /// It is their opacity, by which their samples are multiplied.
    #[doc(alias = "associated")]
    Premultiplied,
}

/// What the samples of a picture stand for.
///
/// Filters weigh samples. What they ought to weigh is light, each pixel's as far as it is opaque: a mean of sRGB's samples is
/// darker than the mean of their light, and a mean of colours that are not multiplied by their opacity has a share of
/// what cannot be seen.
///
/// `full` is the sample of full light and opacity: 255 for `u8`, 65,535 for `u16`, 1 for `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coding {
    /// How samples grow with light.
    pub light: Light,
    /// What the last channel says.
    pub alpha: Alpha,
}

/// What is taken for no opacity at all.
const CLEAR: f32 = 1.0 / 8_388_608.0;

/// The light of a sample between 0 and 1; the curve is continued as an odd function.
fn light_of_srgb(s: f64) -> f64 {
    let magnitude = s.abs();
    let light = if magnitude <= 0.040_45 {
        magnitude / 12.92
    } else {
        ((magnitude + 0.055) / 1.055).powf(2.4)
    };
    light.copysign(s)
}

/// The sample of a light between 0 and 1.
fn srgb_of_light(light: f64) -> f64 {
    let magnitude = light.abs();
    // The curve's two parts meet at sample 0.04045.
    let s = if magnitude <= 0.040_45 / 12.92 {
        magnitude * 12.92
    } else {
        1.055 * magnitude.powf(1.0 / 2.4) - 0.055
    };
    s.copysign(light)
}

/// The curves of one kind of samples, in tables where samples are integers.
struct Curve {
    light: Light,
    full: f32,
    /// The light of each sample.
    lights: Vec<f32>,
    /// From which light on the nearest sample is the next one.
    edges: Vec<f32>,
}

impl Curve {
    fn new<T: Sample>(light: Light) -> Self {
        let full = T::FULL;
        let (mut lights, mut edges) = (Vec::new(), Vec::new());
        if light == Light::Srgb && T::IS_INTEGER {
            let of = |s: f64| light_of_srgb(s / f64::from(full)) as f32;
            let last = full as u32;
            lights = (0..=last).map(|s| of(f64::from(s))).collect();
            edges = (0..last).map(|s| of(f64::from(s) + 0.5)).collect();
        }
        Self { light, full, lights, edges }
    }

    fn decode<T: Sample>(&self, sample: T) -> f32 {
        let value = sample.to_f32();
        match self.light {
            Light::Linear => value / self.full,
            Light::Srgb => match self.lights.get(value as usize) {
                Some(light) => *light,
                None => light_of_srgb(f64::from(value / self.full)) as f32,
            },
        }
    }

    fn encode<T: Sample>(&self, light: f32) -> T {
        match self.light {
            Light::Linear => T::from_f32(light * self.full),
            Light::Srgb if self.edges.is_empty() => {
                T::from_f32((srgb_of_light(f64::from(light)) * f64::from(self.full)) as f32)
            }
            Light::Srgb => T::from_f32(self.edges.partition_point(|edge| *edge <= light) as f32),
        }
    }

    /// The light of a part of full light that is stated by the curve.
    fn bend(&self, part: f32) -> f32 {
        match self.light {
            Light::Linear => part,
            Light::Srgb => light_of_srgb(f64::from(part)) as f32,
        }
    }

    fn unbend(&self, light: f32) -> f32 {
        match self.light {
            Light::Linear => light,
            Light::Srgb => srgb_of_light(f64::from(light)) as f32,
        }
    }
}

impl Coding {
    /// Whether filters can weigh the samples as they stand.
    #[must_use]
    pub fn is_plain(self) -> bool {
        self.light == Light::Linear && self.alpha != Alpha::Straight
    }

    fn check<const C: usize>(self) -> Result<(), Error> {
        if self.alpha != Alpha::None && C % 2 == 1 {
            return Err(Error::OutOfRange {
                what: "channels of a picture with opacity",
                value: C as f64,
                expected: "2 or 4",
            });
        }
        Ok(())
    }

    /// A pixel's light, as far as it is opaque.
    fn decode<T: Sample, const C: usize>(self, curve: &Curve, pixel: &[T; C]) -> [f32; C] {
        let mut light = pixel.map(|sample| curve.decode(sample));
        let [colours @ .., last] = light.as_mut_slice() else { return light };
        if self.alpha == Alpha::None {
            return light;
        }
        // Opacity has no curve.
        *last = pixel.map(Sample::to_f32)[C - 1] / curve.full;
        for (colour, sample) in colours.iter_mut().zip(pixel) {
            if self.alpha == Alpha::Straight {
                *colour *= *last;
            } else if *last > CLEAR {
                *colour = curve.bend(sample.to_f32() / curve.full / *last) * *last;
            } else {
                *colour = 0.0;
            }
        }
        light
    }

    /// The reverse.
    fn encode<T: Sample, const C: usize>(self, curve: &Curve, light: &[f32; C]) -> [T; C] {
        if self.alpha == Alpha::None {
            return light.map(|light| curve.encode(light));
        }
        let alpha = light[C - 1];
        let mut pixel = light.map(|light| {
            let colour = if alpha > CLEAR { light / alpha } else { 0.0 };
            if self.alpha == Alpha::Straight {
                curve.encode(colour)
            } else {
                T::from_f32(curve.unbend(colour) * alpha.clamp(0.0, 1.0) * curve.full)
            }
        });
        pixel[C - 1] = T::from_f32(alpha.clamp(0.0, 1.0) * curve.full);
        pixel
    }
}

/// The light of a picture, as far as each pixel is opaque: the samples of one in `f32` without padding, 0 to 1.
///
/// # Errors
/// [`Error::OutOfRange`] for opacity in a picture of one or three channels.
pub fn light_of<T: Sample, const C: usize>(
    picture: ImageView<'_, T, C>,
    coding: Coding,
) -> Result<Vec<f32>, Error> {
    coding.check::<C>()?;
    let curve = Curve::new::<T>(coding.light);
    let height = picture.height();
    let mut lights = Vec::with_capacity(picture.width() * height * C);
    for row in (0..height).filter_map(|y| picture.row(y)) {
        let (pixels, _) = row.as_chunks::<C>();
        lights.extend(pixels.iter().flat_map(|pixel| coding.decode(&curve, pixel)));
    }
    Ok(lights)
}

/// The reverse of [`light_of`]: pixels whose light is no number are left alone.
///
/// # Errors
/// As [`light_of`], and [`Error::LengthMismatch`] where the lights are not those of such a picture.
pub fn samples_of<T: Sample, const C: usize>(
    lights: &[f32],
    coding: Coding,
    picture: &mut ImageViewMut<'_, T, C>,
) -> Result<(), Error> {
    coding.check::<C>()?;
    let (width, height) = (picture.width(), picture.height());
    if lights.len() != width * height * C {
        let (left, right) = (lights.len(), width * height * C);
        return Err(Error::LengthMismatch { what: "lights and picture", left, right });
    }
    let curve = Curve::new::<T>(coding.light);
    let (lights, _) = lights.as_chunks::<C>();
    for (y, lights) in lights.chunks(width.max(1)).enumerate() {
        let (pixels, _) = picture.row_mut(y).as_chunks_mut::<C>();
        for (pixel, light) in pixels.iter_mut().zip(lights) {
            if light.iter().all(|light| !light.is_nan()) {
                *pixel = coding.encode(&curve, light);
            }
        }
    }
    Ok(())
}

impl Border {
    /// The same border of the light of such pictures: see [`light_of`].
    #[must_use]
    pub fn by_light<T: Sample, const C: usize>(self, coding: Coding) -> Self {
        let Self::Constant(_) = self else { return self };
        let light = coding.decode(&Curve::new::<T>(coding.light), &self.constant::<T, C>());
        let mut values = [0.0; 4];
        for (value, light) in values.iter_mut().zip(light) {
            *value = light;
        }
        Self::Constant(values)
    }
}

/// [`warp`] by light and opacity, whatever the samples stand for.
///
/// Samples become light in `f32`, multiplied by their opacity; that is warped, divided by the opacity it has become and
/// turned into samples again. A border's constant is a pixel like others. It takes sixteen bytes a pixel of four
/// channels, of both pictures; where nothing is to be turned it is [`warp`]. [`light_of`] and [`samples_of`] are its
/// halves, to go with [`warp_area`](super::warp_area) or anything else between them.
///
/// *Accuracy.* Every sample of 8 or 16 bits comes back as itself where it is not filtered. A pixel whose opacity is below
/// 2⁻²³ becomes clear black. Pixels that become no number are left alone.
///
/// ```
/// use collinear::geometry::Affine2;
/// use collinear::resample::{Alpha, Border, Coding, Filter, ImageView, ImageViewMut, Light, warp_by_light};
///
/// // Halfway between an opaque red and a clear blue there is red that is half opaque, and no blue.
/// let source = ImageView::<u8, 4>::new(&[255, 0, 0, 255, 0, 0, 255, 0], 2, 1)?;
/// let half = Affine2::from_coefficients([0.5, 1.0, 0.0], [0.0, 0.0, 1.0]);
/// let coding = Coding { light: Light::Srgb, alpha: Alpha::Straight };
/// let mut pixel = [0; 4];
/// let mut target = ImageViewMut::new(&mut pixel, 1, 1)?;
/// warp_by_light(source, &half, Filter::Bilinear, Border::Clamp, coding, &mut target)?;
/// assert_eq!(pixel, [255, 0, 0, 128]);
///
/// // The mean of black's and white's light is sRGB's 188.
/// let source = ImageView::<u8, 1>::new(&[0, 255], 2, 1)?;
/// let coding = Coding { light: Light::Srgb, alpha: Alpha::None };
/// let mut grey = [0];
/// let mut target = ImageViewMut::new(&mut grey, 1, 1)?;
/// warp_by_light(source, &half, Filter::Bilinear, Border::Clamp, coding, &mut target)?;
/// assert_eq!(grey, [188]);
/// # Ok::<(), collinear::Error>(())
/// ```
///
/// # Errors
/// [`Error::OutOfRange`] for opacity in a picture of one or three channels.
pub fn warp_by_light<T: Sample, const C: usize>(
    source: ImageView<'_, T, C>,
    map: &dyn Map,
    filter: Filter,
    border: Border,
    coding: Coding,
    target: &mut ImageViewMut<'_, T, C>,
) -> Result<(), Error> {
    coding.check::<C>()?;
    if coding.is_plain() {
        warp(source, map, filter, border, target);
        return Ok(());
    }
    let lights = light_of(source, coding)?;
    let lights = ImageView::<f32, C>::new(&lights, source.width(), source.height())?;
    let (width, height) = (target.width(), target.height());
    // What stays so was not painted.
    let mut made = alloc::vec![f32::NAN; width * height * C];
    let mut view = ImageViewMut::<f32, C>::new(&mut made, width, height)?;
    warp(lights, map, filter, border.by_light::<T, C>(coding), &mut view);
    samples_of(&made, coding, target)
}
