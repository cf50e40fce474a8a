//! Maps as source text for shaders: GLSL and WGSL functions with a map's constants.
//!
//! A renderer that draws on a graphics processor evaluates the same map in each fragment. [`source`] writes
//!
//! ```text
//! vec2 NAME(vec2 pixel)         where in the texture the pixel looks, in texels
//! bool NAME_shows(vec2 pixel)   whether it shows anything: before the horizon and the eye, within the lens's fold
//! ```
//!
//! *Frames.* As everywhere: screen and texture points from the top-left corner, pixel centres at halves. WebGPU's
//! `position` and Vulkan's `gl_FragCoord` are so; OpenGL's `gl_FragCoord.y` counts upwards and wants `height - y`. Divide by the
//! texture's size for a sampler.
//!
//! *Precision.* Shaders reckon in `f32`. Coordinates are therefore taken relative to a centre, and the constants are made
//! in `f64`: near the centre the error is one unit in the last place of the texture coordinate (half of it in the constant,
//! half in the sum; 1/256 texel at 40,000), and it grows by about 2⁻²² of the way in the texture from there.

use alloc::format;
use alloc::string::String;

use nalgebra::Point2;

use super::polynomial::{Bilinear, Cubic, EXPONENTS, Quadratic, Terms};
use super::{DistortMap, FractionalLinear, Map};
use crate::camera::Distortion;
use crate::error::Error;
use crate::geometry::Affine2;

/// The language of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Language {
    /// OpenGL, WebGL, Vulkan: any version with `vec2`.
    Glsl,
    /// WebGPU.
    Wgsl,
}

/// A map that a few lines of a shader evaluate.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum ShaderMap<'a> {
    /// An affine map.
    Affine(&'a Affine2),
    /// A fractional-linear map.
    FractionalLinear(&'a FractionalLinear),
    /// A bilinear polynomial.
    Bilinear(&'a Bilinear),
    /// A quadratic polynomial.
    Quadratic(&'a Quadratic),
    /// A cubic polynomial.
    Cubic(&'a Cubic),
    /// Brown's distortion, ideal pixel to distorted pixel.
    Distort(&'a DistortMap),
}

macro_rules! from {
    ($($variant:ident: $map:ty),*) => {$(
        impl<'a> From<&'a $map> for ShaderMap<'a> {
            fn from(map: &'a $map) -> Self {
                Self::$variant(map)
            }
        }
    )*};
}
from!(
    Affine: Affine2, FractionalLinear: FractionalLinear, Bilinear: Bilinear, Quadratic: Quadratic, Cubic: Cubic,
    Distort: DistortMap
);

/// The functions `name` and `name_shows` of a map.
///
/// `centre` is the screen point about which affine and fractional-linear maps are expanded: the middle of what is drawn.
/// Polynomials keep the centre of their control points, lenses their principal point.
///
/// # Errors
/// [`Error::Unknown`] for a name that is no identifier in both languages (ASCII letters, digits and single underscores, a
/// letter first, not `gl_`; reserved words are not looked for); [`Error::Projection`] where the map shows nothing at the
/// centre; [`Error::OutOfRange`] for a constant beyond `f32`.
///
/// # Example
/// u = (3S) / (1 + L) about (0, 1), where w = 2:
///
/// ```
/// use collinear::mapping::FractionalLinear;
/// use collinear::mapping::shader::{Language, source};
/// use nalgebra::Point2;
///
/// let map = FractionalLinear::from_coefficients(
///     [0.0, 3.0, 0.0], [4.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0])?;
/// let text = source(&map, Language::Wgsl, "lookup", &Point2::new(0.0, 1.0))?;
/// assert_eq!(text, "\
/// fn lookup(pixel: vec2<f32>) -> vec2<f32> {
///     let p = pixel - vec2<f32>(0.0, 1.0);
///     let w = 1.0 + (0.0 * p.x + 0.5 * p.y);
///     let d = vec2<f32>(1.5 * p.x + 0.0 * p.y, 0.0 * p.x + -1.0 * p.y);
///     return vec2<f32>(0.0, 2.0) + d / w;
/// }
/// fn lookup_shows(pixel: vec2<f32>) -> bool {
///     let p = pixel - vec2<f32>(0.0, 1.0);
///     let w = 1.0 + (0.0 * p.x + 0.5 * p.y);
///     let e = 1.0 + (0.0 * p.x + 0.0 * p.y);
///     return w > 0.0 && e > 0.0;
/// }
/// ");
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("GLSL", "WGSL", "texture matrix"))]
pub fn source<'a>(
    map: impl Into<ShaderMap<'a>>,
    language: Language,
    name: &str,
    centre: &Point2<f64>,
) -> Result<String, Error> {
    if !is_identifier(name) {
        return Err(Error::Unknown { what: "kind of identifier as the name of a shader function" });
    }
    let writer = Writer { language };
    let (value, shows) = match map.into() {
        ShaderMap::Affine(map) => affine(writer, map, centre)?,
        ShaderMap::FractionalLinear(map) => fractional_linear(writer, map, centre)?,
        ShaderMap::Bilinear(map) => polynomial(writer, &map.terms())?,
        ShaderMap::Quadratic(map) => polynomial(writer, &map.terms())?,
        ShaderMap::Cubic(map) => polynomial(writer, &map.terms())?,
        ShaderMap::Distort(map) => distort(writer, map)?,
    };
    let vector = writer.vector_type();
    Ok(match language {
        Language::Glsl => format!(
            "vec2 {name}(vec2 pixel) {{\n{value}}}\nbool {name}_shows(vec2 pixel) {{\n{shows}}}\n"
        ),
        Language::Wgsl => format!(
            "fn {name}(pixel: {vector}) -> {vector} {{\n{value}}}\n\
             fn {name}_shows(pixel: {vector}) -> bool {{\n{shows}}}\n"
        ),
    })
}

fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !name.starts_with("gl_")
        && !name.contains("__")
        && !name.ends_with('_')
}

