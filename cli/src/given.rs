//! What was observed of a block besides its own image points: control and check points, positions, attitudes, distances.

use std::collections::{HashMap, HashSet};

use anyhow::{Result, anyhow, bail};
use collinear::adjust::{
    AbsoluteOrientationOptions, ImageObservation, IntersectionOptions, PointPair, Precision,
    absolute_orientation, intersect,
};
use collinear::camera::{BrownCamera, EarthCurvature, Refraction};
use collinear::geometry::Similarity;
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::{ExteriorOrientation, Frame};
use collinear_io::observations::ObservationRow;
use collinear_io::observed::{AttitudeRow, DistanceRow, PlaceRow, PositionRow};

use crate::draft::{Draft, Kind};
use crate::reason::reason;

/// What was observed of a block besides its own image points.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// Points whose places take part: with their precisions, or as free of error.
    pub control: Vec<PlaceRow>,
    /// Points whose places are compared afterwards.
    pub check: Vec<PlaceRow>,
    /// The images of the points that control, check points and distances name.
    pub clicks: Vec<ObservationRow>,
    /// Positions of the photographs' antennas.
    pub positions: Vec<PositionRow>,
    /// From the projection centre to the antenna in camera axes, world units, where the positions do not say it.
    pub lever_arm: [f64; 3],
    /// Attitudes of the photographs.
    pub attitudes: Vec<AttitudeRow>,
    /// Distances of points.
    pub distances: Vec<DistanceRow>,
    /// Whether the block is in the frame of these places already; else it is brought there.
    pub in_place: bool,
    /// Whether image points are corrected for refraction.
    pub refraction: bool,
    /// Whether image points are corrected for the Earth's curvature.
    pub earth_curvature: bool,
}

/// What a block knows of it, by its own numbers.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// The places in the block's points of control points with precisions, and of those without.
    pub control: Vec<usize>,
    /// Control points that are exact.
    pub exact: Vec<usize>,
    /// Check points: their places in the block's points, and the known coordinates.
    pub check: Vec<(usize, Point3<f64>)>,
    /// Points that take no part, by name, with the reason.
    pub left_out: Vec<(String, &'static str)>,
    /// Ends and length of each distance.
    pub distances: Vec<([usize; 2], f64)>,
    /// Whether positions or attitudes were observed.
    pub oriented: bool,
    /// How the block was brought to the frame of what was given.
    pub placed: Option<Placed>,
}

impl Known {
    /// Whether something places the block.
    #[must_use]
    pub fn places(&self) -> bool {
        self.oriented || !self.control.is_empty() || !self.exact.is_empty()
    }
}

/// How a block was brought to another frame before its adjustment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Control points that it was laid onto.
    pub points: usize,
    /// Positions that it was laid onto.
    pub positions: usize,
    /// Units of the new frame for one of the old.
    pub scale: f64,
    /// The root mean square distance that was left, world units.
    pub rms: f64,
}

/// The position of an antenna with its lever arm and precision.
pub(crate) type Antenna = (Point3<f64>, Vector3<f64>, Precision<3>);

/// The Earth's mean radius, metres.
const EARTH: f64 = 6_371_000.0;
/// A similarity has seven numbers, a point gives three.
const NEEDED: usize = 3;

impl Given {
    /// Whether there is nothing.
    fn is_empty(&self) -> bool {
        self.control.is_empty()
            && self.check.is_empty()
            && self.clicks.is_empty()
            && self.positions.is_empty()
            && self.attitudes.is_empty()
            && self.distances.is_empty()
            && !self.refraction
            && !self.earth_curvature
    }

