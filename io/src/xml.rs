//! XML of other programs.

use roxmltree::{Document, Error, ParsingOptions};

/// More nodes than any file that is read has, so that a hostile one is refused early.
const MAX_NODES: u32 = 1_000_000;

pub(crate) fn parse(text: &str) -> Result<Document<'_>, Error> {
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options)
}

/// Text as it stands in XML. Control characters that XML cannot have become spaces.
pub(crate) fn escaped(text: &str) -> String {
    let mut all = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => all.push_str("&amp;"),
            '<' => all.push_str("&lt;"),
            '>' => all.push_str("&gt;"),
            '"' => all.push_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => all.push(' '),
            c => all.push(c),
        }
    }
    all
}
