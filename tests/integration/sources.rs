//! docs/sources.md names functions and tests; they exist.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The text of every .rs file in a folder, or of one file.
fn text_below(path: &Path) -> String {
    let below = |folder| fs::read_dir(folder).into_iter().flatten().flatten();
    if path.is_dir() {
        below(path).map(|entry| text_below(&entry.path())).collect()
    } else if path.extension().is_some_and(|e| e == "rs") {
        fs::read_to_string(path).unwrap()
    } else {
        String::new()
    }
}

/// Whether a keyword declares the name somewhere in the text.
fn declares(text: &str, keywords: &[&str], name: &str) -> bool {
    text.lines().map(str::trim_start).filter(|line| !line.starts_with("//")).any(|line| {
        let words: Vec<&str> = line
            .split(|c: char| !(c.is_alphanumeric() || c == '_'))
            .filter(|w| !w.is_empty())
            .collect();
        words.windows(2).any(|pair| keywords.contains(&pair[0]) && pair[1] == name)
    })
}

/// Whether a `pub use` of the text names it.
fn exports(text: &str, name: &str) -> bool {
    let word = |c: char| !(c.is_alphanumeric() || c == '_');
    let statements = text.split("pub use ").skip(1).filter_map(|rest| rest.split(';').next());
    statements.flat_map(|s| s.split(word)).any(|w| w == name)
}

/// Why `module::path::Type::function` is not in the folder `source`, if it is not.
fn missing(source: &Path, item: &str) -> Option<String> {
    let segments: Vec<&str> = item.split("::").collect();
    let mut place = source.to_path_buf();
    let mut rest = segments.as_slice();
    while let Some((first, others)) = rest.split_first() {
        let (folder, file) = (place.join(first), place.join(format!("{first}.rs")));
        if folder.is_dir() {
            place = folder;
        } else if file.is_file() {
            place = file;
        } else {
            break;
        }
        rest = others;
    }
    if rest.len() == segments.len() {
        return Some(format!("`{item}` begins with no module"));
    }
    let text = text_below(&place);
    let keywords = ["fn", "struct", "enum", "trait", "type", "const", "static", "impl"];
    // A type's functions may stand in a module to its right, where what they need is known.
    let elsewhere = |name| declares(&text_below(source), &["fn"], name);
    rest.iter()
        .enumerate()
        .find(|(i, name)| {
            let found = declares(&text, &keywords, name) || exports(&text, name);
            !found && (*i == 0 || !elsewhere(name))
        })
        .map(|(_, name)| name)
        .map(|name| format!("`{item}`: `{name}` is not declared in {}", place.display()))
}

/// The cells of the table rows of a page whose second column has code in it: what, items, tests.
fn rows(page: &str) -> Vec<[Vec<String>; 2]> {
    let code =
        |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    page.lines()
        .filter(|line| line.starts_with('|'))
        .filter_map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').collect();
            let [_, items, tests] = cells.as_slice() else { return None };
            let [items, tests] = [code(items), code(tests)];
            (!items.is_empty()).then_some([items, tests])
        })
        .collect()
}

#[test]
fn every_equation_has_its_function_and_its_test() {
    let page = fs::read_to_string(root().join("docs/sources.md")).unwrap();
    let (source, tests) = (root().join("src"), text_below(&root().join("tests")));
    let rows = rows(&page);
    assert!(rows.len() > 20, "{} rows", rows.len());
    let mut wrong: Vec<String> = Vec::new();
    for [items, names] in &rows {
        wrong.extend(items.iter().filter_map(|item| missing(&source, item)));
        if names.is_empty() {
            wrong.push(format!("{items:?} has no test"));
        }
        let absent = names.iter().filter(|name| !declares(&tests, &["fn"], name));
        wrong.extend(absent.map(|name| format!("no test is named `{name}`")));
    }
    assert!(wrong.is_empty(), "docs/sources.md:\n{}", wrong.join("\n"));
}

#[test]
fn the_equations_of_the_main_sources_are_all_there() {
    let page = fs::read_to_string(root().join("docs/sources.md")).unwrap();
    for equation in [
        "WD eq. 1",
        "WD eq. 2",
        "WD eq. 3",
        "WD eq. 4a",
        "WD eq. 4b",
        "WD table 2",
        "S eq. 5",
        "S eq. 6",
        "S eq. 7",
        "S eq. 8",
    ] {
        assert!(page.contains(&format!("| {equation}")), "{equation}");
    }
}

#[test]
fn the_reader_of_the_page_sees_what_it_must() {
    let source = root().join("src");
    for present in [
        "geometry::Plane",
        "geometry::plane::Plane::through",
        "numeric::least_squares::minimise",
        "camera::SensorModel::locus",
        "camera::collinearity",
        "error::Error",
    ] {
        assert_eq!(missing(&source, present), None);
    }
    for absent in [
        "geometry::Plane::no_such_function",
        "geometry::NoSuchType",
        "geometry::NoSuchType::through",
        "no_such_module::Plane",
        "Plane",
        "mapping::Plane",
    ] {
        assert!(missing(&source, absent).is_some(), "{absent}");
    }
    assert!(declares("pub struct A<T> {", &["struct"], "A"));
    assert!(
        !declares("// struct A", &["struct"], "A") && !declares("struct Ab;", &["struct"], "A")
    );
    assert!(exports("mod a;\npub use a::{\n    B, C,\n};", "C") && !exports("use a::C;", "C"));
    let page = "| a | `x::y`, `z` | `t` |\n| - | - | - |\n| key | source |\n| b | none | `t` |";
    let code = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    assert_eq!(rows(page), [[code(&["x::y", "z"]), code(&["t"])]]);
}
