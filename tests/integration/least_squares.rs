//! The minimiser, robust losses and the consensus search against certified and counted numbers.

use collinear::Error;
use collinear::nalgebra::{Matrix2, SVector, Vector2};
use collinear::numeric::consensus::{ConsensusOptions, Estimator, search};
use collinear::numeric::least_squares::{
    Convergence, Damped, LeastSquaresOptions, NormalEquations, Problem, minimise,
};
use collinear::numeric::robust_loss::RobustLoss;
use proptest::prelude::*;

/// Residuals with their partial derivatives, of two unknowns.
struct TwoUnknowns<F>(F);

impl<F: Fn(&Vector2<f64>) -> Vec<(f64, Vector2<f64>)>> Problem for TwoUnknowns<F> {
    type State = Vector2<f64>;
    type Linear = NormalEquations<2>;
    type Step = SVector<f64, 2>;

    fn cost(&self, state: &Self::State) -> f64 {
        0.5 * (self.0)(state).iter().map(|(r, _)| r * r).sum::<f64>()
    }

    fn linearise(&self, state: &Self::State, linear: &mut Self::Linear) -> f64 {
        linear.clear();
        for (residual, partials) in (self.0)(state) {
            linear.add(&partials, residual, 1.0);
        }
        linear.scaled_gradient()
    }

    fn solve(
        &self,
        state: &Self::State,
        linear: &Self::Linear,
        damping: f64,
    ) -> Option<Damped<Self::Step>> {
        linear.solve(damping, state)
    }

    fn apply(&self, state: &Self::State, step: &Self::Step) -> Self::State {
        state + step
    }
}

fn run(
    residuals: impl Fn(&Vector2<f64>) -> Vec<(f64, Vector2<f64>)>,
    start: [f64; 2],
    options: &LeastSquaresOptions,
) -> (Vector2<f64>, Convergence, NormalEquations<2>) {
    let mut linear = NormalEquations::default();
    let (state, report) =
        minimise(&TwoUnknowns(residuals), Vector2::from(start), &mut linear, options);
    (state, report, linear)
}

/// NIST StRD Misra1a: y = β₁ (1 − exp(−β₂ x)).
fn misra1a(b: &Vector2<f64>) -> Vec<(f64, Vector2<f64>)> {
    let data = [
        (10.07, 77.6),
        (14.73, 114.9),
        (17.94, 141.1),
        (23.93, 190.8),
        (29.61, 239.9),
        (35.18, 289.0),
        (40.02, 332.8),
        (44.82, 378.4),
        (50.76, 434.8),
        (55.05, 477.3),
        (61.01, 536.8),
        (66.40, 593.1),
        (75.47, 689.1),
        (81.78, 760.0),
    ];
    data.iter()
        .map(|&(y, x): &(f64, f64)| {
            let e = (-b[1] * x).exp();
            (b[0] * (1.0 - e) - y, Vector2::new(1.0 - e, b[0] * x * e))
        })
        .collect()
}

#[test]
fn a_certified_regression_is_found_from_both_starts() {
    // NIST Statistical Reference Datasets, Misra1a (Misra 1978), certified values and both starting points.
    for start in [[500.0, 1e-4], [250.0, 5e-4]] {
        let (b, report, linear) = run(misra1a, start, &LeastSquaresOptions::default());
        assert!(report.converged, "{report:?}");
        assert!((b[0] / 2.389_421_291_8e2 - 1.0).abs() < 1e-10, "{b}");
        assert!((b[1] / 5.501_564_318_1e-4 - 1.0).abs() < 1e-10, "{b}");
        let squares = 2.0 * report.final_cost;
        assert!((squares / 1.245_513_889_4e-1 - 1.0).abs() < 1e-10, "{squares}");
        assert!(report.initial_cost > report.final_cost && report.iterations < 30, "{report:?}");
        let covariance = linear.covariance().unwrap() * (squares / 12.0);
        assert!((covariance[(0, 0)].sqrt() / 2.707_007_524_1 - 1.0).abs() < 1e-8);
        assert!((covariance[(1, 1)].sqrt() / 7.266_868_843_6e-6 - 1.0).abs() < 1e-8);
    }
}

