//! Writes a synthetic aerial block as a problem of *Bundle Adjustment in the Large*.
//!
//! ```text
//! block CAMERAS OBSERVATIONS SEED OUT.txt [--overlap ALONG,ACROSS] [--shuffled] [--truth TRUTH.txt]
//! ```
//! The overlap is in percent, 60,30 if nothing is said. `--shuffled` numbers photographs and points at random.

use std::error::Error;

use collinear_peers::synthetic::{Plan, block};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut plain, mut truth) = (vec![], None);
    let mut plan = Plan::new(0, 0, 0);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--shuffled" => plan.shuffled = true,
            "--truth" => truth = Some(value()?),
            "--overlap" => {
                let value = value()?;
                let (along, across) = value.split_once(',').ok_or("two numbers")?;
                plan.overlap = [along.parse::<f64>()? / 100.0, across.parse::<f64>()? / 100.0];
            }
            _ => plain.push(argument),
        }
    }
    let [cameras, observations, seed, out] = &plain[..] else {
        return Err("name the numbers of cameras and observations, a seed and a file".into());
    };
    plan.cameras = cameras.parse()?;
    plan.observations = observations.parse()?;
    plan.seed = seed.parse()?;
    let made = block(&plan)?;
    made.start.write(out.as_ref())?;
    if let Some(path) = truth {
        made.truth.write(path.as_ref())?;
    }
    Ok(())
}
