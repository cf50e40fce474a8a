//! The figures of an adjusted block: cofactors, redundancy numbers, tests.
//!
//! ```text
//! Q_cc = S⁻¹,   Q_cp = −S⁻¹ W V⁻¹,   Q_pp = V⁻¹ − V⁻¹ Wᵀ Q_cp
//! ```
//! The cofactors of what is computed for an observation, A Q Aᵀ, need of Q only the blocks of its photograph, its camera and its
//! point, whatever the datum.

use alloc::vec;
use alloc::vec::Vec;

use nalgebra::{DMatrix, Matrix2, Matrix3, SMatrix, SVector, Vector2};

use super::datum::{Similarity, Transformation, add_null_space, no_rows};
use super::engine::Engine;
use super::evaluate::{Rows, image_of};
use super::given::OfImage;
use super::layout::Role;
use super::normal::{Normal, symmetric};
use super::problem::{CameraId, Image, ImageId, Kind, PointId};
use super::quality::{BundleReport, BundleReportOptions, Cofactors};
use super::schur::times;
use super::state::State;
use super::width::Width;
use super::{dense, solve};
use crate::adjust::report::{self, observed};
use crate::adjust::{ObservationReport, precision};
use crate::camera::{Adjustable, CentralModel};
use crate::error::Error;
use crate::numeric::least_squares::unit_weight;

/// The largest reduced system that is inverted: 12,000² numbers are 1.2 GB.
const MOST_INVERTED: usize = 12_000;

/// Of an observation that took no part.
const NOTHING: ObservationReport = ObservationReport {
    residual: f64::NAN,
    weighted_square: f64::NAN,
    redundancy: f64::NAN,
    w: f64::NAN,
    detectable: f64::NAN,
    influence: f64::NAN,
};

/// Points' cofactors, and those of photographs and points for one point.
struct OfPoint {
    own: Matrix3<f64>,
    /// For each of its observations, rows of the photograph's columns by the point.
    crossed: Vec<[[f64; 3]; super::MOST_COLUMNS]>,
}

