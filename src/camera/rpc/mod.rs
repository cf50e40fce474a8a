//! Rational polynomial cameras: what the vendors of satellite pictures give instead of a sensor.
//!
//! | what | item |
//! | --- | --- |
//! | the numbers of a file, in its own conventions | [`Rpc00b`] |
//! | ground → image, image → ground at a height | [`Rpc`] |
//! | the model in a Cartesian world, on planes and surfaces | [`RpcSensor`] |
//! | its correction by control points | [`Rpc::correct`], [`ImageCorrection`] |
//! | polynomials in place of any other sensor | [`Rpc::fit`], [`Rpc::fit_sensor`] |
//!
//! Ground positions are geodetic on WGS84 and carry in their type what their height counts from. The polynomials know
//! ellipsoidal heights; what takes an [`OrthometricHeight`](crate::geometry::geodetic::OrthometricHeight) takes a geoid
//! with it.

mod bias;
mod correction;
mod cubic;
mod fit;
mod inverse;
mod model;
mod record;
mod sensor;

pub use bias::{ControlPoint, CorrectionModel, CorrectionReport};
pub use correction::ImageCorrection;
pub use fit::{Denominators, FitGrid, FitOptions, FitResiduals, GroundAtHeight, RpcFit};
pub use model::Rpc;
pub use record::Rpc00b;
pub use sensor::RpcSensor;