#[test]
fn a_curved_valley_is_followed_to_its_end() {
    // Rosenbrock (1960): 10 (y − x²) and 1 − x, zero at (1, 1); the cost at (−1.2, 1) is ½ (4.4² + 2.2²) = 12.1.
    let valley = |s: &Vector2<f64>| {
        vec![
            (10.0 * (s[1] - s[0] * s[0]), Vector2::new(-20.0 * s[0], 10.0)),
            (1.0 - s[0], Vector2::new(-1.0, 0.0)),
        ]
    };
    let (s, report, _) = run(valley, [-1.2, 1.0], &LeastSquaresOptions::default());
    assert!(report.converged && report.iterations < 60, "{report:?}");
    assert!((s - Vector2::new(1.0, 1.0)).norm() < 1e-12, "{s}");
    assert!((report.initial_cost - 12.1).abs() < 1e-13);
    // Three linearisations do not reach it, and say so.
    let few = LeastSquaresOptions { max_iterations: 3, ..LeastSquaresOptions::default() };
    let (_, report, _) = run(valley, [-1.2, 1.0], &few);
    assert_eq!((report.converged, report.iterations), (false, 3));
    assert!(report.final_cost < report.initial_cost);
    let none = LeastSquaresOptions { max_iterations: 0, ..LeastSquaresOptions::default() };
    let (s, report, _) = run(valley, [-1.2, 1.0], &none);
    assert_eq!((report.converged, report.iterations, s), (false, 0, Vector2::new(-1.2, 1.0)));
}

#[test]
fn a_valley_is_followed_though_most_of_the_cost_is_out_of_reach() {
    // Rosenbrock's valley and a residual of 100 that nothing changes: 12.1 of a cost of 5012.1 can be won.
    let valley = |s: &Vector2<f64>| {
        vec![
            (10.0 * (s[1] - s[0] * s[0]), Vector2::new(-20.0 * s[0], 10.0)),
            (1.0 - s[0], Vector2::new(-1.0, 0.0)),
            (100.0, Vector2::zeros()),
        ]
    };
    let (s, report, _) = run(valley, [-1.2, 1.0], &LeastSquaresOptions::default());
    assert!(report.converged && (s - Vector2::new(1.0, 1.0)).norm() < 1e-5, "{s} {report:?}");
    assert!((report.initial_cost - 5012.1).abs() < 1e-9);
    assert!((report.final_cost - 5000.0).abs() < 1e-8);
}

#[test]
fn a_start_without_a_cost_stays_where_it_is() {
    let nowhere = |_: &Vector2<f64>| vec![(f64::NAN, Vector2::new(1.0, 0.0))];
    let (s, report, _) = run(nowhere, [3.0, 4.0], &LeastSquaresOptions::default());
    assert!(!report.converged && report.iterations == 0 && s == Vector2::new(3.0, 4.0));
    // A derivative of the wrong sign: no step decreases the cost, and the state does not move.
    let uphill = |s: &Vector2<f64>| vec![(s[0] + 5.0, Vector2::new(-1.0, 0.0))];
    let (s, report, _) = run(uphill, [3.0, 4.0], &LeastSquaresOptions::default());
    assert!(s == Vector2::new(3.0, 4.0) && report.final_cost == 32.0, "{s} {report:?}");
}

#[test]
fn a_gradient_is_small_by_its_cosine_with_the_residuals() {
    // Residuals x and 4, and one that is always zero for the other unknown: at x = 3 the column (1, 0) and the residuals
    // (3, 4) meet at the cosine 3/5.
    let plain = |s: &Vector2<f64>| {
        vec![
            (s[0], Vector2::new(1.0, 0.0)),
            (4.0, Vector2::zeros()),
            (s[1], Vector2::new(0.0, 1.0)),
        ]
    };
    for (tolerance, stays) in [(0.6, true), (0.61, true), (0.59, false), (0.43, false)] {
        let options = LeastSquaresOptions {
            gradient_tolerance: tolerance,
            max_iterations: 1,
            ..LeastSquaresOptions::default()
        };
        let (s, report, _) = run(plain, [3.0, 0.0], &options);
        assert_eq!((report.converged, s == Vector2::new(3.0, 0.0)), (stays, stays), "{tolerance}");
        assert_eq!((report.iterations, report.gradient), (1, 3.0));
        assert_eq!(report.initial_cost, 12.5);
    }
}

/// (x − 5)² whose linear system cannot be solved below a damping of 1; it counts how often it is asked.
struct Reluctant(std::cell::Cell<u32>);

