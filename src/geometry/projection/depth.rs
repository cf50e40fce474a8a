//! Near and far.

use crate::error::Error;

/// The range of depths that a projection keeps, and which end of the depth buffer the near end becomes.
///
/// Depths are distances along the optical axis, in world units.
///
/// ```
/// use collinear::geometry::projection::{ClipConvention, DepthRange, Projection};
///
/// // Reversed and without end, z_ndc = near / Z: depth 10 is at 0.01.
/// let depth = DepthRange::infinite(0.1)?.reversed();
/// let view = Projection::from_field_of_view(1.0, 1.0, depth)?;
/// assert!((view.depth_from_ndc(ClipConvention::Wgpu, 0.01)? - 10.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthRange {
    near: f64,
    far: f64,
    reversed: bool,
}

impl DepthRange {
    /// From `near` to `far`. A perspective projection needs near > 0, an orthographic one does not.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] unless near < far.
    pub fn new(near: f64, far: f64) -> Result<Self, Error> {
        if !(near.is_finite() && far.is_finite()) {
            return Err(Error::NotFinite { what: "depth range" });
        }
        if near >= far {
            return Err(Error::OutOfRange {
                what: "near depth",
                value: near,
                expected: "less than the far depth",
            });
        }
        Ok(Self { near, far, reversed: false })
    }

    /// From `near` without end, for perspective projections.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    #[doc(alias = "infinitePerspective")]
    pub fn infinite(near: f64) -> Result<Self, Error> {
        if !near.is_finite() {
            return Err(Error::NotFinite { what: "near depth" });
        }
        Ok(Self { near, far: f64::INFINITY, reversed: false })
    }

    /// The same range with the near end at the largest normalised device z, and the far end at the smallest.
    ///
    /// With z in [0, 1] and a floating-point depth buffer, 1/z is then resolved about evenly.
    #[must_use]
    #[doc(alias("reverse z", "infinite reverse"))]
    pub fn reversed(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }

    /// The nearest depth kept.
    #[must_use]
    pub fn near(&self) -> f64 {
        self.near
    }

    /// The farthest depth kept, or ∞.
    #[must_use]
    pub fn far(&self) -> f64 {
        self.far
    }

    /// Whether the near end has the largest normalised device z.
    #[must_use]
    pub fn is_reversed(&self) -> bool {
        self.reversed
    }

    fn ends(&self, [lowest, highest]: [f64; 2]) -> [f64; 2] {
        if self.reversed { [highest, lowest] } else { [lowest, highest] }
    }

    /// (α, β) of `z_ndc = α + β / Z`, which is `ends` at near and far.
    pub(super) fn perspective(&self, ndc: [f64; 2]) -> [f64; 2] {
        let [at_near, at_far] = self.ends(ndc);
        if self.far == f64::INFINITY {
            return [at_far, (at_near - at_far) * self.near];
        }
        let length = self.far - self.near;
        // The ends are −1, 0 or 1, so that only sums, quotients and the last product round.
        [
            (at_far * self.far - at_near * self.near) / length,
            (at_near - at_far) * self.near * (self.far / length),
        ]
    }

    /// (α, β) of `z_ndc = α Z + β`, which is `ends` at near and far.
    pub(super) fn orthographic(&self, ndc: [f64; 2]) -> [f64; 2] {
        let [at_near, at_far] = self.ends(ndc);
        let length = self.far - self.near;
        [(at_far - at_near) / length, (at_near * self.far - at_far * self.near) / length]
    }
}
