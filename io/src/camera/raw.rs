//! An interior orientation as the file has it: every field that any model has.

use collinear::camera::Panorama;
use serde::{Deserialize, Serialize};

use super::Interior;
use super::lens::{FisheyeProjection, Lens, Model, coefficients};
use crate::json::object::Object;

/// Makes the fields of the file, each of which may be missing.
macro_rules! fields {
    ($($field:ident: $kind:ty,)*) => {
        #[derive(Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(super) struct RawInterior {
            pub(super) model: Model,
            $(#[serde(default, skip_serializing_if = "Option::is_none")]
            pub(super) $field: Option<$kind>,)*
        }

        impl RawInterior {
            /// Without any field.
            pub(super) fn empty(model: Model) -> Self {
                Self { model, $($field: None,)* }
            }

            /// The first field that is there.
            fn left(&self) -> Option<&'static str> {
                [$((stringify!($field), self.$field.is_some()),)*]
                    .into_iter()
                    .find_map(|(field, there)| there.then_some(field))
            }
        }
    };
}

fields! {
    colmap_model: String,
    parameters: Vec<f64>,
    projection: FisheyeProjection,
    principal_distance: [f64; 2],
    principal_distance_mm: f64,
    principal_point_mm: [f64; 2],
    fiducials: Vec<[f64; 4]>,
    pixels_per_unit: [f64; 2],
    principal_point: [f64; 2],
    skew: f64,
    xi: f64,
    alpha: f64,
    beta: f64,
    omega: f64,
    lambda: f64,
    k: Vec<f64>,
    p: Vec<f64>,
    s: Vec<f64>,
    tau: Vec<f64>,
    b: Vec<f64>,
}

impl TryFrom<Object<RawInterior>> for Interior {
    type Error = String;

    fn try_from(Object(mut raw): Object<RawInterior>) -> Result<Self, String> {
        let model = raw.model.name();
        let interior = raw.take();
        // What is too much is told before what is missing: it is what the writer had in mind.
        match raw.left() {
            Some(field) => {
                Err(format!("the model `{model}` has no `{field}`: remove it or change the model"))
            }
            None => interior,
        }
    }
}

impl RawInterior {
    /// The interior orientation of the model. Every field that the model has is taken, also where another is missing.
    fn take(&mut self) -> Result<Interior, String> {
        let model = self.model;
        let name = model.name();
        let need = |field: &str| format!("the model `{name}` needs `{field}`");
        let principal_point = self.principal_point.take();
        if let Model::Colmap = model {
            self.principal_point = principal_point;
            let (colmap, parameters) = (self.colmap_model.take(), self.parameters.take());
            return Ok(Interior::Colmap {
                model: colmap.ok_or_else(|| need("colmap_model"))?,
                parameters: parameters.ok_or_else(|| need("parameters"))?,
            });
        }
        if let Model::Film = model {
            self.principal_point = principal_point;
            let distance = self.principal_distance_mm.take();
            let (point, fiducials) = (self.principal_point_mm.take(), self.fiducials.take());
            return Ok(Interior::Film {
                principal_distance_mm: distance.ok_or_else(|| need("principal_distance_mm"))?,
                principal_point_mm: point.unwrap_or_default(),
                fiducials: fiducials.ok_or_else(|| need("fiducials"))?,
            });
        }
        let point = principal_point.ok_or_else(|| need("principal_point"));
        if let Model::Orthographic = model {
            let scale = self.pixels_per_unit.take().ok_or_else(|| need("pixels_per_unit"));
            return Ok(Interior::Orthographic { pixels_per_unit: scale?, principal_point: point? });
        }
        let principal_distance = self.principal_distance.take();
        let panorama = match model {
            Model::Equirectangular => Some(Panorama::Equirectangular),
            Model::Cylindrical => Some(Panorama::Cylindrical),
            _ => None,
        };
        if let Some(projection) = panorama {
            return Ok(Interior::Panorama { projection, principal_distance, principal_point });
        }
        let distance = principal_distance.ok_or_else(|| need("principal_distance"));
        let skew = self.skew.take().unwrap_or(0.0);
        if let Some(lens) = Lens::take(model, self) {
            let (principal_distance, principal_point) = (distance?, point?);
            let lens = Box::new(lens?);
            return Ok(Interior::Lens { principal_distance, principal_point, skew, lens });
        }
        if let Model::Pinhole = model {
            let (principal_distance, principal_point) = (distance?, point?);
            return Ok(Interior::Pinhole { principal_distance, principal_point, skew });
        }
        let k = coefficients(self.k.take(), name, "k");
        let p = coefficients(self.p.take(), name, "p");
        let (principal_distance, principal_point) = (distance?, point?);
        Ok(Interior::Brown { principal_distance, principal_point, skew, k: k?, p: p? })
    }
}

impl From<Interior> for RawInterior {
    fn from(interior: Interior) -> Self {
        let pixels = |principal_distance, principal_point, skew: f64, rest| Self {
            principal_distance: Some(principal_distance),
            principal_point: Some(principal_point),
            skew: (skew != 0.0).then_some(skew),
            ..rest
        };
        match interior {
            Interior::Pinhole { principal_distance, principal_point, skew } => {
                pixels(principal_distance, principal_point, skew, Self::empty(Model::Pinhole))
            }
            Interior::Brown { principal_distance, principal_point, skew, k, p } => {
                let (k, p) = (Some(k.into()), Some(p.into()));
                let rest = Self { k, p, ..Self::empty(Model::Brown) };
                pixels(principal_distance, principal_point, skew, rest)
            }
            Interior::Lens { principal_distance, principal_point, skew, lens } => {
                pixels(principal_distance, principal_point, skew, lens.give())
            }
            Interior::Panorama { projection, principal_distance, principal_point } => {
                let model = match projection {
                    Panorama::Equirectangular => Model::Equirectangular,
                    Panorama::Cylindrical => Model::Cylindrical,
                };
                Self { principal_distance, principal_point, ..Self::empty(model) }
            }
            Interior::Colmap { model, parameters } => Self {
                colmap_model: Some(model),
                parameters: Some(parameters),
                ..Self::empty(Model::Colmap)
            },
            Interior::Film { principal_distance_mm, principal_point_mm, fiducials } => Self {
                principal_distance_mm: Some(principal_distance_mm),
                principal_point_mm: (principal_point_mm != [0.0; 2]).then_some(principal_point_mm),
                fiducials: Some(fiducials),
                ..Self::empty(Model::Film)
            },
            Interior::Orthographic { pixels_per_unit, principal_point } => Self {
                pixels_per_unit: Some(pixels_per_unit),
                principal_point: Some(principal_point),
                ..Self::empty(Model::Orthographic)
            },
        }
    }
}
