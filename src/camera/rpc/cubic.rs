//! The cubic polynomials of the three normalised ground coordinates.

use crate::numeric::scalar::Scalar;

/// The number of terms of a cubic in three variables.
pub(super) const TERMS: usize = 20;

/// Which of the four polynomials stands at which place of [`Cubics`].
pub(super) const LINE: [usize; 2] = [0, 1];
pub(super) const SAMPLE: [usize; 2] = [2, 3];

/// The twenty terms of RPC00B (STDI-0002, appendix E, table 8-12) at (L, P, H): longitude, latitude, height.
#[inline]
pub(super) fn terms<S: Scalar>([l, p, h]: [S; 3]) -> [S; TERMS] {
    let (lp, lh, ph) = (l * p, l * h, p * h);
    let (ll, pp, hh) = (l * l, p * p, h * h);
    [
        S::constant(1.0),
        l,
        p,
        h,
        lp,
        lh,
        ph,
        ll,
        pp,
        hh,
        lp * h,
        ll * l,
        l * pp,
        l * hh,
        ll * p,
        pp * p,
        p * hh,
        ll * h,
        pp * h,
        hh * h,
    ]
}

/// ∂terms/∂L, ∂terms/∂P, ∂terms/∂H.
#[inline]
#[rustfmt::skip]
fn term_slopes([l, p, h]: [f64; 3]) -> [[f64; TERMS]; 3] {
    let (lp, lh, ph) = (l * p, l * h, p * h);
    let (ll, pp, hh) = (l * l, p * p, h * h);
    [
        [
            0.0, 1.0, 0.0, 0.0, p, h, 0.0, 2.0 * l, 0.0, 0.0,
            ph, 3.0 * ll, pp, hh, 2.0 * lp, 0.0, 0.0, 2.0 * lh, 0.0, 0.0,
        ],
        [
            0.0, 0.0, 1.0, 0.0, l, 0.0, h, 0.0, 2.0 * p, 0.0,
            lh, 0.0, 2.0 * lp, 0.0, ll, 3.0 * pp, hh, 0.0, 2.0 * ph, 0.0,
        ],
        [
            0.0, 0.0, 0.0, 1.0, 0.0, l, p, 0.0, 0.0, 2.0 * h,
            lp, 0.0, 0.0, 2.0 * lh, 0.0, 0.0, 2.0 * ph, ll, pp, 3.0 * hh,
        ],
    ]
}

/// The four polynomials of a model, term by term: line numerator and denominator, sample numerator and denominator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cubics([[f64; 4]; TERMS]);

impl Cubics {
    pub(super) fn new(polynomials: [&[f64; TERMS]; 4]) -> Self {
        Self(core::array::from_fn(|k| polynomials.map(|p| p[k])))
    }

    /// Four sums over the terms in one pass, always in the order of the terms.
    #[inline]
    fn sums(&self, terms: &[f64; TERMS]) -> [f64; 4] {
        let mut sums = [0.0; 4];
        for (coefficients, term) in self.0.iter().zip(terms) {
            for (sum, c) in sums.iter_mut().zip(coefficients) {
                *sum += c * term;
            }
        }
        sums
    }

    /// The four polynomials.
    #[inline]
    pub(super) fn at(&self, ground: [f64; 3]) -> [f64; 4] {
        self.sums(&terms(ground))
    }

    /// The four polynomials and their slopes by L, P and H.
    #[inline]
    pub(super) fn with_slopes(&self, ground: [f64; 3]) -> ([f64; 4], [[f64; 4]; 3]) {
        (self.at(ground), term_slopes(ground).map(|t| self.sums(&t)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn slopes_agree_with_dual_numbers() {
        for ground in [[0.3, -0.7, 1.1], [-1.4, 0.2, -0.6], [0.0, 0.0, 0.0]] {
            let dual = core::array::from_fn(|i| Dual::<3>::variable(ground[i], i));
            let (by_dual, by_hand) = (terms(dual), term_slopes(ground));
            for (k, term) in by_dual.iter().enumerate() {
                for i in 0..3 {
                    assert!((term.gradient[i] - by_hand[i][k]).abs() < 1e-15, "term {k} by {i}");
                }
            }
        }
    }

    #[test]
    fn every_term_is_the_product_that_the_standard_prints() {
        // With L, P, H = 2, 3, 5 a term is told by its prime factors.
        let printed = [
            1.0, 2.0, 3.0, 5.0, 6.0, 10.0, 15.0, 4.0, 9.0, 25.0, 30.0, 8.0, 18.0, 50.0, 12.0, 27.0,
            75.0, 20.0, 45.0, 125.0,
        ];
        assert_eq!(terms([2.0, 3.0, 5.0]), printed);
    }
}
