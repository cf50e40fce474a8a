//! Lens distortion: a map of the image plane, forward and back.
//!
//! A distortion acts between the [central projection](super::central_projection) and the interior orientation, on points
//! in units of the principal distance. Each type is one formula; its inverse is a damped Newton iteration on the disc
//! where the formula is one to one. The edge of that disc, the fold radius, is found when the lens is made, and
//! what lies beyond it is refused: there a polynomial runs back and would put points from outside the field into the
//! middle of the picture.

mod brown;
mod even_radial;
mod fraser;
mod image_motion;
mod many;
mod metashape;
mod one_to_one;
mod planar;
mod rational;
mod thin_prism;

use core::fmt::Debug;

use nalgebra::{Matrix2, Point2, Vector2};

pub use brown::Brown;
pub use even_radial::EvenRadial;
pub use fraser::Fraser;
pub use image_motion::ImageMotionCompensation;
pub use many::UndistortedMany;
pub use metashape::Metashape;
pub use rational::Rational;
pub use thin_prism::{RadialTangentialThinPrism, ThinPrism};

use super::collinearity::finite;
use super::{Parametrised, parameters};
use crate::error::ProjectionError;
use crate::numeric::polynomial;

/// A map of the image plane by a lens.
///
/// Points are in units of the principal distance, x right and y down. [`undistort`](Self::undistort) after
/// [`distort`](Self::distort) is the identity within the domain, a disc about the axis.
pub trait Distortion: Parametrised {
    /// Distorted point of an ideal point.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] at and beyond the fold radius, [`ProjectionError::NotFinite`].
    fn distort(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError>;

    /// Distorted point with ∂(x″, y″)/∂(x, y).
    ///
    /// # Errors
    /// As [`distort`](Self::distort).
    fn distort_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError>;

    /// The bare formula with ∂(x″, y″)/∂(x, y), beyond the fold too where it has a value there. By default as
    /// [`distort_jacobian`](Self::distort_jacobian).
    ///
    /// # Errors
    /// As [`distort`](Self::distort), for what the formula has no value.
    fn distort_formula_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError> {
        self.distort_jacobian(ideal)
    }

    /// Ideal point of a distorted point, with the report of its iteration.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] where no ideal point of the domain has this image,
    /// [`ProjectionError::NotConverged`] where the residual did not reach its floor, [`ProjectionError::NotFinite`].
    #[doc(alias = "undistortPoints")]
    fn undistort(&self, distorted: &Point2<f64>) -> Result<Undistorted, ProjectionError>;

    /// Undistorts many points in place, in less time than one by one. A point that has no ideal point becomes NaN.
    fn undistort_many(&self, points: &mut [Point2<f64>]) -> UndistortedMany {
        let mut report = UndistortedMany::NONE;
        for point in points {
            report.one(point, self.undistort(point));
        }
        report
    }

    /// ∂(x″, y″)/∂ of each parameter at an ideal point of the domain.
    fn parameter_partials(&self, ideal: &Point2<f64>, out: &mut [Vector2<f64>]);

    /// The radius of ideal points up to which the distortion is one to one; infinite where it is everywhere.
    fn fold_radius(&self) -> f64;
}

/// A point found by iteration, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undistorted {
    /// The ideal point.
    pub point: Point2<f64>,
    /// Newton steps taken.
    pub iterations: u32,
    /// ‖distort(point) − given point‖, in units of the principal distance.
    pub residual: f64,
}

/// No distortion: the ideal camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoDistortion;

parameters::no_parameters!(NoDistortion, "no distortion");

impl Distortion for NoDistortion {
    fn distort(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        finite(*ideal)
    }

    fn distort_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError> {
        Ok((finite(*ideal)?, Matrix2::identity()))
    }

    fn undistort(&self, distorted: &Point2<f64>) -> Result<Undistorted, ProjectionError> {
        Ok(Undistorted { point: finite(*distorted)?, iterations: 0, residual: 0.0 })
    }

    fn parameter_partials(&self, _: &Point2<f64>, _: &mut [Vector2<f64>]) {}

    fn fold_radius(&self) -> f64 {
        f64::INFINITY
    }
}

/// [`Distortion`] of a type that wraps the formula of [`planar`].
macro_rules! planar_distortion {
    ($name:ident) => {
        impl $crate::camera::Distortion for $name {
            #[inline]
            fn distort(
                &self,
                ideal: &nalgebra::Point2<f64>,
            ) -> Result<nalgebra::Point2<f64>, $crate::error::ProjectionError> {
                super::one_to_one::OneToOne::checked(&self.0, ideal)
            }

            #[inline]
            fn distort_jacobian(
                &self,
                ideal: &nalgebra::Point2<f64>,
            ) -> Result<
                (nalgebra::Point2<f64>, nalgebra::Matrix2<f64>),
                $crate::error::ProjectionError,
            > {
                let distorted = super::one_to_one::OneToOne::checked(&self.0, ideal)?;
                Ok((distorted, super::one_to_one::OneToOne::jacobian(&self.0, ideal)))
            }

            #[inline]
            fn distort_formula_jacobian(
                &self,
                ideal: &nalgebra::Point2<f64>,
            ) -> Result<
                (nalgebra::Point2<f64>, nalgebra::Matrix2<f64>),
                $crate::error::ProjectionError,
            > {
                let distorted = super::one_to_one::OneToOne::value(&self.0, ideal);
                Ok((
                    super::finite(distorted)?,
                    super::one_to_one::OneToOne::jacobian(&self.0, ideal),
                ))
            }

            fn undistort(
                &self,
                distorted: &nalgebra::Point2<f64>,
            ) -> Result<super::Undistorted, $crate::error::ProjectionError> {
                super::one_to_one::invert(&self.0, distorted)
            }

            fn undistort_many(
                &self,
                points: &mut [nalgebra::Point2<f64>],
            ) -> super::UndistortedMany {
                super::many::undistort_many(&self.0, points)
            }

            #[inline]
            fn parameter_partials(
                &self,
                ideal: &nalgebra::Point2<f64>,
                out: &mut [nalgebra::Vector2<f64>],
            ) {
                super::one_to_one::OneToOne::columns(&self.0, ideal, out);
            }

            fn fold_radius(&self) -> f64 {
                super::one_to_one::OneToOne::fold_radius(&self.0)
            }
        }
    };
}
use planar_distortion;

/// The ends of the intervals in which a fold is looked for, one after the other: one polynomial search over all of them
/// would place a fold near 1 no better than 10⁻⁸.
const SEARCHED_TO: [f64; 5] = [0.0, 1e4, 1e8, 1e12, 1e16];

/// The first positive root of a polynomial in the radius that is positive at the axis; infinite where there is none.
fn first_root(coefficients: &[f64]) -> f64 {
    let mut roots = [0.0; polynomial::MAX_COEFFICIENTS];
    let degree = coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    let coefficients = &coefficients[..=degree];
    for range in SEARCHED_TO.windows(2) {
        if polynomial::roots_in(coefficients, range[0], range[1], &mut roots) > 0 {
            return roots[0];
        }
    }
    // Past the last interval the highest power alone decides; what it bends back is cut off there.
    let [.., last] = SEARCHED_TO;
    if coefficients[degree] < 0.0 { last } else { f64::INFINITY }
}
