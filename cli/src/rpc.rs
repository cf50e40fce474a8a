//! Places on the Earth through a rational polynomial camera, either way.

use anyhow::Result;
use collinear::camera::Rpc;
use collinear::camera::rpc::{FitGrid, FitOptions, RpcFit};
use collinear::geometry::geodetic::{EllipsoidalHeight, GeoidGrid, OrthometricHeight};
use collinear::nalgebra::Point2;
use collinear_io::points::{GeographicRow, ImagePointRow};
use collinear_io::rpc::{RpcFile, World};
use collinear_io::sensor::SensorFile;

use crate::project::{OK, ProjectedRow, table};

/// What heights count from.
#[derive(Clone, Debug)]
pub enum Heights {
    /// The WGS84 ellipsoid.
    Ellipsoid,
    /// A geoid above it.
    Geoid(GeoidGrid),
}

/// Nodes of a fit along x, along y, and layers of height.
const NODES: [usize; 3] = [15, 15, 7];

/// Rational polynomials in place of a camera or a scanner whose world is a frame on WGS84, between two heights (metres above the
/// ellipsoid), with the picture's size and the world; and how far they are from it.
///
/// # Errors
/// A sensor or a world out of their domain, and those of [`Rpc::fit_sensor`].
pub fn fit(sensor: &SensorFile, world: World, heights: [f64; 2]) -> Result<(RpcFile, RpcFit)> {
    let [width, height] = sensor.size();
    let grid = FitGrid {
        corners: [Point2::origin(), Point2::new(width.into(), height.into())],
        heights: heights.map(EllipsoidalHeight),
        nodes: NODES,
    };
    let found =
        Rpc::fit_sensor(&*sensor.sensor()?, &world.frame()?, &grid, &FitOptions::default())?;
    let mut file = RpcFile::from_rpc(&found.rpc);
    (file.width, file.height, file.world) = (Some(width), Some(height), Some(world));
    Ok((file, found))
}

/// The images of places. Whether they lie in the picture is not known: its size is not in the camera's file.
#[must_use]
pub fn project(rpc: &Rpc, heights: &Heights, places: &[GeographicRow]) -> Vec<ProjectedRow> {
    let image = |place: &GeographicRow| {
        let (latitude, longitude) = (place.latitude_deg, place.longitude_deg);
        let height = match heights {
            Heights::Ellipsoid => place.height,
            Heights::Geoid(geoid) => {
                let n = geoid.undulation(latitude.to_radians(), longitude.to_radians());
                place.height + n.map_err(|e| e.to_string())?
            }
        };
        let height = EllipsoidalHeight(height);
        rpc.project_degrees(latitude, longitude, height).map_err(|e| e.to_string())
    };
    let row = |place: &GeographicRow| {
        let world = [place.longitude_deg, place.latitude_deg, place.height];
        let (image, status) = match image(place) {
            Ok(p) => (Some([p.x, p.y]), OK.to_owned()),
            Err(reason) => (None, reason),
        };
        ProjectedRow { id: place.id.clone(), world: Some(world), image, status }
    };
    places.iter().map(row).collect()
}

/// The places that image points show at one height.
#[must_use]
pub fn ground(
    rpc: &Rpc,
    heights: &Heights,
    height: f64,
    points: &[ImagePointRow],
) -> Vec<ProjectedRow> {
    let place = |image: &Point2<f64>| match heights {
        Heights::Ellipsoid => {
            rpc.at_height(image, EllipsoidalHeight(height)).map_err(|e| e.to_string())
        }
        Heights::Geoid(geoid) => rpc
            .at_orthometric_height(image, OrthometricHeight(height), geoid)
            .map_err(|e| e.to_string()),
    };
    let row = |point: &ImagePointRow| {
        let (world, status) = match place(&Point2::from(point.image)) {
            Ok(p) => {
                let (latitude, longitude) = (p.latitude(), p.longitude());
                let world = [longitude.to_degrees(), latitude.to_degrees(), height];
                (Some(world), OK.to_owned())
            }
            Err(reason) => (None, reason),
        };
        ProjectedRow { id: point.id.clone(), world, image: Some(point.image), status }
    };
    points.iter().map(row).collect()
}

/// The table `id,lon,lat,h,x,y,status`: degrees, metres and pixels.
#[must_use]
pub fn to_csv(rows: &[ProjectedRow]) -> String {
    table("lon,lat,h", rows)
}
