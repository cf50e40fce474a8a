//! The motion between two cameras from five pairs of directions: every root.

use nalgebra::{Matrix3, Matrix5, Rotation3, SMatrix, SVector, Schur, UnitVector3, Vector3};

use super::p3p::unit_vector;
use super::roots::Roots;
use crate::error::Error;
use crate::geometry::rotation::{RotationVector, orthonormalised};
use crate::geometry::{Pose, axes};

/// Up to ten motions, second_from_first with a base of length one.
pub type MotionRoots = Roots<10>;

/// All motions between two cameras that let five pairs of rays meet in front of both.
///
/// *Model.* The centre of the second camera is b in the first one's axes, ‖b‖ = 1, and R is second_from_first:
///
/// ```text
/// b · (dᵢ × Rᵀ dᵢ′) = 0      or   dᵢ′ᵀ E dᵢ = 0,   E = −R [b]×,   det E = 0,   2 E Eᵀ E = tr(E Eᵀ) E      (Demazure 1988)
/// ```
///
/// Five pairs leave E in a space of four dimensions, and the ten cubic equations there have ten roots, complex ones among them
/// (Nistér 2004). They are eigenvectors of a matrix of order ten (Stewénius, Engels & Nistér 2006). Each E is four motions, of which
/// the one with all five points at positive distances is kept, if there is one, and refined by Newton steps on the five
/// equations.
///
/// *Roots.* None to ten. The scalar triple products of each vanish within 10⁻¹³. Roots that coincide, as on a critical surface, are
/// found once or more often, and less exactly: within the square root of rounding.
///
/// *Frames and units.* Directions in camera axes (x right, y down, z forward), of any positive length. The pose's origin is b.
///
/// # Errors
/// [`Error::NotFinite`]; [`Error::Degenerate`] for a direction of length zero, and where the five equations are not independent, as for
/// the same pair twice, or leave a family of motions open, as without a base (the measure is the smallest pivot).
///
/// # Example
/// Two level cameras, the second one unit to the right and turned a quarter about the line of sight. The points are at small integers.
/// ```
/// use collinear::adjust::five_point;
/// use collinear::nalgebra::Vector3;
///
/// let first = [[1, 2, 5], [-2, 1, 7], [3, -1, 9], [-1, -3, 6], [2, 2, 11]].map(|p| p.map(f64::from));
/// let roots = five_point(
///     &first.map(Vector3::from),
///     // (x, y, z) ↦ (x − 1, y, z), then x to y.
///     &first.map(|[x, y, z]| Vector3::new(-y, x - 1.0, z)),
/// )?;
/// let found = roots.iter().find(|m| (m.origin.coords - Vector3::x()).norm() < 1e-12).ok_or("missed")?;
/// assert!((found.rotation * Vector3::x() - Vector3::y()).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias(
    "findEssentialMat",
    "essential matrix",
    "relative pose",
    "relative orientation",
    "Nister"
))]
pub fn five_point(
    first: &[Vector3<f64>; 5],
    second: &[Vector3<f64>; 5],
) -> Result<MotionRoots, Error> {
    let mut pairs = [(Vector3::zeros(), Vector3::zeros()); 5];
    for (pair, (a, b)) in pairs.iter_mut().zip(first.iter().zip(second)) {
        *pair = (unit_vector(a)?, unit_vector(b)?);
    }
    let space = null_space(&pairs)?;
    let mut found = MotionRoots::none();
    let mut pivot = 0.0;
    for mixing in MIXINGS {
        let basis = mixed(&space, &mixing);
        let action = match action_matrix(&basis) {
            Ok(action) => action,
            Err(small) => {
                pivot = small;
                continue;
            }
        };
        each_root(&action, |weights| {
            let e = basis[0] * weights[0]
                + basis[1] * weights[1]
                + basis[2] * weights[2]
                + basis[3] * weights[3];
            if let Some(pose) = motion(&e, &pairs) {
                push(&mut found, pose);
            }
        });
        return Ok(found);
    }
    let what = "motions that five pairs of directions leave open";
    Err(Error::Degenerate { what, measure: pivot, limit: LEAST_PIVOT })
}

fn push(found: &mut MotionRoots, pose: Pose) {
    let same = |p: &Pose| {
        (p.origin - pose.origin).amax() + (p.rotation.matrix() - pose.rotation.matrix()).amax()
            < 1e-9
    };
    if !found.iter().any(same) {
        found.push(pose);
    }
}

