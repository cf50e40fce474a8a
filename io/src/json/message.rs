//! What serde says, in the words of JSON instead of Rust.

use serde_path_to_error::{Path, Segment};

use crate::error::{Error, ErrorKind};

/// The path to a field as a person writes it: `shots["01.jpg"].rotation[2]`.
pub(super) fn path(path: &Path) -> String {
    let mut text = String::new();
    for segment in path {
        match segment {
            Segment::Seq { index } => text.push_str(&format!("[{index}]")),
            Segment::Map { key } | Segment::Enum { variant: key } => {
                let plain =
                    !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
                if !plain {
                    text.push_str(&format!("[{key:?}]"));
                } else if text.is_empty() {
                    text.push_str(key);
                } else {
                    text.push('.');
                    text.push_str(key);
                }
            }
            Segment::Unknown => text.push_str("[?]"),
        }
    }
    text
}

/// An error with its place and a message that a writer of JSON understands.
pub(super) fn explain(field: &str, error: &serde_json::Error) -> Error {
    let (line, column) = (error.line(), error.column());
    let whole = error.to_string();
    let raw = whole.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&whole);
    // The key of an unknown field ends the path already.
    ErrorKind::Json { field: field.to_owned(), message: reword(raw, field), line, column }.into()
}

fn reword(raw: &str, field: &str) -> String {
    if let Some(rest) =
        raw.strip_prefix("invalid type: ").or_else(|| raw.strip_prefix("invalid value: "))
        && let Some((found, expected)) = rest.rsplit_once(", expected ")
    {
        return format!("expected {}, found {}", expectation(expected), finding(found));
    }
    if let Some(rest) = raw.strip_prefix("invalid length ")
        && let Some((found, expected)) = rest.split_once(", expected ")
    {
        return format!("expected {}, found {found} entries", expectation(expected));
    }
    if let Some(rest) = raw.strip_prefix("unknown field `")
        && let Some((name, known)) = rest.split_once('`')
    {
        let known = known.trim_start_matches(", expected ").trim_start_matches("one of ");
        return format!("unknown field{}", advice(name, known));
    }
    if let Some(rest) = raw.strip_prefix("unknown variant ") {
        let (found, expected) = rest.split_once(", expected ").unwrap_or((rest, "another"));
        return format!("expected {expected}, found {found}");
    }
    if raw == "trailing characters" && !field.is_empty() {
        return "has more entries than expected".into();
    }
    raw.to_owned()
}

/// What to do about an unknown field.
fn advice(name: &str, known: &str) -> String {
    let nearest = known
        .split('`')
        .skip(1)
        .step_by(2)
        .map(|k| (edits(name, k), k))
        .min()
        .filter(|(n, k)| *n <= 1 + k.len() / 4);
    match nearest {
        Some((_, k)) => format!(", did you mean `{k}`?"),
        None => format!(", remove it: the fields here are {known}"),
    }
}

/// Levenshtein's distance.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut last = i + 1;
        let mut next = vec![last];
        for (pair, cb) in row.windows(2).zip(&b) {
            last = (last + 1).min(pair[1] + 1).min(pair[0] + usize::from(ca != *cb));
            next.push(last);
        }
        row = next;
    }
    row.last().copied().unwrap_or(0)
}

fn expectation(rust: &str) -> String {
    match rust {
        "f64" | "f32" => "a number".into(),
        "u8" => "a whole number from 0 to 255".into(),
        "u16" | "u32" | "u64" | "usize" => "a whole number from 0".into(),
        "i32" | "i64" => "a whole number".into(),
        "a sequence" => "a list".into(),
        "a map" => "an object".into(),
        "a string" | "str" | "a borrowed string" => "a string".into(),
        other if other.starts_with("struct ") => "an object".into(),
        other if other.starts_with("enum ") => "a string".into(),
        other => match other.strip_prefix("an array of length ") {
            Some(n) => format!("a list of {n}"),
            None => other.into(),
        },
    }
}

fn finding(found: &str) -> String {
    match found {
        "null" => "null".into(),
        "sequence" => "a list".into(),
        "map" => "an object".into(),
        other => {
            if let Some(text) = other.strip_prefix("string ") {
                return format!("the string {text}");
            }
            // A float as large or as small as they get is hundreds of digits.
            if let Some(number) = other.strip_prefix("floating point ")
                && let Ok(value) = number.trim_matches('`').parse::<f64>()
                && !(value == 0.0 || (1e-4..1e16).contains(&value.abs()))
            {
                return format!("{value:e}");
            }
            other
                .trim_start_matches("integer ")
                .trim_start_matches("floating point ")
                .trim_start_matches("boolean ")
                .trim_matches('`')
                .into()
        }
    }
}
