//! The order of the modules, held by reading the sources: data flows one way and so do imports (DESIGN, "Modules, and
//! who may import whom"). Also the sizes and names of files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The modules from the left to the right. Each may use those before it; `adjust` and the rendering side, which begins
/// with `mapping`, may not use one another.
const ORDER: [&str; 11] = [
    "error", "interop", "numeric", "geometry", "camera", "adjust", "mapping", "resample",
    "texturer", "terrain", "view",
];
const BANNED_NAMES: [&str; 6] = ["utils", "util", "common", "helpers", "misc", "prelude"];
const MAX_LINES: usize = 1000;
const MEDIAN_LINES: usize = 300;

/// A token of Rust: an identifier, `::`, or one character.
fn tokens(text: &str) -> Vec<String> {
    let c: Vec<char> = text.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let word = |x: char| x.is_alphanumeric() || x == '_';
    let (mut found, mut i) = (Vec::new(), 0);
    while i < c.len() {
        // `r`, `b`, `br` and hashes before a quote open a raw or byte string.
        let mut quote = i;
        while matches!(at(quote), 'r' | 'b' | 'c') && quote < i + 2 {
            quote += 1;
        }
        let hashes = (quote..).take_while(|&k| at(k) == '#').count();
        let opens = at(quote + hashes) == '"';
        let raw = opens && (i..quote).any(|k| at(k) == 'r');
        if at(i) == '/' && at(i + 1) == '/' {
            i += (i..c.len()).take_while(|&k| at(k) != '\n').count();
        } else if at(i) == '/' && at(i + 1) == '*' {
            let mut depth = 0;
            loop {
                match (at(i), at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
                if depth == 0 || i >= c.len() {
                    break;
                }
            }
        } else if raw {
            i = quote + hashes + 1;
            while i < c.len() && !(at(i) == '"' && (1..=hashes).all(|k| at(i + k) == '#')) {
                i += 1;
            }
            i += 1 + hashes;
        } else if opens && hashes == 0 {
            i = quote + 1;
            while i < c.len() && at(i) != '"' {
                i += if at(i) == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if at(i) == '\'' && (at(i + 1) == '\\' || at(i + 2) == '\'') {
            i += if at(i + 1) == '\\' { 3 } else { 2 }; // a character; otherwise a lifetime
            i += (i..c.len()).take_while(|&k| at(k) != '\'').count() + 1;
        } else if word(at(i)) {
            let length = (i..c.len()).take_while(|&k| word(at(k))).count();
            found.push(c[i..i + length].iter().collect());
            i += length;
        } else if at(i) == ':' && at(i + 1) == ':' {
            found.push("::".to_owned());
            i += 2;
        } else {
            if !at(i).is_whitespace() {
                found.push(at(i).to_string());
            }
            i += 1;
        }
    }
    found
}

/// The paths that a path's remaining tokens spell, groups opened; returns the index after it.
fn expand(
    tokens: &[String],
    mut i: usize,
    prefix: &[String],
    paths: &mut Vec<Vec<String>>,
) -> usize {
    let mut path = prefix.to_vec();
    let get = |i: usize| tokens.get(i).map_or("", String::as_str);
    loop {
        match get(i) {
            "{" => {
                i += 1;
                while !matches!(get(i), "}" | "") {
                    i = expand(tokens, i, &path, paths);
                    while !matches!(get(i), "," | "}" | "") {
                        i += 1; // `as name`
                    }
                    i += usize::from(get(i) == ",");
                }
                return i + 1;
            }
            "*" => {
                path.push("*".to_owned());
                i += 1;
            }
            name if name.starts_with(|x: char| x.is_alphabetic() || x == '_') => {
                path.push(name.to_owned());
                i += 1;
                if get(i) == "::" {
                    i += 1;
                    continue;
                }
            }
            _ => {} // `Vec::<f64>` and the like
        }
        paths.push(path);
        return i;
    }
}

/// The module path of a file of src/: `geometry/plane.rs` and `geometry/plane/mod.rs` are `geometry::plane`.
fn module_of(file: &str) -> Vec<String> {
    let path = file.trim_end_matches(".rs").trim_end_matches("/mod");
    if path == "lib" { Vec::new() } else { path.split('/').map(str::to_owned).collect() }
}

/// What is wrong with one file of src/.
fn violations(file: &str, text: &str) -> Vec<String> {
    let tokens = tokens(text);
    let home = module_of(file);
    let mut found = Vec::new();
    let mut say = |what: String| found.push(format!("{file}: {what}"));
    for name in home.iter().filter(|n| BANNED_NAMES.contains(&n.as_str())) {
        say(format!("a module is named for what it does, not `{name}`"));
    }
    let names = |name: &str| tokens.iter().any(|t| t == name);
    if names("nalgebra") && names("glam") && !matches!(file, "interop.rs" | "lib.rs") {
        say("only interop.rs names nalgebra and glam together".to_owned());
    }

    // Inline modules: where `super` counts from, and where a test may import its subject by `*`.
    let mut inner: Vec<(String, usize)> = Vec::new();
    let mut depth = 0;
    let mut i = 0;
    while i < tokens.len() {
        let token = tokens[i].as_str();
        let next = |k: usize| tokens.get(i + k).map_or("", String::as_str);
        match token {
            "{" => depth += 1,
            "}" => {
                depth -= usize::from(depth > 0);
                inner.retain(|(_, d)| *d <= depth);
            }
            "mod" => {
                if BANNED_NAMES.contains(&next(1)) {
                    say(format!("a module is named for what it does, not `{}`", next(1)));
                }
                if next(2) == "{" {
                    inner.push((next(1).to_owned(), depth + 1));
                }
            }
            _ => {}
        }
        let starts = matches!(token, "crate" | "super" | "self") && next(1) == "::";
        let glob = token == "::" && next(1) == "*";
        if !starts {
            if glob {
                say("a glob hides where names come from".to_owned());
            }
            i += 1;
            continue;
        }
        let mut paths = Vec::new();
        i = expand(&tokens, i, &[], &mut paths);
        let mut here = home.clone();
        here.extend(inner.iter().map(|(name, _)| name.clone()));
        let in_tests = inner.iter().any(|(name, _)| name == "tests");
        for path in paths {
            if path.last().is_some_and(|last| last == "*") && !in_tests {
                say(format!("a glob hides where names come from: {}", path.join("::")));
            }
            let supers = path.iter().take_while(|s| *s == "super").count();
            let base = match path[0].as_str() {
                "crate" => &[][..],
                "super" => &here[..here.len().saturating_sub(supers)],
                _ => &here[..],
            };
            let rest = path.iter().skip(supers.max(1)).filter(|s| *s != "self");
            let absolute: Vec<&String> = base.iter().chain(rest).collect();
            let (Some(from), Some(to)) = (home.first(), absolute.first()) else { continue };
            if let Some(why) = forbidden(from, to) {
                say(format!("{}: {why}", path.join("::")));
            }
        }
    }
    found
}

/// Why a module may not use another, if it may not.
fn forbidden(from: &str, to: &str) -> Option<String> {
    let rank = |name: &str| ORDER.iter().position(|m| *m == name);
    let Some(left) = rank(from) else {
        return Some(format!("`{from}` has no place in the order of modules"));
    };
    let Some(right) = rank(to) else {
        return Some(format!("`{to}` is no module: name the one the item lives in"));
    };
    if right > left {
        return Some(format!("`{from}` stands to the left of `{to}`"));
    }
    (to == "adjust" && from != "adjust").then(|| "the rendering side does not adjust".to_owned())
}

/// Every .rs file below a folder of the repository, by its path from there.
fn sources(folder: &str) -> BTreeMap<String, String> {
    fn visit(folder: &Path, root: &Path, found: &mut BTreeMap<String, String>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                visit(&path, root, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name = path.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
                found.insert(name, std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut found = BTreeMap::new();
    visit(&root, &root, &mut found);
    found
}

#[test]
fn imports_flow_one_way() {
    let files = sources("src");
    assert!(files.contains_key("lib.rs") && files.len() > 20);
    let found: Vec<String> = files.iter().flat_map(|(file, text)| violations(file, text)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn files_are_short() {
    let mut library: Vec<usize> = Vec::new();
    for folder in ["src", "io/src", "cli/src", "peers", "tests", "examples", "benches"] {
        for (file, text) in sources(folder) {
            let lines = text.lines().count();
            assert!(lines <= MAX_LINES, "{folder}/{file} has {lines} lines");
            if folder == "src" {
                library.push(lines);
            }
        }
    }
    library.sort_unstable();
    let median = library[library.len() / 2];
    assert!(median < MEDIAN_LINES, "the median file of src/ has {median} lines");
}

#[test]
fn the_reader_of_paths_sees_what_it_must() {
    for (file, text) in [
        ("geometry/plane.rs", "use crate::camera::Frame;"),
        ("geometry/plane.rs", "use crate::{error::Error, camera::{self, Frame as F}};"),
        ("geometry/plane.rs", "use crate::{numeric::{float, twofold::Twofold}, mapping::Map};"),
        ("geometry/plane.rs", "fn f() -> crate::resample::Border { todo!() }"),
        ("geometry/plane.rs", "fn f() { let x = Vec::<crate::view::View>::new(); }"),
        ("geometry/plane.rs", "use super::super::camera::Frame;"),
        ("geometry/mod.rs", "use super::camera::Frame;"),
        ("geometry/homography/fit.rs", "use super::super::super::adjust::resect;"),
        ("geometry/plane.rs", "mod inner { use super::super::super::camera::Frame; }"),
        (
            "geometry/plane.rs",
            "mod tests { } mod b { mod c { use super::super::super::super::view::V; } }",
        ),
        ("geometry/plane.rs", "#[cfg(test)] mod tests { use crate::camera::Frame; }"),
        ("geometry/plane.rs", "/* '\"' */ const Q: char = '\"'; use crate::camera::Frame; // \""),
        (
            "geometry/plane.rs",
            "fn f<'a>(x: &'a str) { g(r#\"\"#, b'\\'', \"\\\"\") } use crate::camera::F;",
        ),
        ("adjust/dlt.rs", "use crate::mapping::Map;"),
        ("mapping/mod.rs", "use crate::adjust::resect;"),
        ("view/mod.rs", "use crate::adjust::resect;"),
        ("error.rs", "use crate::interop::vec3;"),
        ("camera/mod.rs", "use crate::Error;"),
        ("toolbox/mod.rs", "use crate::error::Error;"),
        ("camera/mod.rs", "pub use frame::*;"),
        ("camera/mod.rs", "use crate::geometry::{Plane, *};"),
        ("lib.rs", "pub use geometry::*;"),
        ("camera/mod.rs", "mod utils;"),
        ("camera/common.rs", ""),
        ("prelude.rs", ""),
        (
            "texturer/scan.rs",
            "use nalgebra::Point2; pub fn f(p: Point2<f64>) -> glam::Vec2 { g(p) }",
        ),
    ] {
        assert!(!violations(file, text).is_empty(), "{file}: {text}");
    }
    for (file, text) in [
        ("geometry/plane.rs", "use crate::error::Error; use super::ray::Ray; use self::inner::x;"),
        (
            "geometry/plane.rs",
            "// use crate::camera::Frame;\n/// [`crate::camera::Frame`]\nstruct S;",
        ),
        ("geometry/plane.rs", "const S: &str = \"use crate::camera::Frame;\";"),
        ("geometry/plane.rs", "const S: &str = r#\"\" use crate::camera::Frame;\"#;"),
        ("geometry/plane.rs", "mod tests { use super::*; use super::super::ray::Ray; }"),
        (
            "geometry/plane.rs",
            "pub(crate) fn f() {} pub(super) fn g() {} pub(in crate::geometry) fn h() {}",
        ),
        ("adjust/dlt.rs", "use crate::{camera::Frame, numeric::least_squares};"),
        ("mapping/mod.rs", "use crate::camera::Frame; fn f() { crate::geometry::g(2 * 3) }"),
        ("view/mod.rs", "use crate::terrain::Field; use glam::Vec2;"),
        ("lib.rs", "pub mod camera; pub use camera::Frame; pub use glam; pub use nalgebra;"),
        ("interop.rs", "use nalgebra::Point2; pub fn f(p: Point2<f64>) -> glam::Vec2 { g(p) }"),
    ] {
        assert_eq!(violations(file, text), Vec::<String>::new(), "{text}");
    }
}
