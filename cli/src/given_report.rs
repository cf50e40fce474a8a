//! The protocol of what was observed of a block besides image points.

use std::fmt::Write;

use anyhow::{Result, anyhow};
use collinear::adjust::bundle::{CheckPoints, Observation, PointId, VarianceComponent};
use collinear::adjust::{CRITICAL_VALUE, ObservationReport};
use collinear::nalgebra::Point3;
use serde_json::{Value, json};

use crate::adjust::{LISTED, Outcome};
use crate::block::Block;
use crate::protocol::{Table, decimals_for, fixed, number};
use crate::reason::reason;

/// Kinds of observations with a precision of their own, by the number of their group.
const GROUPS: [(&str, &str); 7] = [
    ("image points", "image_points"),
    ("clicks", "clicks"),
    ("control points", "control_points"),
    ("positions", "positions"),
    ("attitudes", "attitudes"),
    ("distances", "distances"),
    ("parameters", "parameters"),
];

/// The group of an observation.
pub(crate) fn group(block: &Block, of: Observation) -> usize {
    match of {
        Observation::ImagePoint(i) => usize::from(i + block.clicks >= block.observations.len()),
        Observation::ControlPoint(_) => 2,
        Observation::Position(_) => 3,
        Observation::Attitude(_) => 4,
        Observation::Distance(_) => 5,
        _ => 6,
    }
}

/// How the precision of a kind of observations was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// What is left at the end, of the precisions found: σ̂ is 1.
    pub component: VarianceComponent,
    /// What the stated standard deviations were multiplied with.
    pub factor: f64,
}

/// Why a group's precision was not found.
pub(crate) fn unknown_precision(group: usize, factor: f64) -> String {
    let (name, _) = GROUPS[group.min(6)];
    if factor < 1.0 {
        format!(
            "--variances: the {name} agree with the rest better than any precision explains; \
             with so few of them state a precision and leave --variances off"
        )
    } else {
        format!("--variances: nothing controls the {name}, so that nothing tells their precision")
    }
}

/// Check points against their known places; none where there are no check points.
pub(crate) fn check(
    block: &Block,
    adjusted: &collinear::adjust::bundle::Adjusted<collinear::camera::BrownCamera>,
) -> Result<Option<CheckPoints>> {
    let ids: Vec<PointId> = block.bundle.point_ids().collect();
    let known: Vec<(PointId, Point3<f64>)> = (block.known.check.iter())
        .filter_map(|(place, at)| Some((*ids.get(*place)?, *at)))
        .collect();
    if known.is_empty() {
        return Ok(None);
    }
    adjusted.check(&known).map(Some).map_err(|e| anyhow!("--check: {}", reason(&e)))
}

/// A name with the reports of its numbers.
type Named = (String, Vec<ObservationReport>);

/// Radians to degrees for attitudes.
fn in_degrees(report: &ObservationReport) -> ObservationReport {
    let [residual, detectable] = [report.residual, report.detectable].map(f64::to_degrees);
    ObservationReport { residual, detectable, ..*report }
}

/// Decimals that show three digits of the largest.
fn decimals(values: impl Iterator<Item = f64>) -> usize {
    decimals_for(values.map(f64::abs).filter(|v| v.is_finite()).fold(0.0, f64::max)).clamp(2, 6)
}

impl Outcome {
    /// The names of control points with a precision and of photographs with positions or attitudes, each with its reports; attitudes in
    /// degrees.
    fn observed(&self, block: &Block) -> [(usize, Vec<Named>); 4] {
        let Some(quality) = &self.quality else { return [2, 3, 4, 5].map(|g| (g, vec![])) };
        let photograph = |i: usize| block.photographs.get(i).cloned().unwrap_or_default();
        let point = |i: usize| block.points.get(i).cloned().unwrap_or_default();
        let control = quality.control_points.iter();
        let distance = |(i, report): (usize, &ObservationReport)| {
            let ends = block.known.distances.get(i).map(|(ends, _)| ends.map(point));
            let [from, to] = ends.unwrap_or_default();
            (format!("{from} – {to}"), vec![*report])
        };
        [
            (2, control.map(|(id, r)| (point(id.number()), r.to_vec())).collect()),
            (
                3,
                quality
                    .positions
                    .iter()
                    .map(|(id, r)| (photograph(id.number()), r.to_vec()))
                    .collect(),
            ),
            (
                4,
                (quality.attitudes.iter())
                    .map(|(id, r)| (photograph(id.number()), r.iter().map(in_degrees).collect()))
                    .collect(),
            ),
            (5, quality.distances.iter().enumerate().map(distance).collect()),
        ]
    }

