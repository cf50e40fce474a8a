//! When a scan sees a point: one equation in time.

use crate::error::ProjectionError;

/// The pieces in which the scan is searched where its ends do not enclose the moment.
const PIECES: u32 = 64;

/// A Newton step of so few lines is not taken: the search ends.
const SURE: f64 = 1e-10;

/// What a search that has come to the last digits must have reached, in lines.
const NANOLINE: f64 = 1e-9;

/// By no more may a Newton step move the image, in pixels. A step is small too where the point passes the edge of the camera's
/// half-space, and its image lies far off.
const MICROPIXEL: f64 = 1e-6;

/// Halvings of a piece in search of the turn of the function: to some 10⁻⁶ of it.
const MOST_HALVINGS: u32 = 20;

/// Thirds taken off two pieces in search of the time at which the point is most ahead: to some 10⁻⁴ of them.
const MOST_THIRDS: u32 = 24;

/// Evaluations for one bracket: bisection alone reaches neighbouring floats in fewer.
const MOST_STEPS: u32 = 200;

/// How far the point is from being seen at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Miss {
    /// A function of time that is zero when the point is seen.
    pub(super) value: f64,
    /// Its derivative.
    pub(super) slope: f64,
    /// How fast the image moves through the camera, or where the image states the time the ray of that time: pixels for each unit of
    /// Newton's step.
    pub(super) speed: f64,
}

impl Miss {
    /// Newton's step in time.
    fn step(&self) -> f64 {
        -self.value / self.slope
    }
}

/// The time at which `miss` vanishes: the whole interval where its ends enclose a root, else the first of 64 pieces that do, or
/// in which the function turns beyond zero.
///
/// A change of sign that is a jump, as at the seam of a panorama, is passed over; it is the error where the ends say that the
/// root should be within. The root is exact to a nanoline: `unit` is the time of a line. A point that the camera has in its lens
/// for less than a piece is looked for where `ahead`, the cosine of its angle from the camera's axis, is greatest.
pub(super) fn find<T>(
    interval: [f64; 2],
    unit: f64,
    ahead: impl Fn(f64) -> f64,
    mut miss: impl FnMut(f64) -> Result<(Miss, T), ProjectionError>,
) -> Result<(f64, T), ProjectionError> {
    let [first, last] = interval;
    let (start, end) = (miss(first), miss(last));
    if let (Ok((a, _)), Ok((b, _))) = (&start, &end)
        && let Outcome::Found(found) = refine([first, last], [*a, *b], unit, &mut miss)
    {
        return Ok(found);
    }
    let reason = start.as_ref().err().or(end.as_ref().err()).copied();
    let nearest = nearest_end(interval, [&start, &end]);
    let mut stuck = None;
    let mut before = start.map(|(m, _)| m).ok();
    let mut seen = before.is_some();
    for piece in 1..=PIECES {
        let at = |k: u32| first + (last - first) * (f64::from(k) / f64::from(PIECES));
        let after = if piece == PIECES {
            end.as_ref().ok().map(|e| e.0)
        } else {
            miss(at(piece)).ok().map(|m| m.0)
        };
        match within([at(piece - 1), at(piece)], [before, after], unit, &mut miss) {
            Outcome::Found(found) => return Ok(found),
            Outcome::Stuck { iterations, residual } => {
                stuck = stuck.or(Some(ProjectionError::NotConverged { iterations, residual }));
            }
            Outcome::None => {}
        }
        seen |= after.is_some();
        before = after;
    }
    if !seen && let Some(([a, b], t)) = foremost(interval, &ahead) {
        let before_it = miss(t).ok().map(|m| m.0);
        for (times, ends) in [([a, t], [None, before_it]), ([t, b], [before_it, None])] {
            if let Outcome::Found(found) = within(times, ends, unit, &mut miss) {
                return Ok(found);
            }
        }
    }
    Err(match (stuck, reason) {
        // A seam far from the point is none of its business.
        (Some(stuck), _) if nearest >= first && nearest <= last => stuck,
        // Never before the camera, or never in its lens: the reason of an end.
        (None, Some(reason)) if !seen => reason,
        _ => {
            let outside = nearest < first || nearest > last;
            let time = if outside { nearest } else { f64::NAN };
            ProjectionError::OutsideScan { time, first, last }
        }
    })
}

/// Where Newton's step leads from the end that is nearer to the root.
fn nearest_end<T>([first, last]: [f64; 2], ends: [&Result<(Miss, T), ProjectionError>; 2]) -> f64 {
    let from = |t: f64, end: &Result<(Miss, T), ProjectionError>| {
        end.as_ref().ok().map(|(m, _)| m.step()).filter(|s| s.is_finite()).map(|s| (s.abs(), t + s))
    };
    let candidates = [from(first, ends[0]), from(last, ends[1])];
    let best = candidates.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(f64::NAN, |(_, t)| t)
}

