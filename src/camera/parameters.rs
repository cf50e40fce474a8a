//! Models with named parameters.

use core::fmt::Debug;

use super::ParameterGroup;
use crate::error::Error;

/// A formula with named parameters: a central projection, a distortion.
pub trait Parametrised: Copy + Debug + Send + Sync {
    /// What the parameters are, as `"lens distortion"`.
    const NAME: &'static str;
    /// Their names, in order.
    const PARAMETERS: &'static [&'static str];

    /// The current values, written in order.
    fn values(&self, out: &mut [f64]);

    /// The same formula with other values.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::OutOfRange`] where they make no valid model.
    fn with_values(&self, values: &[f64]) -> Result<Self, Error>;
}

/// No formula has more parameters.
pub(super) const MOST: usize = 16;

pub(super) fn group<P: Parametrised>() -> ParameterGroup {
    ParameterGroup { name: P::NAME, len: P::PARAMETERS.len() }
}

/// Copies values out, as many as fit.
pub(super) fn write<T: Copy>(values: &[T], out: &mut [T]) {
    for (o, v) in out.iter_mut().zip(values) {
        *o = *v;
    }
}

/// The values as an array.
pub(super) fn read<const N: usize>(values: &[f64]) -> Result<[f64; N], Error> {
    values.try_into().map_err(|_| Error::LengthMismatch {
        what: "parameter group and values",
        left: N,
        right: values.len(),
    })
}

/// The formula with its parameters moved by a step.
pub(super) fn moved<P: Parametrised>(model: &P, step: &[f64]) -> Result<P, Error> {
    let len = P::PARAMETERS.len();
    if step.len() != len {
        return Err(Error::LengthMismatch {
            what: "parameter group and step",
            left: len,
            right: step.len(),
        });
    }
    let mut values = [0.0; MOST];
    model.values(&mut values);
    for (v, s) in values.iter_mut().zip(step) {
        *v += s;
    }
    model.with_values(&values[..len])
}

/// [`Parametrised`] of a formula without parameters.
macro_rules! no_parameters {
    ($name:ident, $what:literal) => {
        impl $crate::camera::Parametrised for $name {
            const NAME: &'static str = $what;
            const PARAMETERS: &'static [&'static str] = &[];

            fn values(&self, _: &mut [f64]) {}

            fn with_values(&self, _: &[f64]) -> Result<Self, $crate::error::Error> {
                Ok(*self)
            }
        }
    };
}
pub(super) use no_parameters;