    /// For each point its image points that take part, and their root mean square, pixels.
    fn of_points(&self, block: &Block) -> Vec<(usize, f64)> {
        self.sums(block, block.points.len(), |(_, point, _)| *point)
    }

    /// How the block was placed, and what was left out.
    pub(crate) fn write_placed(&self, block: &Block, text: &mut String) {
        for (name, why) in &block.known.left_out {
            let _ = writeln!(text, "left out         point {name}: {why}");
        }
        if let Some(placed) = &block.known.placed {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "placed by        {} control points, {} positions: scale {:.6}, rms {} before the adjustment",
                placed.points,
                placed.positions,
                placed.scale,
                fixed(placed.rms, decimals_for(placed.rms).clamp(2, 6))
            );
        }
    }

    /// Tables of control points, positions, attitudes, distances, check points and variance components.
    pub(crate) fn write_given(&self, block: &Block, text: &mut String) {
        let points = self.of_points(block);
        let observed = self.observed(block);
        let exact = block.known.exact.iter();
        if self.quality.is_some() && !(block.known.exact.is_empty() && observed[0].1.is_empty()) {
            text.push_str("\ncontrol points (v: given minus adjusted, world units; the rays' rms in pixels)\n");
            let mut table = Table::new(&[
                "point", "rays", "rms px", "v X", "v Y", "v Z", "r X", "r Y", "r Z", "w X", "w Y",
                "w Z",
            ]);
            let start = |place: usize| {
                let (rays, rms) = points[place];
                vec![block.points[place].clone(), rays.to_string(), fixed(rms, 3)]
            };
            for place in exact {
                let mut cells = start(*place);
                cells.push("exact".to_owned());
                table.row(cells);
            }
            let all = observed[0].1.iter().flat_map(|(_, r)| r).map(|r| r.residual);
            let decimals = decimals(all);
            for (place, (_, reports)) in block.known.control.iter().zip(&observed[0].1) {
                let mut cells = start(*place);
                append(&mut cells, reports, decimals);
                table.row(cells);
            }
            table.write(text);
        }
        for ((_, list), (title, columns)) in observed.iter().skip(1).zip([
            (
                "positions (v: given minus adjusted, world units)",
                &["photograph", "v X", "v Y", "v Z", "r X", "r Y", "r Z", "w X", "w Y", "w Z"][..],
            ),
            (
                "attitudes (v: given minus adjusted, turns about the camera's axes in degrees)",
                &["photograph", "v x", "v y", "v z", "r x", "r y", "r z", "w x", "w y", "w z"],
            ),
            ("distances (v: given minus adjusted, world units)", &["from – to", "v", "r", "w"]),
        ]) {
            if list.is_empty() {
                continue;
            }
            let _ = writeln!(text, "\n{title}");
            let mut table = Table::new(columns);
            let decimals = decimals(list.iter().flat_map(|(_, r)| r).map(|r| r.residual));
            for (name, reports) in list {
                let mut cells = vec![name.clone()];
                append(&mut cells, reports, decimals);
                table.row(cells);
            }
            table.write(text);
        }
        self.write_check(block, &points, text);
        self.write_components(text);
    }

    fn write_check(&self, block: &Block, points: &[(usize, f64)], text: &mut String) {
        let Some(check) = &self.check else { return };
        text.push_str(if block.known.places() {
            "\ncheck points (adjusted minus known, world units)\n"
        } else {
            "\ncheck points (adjusted minus known, in the block's own frame: nothing that was given places it)\n"
        });
        let mut table = Table::new(&["point", "rays", "d X", "d Y", "d Z"]);
        let decimals = decimals([check.largest].into_iter());
        for (id, d) in &check.differences {
            let place = id.number();
            let mut cells = vec![block.points[place].clone(), points[place].0.to_string()];
            cells.extend(d.iter().map(|d| fixed(*d, decimals)));
            table.row(cells);
        }
        for (name, d) in [("mean", check.mean), ("rms", check.rms)] {
            let mut cells = vec![name.to_owned(), String::new()];
            cells.extend(d.iter().map(|d| fixed(*d, decimals)));
            table.row(cells);
        }
        table.write(text);
        let _ = writeln!(text, "  largest distance {}", fixed(check.largest, decimals));
        for id in &check.undetermined {
            let name = &block.points[id.number()];
            let _ = writeln!(text, "  {name}: fewer than two photographs determine it");
        }
    }

    fn write_components(&self, text: &mut String) {
        let Some(components) = &self.components else { return };
        text.push_str(
            "\nprecisions found (sigma: what the stated standard deviations are multiplied with)\n",
        );
        let mut table = Table::new(&["group", "numbers", "redundancy", "sigma", "uncertainty"]);
        for Component { component, factor } in components {
            table.row(vec![
                GROUPS[component.group.min(6)].0.to_owned(),
                component.observations.to_string(),
                fixed(component.redundancy, 1),
                fixed(*factor, 4),
                fixed(factor * component.uncertainty(), 4),
            ]);
        }
        table.write(text);
    }

    /// The numbers besides image points with a test beyond the critical value, the largest first: kind, name, component.
    fn given_suspects(
        &self,
        block: &Block,
    ) -> Vec<(usize, String, &'static str, ObservationReport)> {
        let mut list = Vec::new();
        for (group, observed) in self.observed(block) {
            let names: &[&'static str] = match group {
                2 | 3 => &["X", "Y", "Z"],
                4 => &["x", "y", "z"],
                _ => &["length"],
            };
            for (name, reports) in observed {
                let beyond = names.iter().zip(reports).filter(|(_, r)| r.w.abs() > CRITICAL_VALUE);
                list.extend(beyond.map(|(component, r)| (group, name.clone(), *component, r)));
            }
        }
        list.sort_by(|a, b| b.3.w.abs().total_cmp(&a.3.w.abs()));
        list
    }

    /// The suspects among them.
    pub(crate) fn write_given_suspects(&self, block: &Block, text: &mut String) {
        let observed = self.observed(block);
        let count: usize = observed.iter().flat_map(|(_, l)| l).map(|(_, r)| r.len()).sum();
        if count == 0 {
            return;
        }
        let suspects = self.given_suspects(block);
        let _ = writeln!(
            text,
            "\nother observations with a test beyond {CRITICAL_VALUE:.2}: {} of {count}{}",
            suspects.len(),
            if suspects.len() > LISTED { ", the largest" } else { "" }
        );
        if suspects.is_empty() {
            return;
        }
        let mut table = Table::new(&["of", "name", "", "v", "r", "w"]);
        let decimals = decimals(suspects.iter().map(|s| s.3.residual));
        for (group, name, component, r) in suspects.into_iter().take(LISTED) {
            let mut cells = vec![GROUPS[group].0.to_owned(), name, component.to_owned()];
            append(&mut cells, &[r], decimals);
            table.row(cells);
        }
        table.write(text);
    }

    /// All of it for machines: fields of the protocol's object.
    pub(crate) fn given_json(&self, block: &Block) -> Vec<(&'static str, Value)> {
        let points = self.of_points(block);
        let observed = self.observed(block);
        let rows = |list: &[Named], key: &str, unit: &str| -> Value {
            let rows = list.iter().map(|(name, r)| {
                let mut row = reports(r, unit);
                row[key] = json!(name);
                row
            });
            rows.collect()
        };
        let mut control: Vec<Value> = (block.known.exact.iter())
            .map(|place| json!({ "point": block.points[*place], "rays": points[*place].0, "exact": true }))
            .collect();
        for (place, (name, r)) in block.known.control.iter().zip(&observed[0].1) {
            let mut row = reports(r, "residual");
            row["point"] = json!(name);
            row["rays"] = json!(points[*place].0);
            row["exact"] = json!(false);
            control.push(row);
        }
        let distances: Vec<Value> = (block.known.distances.iter().zip(&observed[3].1))
            .map(|((ends, length), (_, r))| {
                let mut row = reports(r, "residual");
                row["from"] = json!(block.points[ends[0]]);
                row["to"] = json!(block.points[ends[1]]);
                row["length"] = json!(length);
                row
            })
            .collect();
        let suspects: Vec<Value> = (self.given_suspects(block).into_iter())
            .map(|(group, name, component, r)| {
                json!({
                    "kind": GROUPS[group].1, "name": name, "component": component,
                    "w": number(r.w), "redundancy": number(r.redundancy),
                })
            })
            .collect();
        let check = self.check.as_ref().map(|check| {
            let three = |d: &collinear::nalgebra::Vector3<f64>| -> Vec<Value> {
                d.iter().map(|v| number(*v)).collect()
            };
            let name = |id: &PointId| &block.points[id.number()];
            let differences: Vec<Value> = (check.differences.iter())
                .map(|(id, d)| json!({ "point": name(id), "rays": points[id.number()].0, "difference": three(d) }))
                .collect();
            json!({
                "differences": differences, "mean": three(&check.mean), "rms": three(&check.rms),
                "largest": number(check.largest),
                "undetermined": check.undetermined.iter().map(name).collect::<Vec<_>>(),
            })
        });
        let components = self.components.as_ref().map(|list| -> Value {
            let list = list.iter().map(|Component { component, factor }| {
                json!({
                    "group": GROUPS[component.group.min(6)].1, "numbers": component.observations,
                    "redundancy": number(component.redundancy), "sigma": number(*factor),
                    "uncertainty": number(factor * component.uncertainty()),
                })
            });
            list.collect()
        });
        let placed = block.known.placed.map(|p| {
            json!({ "control_points": p.points, "positions": p.positions, "scale": p.scale, "rms": number(p.rms) })
        });
        vec![
            ("datum", json!(if block.known.places() { "given" } else { "free" })),
            ("placed", json!(placed)),
            (
                "left_out_points",
                block
                    .known
                    .left_out
                    .iter()
                    .map(|(n, why)| json!({ "point": n, "reason": why }))
                    .collect(),
            ),
            ("control_points", json!(control)),
            ("positions", rows(&observed[1].1, "photograph", "residual")),
            ("attitudes", rows(&observed[2].1, "photograph", "residual_deg")),
            ("distances", json!(distances)),
            ("given_suspects", json!(suspects)),
            ("check_points", json!(check)),
            ("variance_components", json!(components)),
        ]
    }
}

/// v, r and w of some numbers.
fn append(cells: &mut Vec<String>, reports: &[ObservationReport], decimals: usize) {
    cells.extend(reports.iter().map(|r| fixed(r.residual, decimals)));
    cells.extend(reports.iter().map(|r| fixed(r.redundancy, 3)));
    cells.extend(reports.iter().map(|r| fixed(r.w, 2)));
}

/// The same for machines, the residual under a name that says its unit.
fn reports(list: &[ObservationReport], residual: &str) -> Value {
    let all = |f: &dyn Fn(&ObservationReport) -> f64| -> Value {
        list.iter().map(|r| number(f(r))).collect()
    };
    let mut row = json!({ "redundancy": all(&|r| r.redundancy), "w": all(&|r| r.w) });
    row[residual] = all(&|r| r.residual);
    row
}