impl Problem for Reluctant {
    type State = f64;
    type Linear = f64;
    type Step = f64;

    fn cost(&self, x: &f64) -> f64 {
        0.5 * (x - 5.0) * (x - 5.0)
    }

    fn linearise(&self, x: &f64, gradient: &mut f64) -> f64 {
        *gradient = x - 5.0;
        gradient.abs()
    }

    fn solve(&self, x: &f64, gradient: &f64, damping: f64) -> Option<Damped<f64>> {
        self.0.set(self.0.get() + 1);
        assert!(self.0.get() < 2000, "asked without end");
        let step = -gradient / (1.0 + damping);
        (damping >= 1.0).then_some(Damped {
            step,
            predicted_decrease: 0.5 * step * (damping * step - gradient),
            relative_length: (step / x).abs(),
        })
    }

    fn apply(&self, x: &f64, step: &f64) -> f64 {
        x + step
    }
}

#[test]
fn damping_grows_until_a_system_can_be_solved() {
    let problem = Reluctant(std::cell::Cell::new(0));
    let options = LeastSquaresOptions { max_iterations: 1, ..LeastSquaresOptions::default() };
    let (x, report) = minimise(&problem, 1.0, &mut 0.0, &options);
    // 10⁻⁴ times 2, 4, 8, 16, 32: the sixth is 3.2768, and the step 4 / 4.2768.
    assert_eq!((problem.0.get(), report.iterations), (6, 1));
    assert!((x - (1.0 + 4.0 / 4.2768)).abs() < 1e-14, "{x}");
    // ½ x² with steps ten times too long: they lead uphill until 10 / (1 + λ) < 2. The seventh damping is 10⁻⁴ · 2²¹.
    struct Overshooting(std::cell::Cell<u32>);
    impl Problem for Overshooting {
        type State = f64;
        type Linear = ();
        type Step = f64;
        fn cost(&self, x: &f64) -> f64 {
            0.5 * x * x
        }
        fn linearise(&self, x: &f64, (): &mut ()) -> f64 {
            x.abs()
        }
        fn solve(&self, x: &f64, (): &(), damping: f64) -> Option<Damped<f64>> {
            self.0.set(self.0.get() + 1);
            let step = -10.0 * x / (1.0 + damping);
            Some(Damped { step, predicted_decrease: 1.0, relative_length: 1.0 })
        }
        fn apply(&self, x: &f64, step: &f64) -> f64 {
            x + step
        }
    }
    let problem = Overshooting(std::cell::Cell::new(0));
    let (x, _) = minimise(&problem, 1.0, &mut (), &options);
    assert_eq!(problem.0.get(), 7);
    assert!((x - (1.0 - 10.0 / 210.7152)).abs() < 1e-14, "{x}");
    // A system that is never solved ends the search where it is.
    struct Never;
    impl Problem for Never {
        type State = f64;
        type Linear = ();
        type Step = f64;
        fn cost(&self, x: &f64) -> f64 {
            x * x
        }
        fn linearise(&self, x: &f64, (): &mut ()) -> f64 {
            x.abs()
        }
        fn solve(&self, _: &f64, (): &(), _: f64) -> Option<Damped<f64>> {
            None
        }
        fn apply(&self, x: &f64, step: &f64) -> f64 {
            x + step
        }
    }
    let (x, report) = minimise(&Never, 2.0, &mut (), &LeastSquaresOptions::default());
    assert_eq!((x, report.converged, report.iterations, report.final_cost), (2.0, false, 1, 4.0));
}