/// Vectors that turn the basis of the null space, so that no root lies where the fourth factor vanishes: a basis of simple scenes may
/// have such roots. The second is for the scene that the first one does not fit.
const MIXINGS: [[f64; 4]; 3] =
    [[0.62, -0.31, 0.53, 0.49], [0.21, 0.74, -0.45, 0.46], [-0.57, 0.12, 0.66, 0.48]];

/// Four orthonormal vectors that the five equations d′ᵀ E d = 0 leave free, E row by row.
fn null_space(pairs: &[(Vector3<f64>, Vector3<f64>); 5]) -> Result<[SVector<f64, 9>; 4], Error> {
    let mut projector = SMatrix::<f64, 9, 9>::identity();
    let mut least = f64::INFINITY;
    let mut rows: [SVector<f64, 9>; 5] =
        pairs.map(|(d, e)| SVector::from_fn(|k, _| e[k / 3] * d[k % 3]));
    // The row with the largest rest first: its rest is the pivot.
    for step in 0..5 {
        let rest = |row: &SVector<f64, 9>| (projector * row).norm();
        let mut best = step;
        for k in step + 1..5 {
            if rest(&rows[k]) > rest(&rows[best]) {
                best = k;
            }
        }
        rows.swap(step, best);
        let q = projector * rows[step];
        least = least.min(q.norm());
        let limit = 16.0 * f64::EPSILON;
        if !(least > limit) {
            let what = "five pairs of directions";
            return Err(Error::Degenerate { what, measure: least, limit });
        }
        // Projected twice: once leaves ε over the pivot.
        let q = (projector * q.normalize()).normalize();
        projector -= q * q.transpose();
    }
    let mut free = [SVector::zeros(); 4];
    for vector in &mut free {
        let k = projector.diagonal().imax();
        let q: SVector<f64, 9> = projector.column(k).normalize();
        let q = (projector * q).normalize();
        projector -= q * q.transpose();
        *vector = q;
    }
    Ok(free)
}

/// The basis reflected at the plane across a vector, as matrices of norm √2.
fn mixed(space: &[SVector<f64, 9>; 4], mixing: &[f64; 4]) -> [Matrix3<f64>; 4] {
    let squared: f64 = mixing.iter().map(|m| m * m).sum();
    let sum = (0..4).fold(SVector::<f64, 9>::zeros(), |s, i| s + space[i] * mixing[i]);
    core::array::from_fn(|i| {
        let v = space[i] - sum * (2.0 * mixing[i] / squared);
        Matrix3::from_row_slice(v.as_slice()) * core::f64::consts::SQRT_2
    })
}

/// A polynomial of the first degree in (x, y, z): factors of x, y, z, 1.
type Linear = [f64; 4];
/// Of the second: x², xy, xz, y², yz, z², x, y, z, 1.
type Quadratic = [f64; 10];
/// Of the third: x³, x²y, x²z, xy², xyz, xz², y³, y²z, yz², z³, then the second degree.
type Cubic = [f64; 20];

/// Where the product of two of x, y, z, 1 stands in a quadratic.
const SECOND: [[usize; 4]; 4] = [[0, 1, 2, 6], [1, 3, 4, 7], [2, 4, 5, 8], [6, 7, 8, 9]];
/// Where the product of a monomial of the second degree and one of x, y, z, 1 stands in a cubic.
const THIRD: [[usize; 4]; 10] = [
    [0, 1, 2, 10],
    [1, 3, 4, 11],
    [2, 4, 5, 12],
    [3, 6, 7, 13],
    [4, 7, 8, 14],
    [5, 8, 9, 15],
    [10, 11, 12, 16],
    [11, 13, 14, 17],
    [12, 14, 15, 18],
    [16, 17, 18, 19],
];

fn add_square(sum: &mut Quadratic, a: &Linear, b: &Linear, factor: f64) {
    for i in 0..4 {
        for j in 0..4 {
            sum[SECOND[i][j]] += factor * a[i] * b[j];
        }
    }
}

fn add_cube(sum: &mut Cubic, a: &Quadratic, b: &Linear) {
    for i in 0..10 {
        for j in 0..4 {
            sum[THIRD[i][j]] += a[i] * b[j];
        }
    }
}