/// The words in which the languages differ.
#[derive(Clone, Copy)]
struct Writer {
    language: Language,
}

impl Writer {
    fn vector_type(self) -> &'static str {
        match self.language {
            Language::Glsl => "vec2",
            Language::Wgsl => "vec2<f32>",
        }
    }

    fn vector(self, x: &str, y: &str) -> String {
        format!("{}({x}, {y})", self.vector_type())
    }

    fn constant(self, c: [f64; 2]) -> Result<String, Error> {
        Ok(self.vector(&literal(c[0])?, &literal(c[1])?))
    }

    fn declare(self, glsl: &str, name: &str, value: &str) -> String {
        match self.language {
            Language::Glsl => format!("    {glsl} {name} = {value};\n"),
            Language::Wgsl => format!("    let {name} = {value};\n"),
        }
    }

    fn declare_vector(self, name: &str, value: &str) -> String {
        self.declare("vec2", name, value)
    }

    fn declare_number(self, name: &str, value: &str) -> String {
        self.declare("float", name, value)
    }
}

/// A number as both languages read it back to the same `f32`.
fn literal(value: f64) -> Result<String, Error> {
    let single = value as f32;
    if !single.is_finite() {
        let expected = "a number that f32 holds";
        return Err(Error::OutOfRange { what: "constant of a shader", value, expected });
    }
    Ok(format!("{single:?}"))
}

/// a p.x + b p.y.
fn form(a: f64, b: f64) -> Result<String, Error> {
    Ok(format!("{} * p.x + {} * p.y", literal(a)?, literal(b)?))
}

/// The bodies of the two functions.
type Bodies = (String, String);

const ALWAYS: &str = "    return true;\n";

fn affine(w: Writer, map: &Affine2, centre: &Point2<f64>) -> Result<Bodies, Error> {
    let at = map.at(centre)?;
    let m = &map.linear;
    let mut body = w.declare_vector("p", &format!("pixel - {}", w.constant([centre.x, centre.y])?));
    let d = w.vector(&form(m.m11, m.m12)?, &form(m.m21, m.m22)?);
    body += &format!("    return {} + {d};\n", w.constant([at.x, at.y])?);
    Ok((body, String::from(ALWAYS)))
}

