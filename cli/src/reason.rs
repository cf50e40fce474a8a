//! What the library's errors say, in the words of a program that knows what was measured.

use collinear::Error;
use collinear::error::Brief;

/// An error's text where nothing stands before it but a name.
pub(crate) fn reason(error: &Error) -> String {
    match *error {
        // Which configuration is a clause of its own, as `parallel rays` or `the points lie on a line`.
        Error::Degenerate { what, measure, limit } => {
            let what = what.strip_prefix("resection: ").unwrap_or(what);
            let (measure, limit) = (Brief(measure), Brief(limit));
            format!("degenerate: {what} (measure {measure}, needed more than {limit})")
        }
        Error::TooFewPoints { needed, got: 1 } => format!("1 point given, {needed} needed"),
        other => other.to_string(),
    }
}