    /// Refuses what is there twice.
    fn unique(&self) -> Result<()> {
        let control = || self.control.iter().map(|r| r.id.as_str());
        let check = || self.check.iter().map(|r| r.id.as_str());
        for (option, twice) in [
            ("--control: point", twice(control())),
            ("--check: point", twice(check())),
            ("--positions: photograph", twice(self.positions.iter().map(|r| r.photo.as_str()))),
            ("--attitudes: photograph", twice(self.attitudes.iter().map(|r| r.photo.as_str()))),
        ] {
            if let Some(name) = twice {
                bail!("{option} `{name}` is there twice");
            }
        }
        if let Some(name) = twice(control().chain(check())) {
            bail!("point `{name}` is in --control and in --check");
        }
        let clicks = self.clicks.iter().map(|r| (r.photo.as_str(), r.id.as_str()));
        if let Some((photo, id)) = twice(clicks) {
            bail!("--clicks: point `{id}` is there twice in photograph `{photo}`");
        }
        Ok(())
    }
}

/// The first that was there before.
fn twice<T: Copy + Eq + std::hash::Hash>(mut list: impl Iterator<Item = T>) -> Option<T> {
    let mut seen = HashSet::new();
    list.find(|t| !seen.insert(*t))
}

/// Finds photographs by their name, or by it without folder and extension.
struct Names {
    exact: HashMap<String, usize>,
    /// None where two have the same.
    short: HashMap<String, Option<usize>>,
    some: String,
}

impl Names {
    fn new<'a>(names: impl Iterator<Item = &'a str> + Clone) -> Self {
        let mut short = HashMap::new();
        for (i, name) in names.clone().enumerate() {
            short.entry(stem(name).to_owned()).and_modify(|p| *p = None).or_insert(Some(i));
        }
        let exact = names.clone().enumerate().map(|(i, n)| (n.to_owned(), i)).collect();
        let more = if names.clone().count() > 5 { ", …" } else { "" };
        let some = names.take(5).collect::<Vec<_>>().join(", ") + more;
        Self { exact, short, some }
    }

    fn find(&self, option: &str, name: &str) -> Result<usize> {
        if let Some(place) = self.exact.get(name) {
            return Ok(*place);
        }
        match self.short.get(stem(name)) {
            Some(Some(place)) => Ok(*place),
            Some(None) => bail!(
                "{option}: photograph `{name}` may be one of several: there are {}",
                self.some
            ),
            None => {
                bail!("{option}: the block has no photograph `{name}`: there are {}", self.some)
            }
        }
    }
}

/// A file's name without folder and extension.
fn stem(name: &str) -> &str {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}

/// A point that was clicked.
struct Clicked<'a> {
    clicks: Vec<(usize, &'a ObservationRow)>,
    /// Where the rays meet, in the frame of the block.
    place: Result<Point3<f64>, String>,
}

impl Draft {
    /// Adds what was observed besides, after the block was brought to its frame.
    pub(crate) fn give(&mut self, given: &Given) -> Result<()> {
        if given.is_empty() {
            return Ok(());
        }
        given.unique()?;
        let names = Names::new(self.photographs.iter().map(|(name, _, _)| name.as_str()));
        let clicked = self.clicked(given, &names)?;
        let mut positions = Vec::new();
        for row in &given.positions {
            positions.push((names.find("--positions", &row.photo)?, row));
        }
        let mut attitudes = Vec::new();
        for row in &given.attitudes {
            attitudes.push((names.find("--attitudes", &row.photo)?, row));
        }
        for (option, list) in [
            ("--positions", positions.iter().map(|p| p.0).collect::<Vec<_>>()),
            ("--attitudes", attitudes.iter().map(|p| p.0).collect()),
        ] {
            if let Some(place) = twice(list.into_iter()) {
                bail!("{option}: photograph `{}` is there twice", self.photographs[place].0);
            }
        }
        if !attitudes.is_empty() && positions.is_empty() && given.control.is_empty() {
            bail!("--attitudes alone place no block: give --control or --positions too");
        }
        let moved =
            if given.in_place { None } else { self.placement(given, &clicked, &positions)? };
        if let Some((similarity, placed)) = &moved {
            self.move_by(similarity);
            self.known.placed = *placed;
        }
        let moved = moved.map(|(similarity, _)| similarity);
        self.add_clicked(given, &clicked, moved.as_ref())?;
        for (photograph, row) in positions {
            let lever = Vector3::from(row.lever_arm.unwrap_or(given.lever_arm));
            let antenna = (row.world.into(), lever, Precision::Sigmas(row.sigma));
            self.positions.push((photograph, antenna));
        }
        for (photograph, row) in attitudes {
            self.attitudes.push((photograph, attitude(row)));
        }
        if given.refraction || given.earth_curvature {
            self.correct(given)?;
        }
        Ok(())
    }

