//! The new view, resampled from the photographs on disk and compared with direct casting.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use crate::brute_force::caster::{Sight, Town, in_parallel};
use crate::brute_force::picture::{Image, write_png};

struct Verdict {
    textured: [f64; 3],
    cast: [f64; 3],
    sight: Sight,
    polygon: Option<usize>,
}

pub(crate) fn run(town: &Town, directory: &Path) -> Result<(), Box<dyn Error>> {
    let images = town
        .photographs
        .iter()
        .map(|p| Image::read(&directory.join(format!("{}.png", p.name))))
        .collect::<Result<Vec<_>, _>>()?;
    let view = &town.view;
    let rows = in_parallel(view.height, |y| {
        (0..view.width)
            .map(|x| {
                let hit = town.look(view, (x as f64 + 0.5, y as f64 + 0.5));
                let cast = town.pixel(view, x, y);
                let place = hit.and_then(|h| {
                    let photograph = town.assigned[h.polygon];
                    Some((photograph, town.photographs[photograph].camera.project(h.point)?))
                });
                let textured = place.map_or([0.0; 3], |(i, p)| images[i].bilinear(p));
                let polygon = hit.map(|h| h.polygon);
                Verdict { textured, cast, sight: town.sight(view, x, y), polygon }
            })
            .collect::<Vec<_>>()
    });
    let all: Vec<Verdict> = rows.into_iter().flatten().collect();
    report(town, &all);
    let pick = |f: fn(&Verdict) -> [f64; 3]| all.iter().map(f).collect::<Vec<_>>();
    write_png(&directory.join("check-textured.png"), view, &pick(|v| v.textured))?;
    write_png(&directory.join("check-cast.png"), view, &pick(|v| v.cast))?;
    write_png(
        &directory.join("check-error.png"),
        view,
        &pick(|v| {
            let shade = match v.sight {
                Sight::Unoccluded => [0.0, 0.0, 0.0],
                Sight::NearEdge => [0.0, 40.0, 0.0],
                Sight::Hidden => [150.0, 0.0, 0.0],
                Sight::Background => [0.0, 0.0, 150.0],
            };
            let error = difference(v) * 20.0;
            shade.map(|s| if v.sight == Sight::Unoccluded { f64::min(error, 255.0) } else { s })
        }),
    )?;
    Ok(())
}

/// Mean over the channels, both rounded to 8 bits.
fn difference(v: &Verdict) -> f64 {
    let pairs = v.textured.iter().zip(&v.cast);
    pairs.map(|(a, b)| ((a + 0.5).floor() - (b + 0.5).floor()).abs()).sum::<f64>() / 3.0
}

fn report(town: &Town, all: &[Verdict]) {
    let count = |s: Sight| all.iter().filter(|v| v.sight == s).count() as f64 / all.len() as f64;
    for sight in [Sight::Unoccluded, Sight::NearEdge, Sight::Hidden, Sight::Background] {
        eprintln!("{sight:?}: {:.3} %", 100.0 * count(sight));
    }
    let mut errors: Vec<f64> =
        all.iter().filter(|v| v.sight == Sight::Unoccluded).map(difference).collect();
    errors.sort_by(f64::total_cmp);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
    eprintln!(
        "unoccluded: mean {mean:.4}, median {:.3}, 95 % {:.3}, 99 % {:.3}, largest {:.3} of 255",
        at(0.5),
        at(0.95),
        at(0.99),
        at(1.0)
    );
    let seen: Vec<f64> = all
        .iter()
        .filter(|v| matches!(v.sight, Sight::Unoccluded | Sight::NearEdge))
        .map(difference)
        .collect();
    eprintln!("seen, edges too: mean {:.4}", seen.iter().sum::<f64>() / seen.len() as f64);
    // Which things hide most pixels, and which differ most.
    let mut hidden: BTreeMap<&str, f64> = BTreeMap::new();
    let mut wrong: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for v in all {
        let Some(polygon) = v.polygon else { continue };
        let name = town.polygons[polygon].name.as_str();
        if v.sight == Sight::Hidden {
            *hidden.entry(name).or_default() += 1.0;
        } else if v.sight == Sight::Unoccluded {
            let entry = wrong.entry(name).or_default();
            *entry = (entry.0 + difference(v), entry.1 + 1.0);
        }
    }
    let mut hidden: Vec<_> = hidden.into_iter().collect();
    hidden.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (name, pixels) in hidden.iter().take(25) {
        eprintln!("  hidden {pixels:6} {name}");
    }
    let mut wrong: Vec<_> = wrong.into_iter().collect();
    wrong.sort_by(|a, b| b.1.0.total_cmp(&a.1.0));
    for (name, (sum, pixels)) in wrong.iter().take(25) {
        eprintln!("  error {:.3} over {pixels:6} {name}", sum / pixels);
    }
}