impl<C: CentralModel + Adjustable + Clone, E: Width, K: Width> Engine<'_, C, E, K> {
    pub(super) fn report(
        &self,
        state: &State<C>,
        how: &BundleReportOptions<'_>,
    ) -> Result<BundleReport, Error> {
        let (bundle, layout) = (self.bundle, self.layout);
        let n = layout.reduced(bundle);
        if n > MOST_INVERTED {
            return Err(Error::OutOfRange {
                what: "number of unknowns of photographs and cameras to be judged",
                value: n as f64,
                expected: "at most 12000",
            });
        }
        let mut normal = Normal::default();
        self.linearise_into(state, &mut normal);
        let free = Similarity::of_datum(how.datum, bundle, layout, state)?;
        // The pivots of a block that nothing places are rounding: whether they are positive is chance.
        let singular = report::undetermined(0.0, f64::EPSILON);
        if free.is_none() && layout.free > 0 {
            return Err(singular);
        }
        let inverses = self.inverses(&normal, 0.0).ok_or(singular)?;
        let mut matrix = self.reduce(&normal, &inverses).matrix;
        let scale = solve::scale(&normal.diagonal);
        solve::scale_matrix(&mut matrix, &scale, &normal.diagonal, 0.0);
        let g = free.as_ref().map(|f| f.of_reduced(bundle, layout, state));
        if let Some(g) = &g {
            add_null_space(&mut matrix, &scale, g);
        }
        dense::factorise(&mut matrix, n).map_err(|_| singular)?;
        let mut q = dense::inverse(&matrix, n);
        drop(matrix);
        for (r, row) in q.chunks_exact_mut(n.max(1)).enumerate() {
            for (s, v) in row.iter_mut().enumerate() {
                *v *= scale[r] * scale[s];
                if normal.diagonal[r] == 0.0 || normal.diagonal[s] == 0.0 {
                    *v = 0.0;
                }
            }
        }
        let conditions = free.as_ref().map_or(0, |f| f.count);
        let mut report = self.figures(state, &normal, conditions, how)?;
        let mut points = self.judge(state, &inverses, &normal, &q, &mut report);
        // Σ rᵢ is r unless the matrix was singular but for rounding, as where parts hang together by two points.
        let off = (report.redundancy_sum() - report.redundancy as f64).abs();
        let limit = 1e-3 + 1e-8 * report.observations as f64;
        if !(off <= limit) {
            return Err(singular);
        }
        if let (Some(free), Some(g)) = (&free, g) {
            let transformation = self.transformation(state, &normal, &inverses, &q, free, g)?;
            for (i, q) in points.iter_mut().enumerate() {
                if layout.roles[i] != Role::Constant {
                    transformation.point(q, i);
                }
            }
            let places: Vec<usize> = (0..n).collect();
            let mut whole = DMatrix::from_row_slice(n, n, &q);
            transformation.reduced(&mut whole, &places);
            q.copy_from_slice(whole.as_slice());
        }
        report.cofactors = Cofactors {
            reduced: q,
            size: n,
            image_places: (0..bundle.images.len()).map(|i| self.places(i)).collect(),
            camera_places: (bundle.cameras.iter().enumerate())
                .map(|(i, c)| {
                    (0..c.columns.len()).map_while(|k| self.parameter_column(i, k)).collect()
                })
                .collect(),
            points,
        };
        Ok(report)
    }

    /// The places of all columns of a photograph in the reduced system.
    fn places(&self, image: usize) -> Vec<usize> {
        let (bundle, layout) = (self.bundle, self.layout);
        let camera = bundle.images[image].camera as usize;
        let shared = layout.camera_column(bundle.images.len(), camera);
        let columns = 6 + bundle.cameras[camera].columns.len();
        let place =
            |c| if c < layout.own { image * layout.own + c } else { shared + c - layout.own };
        (0..columns).map(place).collect()
    }

    /// Numbers of observations and unknowns, and σ₀.
    fn figures(
        &self,
        state: &State<C>,
        normal: &Normal,
        conditions: usize,
        how: &BundleReportOptions<'_>,
    ) -> Result<BundleReport, Error> {
        let (bundle, layout) = (self.bundle, self.layout);
        let (mut image_points, mut weighted_sum) = (0, 0.0);
        for place in 0..layout.order.len() {
            let seen = layout.seen(bundle, place);
            let [x, y] = super::evaluate::residual(bundle, state, seen, self.outside)?;
            let weight = self.loss.weight(x * x + y * y);
            weighted_sum += weight * (x * x + y * y);
            image_points += 2 * usize::from(weight > 0.0);
        }
        weighted_sum += 2.0 * self.given_cost(state);
        let control =
            bundle.points.iter().filter(|p| matches!(p.kind, Kind::Control { .. })).count();
        let of_images: usize = bundle.images.iter().map(Image::observed_numbers).sum();
        let observations =
            image_points + 3 * control + of_images + bundle.distances.len() + normal.observed.len();
        let unknowns = normal.diagonal.iter().filter(|d| **d > 0.0).count()
            + 3 * layout.roles.iter().filter(|r| **r == Role::Eliminated).count();
        let redundancy =
            (observations + conditions).checked_sub(unknowns).ok_or(Error::TooFewPoints {
                needed: (unknowns - conditions).div_ceil(2),
                got: observations / 2,
            })?;
        let sigma0 = unit_weight(weighted_sum, redundancy);
        let sigma = report::sigma(sigma0, how.estimate_sigma);
        Ok(BundleReport {
            observations,
            unknowns,
            conditions,
            redundancy,
            weighted_sum,
            sigma0,
            sigma,
            image_points: vec![[NOTHING; 2]; bundle.seen.len()],
            control_points: Vec::with_capacity(control),
            positions: Vec::new(),
            attitudes: Vec::new(),
            distances: Vec::with_capacity(bundle.distances.len()),
            parameters: Vec::with_capacity(normal.observed.len()),
            cofactors: Cofactors {
                reduced: Vec::new(),
                size: 0,
                image_places: Vec::new(),
                camera_places: Vec::new(),
                points: Vec::new(),
            },
        })
    }

    /// Q_pp and Q_cp of a point.
    fn of_point(&self, point: usize, inverse: &[f64; 6], normal: &Normal, q: &[f64]) -> OfPoint {
        let (bundle, layout, k) = (self.bundle, self.layout, self.total.get());
        let n = layout.reduced(bundle);
        let places = layout.first[point]..layout.first[point + 1];
        let all: Vec<Vec<usize>> =
            places.clone().map(|p| self.places(layout.seen(bundle, p).image as usize)).collect();
        let mut crossed = vec![[[0.0; 3]; super::MOST_COLUMNS]; places.len()];
        match layout.roles[point] {
            Role::Constant => OfPoint { own: Matrix3::zeros(), crossed },
            Role::Kept(kept) => {
                let at = layout.kept_column(bundle, kept as usize);
                for (rows, columns) in crossed.iter_mut().zip(&all) {
                    for (row, column) in rows.iter_mut().zip(columns) {
                        *row = [0, 1, 2].map(|c| q[column * n + at + c]);
                    }
                }
                let own = Matrix3::from_fn(|r, c| q[(at + r) * n + at + c]);
                OfPoint { own, crossed }
            }
            Role::Eliminated => {
                // Q_cp = −Q_cc W V⁻¹, Q_pp = V⁻¹ − V⁻¹ Wᵀ Q_cp.
                for (rows, columns) in crossed.iter_mut().zip(&all) {
                    for (row, column) in rows.iter_mut().zip(columns) {
                        let line = &q[column * n..][..n];
                        let mut sum = [0.0; 3];
                        for (place, others) in places.clone().zip(&all) {
                            let w = &normal.w[place * 3 * k..][..3 * k];
                            for (i, other) in others.iter().enumerate() {
                                for c in 0..3 {
                                    sum[c] += line[*other] * w[c * k + i];
                                }
                            }
                        }
                        *row = times(inverse, sum).map(|v| -v);
                    }
                }
                let mut weighted = Matrix3::zeros();
                for ((place, rows), columns) in places.clone().zip(&crossed).zip(&all) {
                    let w = &normal.w[place * 3 * k..][..3 * k];
                    for (i, row) in rows.iter().enumerate().take(columns.len()) {
                        for r in 0..3 {
                            for c in 0..3 {
                                weighted[(r, c)] += w[r * k + i] * row[c];
                            }
                        }
                    }
                }
                let v = symmetric(*inverse);
                let own = v - v * weighted;
                OfPoint { own: (own + own.transpose()) * 0.5, crossed }
            }
        }
    }

    /// The reports of all observations, and the cofactors of the points.
    fn judge(
        &self,
        state: &State<C>,
        inverses: &[[f64; 6]],
        normal: &Normal,
        q: &[f64],
        report: &mut BundleReport,
    ) -> Vec<Matrix3<f64>> {
        let (bundle, layout, k) = (self.bundle, self.layout, self.total.get());
        let n = layout.reduced(bundle);
        let sigma = report.sigma;
        let mut rows = Rows::default();
        let mut points = Vec::with_capacity(bundle.points.len());
        for (point, inverse) in inverses.iter().enumerate() {
            let of_point = self.of_point(point, inverse, normal, q);
            let places = layout.first[point]..layout.first[point + 1];
            for (place, crossed) in places.zip(&of_point.crossed) {
                let seen = layout.seen(bundle, place);
                if rows.fill(bundle, state, seen, self.outside, k).is_err() {
                    continue;
                }
                let [x, y] = rows.residual;
                let weight = self.loss.weight(x * x + y * y);
                if !(weight > 0.0) {
                    continue;
                }
                let columns = self.places(seen.image as usize);
                let by_point = SMatrix::<f64, 2, 3>::from_fn(|r, c| rows.by_point[r][c]);
                let mut explained = by_point * of_point.own * by_point.transpose();
                for (i, column) in columns.iter().enumerate() {
                    let a = Vector2::new(rows.by_image[0][i], rows.by_image[1][i]);
                    let crossed = by_point * nalgebra::Vector3::from(crossed[i]);
                    explained += a * crossed.transpose() + crossed * a.transpose();
                    let mut sum = Vector2::zeros();
                    for (j, other) in columns.iter().enumerate() {
                        let b = Vector2::new(rows.by_image[0][j], rows.by_image[1][j]);
                        sum += b * q[column * n + other];
                    }
                    explained += a * sum.transpose();
                }
                // The rows are weighted: with W Σ Wᵀ = I, Σ − A Q Aᵀ is W⁻¹ (I/ρ′ − Ã Q Ãᵀ) W⁻ᵀ.
                let [w11, w12, w22] = bundle.precisions[seen.precision as usize];
                let back = Matrix2::new(1.0 / w11, 0.0, -w12 / (w11 * w22), 1.0 / w22);
                let unexplained =
                    back * (Matrix2::identity() / weight - explained) * back.transpose();
                let covariance = back * back.transpose() / weight;
                if let Ok(image) = image_of(bundle, state, seen, self.outside) {
                    let residual = seen.at - image;
                    report.image_points[layout.order[place] as usize] =
                        observed(&unexplained, &covariance, &residual, sigma);
                }
            }
            if let Kind::Control { given, weight } = &bundle.points[point].kind {
                let covariance = precision::inverse(weight);
                let residual = given - state.points[point];
                let values = observed(&(covariance - of_point.own), &covariance, &residual, sigma);
                report.control_points.push((PointId(point as u32), values));
            }
            points.push(of_point.own);
        }
        for (i, (image, exterior)) in bundle.images.iter().zip(&state.exteriors).enumerate() {
            if image.held {
                continue;
            }
            let at = i * layout.own;
            let own = SMatrix::<f64, 6, 6>::from_fn(|r, c| q[(at + r) * n + at + c]);
            let values = |OfImage { off, partials, weight }: OfImage| {
                let covariance = precision::inverse(&weight);
                let unexplained = covariance - partials * own * partials.transpose();
                (ImageId(i as u32), observed(&unexplained, &covariance, &-off, sigma))
            };
            report.positions.extend(image.position.map(|p| values(p.at(exterior))));
            report.attitudes.extend(image.attitude.map(|a| values(a.at(exterior))));
        }
        for distance in &bundle.distances {
            let [a, b] = distance.ends.map(|e| state.points[e as usize]);
            let apart = a - b;
            let length = apart.norm();
            let along = apart / length;
            let mut explained = 0.0;
            for (p, s) in distance.ends.iter().zip([1.0, -1.0]) {
                for (o, t) in distance.ends.iter().zip([1.0, -1.0]) {
                    let roles = [*p, *o].map(|p| layout.roles[p as usize]);
                    let [Role::Kept(p), Role::Kept(o)] = roles else { continue };
                    let [p, o] = [p, o].map(|p| layout.kept_column(bundle, p as usize));
                    let block = Matrix3::from_fn(|r, c| q[(p + r) * n + o + c]);
                    explained += s * t * along.dot(&(block * along));
                }
            }
            report.distances.push(one(distance.weight, explained, distance.length - length, sigma));
        }
        for parameter in &normal.observed {
            let value = one(parameter.weight, q[parameter.at * (n + 1)], -parameter.off, sigma);
            report.parameters.push((CameraId(parameter.camera), parameter.unknown, value));
        }
        points
    }

    /// The S-transformation to inner constraints over the datum points.
    fn transformation(
        &self,
        state: &State<C>,
        normal: &Normal,
        inverses: &[[f64; 6]],
        q: &[f64],
        free: &Similarity,
        g: DMatrix<f64>,
    ) -> Result<Transformation, Error> {
        let (bundle, layout, k) = (self.bundle, self.layout, self.total.get());
        let n = layout.reduced(bundle);
        // G of all points; B of those of the datum.
        let (mut g_points, mut of_points) =
            (no_rows(bundle.points.len()), no_rows(bundle.points.len()));
        for (i, point) in state.points.iter().enumerate() {
            if layout.roles[i] != Role::Constant {
                g_points[i] = free.of_point(point);
                if free.places_by(i) {
                    of_points[i] = g_points[i];
                }
            }
        }
        // B of the reduced system: −W V⁻¹ G_p, and G itself of the points that are kept.
        let mut b = DMatrix::<f64>::zeros(n, free.count);
        for point in 0..bundle.points.len() {
            if let Role::Kept(place) = layout.roles[point] {
                let at = layout.kept_column(bundle, place as usize);
                for c in 0..free.count {
                    for r in 0..3 {
                        b[(at + r, c)] += of_points[point][(r, c)];
                    }
                }
                continue;
            }
            let reduced = symmetric(inverses[point]) * of_points[point];
            for place in layout.first[point]..layout.first[point + 1] {
                let w = &normal.w[place * 3 * k..][..3 * k];
                let columns = self.places(layout.seen(bundle, place).image as usize);
                for (i, column) in columns.iter().enumerate() {
                    for c in 0..free.count {
                        let sum: f64 = (0..3).map(|r| w[r * k + i] * reduced[(r, c)]).sum();
                        b[(*column, c)] -= sum;
                    }
                }
            }
        }
        let z = DMatrix::from_row_slice(n, n, q) * b;
        let mut z_points = no_rows(bundle.points.len());
        for point in 0..bundle.points.len() {
            if let Role::Kept(place) = layout.roles[point] {
                let at = layout.kept_column(bundle, place as usize);
                for c in 0..free.count {
                    for r in 0..3 {
                        z_points[point][(r, c)] = z[(at + r, c)];
                    }
                }
                continue;
            }
            let mut sum = of_points[point];
            for place in layout.first[point]..layout.first[point + 1] {
                let w = &normal.w[place * 3 * k..][..3 * k];
                let columns = self.places(layout.seen(bundle, place).image as usize);
                for (i, column) in columns.iter().enumerate() {
                    for c in 0..free.count {
                        for r in 0..3 {
                            sum[(r, c)] -= w[r * k + i] * z[(*column, c)];
                        }
                    }
                }
            }
            z_points[point] = symmetric(inverses[point]) * sum;
        }
        Transformation::new((g, g_points), &of_points, (z, z_points), free.count)
    }
}

/// The report of a single number.
fn one(weight: f64, explained: f64, residual: f64, sigma: f64) -> ObservationReport {
    let covariance = SMatrix::<f64, 1, 1>::new(1.0 / weight);
    let unexplained = covariance - SMatrix::<f64, 1, 1>::new(explained);
    let [value] = observed(&unexplained, &covariance, &SVector::<f64, 1>::new(residual), sigma);
    value
}