    /// The clicked points by name, each with the place where its rays meet.
    fn clicked<'a>(
        &mut self,
        given: &'a Given,
        names: &Names,
    ) -> Result<HashMap<&'a str, Clicked<'a>>> {
        let known: HashSet<&str> = (given.control.iter().chain(&given.check))
            .map(|r| r.id.as_str())
            .chain(given.distances.iter().flat_map(|r| &r.ends).map(String::as_str))
            .collect();
        let mut unknown = HashSet::new();
        let mut clicks: HashMap<&str, Vec<(usize, &ObservationRow)>> = HashMap::new();
        for row in &given.clicks {
            let photograph = names.find("--clicks", &row.photo)?;
            if !known.contains(row.id.as_str()) {
                if unknown.insert(row.id.as_str()) {
                    let why = "clicked, but in none of --control, --check, --distances";
                    self.known.left_out.push((row.id.clone(), why));
                }
                continue;
            }
            let list = clicks.entry(&row.id).or_default();
            if list.iter().any(|(other, _)| *other == photograph) {
                bail!("--clicks: point `{}` is there twice in photograph `{}`", row.id, row.photo);
            }
            list.push((photograph, row));
        }
        if let Some(end) =
            given.distances.iter().flat_map(|r| &r.ends).find(|e| !clicks.contains_key(e.as_str()))
        {
            bail!("--distances: point `{end}` is clicked in no photograph");
        }
        let with_place = |(id, clicks): (_, Vec<(usize, &'a ObservationRow)>)| {
            let place = self.meeting(&clicks);
            (id, Clicked { clicks, place })
        };
        Ok(clicks.into_iter().map(with_place).collect())
    }

    fn frame(&self, photograph: usize) -> Frame<BrownCamera> {
        let (_, exterior, camera) = &self.photographs[photograph];
        Frame::new(*exterior, self.cameras[*camera].1)
    }

    /// Where the rays of clicks meet.
    fn meeting(&self, clicks: &[(usize, &ObservationRow)]) -> Result<Point3<f64>, String> {
        if clicks.len() < 2 {
            return Err("clicked in 1 photograph, 2 needed".to_owned());
        }
        let frames: Vec<_> = clicks.iter().map(|(photograph, _)| self.frame(*photograph)).collect();
        let rays: Vec<_> = (frames.iter().zip(clicks))
            .map(|(frame, (_, row))| {
                ImageObservation::new(frame, Point2::from(row.image))
                    .with_precision(self.precision(row.sigma))
            })
            .collect();
        let found = intersect(&rays, &IntersectionOptions::default());
        found.map(|f| f.point).map_err(|e| reason(&e))
    }

    /// The similarity to the frame of what is given.
    fn placement(
        &self,
        given: &Given,
        clicked: &HashMap<&str, Clicked<'_>>,
        positions: &[(usize, &PositionRow)],
    ) -> Result<Option<(Similarity, Option<Placed>)>> {
        if given.control.is_empty() && positions.is_empty() {
            return self.scaling(given, clicked);
        }
        let (mut pairs, mut without) = (Vec::new(), Vec::new());
        for row in &given.control {
            match clicked.get(row.id.as_str()).map(|c| &c.place) {
                Some(Ok(place)) => pairs.push(PointPair::new(*place, row.world.into())),
                Some(Err(why)) => without.push(format!("`{}` {why}", row.id)),
                None => without.push(format!("`{}` clicked in no photograph", row.id)),
            }
        }
        let points = pairs.len();
        // A photograph that is going to be left out says nothing of the block's place.
        let usable = self.usable(false);
        let positions: Vec<_> = positions.iter().filter(|(p, _)| usable[*p].1).collect();
        for (photograph, row) in &positions {
            let center = self.photographs[*photograph].1.projection_center();
            pairs.push(PointPair::new(center, row.world.into()));
        }
        let hint = "with --placed it is adjusted where it is";
        if pairs.len() < NEEDED {
            let more = if without.len() > 5 { ", …" } else { "" };
            without.truncate(5);
            let without = if without.is_empty() {
                String::new()
            } else {
                format!(": {}{more}", without.join(", "))
            };
            bail!(
                "the block cannot be placed by {points} control points clicked in two photographs and {} positions, {NEEDED} needed{without}; {hint}",
                positions.len()
            );
        }
        let options = AbsoluteOrientationOptions::default();
        let found = absolute_orientation(&pairs, &options)
            .map_err(|e| anyhow!("the block cannot be placed: {}; {hint}", reason(&e)))?;
        let squares = pairs.iter().map(|p| (found.similarity.apply(&p.from) - p.to).norm_squared());
        let placed = Placed {
            points,
            positions: positions.len(),
            scale: found.similarity.scale(),
            rms: (squares.sum::<f64>() / pairs.len() as f64).sqrt(),
        };
        Ok(Some((found.similarity, Some(placed))))
    }

    /// The scale that distances alone give, the block's first projection centre staying where it is.
    fn scaling(
        &self,
        given: &Given,
        clicked: &HashMap<&str, Clicked<'_>>,
    ) -> Result<Option<(Similarity, Option<Placed>)>> {
        let (mut given_sum, mut block_sum) = (0.0, 0.0);
        for row in &given.distances {
            let [a, b] = row
                .ends
                .each_ref()
                .map(|end| clicked.get(end.as_str()).and_then(|c| c.place.as_ref().ok()));
            if let (Some(a), Some(b)) = (a, b) {
                given_sum += row.length;
                block_sum += (a - b).norm();
            }
        }
        let center = self.photographs.first().map(|(_, e, _)| e.projection_center());
        let (Some(center), true) = (center, block_sum > 0.0) else { return Ok(None) };
        let similarity =
            Similarity::new(given_sum / block_sum, Rotation3::identity(), center, center);
        Ok(Some((similarity.map_err(|e| anyhow!("--distances: {}", reason(&e)))?, None)))
    }

    fn move_by(&mut self, similarity: &Similarity) {
        for (_, exterior, _) in &mut self.photographs {
            let pose = similarity.apply_to_pose(exterior.pose());
            *exterior = ExteriorOrientation::new(pose.origin, pose.rotation);
        }
        for (_, point, _) in &mut self.points {
            *point = similarity.apply(point);
        }
    }

    /// Adds control points, check points and ends of distances with their images.
    fn add_clicked(
        &mut self,
        given: &Given,
        clicked: &HashMap<&str, Clicked<'_>>,
        moved: Option<&Similarity>,
    ) -> Result<()> {
        let meeting = |c: &Clicked<'_>| {
            c.place.clone().map(|p| moved.map_or(p, |similarity| similarity.apply(&p)))
        };
        self.own_points = self.points.len();
        let mut places: HashMap<&str, usize> = HashMap::new();
        let control = given.control.iter().map(|row| (row, true));
        for (row, control) in control.chain(given.check.iter().map(|row| (row, false))) {
            let Some(clicked) = clicked.get(row.id.as_str()) else {
                self.known.left_out.push((row.id.clone(), "clicked in no photograph"));
                continue;
            };
            let world = Point3::from(row.world);
            let (start, kind) = match (control, row.sigma) {
                (true, Some(sigma)) => (world, Kind::Control(Precision::Sigmas(sigma))),
                (true, None) => (world, Kind::Exact),
                (false, _) => (meeting(clicked).unwrap_or(world), Kind::Pass),
            };
            let list = match kind {
                Kind::Control(_) => Some(&mut self.known.control),
                Kind::Exact => Some(&mut self.known.exact),
                Kind::Pass => None,
            };
            let place = self.points.len();
            match list {
                Some(list) => list.push(place),
                None => self.known.check.push((place, world)),
            }
            self.points.push((row.id.clone(), start, kind));
            places.insert(&row.id, place);
            self.click(place, clicked);
        }
        for row in &given.distances {
            let mut ends = [0; 2];
            for (end, name) in ends.iter_mut().zip(&row.ends) {
                if let Some(place) = places.get(name.as_str()) {
                    *end = *place;
                    continue;
                }
                let Some(clicked) = clicked.get(name.as_str()) else { continue };
                let start = meeting(clicked)
                    .map_err(|why| anyhow!("--distances: point `{name}`: {why}"))?;
                *end = self.points.len();
                self.points.push((name.clone(), start, Kind::Pass));
                places.insert(name, *end);
                self.click(*end, clicked);
            }
            self.known.distances.push((ends, row.length));
            self.distance_sigmas.push(row.sigma);
        }
        Ok(())
    }

    fn click(&mut self, point: usize, clicked: &Clicked<'_>) {
        for (photograph, row) in &clicked.clicks {
            self.observe(*photograph, point, row.image, row.sigma);
        }
    }

    /// Corrects image points for air and the Earth's curvature, by the approximate orientations.
    fn correct(&mut self, given: &Given) -> Result<()> {
        let (option, heights) = (
            if given.refraction { "--refraction" } else { "--earth-curvature" },
            given.control.iter().map(|row| row.world[2]),
        );
        if given.control.is_empty() {
            bail!("{option}: the ground's height is that of the control points: give --control");
        }
        let ground = heights.sum::<f64>() / given.control.len() as f64;
        let mut models = Vec::new();
        for (name, exterior, _) in &self.photographs {
            let camera = exterior.projection_center().z;
            let named =
                |e: collinear::Error| anyhow!("{option}: photograph {name}: {}", reason(&e));
            let air = given.refraction.then(|| Refraction::standard_atmosphere(camera, ground));
            // Maps have lengths at sea level.
            let earth = given.earth_curvature.then(|| {
                EarthCurvature::new(EARTH, camera, ground).and_then(|e| e.with_lengths_at(0.0))
            });
            models.push((air.transpose().map_err(named)?, earth.transpose().map_err(named)?));
        }
        let up = Vector3::z_axis();
        for i in 0..self.observations.len() {
            let (photograph, point) = (self.observations[i].photograph, self.observations[i].point);
            let (frame, (air, earth)) = (self.frame(photograph), &models[photograph]);
            let mut at = Ok(self.observations[i].at);
            if let Some(air) = air {
                at = at.and_then(|at| air.corrected(&frame, &up, &at));
            }
            if let Some(earth) = earth {
                at = at.and_then(|at| earth.corrected(&frame, &up, &at));
            }
            let (photograph, point) = (&self.photographs[photograph].0, &self.points[point].0);
            self.observations[i].corrected =
                at.map_err(|e| anyhow!("{option}: point {point} in photograph {photograph}: {e}"))?;
        }
        Ok(())
    }
}

/// camera_from_world of a photograph, and the precision of a turn about the camera's axes.
fn attitude(row: &AttitudeRow) -> (Rotation3<f64>, Precision<3>) {
    let exterior = ExteriorOrientation::from_omega_phi_kappa(Point3::origin(), &row.angles);
    let turn = exterior.rotation_from_omega_phi_kappa();
    let variances = Matrix3::from_diagonal(&Vector3::from(row.sigma.map(|s| s * s)));
    let covariance = turn * variances * turn.transpose();
    // Rounding would leave it unsymmetric.
    let covariance = (covariance + covariance.transpose()) * 0.5;
    (exterior.camera_from_world(), Precision::Covariance(covariance))
}
