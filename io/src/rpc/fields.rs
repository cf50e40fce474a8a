//! The ninety-two numbers of a camera, as a reader meets them.

use collinear::camera::rpc::Rpc00b;

use super::RpcFile;
use crate::error::{Error, RpcProblem};

/// How a format names the numbers, in the order of [`Fields`].
pub(super) struct Names {
    pub(super) scalars: [&'static str; 12],
    pub(super) polynomials: [&'static str; 4],
    /// The index of the first coefficient, where each stands on a line of its own.
    pub(super) first: usize,
}

/// The numbers found so far: ten offsets and scales, the two errors, the four polynomials.
pub(super) struct Fields<'a> {
    names: &'a Names,
    scalars: [Option<f64>; 12],
    polynomials: [[Option<f64>; 20]; 4],
}

/// The scalars that must be there: the offsets and scales come first.
const NEEDED: usize = 10;

impl<'a> Fields<'a> {
    pub(super) fn new(names: &'a Names) -> Self {
        Self { names, scalars: [None; 12], polynomials: [[None; 20]; 4] }
    }

    /// Takes a number if the format knows its name. `false`: it is none of a camera's.
    pub(super) fn scalar(&mut self, name: &str, line: usize, text: &str) -> Result<bool, Error> {
        let Some(i) = self.names.scalars.iter().position(|n| *n == name) else {
            return Ok(false);
        };
        put(&mut self.scalars[i], name, line, text)?;
        Ok(true)
    }

    /// Takes one coefficient, as `LINE_NUM_COEFF_1`.
    pub(super) fn coefficient(
        &mut self,
        name: &str,
        line: usize,
        text: &str,
    ) -> Result<bool, Error> {
        let Some((polynomial, index)) = name.rsplit_once('_') else { return Ok(false) };
        let Some(p) = self.names.polynomials.iter().position(|n| *n == polynomial) else {
            return Ok(false);
        };
        let place = index.parse::<usize>().ok().and_then(|i| i.checked_sub(self.names.first));
        let Some(slot) = place.and_then(|i| self.polynomials[p].get_mut(i)) else {
            let expected = "twenty coefficients, counted as the format does";
            return Err(RpcProblem::Convention {
                line,
                field: polynomial.to_owned(),
                found: short(index),
                expected,
            }
            .into());
        };
        put(slot, name, line, text)?;
        Ok(true)
    }

    /// Takes a whole polynomial.
    pub(super) fn polynomial<'t>(
        &mut self,
        name: &str,
        line: usize,
        texts: impl Iterator<Item = &'t str>,
    ) -> Result<bool, Error> {
        let Some(p) = self.names.polynomials.iter().position(|n| *n == name) else {
            return Ok(false);
        };
        let field = || name.to_owned();
        let mut found = 0;
        for text in texts {
            if let Some(slot) = self.polynomials[p].get_mut(found) {
                put(slot, name, line, text)?;
            }
            found += 1;
        }
        if found != 20 {
            return Err(RpcProblem::Coefficients { line, field: field(), found }.into());
        }
        Ok(true)
    }

    /// Whether a number has been found.
    pub(super) fn any(&self) -> bool {
        self.scalars.iter().chain(self.polynomials.as_flattened()).any(Option::is_some)
    }

    /// The camera, once every number is there and the library takes them. `order` brings a polynomial to RPC00B.
    pub(super) fn finish(self, order: impl Fn(&[f64; 20]) -> [f64; 20]) -> Result<RpcFile, Error> {
        let missing = |field: String| RpcProblem::Missing { field };
        let mut s = [0.0; NEEDED];
        for (i, value) in s.iter_mut().enumerate() {
            *value = self.scalars[i].ok_or_else(|| missing(self.names.scalars[i].to_owned()))?;
        }
        let mut c = [[0.0; 20]; 4];
        for (p, polynomial) in c.iter_mut().enumerate() {
            for (i, value) in polynomial.iter_mut().enumerate() {
                *value = self.polynomials[p][i].ok_or_else(|| {
                    let name = self.names.polynomials[p];
                    missing(format!("{name}_{:02}", i + self.names.first))
                })?;
            }
            *polynomial = order(polynomial);
        }
        let file = RpcFile::from_record(&Rpc00b {
            line_offset: s[0],
            sample_offset: s[1],
            latitude_offset_deg: s[2],
            longitude_offset_deg: s[3],
            height_offset: s[4],
            line_scale: s[5],
            sample_scale: s[6],
            latitude_scale_deg: s[7],
            longitude_scale_deg: s[8],
            height_scale: s[9],
            line_numerator: c[0],
            line_denominator: c[1],
            sample_numerator: c[2],
            sample_denominator: c[3],
            // Unknown is written as −1 by some.
            error_bias: self.scalars[10].filter(|v| *v >= 0.0),
            error_random: self.scalars[11].filter(|v| *v >= 0.0),
        });
        file.rpc()?;
        Ok(file)
    }
}

fn put(slot: &mut Option<f64>, field: &str, line: usize, text: &str) -> Result<(), Error> {
    if slot.is_some() {
        return Err(RpcProblem::Duplicate { line, field: field.to_owned() }.into());
    }
    let value = text.parse().ok().filter(|v: &f64| v.is_finite());
    let problem = || RpcProblem::NotANumber { line, field: field.to_owned(), text: short(text) };
    *slot = Some(value.ok_or_else(problem)?);
    Ok(())
}

/// The start of a text, for a message.
pub(super) fn short(text: &str) -> String {
    text.chars().take(40).collect()
}
