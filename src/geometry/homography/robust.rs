//! Homographies from points some of which are wrong.

use alloc::vec::Vec;

use nalgebra::Point2;

use super::Homography;
use super::fit::{FitOptions, HomographyFit};
use crate::error::Error;
use crate::numeric::consensus::{ConsensusOptions, Estimator, chosen, search};

/// A homography that most points agree on.
#[derive(Clone, Debug)]
pub struct RobustHomography {
    /// The least-squares fit to the inliers; its residuals are theirs, in order.
    pub fit: HomographyFit,
    /// For each point, whether it lies within the threshold of the map that the search found.
    pub inliers: Vec<bool>,
    /// How many do.
    pub inlier_count: usize,
    /// Samples tried.
    pub trials: u32,
}

impl Homography {
    /// The homography that the largest part of the points agrees on, by random samples of four
    /// ([`consensus`](crate::numeric::consensus)), fitted to its inliers.
    ///
    /// A sample is passed over without a trial where three of its points lie on a line or where no map keeps all four in
    /// front of its horizon. The residual that [`ConsensusOptions::threshold`] bounds is the distance in the image, in
    /// pixels; a point beyond the horizon is no inlier.
    ///
    /// The same input and seed give the same result. Whether to believe it is told by
    /// [`RobustHomography::inlier_count`]: among n points without any relation, four plus
    /// [`min_support`](ConsensusOptions::min_support) seldom agree by chance, and a result with hardly more is not better
    /// than that.
    ///
    /// # Errors
    /// [`Error::NoConsensus`], and as [`fit`](Self::fit).
    ///
    /// # Example
    /// ```
    /// use collinear::geometry::Homography;
    /// use collinear::numeric::consensus::ConsensusOptions;
    /// use nalgebra::Point2;
    ///
    /// // A grid seen as x/(1 + y/10), y/(1 + y/10); every third point is wrong.
    /// let grid: Vec<_> = (0..36).map(|i| Point2::new(f64::from(i % 6), f64::from(i / 6))).collect();
    /// let image: Vec<_> = grid.iter().enumerate().map(|(i, p)| {
    ///     let right = Point2::from(p.coords / (1.0 + p.y / 10.0));
    ///     if i % 3 == 0 { Point2::new(7.0 + right.y, f64::from(i as u32)) } else { right }
    /// }).collect();
    /// let options = ConsensusOptions { threshold: 1e-6, ..Default::default() };
    /// let found = Homography::fit_robust(&grid, &image, &options)?;
    /// assert_eq!(found.inlier_count, 24);
    /// assert!((found.fit.homography.normalised().m32 - 0.1).abs() < 1e-12);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[doc(alias("RANSAC", "MSAC"))]
    pub fn fit_robust(
        object: &[Point2<f64>],
        image: &[Point2<f64>],
        options: &ConsensusOptions,
    ) -> Result<RobustHomography, Error> {
        if object.len() != image.len() {
            return Err(Error::LengthMismatch {
                what: "object and image points",
                left: object.len(),
                right: image.len(),
            });
        }
        if !object.iter().chain(image).all(|p| p.x.is_finite() && p.y.is_finite()) {
            return Err(Error::NotFinite { what: "homography control point" });
        }
        let points = Pairs { object, image };
        let found = search(&points, options)?;
        let (from, to) = points.select(&found.inliers);
        let fit = Self::fit(&from, &to, &FitOptions::default())?;
        Ok(RobustHomography {
            fit,
            inliers: found.inliers,
            inlier_count: found.inlier_count,
            trials: found.trials,
        })
    }
}

struct Pairs<'a> {
    object: &'a [Point2<f64>],
    image: &'a [Point2<f64>],
}

impl Pairs<'_> {
    fn select(&self, inliers: &[bool]) -> (Vec<Point2<f64>>, Vec<Point2<f64>>) {
        (chosen(self.object, inliers), chosen(self.image, inliers))
    }
}

impl Estimator for Pairs<'_> {
    type Model = Homography;
    const SAMPLE: usize = 4;

    fn len(&self) -> usize {
        self.object.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<Homography>) {
        if let &[a, b, c, d] = sample {
            let four = |points: &[Point2<f64>]| [points[a], points[b], points[c], points[d]];
            models.extend(Homography::from_four_points(&four(self.object), &four(self.image)).ok());
        }
    }

    fn squared_residual(&self, model: &Homography, index: usize) -> f64 {
        match model.apply(&self.object[index]) {
            Ok(p) => (p - self.image[index]).norm_squared(),
            Err(_) => f64::INFINITY,
        }
    }

    fn refine(&self, _: &Homography, inliers: &[bool]) -> Option<Homography> {
        let (object, image) = self.select(inliers);
        if object.len() <= Self::SAMPLE {
            return None;
        }
        let mut options = FitOptions::default();
        options.least_squares.max_iterations = 4;
        Some(Homography::fit(&object, &image, &options).ok()?.homography)
    }
}