#[test]
fn normal_equations_by_hand() {
    // Rows (1, 2 | 3) of weight 2 and (0, 1 | −1) of weight 4: JᵀWJ = (2 4; 4 12), JᵀWr = (6, 8).
    let mut normal = NormalEquations::<2>::default();
    normal.add(&Vector2::new(1.0, 2.0), 3.0, 2.0);
    normal.add(&Vector2::new(0.0, 1.0), -1.0, 4.0);
    assert_eq!(normal.matrix(), Matrix2::new(2.0, 4.0, 4.0, 12.0));
    assert!((normal.scaled_gradient() - 6.0 / 2f64.sqrt()).abs() < 1e-15);
    // (2 4; 4 12) δ = −(6, 8): δ = (−5, 1); the cost ½ (2·9 + 4·1) = 11 falls to 0, and by ½ (30 − 8).
    let sizes = Vector2::new(10.0, -0.5);
    let step = normal.solve(0.0, &sizes).unwrap();
    assert!((step.step - Vector2::new(-5.0, 1.0)).norm() < 1e-14);
    assert!((step.predicted_decrease - 11.0).abs() < 1e-13);
    assert!((step.relative_length - 2.0).abs() < 1e-14);
    // λ = 1: (4 4; 4 24) δ = −(6, 8): δ = (−112, −8) / 80 = (−1.4, −0.1). The linear model's decrease is
    // −g·δ − ½ δᵀ(2 4; 4 12)δ = 9.2 − ½ (3.92 + 1.12 + 0.12) = 6.62.
    let step = normal.solve(1.0, &sizes).unwrap();
    assert!((step.step - Vector2::new(-1.4, -0.1)).norm() < 1e-14);
    assert!((step.predicted_decrease - 6.62).abs() < 1e-13, "{}", step.predicted_decrease);
    // The inverse of (2 4; 4 12) is (12 −4; −4 2) / 8.
    let covariance = normal.covariance().unwrap();
    assert!((covariance - Matrix2::new(1.5, -0.5, -0.5, 0.25)).norm() < 1e-14);
    let parts =
        NormalEquations::from_parts(Matrix2::new(2.0, 77.0, 4.0, 12.0), Vector2::new(6.0, 8.0));
    assert_eq!(parts.matrix(), normal.matrix());
    // One row does not determine two unknowns; an unknown that nothing depends on stays.
    let mut one = NormalEquations::<2>::default();
    one.add(&Vector2::new(1.0, 2.0), 3.0, 1.0);
    assert!(one.covariance().is_none() || one.covariance().unwrap().norm() > 1e12);
    let mut idle = NormalEquations::<2>::default();
    idle.add(&Vector2::new(2.0, 0.0), 3.0, 1.0);
    assert!((idle.solve(0.0, &sizes).unwrap().step - Vector2::new(-1.5, 0.0)).norm() < 1e-15);
    assert_eq!(idle.scaled_gradient(), 3.0);
}

#[test]
fn losses_by_hand() {
    // Residual 6 at scale 2: s = 9. Huber 4 (2·3 − 1), weight 1/3; Cauchy 4 ln 10, weight 1/10; truncated 4, weight 0.
    let ln10 = core::f64::consts::LN_10;
    for (loss, cost, weight) in [
        (RobustLoss::Squared, 36.0, 1.0),
        (RobustLoss::Huber { scale: 2.0 }, 20.0, 1.0 / 3.0),
        (RobustLoss::Cauchy { scale: 2.0 }, 4.0 * ln10, 0.1),
        (RobustLoss::Tukey { scale: 2.0 }, 4.0 / 3.0, 0.0),
        (RobustLoss::Truncated { scale: 2.0 }, 4.0, 0.0),
        // Residual 6 within scale 12: s = 1/4.
        (RobustLoss::Huber { scale: 12.0 }, 36.0, 1.0),
        (RobustLoss::Cauchy { scale: 12.0 }, 144.0 * 1.25f64.ln(), 0.8),
        (RobustLoss::Tukey { scale: 12.0 }, 27.75, 0.5625),
        (RobustLoss::Truncated { scale: 12.0 }, 36.0, 1.0),
    ] {
        assert!((loss.cost(36.0) - cost).abs() < 1e-13, "{loss:?} {}", loss.cost(36.0));
        assert!((loss.weight(36.0) - weight).abs() < 1e-15, "{loss:?} {}", loss.weight(36.0));
    }
    // Far within the scale, at s of 10⁻¹⁶ and of 10⁻⁴, a loss is the square less the fraction s/2 or s of it.
    for scale in [1e8, 1e2] {
        for (loss, share) in
            [(RobustLoss::Cauchy { scale }, 0.5), (RobustLoss::Tukey { scale }, 1.0)]
        {
            let off = loss.cost(1.0) - (1.0 - share / (scale * scale));
            assert!(off.abs() < 1e-8, "{loss:?} {off}");
        }
    }
}