/// Multiplication by x on the monomials of the second degree, modulo the ten equations; the pivot where the cubic monomials cannot be
/// eliminated from these.
fn action_matrix(basis: &[Matrix3<f64>; 4]) -> Result<SMatrix<f64, 10, 10>, f64> {
    let entry = |i: usize, j: usize| -> Linear { core::array::from_fn(|k| basis[k][(i, j)]) };
    let mut rows = [[0.0; 20]; 10];
    // det E by the first row.
    for (j, (a, b)) in [(0, (1, 2)), (1, (2, 0)), (2, (0, 1))] {
        let mut minor = [0.0; 10];
        add_square(&mut minor, &entry(1, a), &entry(2, b), 1.0);
        add_square(&mut minor, &entry(1, b), &entry(2, a), -1.0);
        add_cube(&mut rows[9], &minor, &entry(0, j));
    }
    // (E Eᵀ − ½ tr(E Eᵀ)) E.
    let mut products = [[[0.0; 10]; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                add_square(&mut products[i][j], &entry(i, k), &entry(j, k), 1.0);
            }
        }
    }
    let half: Quadratic =
        core::array::from_fn(|k| 0.5 * (products[0][0][k] + products[1][1][k] + products[2][2][k]));
    for i in 0..3 {
        for k in 0..10 {
            products[i][i][k] -= half[k];
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                add_cube(&mut rows[3 * i + j], &products[i][k], &entry(k, j));
            }
        }
    }
    eliminate(&mut rows)?;
    let mut action = SMatrix::<f64, 10, 10>::zeros();
    for i in 0..6 {
        for j in 0..10 {
            action[(i, j)] = -rows[i][10 + j];
        }
    }
    // x · x, x · y, x · z, x · 1.
    for (row, column) in [(6, 0), (7, 1), (8, 2), (9, 6)] {
        action[(row, column)] = 1.0;
    }
    Ok(action)
}

/// Below it a pivot is rounding: the equations have coefficients near one.
const LEAST_PIVOT: f64 = 1e-11;

/// Gauss–Jordan elimination of the first ten columns with the largest pivot of each column.
fn eliminate(rows: &mut [[f64; 20]; 10]) -> Result<(), f64> {
    for k in 0..10 {
        let mut best = k;
        for i in k + 1..10 {
            if rows[i][k].abs() > rows[best][k].abs() {
                best = i;
            }
        }
        rows.swap(k, best);
        let pivot = rows[k][k];
        if !(pivot.abs() > LEAST_PIVOT) {
            return Err(pivot.abs());
        }
        for j in k..20 {
            rows[k][j] /= pivot;
        }
        let row = rows[k];
        for (i, other) in rows.iter_mut().enumerate() {
            let factor = other[k];
            if i != k && factor != 0.0 {
                for j in k..20 {
                    other[j] -= factor * row[j];
                }
            }
        }
    }
    Ok(())
}

/// The factors of the basis at each real root: eigenvectors, by inverse iteration.
fn each_root(action: &SMatrix<f64, 10, 10>, mut take: impl FnMut([f64; 4])) {
    let Some(schur) = Schur::try_new(*action, f64::EPSILON, 1000) else { return };
    for value in &schur.complex_eigenvalues() {
        // A double root may part into a pair whose imaginary parts are the square root of rounding.
        if !(value.im >= 0.0 && value.im <= 1e-5 * (1.0 + value.re.abs())) {
            continue;
        }
        // A shift beside the eigenvalue keeps the matrix regular.
        let shift = value.re + 1e-11 * (1.0 + value.re.abs());
        let factor = (action - SMatrix::identity() * shift).lu();
        let mut vector = SVector::<f64, 10>::repeat(1.0);
        for _ in 0..3 {
            let Some(next) = factor.solve(&vector) else { break };
            vector = next / next.amax();
        }
        let weights = [vector[6], vector[7], vector[8], vector[9]];
        let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
        if size > 0.0 && size.is_finite() {
            take(weights.map(|w| w / size));
        }
    }
}

/// The one of the four motions of E with all points at positive distances, refined.
///
/// ```text
/// ‖E‖² = 2,  t ∝ the null vector of Eᵀ:   R = cof E ∓ [t]× E,   b = −Rᵀ t
/// ```
fn motion(e: &Matrix3<f64>, pairs: &[(Vector3<f64>, Vector3<f64>); 5]) -> Option<Pose> {
    let e = e * (core::f64::consts::SQRT_2 / e.norm());
    let [a, b, c] = [0, 1, 2].map(|j| e.column(j).into_owned());
    let crosses = [b.cross(&c), c.cross(&a), a.cross(&b)];
    let largest = crosses.iter().max_by(|p, q| p.norm().total_cmp(&q.norm()))?;
    let t = largest.normalize();
    let cofactors = Matrix3::from_columns(&crosses);
    let turned = t.cross_matrix() * e;
    for rotation in [cofactors - turned, cofactors + turned] {
        let Ok(rotation) = orthonormalised(&rotation) else { continue };
        for sign in [1.0, -1.0] {
            let base = rotation.inverse() * t * sign;
            if pairs.iter().all(|(d, e)| in_front(&rotation, &base, d, e)) {
                return refine(rotation, base, pairs);
            }
        }
    }
    None
}

