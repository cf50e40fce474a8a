//! The central models of camera files: a table.

use std::sync::Arc;

use collinear::camera::{
    Brown, CentralCamera, CentralModel, CentralProjection, Distortion, Division, DoubleSphere,
    EnhancedUnified, EvenRadial, FieldOfView, Fisheye, Fraser, Gnomonic, InteriorOrientation,
    Metashape, NoDistortion, RadialTangentialThinPrism, Rational, ThinPrism, UnifiedSphere,
};
use serde::{Deserialize, Serialize};

use super::raw::RawInterior;
use crate::check::{finite, in_range};
use crate::error::FieldError;

/// How a fisheye without errors images the angle θ from its axis; the radius is in units of the principal distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FisheyeProjection {
    /// r = θ.
    #[default]
    Equidistant,
    /// r = 2 tan(θ/2).
    Stereographic,
    /// r = 2 sin(θ/2).
    Equisolid,
    /// r = sin θ.
    Orthographic,
}

/// Makes [`Lens`] and what reads, writes, checks and builds it of one entry for each model: its name, its fields, and the
/// library's camera of an interior orientation.
macro_rules! lenses {
    ($($(#[$about:meta])* $variant:ident = $name:literal {
        $($(#[$meaning:meta])* $field:ident: $kind:ty,)*
    } => |$interior:ident| $camera:expr;)*) => {
        /// The lens of a camera with one projection centre: projection and distortion.
        ///
        /// Equations, units and defaults: `docs/formats.md`, "camera".
        #[derive(Clone, Debug, PartialEq)]
        pub enum Lens {
            $($(#[$about])* $variant { $($(#[$meaning])* $field: $kind,)* },)*
        }

        /// The models by the names of the files.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        pub(super) enum Model {
            #[serde(rename = "pinhole")]
            Pinhole,
            #[serde(rename = "brown")]
            Brown,
            $(#[serde(rename = $name)] $variant,)*
            #[serde(rename = "equirectangular")]
            Equirectangular,
            #[serde(rename = "cylindrical")]
            Cylindrical,
            #[serde(rename = "film")]
            Film,
            #[serde(rename = "colmap")]
            Colmap,
            #[serde(rename = "orthographic")]
            Orthographic,
        }

        impl Model {
            /// The name.
            pub(super) fn name(self) -> &'static str {
                match self {
                    Self::Pinhole => "pinhole",
                    Self::Brown => "brown",
                    $(Self::$variant => $name,)*
                    Self::Equirectangular => "equirectangular",
                    Self::Cylindrical => "cylindrical",
                    Self::Film => "film",
                    Self::Colmap => "colmap",
                    Self::Orthographic => "orthographic",
                }
            }
        }

        impl Lens {
            /// The model's name in a file.
            #[must_use]
            pub fn model(&self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $name,)*
                }
            }

            pub(super) fn check(&self) -> Result<(), FieldError> {
                match self {
                    $(Self::$variant { $($field),* } => {
                        $(Entry::check($field, stringify!($field))?;)*
                    })*
                }
                Ok(())
            }

            /// The lens of a model, its fields taken out of the file's; none where the model is no lens.
            pub(super) fn take(model: Model, raw: &mut RawInterior) -> Option<Result<Self, String>> {
                Some(match model {
                    $(Model::$variant => {
                        $(let $field = Entry::read(raw.$field.take(), $name, stringify!($field));)*
                        let lens = || Ok(Self::$variant { $($field: $field?,)* });
                        lens()
                    })*
                    _ => return None,
                })
            }

            /// The file's fields.
            pub(super) fn give(self) -> RawInterior {
                match self {
                    $(Self::$variant { $($field),* } => RawInterior {
                        $($field: Entry::write($field),)*
                        ..RawInterior::empty(Model::$variant)
                    },)*
                }
            }

            /// The library's camera, or the field that it refuses and why.
            pub(crate) fn central(
                &self,
                interior: InteriorOrientation,
            ) -> Result<Arc<dyn CentralModel>, (&'static str, collinear::Error)> {
                match self.clone() {
                    $(Self::$variant { $($field),* } => {
                        let $interior = interior;
                        let camera = || -> Result<Arc<dyn CentralModel>, collinear::Error> { $camera };
                        camera().map_err(|e| (to_blame(&e, &[$(stringify!($field)),*]), e))
                    })*
                }
            }
        }
    };
}

lenses! {
    /// A perspective through a lens with rational radial, decentring and thin-prism distortion before a tilted sensor:
    /// OpenCV's model of 4, 5, 8, 12 or 14 coefficients.
    Rational = "rational" {
        /// k1 to k6: three of the numerator, three of the denominator.
        k: [f64; 6],
        /// p1, p2.
        p: [f64; 2],
        /// s1 to s4.
        s: [f64; 4],
        /// τx, τy in radians.
        tau: [f64; 2],
    } => |interior| through(interior, Gnomonic, Rational::new(k, p, s, tau)?);

    /// A perspective through a lens as Agisoft Metashape has it.
    Metashape = "metashape" {
        /// K1 to K4.
        k: [f64; 4],
        /// P1 to P4, in Metashape's order.
        p: [f64; 4],
    } => |interior| through(interior, Gnomonic, Metashape::new(k, p)?);

    /// A perspective whose measured coordinates are corrected as calibration reports say (Fraser 1997).
    Fraser = "fraser" {
        /// K1, K2, K3.
        k: [f64; 3],
        /// P1, P2.
        p: [f64; 2],
        /// b1, b2: affinity and shear.
        b: [f64; 2],
        /// The principal distance in millimetres where k and p are those of millimetres; else they are those of units of the
        /// principal distance.
        principal_distance_mm: Option<f64>,
    } => |interior| through(interior, Gnomonic, match principal_distance_mm {
        Some(c) => Fraser::from_millimetres(c, k, p, b)?,
        None => Fraser::new(k, p, b)?,
    });

    /// A fisheye with radial distortion of its image: OpenCV's `fisheye` where the projection is equidistant.
    Fisheye = "fisheye" {
        /// The fisheye without errors.
        projection: FisheyeProjection,
        /// k1 to k4, of the powers r², r⁴, r⁶, r⁸ of the projection's radius.
        k: [f64; 4],
    } => |interior| through(interior, match projection {
        FisheyeProjection::Equidistant => Fisheye::Equidistant,
        FisheyeProjection::Stereographic => Fisheye::Stereographic,
        FisheyeProjection::Equisolid => Fisheye::Equisolid,
        FisheyeProjection::Orthographic => Fisheye::Orthographic,
    }, EvenRadial::new(k)?);

    /// An equidistant fisheye with radial, decentring and thin-prism distortion: COLMAP's `THIN_PRISM_FISHEYE`.
    ThinPrismFisheye = "thin_prism_fisheye" {
        /// k1 to k4.
        k: [f64; 4],
        /// p1, p2.
        p: [f64; 2],
        /// s1, s2: COLMAP's sx1, sy1.
        s: [f64; 2],
    } => |interior| through(interior, Fisheye::Equidistant, ThinPrism::new(k, p, s)?);

    /// Project Aria's *Fisheye624*, COLMAP's `RAD_TAN_THIN_PRISM_FISHEYE`.
    Fisheye624 = "fisheye624" {
        /// k0 to k5.
        k: [f64; 6],
        /// p0, p1.
        p: [f64; 2],
        /// s0 to s3.
        s: [f64; 4],
    } => |interior| {
        through(interior, Fisheye::Equidistant, RadialTangentialThinPrism::new(k, p, s)?)
    };

    /// Devernay and Faugeras's fisheye of one parameter, COLMAP's `FOV`.
    FieldOfView = "field_of_view" {
        /// ω in radians, between 0 and π.
        omega: f64,
    } => |interior| through(interior, FieldOfView::new(omega)?, NoDistortion);

    /// Fitzgibbon's division lens, COLMAP's `DIVISION`.
    Division = "division" {
        /// λ for radii in units of the principal distance.
        lambda: f64,
    } => |interior| through(interior, Division::new(lambda)?, NoDistortion);

    /// The unified projection and Brown's distortion: Mei and Rives's model, OpenCV's `omnidir`.
    Unified = "unified" {
        /// ξ, from 0 to 10⁶.
        xi: f64,
        /// k1, k2, k3.
        k: [f64; 3],
        /// p1, p2.
        p: [f64; 2],
    } => |interior| through(interior, UnifiedSphere::new(xi)?, Brown::new(k, p)?);

    /// The enhanced unified projection, COLMAP's `EUCM`.
    EnhancedUnified = "enhanced_unified" {
        /// α, from 0 to 1.
        alpha: f64,
        /// β, from 10⁻⁶ to 10⁶.
        beta: f64,
    } => |interior| through(interior, EnhancedUnified::new(alpha, beta)?, NoDistortion);

    /// The double sphere projection.
    DoubleSphere = "double_sphere" {
        /// ξ, between −1 and 1.
        xi: f64,
        /// α, from 0 to 1.
        alpha: f64,
    } => |interior| through(interior, DoubleSphere::new(xi, alpha)?, NoDistortion);
}

fn through(
    interior: InteriorOrientation,
    projection: impl CentralProjection + 'static,
    distortion: impl Distortion + 'static,
) -> Result<Arc<dyn CentralModel>, collinear::Error> {
    Ok(Arc::new(CentralCamera::from_parts(interior, projection, distortion)))
}

/// The field of a model that an error is about. The library begins with the parameter's name where there is one; a fold radius
/// is that of all coefficients, and the first of them is named.
fn to_blame(error: &collinear::Error, fields: &[&'static str]) -> &'static str {
    let (collinear::Error::OutOfRange { what, .. } | collinear::Error::NotFinite { what }) = error
    else {
        return fields.first().copied().unwrap_or_default();
    };
    let first = match what.split(' ').next() {
        Some("tilt") => "tau",
        Some("affinity") => "b",
        other => other.unwrap_or_default(),
    };
    let (coefficients, named) = (|f: &&&str| **f == "k", |f: &&&str| **f == first);
    let found = fields.iter().find(named).or_else(|| fields.iter().find(coefficients));
    found.or(fields.first()).copied().unwrap_or_default()
}

/// A field of a model.
trait Entry: Sized {
    /// As the file has it.
    type Raw;
    /// From what the file says, or the model's need of it.
    fn read(raw: Option<Self::Raw>, model: &str, field: &str) -> Result<Self, String>;
    fn write(self) -> Option<Self::Raw>;
    fn check(&self, field: &str) -> Result<(), FieldError>;
}

/// Coefficients, zero where the file has none.
impl<const N: usize> Entry for [f64; N] {
    type Raw = Vec<f64>;

    fn read(raw: Option<Vec<f64>>, model: &str, field: &str) -> Result<Self, String> {
        let Some(values) = raw else { return Ok([0.0; N]) };
        let found = values.len();
        values.try_into().map_err(|_| {
            format!("the model `{model}` has a `{field}` of {N} numbers, found {found}")
        })
    }

    fn write(self) -> Option<Vec<f64>> {
        Some(self.into())
    }

    fn check(&self, field: &str) -> Result<(), FieldError> {
        finite(field, self)
    }
}

/// A parameter that the model cannot do without.
impl Entry for f64 {
    type Raw = Self;

    fn read(raw: Option<Self>, model: &str, field: &str) -> Result<Self, String> {
        raw.ok_or_else(|| format!("the model `{model}` needs `{field}`"))
    }

    fn write(self) -> Option<Self> {
        Some(self)
    }

    fn check(&self, field: &str) -> Result<(), FieldError> {
        finite(field, &[*self]).map_err(|e| FieldError::new(field, e.problem))
    }
}

/// A length that may be left out.
impl Entry for Option<f64> {
    type Raw = f64;

    fn read(raw: Self, _: &str, _: &str) -> Result<Self, String> {
        Ok(raw)
    }

    fn write(self) -> Self {
        self
    }

    fn check(&self, field: &str) -> Result<(), FieldError> {
        let expected = "a number from 1e-6 to 1e9";
        self.map_or(Ok(()), |v| in_range(field, v, expected, |v| (1e-6..=1e9).contains(&v)))
    }
}

impl Entry for FisheyeProjection {
    type Raw = Self;

    fn read(raw: Option<Self>, _: &str, _: &str) -> Result<Self, String> {
        Ok(raw.unwrap_or_default())
    }

    fn write(self) -> Option<Self> {
        Some(self)
    }

    fn check(&self, _: &str) -> Result<(), FieldError> {
        Ok(())
    }
}

/// Brown's coefficients, which older variants of [`super::Interior`] hold.
pub(super) fn coefficients<const N: usize>(
    raw: Option<Vec<f64>>,
    model: &str,
    field: &str,
) -> Result<[f64; N], String> {
    Entry::read(raw, model, field)
}