proptest! {
    #[test]
    fn a_weight_is_the_slope_of_its_loss(squared in 0.01..100.0f64, scale in 0.5..5.0f64) {
        prop_assume!((squared / (scale * scale) - 1.0).abs() > 1e-3);
        let h = 1e-5 * squared;
        for loss in [
            RobustLoss::Squared,
            RobustLoss::Huber { scale },
            RobustLoss::Cauchy { scale },
            RobustLoss::Tukey { scale },
            RobustLoss::Truncated { scale },
        ] {
            let slope = (loss.cost(squared + h) - loss.cost(squared - h)) / (2.0 * h);
            prop_assert!((slope - loss.weight(squared)).abs() < 1e-6, "{:?}", loss);
        }
    }
}

/// The common value of numbers, determined by one of them.
struct Level {
    values: Vec<f64>,
    refines: bool,
}

impl Estimator for Level {
    type Model = f64;
    const SAMPLE: usize = 1;
    fn len(&self) -> usize {
        self.values.len()
    }
    fn minimal(&self, sample: &[usize], models: &mut Vec<f64>) {
        models.push(self.values[sample[0]]);
    }
    fn squared_residual(&self, model: &f64, index: usize) -> f64 {
        (self.values[index] - model).powi(2)
    }
    fn refine(&self, _: &f64, inliers: &[bool]) -> Option<f64> {
        let chosen: Vec<f64> =
            self.values.iter().zip(inliers).filter(|(_, i)| **i).map(|(v, _)| *v).collect();
        (self.refines && !chosen.is_empty())
            .then(|| chosen.iter().sum::<f64>() / chosen.len() as f64)
    }
}

#[test]
fn a_search_counts_what_agrees_to_the_threshold_itself() {
    // Without refining: 10 is off by 0, 0 and 2, the threshold itself; 12 by 2, 2 and 0, which sums to more.
    let values = vec![10.0, 50.0, 10.0, 12.0, -40.0];
    let options =
        ConsensusOptions { threshold: 2.0, min_support: 2, ..ConsensusOptions::default() };
    let found = search(&Level { values: values.clone(), refines: false }, &options).unwrap();
    assert_eq!((found.model, found.inlier_count), (10.0, 3));
    assert_eq!(found.inliers, [true, false, true, true, false]);
    // Refined it is the mean of the three.
    let refined = search(&Level { values: values.clone(), refines: true }, &options).unwrap();
    assert_eq!((refined.model, refined.inlier_count), (32.0 / 3.0, 3));
    // Support of three beyond the sample is more than there is.
    let more = ConsensusOptions { min_support: 3, ..options };
    assert!(matches!(
        search(&Level { values, refines: true }, &more),
        Err(Error::NoConsensus { inliers: 3, needed: 4, .. })
    ));
    // As many as asked for, or all: never more than there are.
    let all = ConsensusOptions { min_support: usize::MAX, ..options };
    let level = Level { values: vec![9.0, 10.0, 11.0], refines: true };
    assert_eq!(search(&level, &all).unwrap().inlier_count, 3);
}

#[test]
fn a_search_ends_when_one_good_sample_is_likely_enough() {
    // 5 of 100 agree: ln(1 − 0.9999) / ln(1 − 0.05) = 179.56, so 180 trials (unless none of the five was drawn by then).
    let values: Vec<f64> =
        (0..100).map(|i| if i % 20 == 7 { 0.0 } else { 1000.0 + 10.0 * f64::from(i) }).collect();
    let level = Level { values, refines: true };
    let options = ConsensusOptions { threshold: 1.0, ..ConsensusOptions::default() };
    let found = search(&level, &options).unwrap();
    assert_eq!((found.model, found.inlier_count, found.trials), (0.0, 5, 180));
    // Half the confidence: ln(1/2) / ln(0.95) = 13.5, and 32 trials are done anyway.
    let hasty = ConsensusOptions { confidence: 0.5, min_trials: 0, seed: 3, ..options };
    let found = search(&level, &hasty).unwrap();
    assert!(found.trials >= 14, "{}", found.trials);
    for threshold in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let bad = ConsensusOptions { threshold, ..options };
        assert!(matches!(
            search(&Level { values: vec![1.0; 9], refines: true }, &bad),
            Err(Error::OutOfRange { .. })
        ));
    }
    assert_eq!(
        search(&Level { values: vec![], refines: true }, &options).err(),
        Some(Error::TooFewPoints { needed: 1, got: 0 })
    );
}