/// Whether the rays, brought to one plane, meet at positive distances along both.
pub(super) fn in_front(
    rotation: &Rotation3<f64>,
    base: &Vector3<f64>,
    first: &Vector3<f64>,
    second: &Vector3<f64>,
) -> bool {
    // λ d − μ d′ = b by its products with d and d′.
    let other = rotation.inverse() * second;
    let cosine = first.dot(&other);
    let (along, against) = (base.dot(first), base.dot(&other));
    along - cosine * against > 0.0 && cosine * along - against > 0.0
}

/// Two unit vectors across a unit vector and each other.
pub(super) fn tangents(b: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let axes = axes(&UnitVector3::new_unchecked(*b));
    [0, 1].map(|i| axes.matrix().column(i).into_owned())
}

/// b · (d × Rᵀ d′), with its derivatives by the base along the two tangents and by a left rotation vector of R.
pub(super) fn coplanarity(
    rotation: &Rotation3<f64>,
    base: &Vector3<f64>,
    tangents: &[Vector3<f64>; 2],
    first: &Vector3<f64>,
    second: &Vector3<f64>,
) -> (f64, SVector<f64, 5>) {
    let other = rotation.inverse() * second;
    let normal = first.cross(&other);
    // exp([δ]×) R turns Rᵀ d′ by −Rᵀ (δ × d′): b · (d × ·) = (b × d) · Rᵀ (d′ × δ) = ((R (b × d)) × d′) · δ.
    let by_turn = (rotation * base.cross(first)).cross(second);
    let by = [tangents[0].dot(&normal), tangents[1].dot(&normal), by_turn.x, by_turn.y, by_turn.z];
    (base.dot(&normal), SVector::from(by))
}

/// Newton's steps on the five equations; `None` where they do not come to vanish.
fn refine(
    mut rotation: Rotation3<f64>,
    mut base: Vector3<f64>,
    pairs: &[(Vector3<f64>, Vector3<f64>); 5],
) -> Option<Pose> {
    let evaluate =
        |rotation: &Rotation3<f64>, base: &Vector3<f64>, tangents: &[Vector3<f64>; 2]| {
            let mut jacobian = Matrix5::zeros();
            let mut values = SVector::<f64, 5>::zeros();
            for (i, (d, e)) in pairs.iter().enumerate() {
                let (value, by) = coplanarity(rotation, base, tangents, d, e);
                values[i] = value;
                jacobian.set_row(i, &by.transpose());
            }
            (values, jacobian)
        };
    let mut across = tangents(&base);
    let (mut values, mut jacobian) = evaluate(&rotation, &base, &across);
    for _ in 0..12 {
        if values.amax() <= 0.25 * f64::EPSILON {
            break;
        }
        let Some(step) = jacobian.lu().solve(&values) else { break };
        if !(step.amax() < 0.5) {
            break;
        }
        let (next_rotation, next_base) = moved(&rotation, &base, &across, &-step)?;
        let next_across = tangents(&next_base);
        let (after, next_jacobian) = evaluate(&next_rotation, &next_base, &next_across);
        if !(after.amax() < values.amax()) {
            break;
        }
        (rotation, base, across) = (next_rotation, next_base, next_across);
        (values, jacobian) = (after, next_jacobian);
    }
    let good =
        values.amax() <= 1e-13 && pairs.iter().all(|(d, e)| in_front(&rotation, &base, d, e));
    good.then(|| Pose::new(rotation, base.into()))
}

/// A motion moved by a step along the tangents and by a left rotation vector.
pub(super) fn moved(
    rotation: &Rotation3<f64>,
    base: &Vector3<f64>,
    tangents: &[Vector3<f64>; 2],
    step: &SVector<f64, 5>,
) -> Option<(Rotation3<f64>, Vector3<f64>)> {
    let turn = RotationVector { x: step[2], y: step[3], z: step[4] }.rotation();
    let rotation = orthonormalised(&(turn.matrix() * rotation.matrix())).ok()?;
    let base = (base + tangents[0] * step[0] + tangents[1] * step[1]).normalize();
    Some((rotation, base))
}