/// u = u(centre) + d(p) / w(p), so that nothing large cancels.
fn fractional_linear(
    w: Writer,
    map: &FractionalLinear,
    centre: &Point2<f64>,
) -> Result<Bodies, Error> {
    let at = map.at(centre)?;
    let [p, q, r] = map.coefficients();
    let e = map.eye_coefficients();
    let there = |c: [f64; 3]| c[0] + c[1] * centre.x + c[2] * centre.y;
    let (rc, ec) = (there(r), there(e));
    let slope = |c: [f64; 3], u: f64| [1, 2].map(|k: usize| (c[k] - u * r[k]) / rc);
    let ([ux, uy], [vx, vy]) = (slope(p, at.x), slope(q, at.y));
    let mut common =
        w.declare_vector("p", &format!("pixel - {}", w.constant([centre.x, centre.y])?));
    common += &w.declare_number("w", &format!("1.0 + ({})", form(r[1] / rc, r[2] / rc)?));
    let mut value = common.clone();
    value += &w.declare_vector("d", &w.vector(&form(ux, uy)?, &form(vx, vy)?));
    value += &format!("    return {} + d / w;\n", w.constant([at.x, at.y])?);
    common += &w.declare_number("e", &format!("1.0 + ({})", form(e[1] / ec, e[2] / ec)?));
    common += "    return w > 0.0 && e > 0.0;\n";
    Ok((value, common))
}

fn polynomial(w: Writer, terms: &Terms<'_>) -> Result<Bodies, Error> {
    let Terms { centre, half, offset, a, b } = *terms;
    let inverse = half.map(|h| 1.0 / h);
    let mut body = w.declare_vector(
        "p",
        &format!("(pixel - {}) * {}", w.constant(centre)?, w.constant(inverse)?),
    );
    for (name, coefficients) in [("du", a), ("dv", b)] {
        let mut sum = String::new();
        for (c, (i, j)) in coefficients.iter().zip(EXPONENTS).skip(1).rev() {
            let joint = if sum.is_empty() { "" } else { " + " };
            sum += &format!("{joint}{}{}{}", literal(*c)?, " * p.x".repeat(i), " * p.y".repeat(j));
        }
        body += &w.declare_number(name, &sum);
    }
    let constant = w.constant([offset[0] + a[0], offset[1] + b[0]])?;
    body += &format!("    return {constant} + {};\n", w.vector("du", "dv"));
    Ok((body, String::from(ALWAYS)))
}

/// pixel + A (distorted − n), n = A⁻¹ (pixel − principal point): the displacement alone is rounded.
fn distort(w: Writer, map: &DistortMap) -> Result<Bodies, Error> {
    let camera = map.camera();
    let (interior, lens) = (camera.interior(), camera.distortion());
    let point = interior.principal_point();
    let (forward, inverse) = (interior.matrix(), interior.inverse_matrix());
    let ([k1, k2, k3], [p1, p2]) = (lens.radial(), lens.decentering());
    let mut common = w.declare_vector("p", &format!("pixel - {}", w.constant([point.x, point.y])?));
    let normalised = w
        .vector(&form(inverse[(0, 0)], inverse[(0, 1)])?, &form(inverse[(1, 0)], inverse[(1, 1)])?);
    common += &w.declare_vector("n", &normalised);
    common += &w.declare_number("s", "n.x * n.x + n.y * n.y");
    let fold = lens.fold_radius();
    let mut value = common.clone();
    value += &w.declare_number(
        "k",
        &format!("s * ({} + s * ({} + s * {}))", literal(k1)?, literal(k2)?, literal(k3)?),
    );
    value += &w.declare_number("t", "2.0 * n.x * n.y");
    let [p1, p2] = [literal(p1)?, literal(p2)?];
    let d = w.vector(
        &format!("k * n.x + {p1} * t + {p2} * (s + 2.0 * n.x * n.x)"),
        &format!("k * n.y + {p1} * (s + 2.0 * n.y * n.y) + {p2} * t"),
    );
    value += &w.declare_vector("d", &d);
    let row = |i: usize| -> Result<String, Error> {
        Ok(format!("{} * d.x + {} * d.y", literal(forward[(i, 0)])?, literal(forward[(i, 1)])?))
    };
    value += &format!("    return pixel + {};\n", w.vector(&row(0)?, &row(1)?));
    // The largest fold that `f32` holds squared stands for none.
    let limit = (fold * fold).min(f64::from(f32::MAX));
    common += &format!("    return s < {};\n", literal(limit)?);
    Ok((value, common))
}
