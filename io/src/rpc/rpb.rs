//! DigitalGlobe's `.RPB`: statements `name = value;` in a group, lists in parentheses.

use std::fmt::Write;

use collinear::camera::rpc::Rpc00b;

use super::RpcFile;
use super::fields::{Fields, Names, short};
use super::text::numbers;
use crate::error::{Error, RpcProblem};

const RPB: Names = Names {
    scalars: [
        "lineOffset",
        "sampOffset",
        "latOffset",
        "longOffset",
        "heightOffset",
        "lineScale",
        "sampScale",
        "latScale",
        "longScale",
        "heightScale",
        "errBias",
        "errRand",
    ],
    polynomials: ["lineNumCoef", "lineDenCoef", "sampNumCoef", "sampDenCoef"],
    first: 1,
};

/// Parses an RPB. Other names are passed over.
///
/// # Errors
/// As [`read`](super::read); [`RpcProblem::Convention`] for a `SpecId` that is neither RPC00A nor RPC00B.
pub fn parse_rpb(text: &str) -> Result<RpcFile, Error> {
    let mut fields = Fields::new(&RPB);
    let mut older = false;
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
    while let Some((line, start)) = lines.next() {
        let group = ["BEGIN_GROUP", "END_GROUP"].iter().any(|word| start.starts_with(word));
        if start.is_empty() || group || start.trim_end_matches(';') == "END" {
            continue;
        }
        let expected = "name = value;";
        let wrong = || RpcProblem::Statement { line, text: short(start), expected };
        let (name, first) = start.split_once('=').ok_or_else(wrong)?;
        let name = name.trim();
        // A list goes on over the lines, to the semicolon.
        let mut value = first.to_owned();
        while !value.contains(';') {
            let (_, more) = lines.next().ok_or_else(wrong)?;
            value.push(' ');
            value.push_str(more);
        }
        let value = value.split(';').next().unwrap_or_default().trim();
        if name == "SpecId" {
            older = match value.trim_matches('"') {
                "RPC00A" => true,
                "RPC00B" => false,
                other => {
                    let (field, found) = (name.to_owned(), short(other));
                    let expected = "RPC00A or RPC00B";
                    return Err(RpcProblem::Convention { line, field, found, expected }.into());
                }
            };
        } else if !fields.scalar(name, line, value)? && RPB.polynomials.contains(&name) {
            let list = value.strip_prefix('(').and_then(|v| v.strip_suffix(')'));
            let list = list.ok_or_else(wrong)?;
            fields.polynomial(name, line, list.split(',').map(str::trim))?;
        }
    }
    if !fields.any() {
        return Err(RpcProblem::NotAnRpc.into());
    }
    fields.finish(|p| if older { Rpc00b::from_rpc00a_order(p) } else { *p })
}

pub(super) fn to_rpb(file: &RpcFile) -> String {
    let (scalars, polynomials) = numbers(file);
    let mut text = String::from("SpecId = \"RPC00B\";\nBEGIN_GROUP = IMAGE\n");
    // The errors come first, and are always there.
    for i in [10, 11, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9] {
        let value = scalars[i].unwrap_or(-1.0);
        // Writing to a string does not fail.
        let _ = writeln!(text, "\t{} = {value:e};", RPB.scalars[i]);
    }
    for (name, polynomial) in RPB.polynomials.iter().zip(polynomials) {
        let list: Vec<String> = polynomial.iter().map(|c| format!("\t\t\t{c:e}")).collect();
        let _ = writeln!(text, "\t{name} = (\n{});", list.join(",\n"));
    }
    text.push_str("END_GROUP = IMAGE\nEND;\n");
    text
}