/// The time at which `ahead` is greatest, and the ends of the two pieces around it; none where the point is never ahead.
fn foremost([first, last]: [f64; 2], ahead: &impl Fn(f64) -> f64) -> Option<([f64; 2], f64)> {
    let at = |k: u32| first + (last - first) * (f64::from(k) / f64::from(PIECES));
    let (k, most) = (0..=PIECES).map(|k| (k, ahead(at(k)))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    if !(most > 0.0) {
        return None;
    }
    let ends = [at(k.saturating_sub(1)), at((k + 1).min(PIECES))];
    let [mut a, mut b] = ends;
    for _ in 0..MOST_THIRDS {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if ahead(c) < ahead(d) {
            a = c;
        } else {
            b = d;
        }
    }
    Some((ends, 0.5 * (a + b)))
}

/// The root within a piece, where its ends are enough to tell.
fn within<T>(
    times: [f64; 2],
    ends: [Option<Miss>; 2],
    unit: f64,
    miss: &mut impl FnMut(f64) -> Result<(Miss, T), ProjectionError>,
) -> Outcome<T> {
    let bracket = match ends {
        [Some(a), Some(b)] => enclosed(times, [a, b], miss),
        [Some(a), None] => beside(times, a, miss),
        [None, Some(b)] => beside([times[1], times[0]], b, miss)
            .map(|(times, ends)| ([times[1], times[0]], [ends[1], ends[0]])),
        [None, None] => None,
    };
    bracket.map_or(Outcome::None, |(times, ends)| refine(times, ends, unit, miss))
}

/// Of a piece from whose first end alone the point is seen, a part whose ends have different signs.
fn beside<T>(
    [mut seen, mut unseen]: [f64; 2],
    mut at_seen: Miss,
    miss: &mut impl FnMut(f64) -> Result<(Miss, T), ProjectionError>,
) -> Option<([f64; 2], [Miss; 2])> {
    for _ in 0..MOST_HALVINGS {
        let middle = 0.5 * (seen + unseen);
        match miss(middle) {
            Ok((found, _)) if found.value.signum() != at_seen.value.signum() => {
                return Some(([seen, middle], [at_seen, found]));
            }
            Ok((found, _)) => (seen, at_seen) = (middle, found),
            Err(_) => unseen = middle,
        }
    }
    None
}

/// A part of the piece whose ends have different signs: the piece itself, or where the function turns within it and reaches
/// beyond zero, the part before its turn.
fn enclosed<T>(
    [mut a, mut b]: [f64; 2],
    [at_a, at_b]: [Miss; 2],
    miss: &mut impl FnMut(f64) -> Result<(Miss, T), ProjectionError>,
) -> Option<([f64; 2], [Miss; 2])> {
    let sign = at_a.value.signum();
    if sign != at_b.value.signum() {
        return Some(([a, b], [at_a, at_b]));
    }
    let towards = |m: &Miss| m.slope * sign < 0.0;
    if !towards(&at_a) || towards(&at_b) {
        return None;
    }
    let mut before = at_a;
    for _ in 0..MOST_HALVINGS {
        let middle = 0.5 * (a + b);
        let (found, _) = miss(middle).ok()?;
        if found.value.signum() != sign {
            return Some(([a, middle], [before, found]));
        }
        if towards(&found) {
            (a, before) = (middle, found);
        } else {
            b = middle;
        }
    }
    None
}

enum Outcome<T> {
    Found((f64, T)),
    /// A jump from one sign to the other; the residual in lines.
    Stuck {
        iterations: u32,
        residual: f64,
    },
    None,
}

/// Newton's steps kept within a shrinking bracket.
fn refine<T>(
    [mut a, mut b]: [f64; 2],
    ends: [Miss; 2],
    unit: f64,
    miss: &mut impl FnMut(f64) -> Result<(Miss, T), ProjectionError>,
) -> Outcome<T> {
    let [at_a, at_b] = ends.map(|m| m.value);
    if !(at_a <= 0.0 && at_b >= 0.0 || at_a >= 0.0 && at_b <= 0.0) {
        return Outcome::None;
    }
    let rising = at_a < at_b;
    // Where the chord crosses zero.
    let mut t = if at_a == at_b { a } else { a + (b - a) * (at_a / (at_a - at_b)) };
    let mut last = f64::INFINITY;
    let mut lines = f64::INFINITY;
    for iterations in 1..=MOST_STEPS {
        let Ok((found, rest)) = miss(t.clamp(a, b)) else { return Outcome::None };
        t = t.clamp(a, b);
        // Where time changes nothing every time is a root, and none is the moment: 0/0.
        let step = if found.value == 0.0 && found.slope != 0.0 { 0.0 } else { found.step() };
        lines = (step / unit).abs();
        *(if (found.value < 0.0) == rising { &mut a } else { &mut b }) = t;
        let middle = 0.5 * (a + b);
        // At the last digits steps no longer shrink, and no float is left between neighbours.
        let at_the_end = lines > 0.5 * last || !(middle > a && middle < b);
        let near = lines <= SURE || lines <= NANOLINE && at_the_end;
        if near && (step * found.speed).abs() <= MICROPIXEL {
            return Outcome::Found((t, rest));
        }
        if !(middle > a && middle < b) {
            return Outcome::Stuck { iterations, residual: lines };
        }
        let next = t + step;
        let newton = next > a && next < b && lines <= 0.5 * last;
        last = if newton { lines } else { f64::INFINITY };
        t = if newton { next } else { middle };
    }
    Outcome::Stuck { iterations: MOST_STEPS, residual: lines }
}
