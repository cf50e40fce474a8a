//! The program `collinear`.

mod command;

use std::io::Write;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};

/// Exit code where the work failed.
const FAILURE: u8 = 1;
/// Exit code where the command line is wrong.
const USAGE: u8 = 2;

#[derive(Debug, Parser)]
#[command(name = "collinear", version, about = ABOUT, after_help = AFTER, max_term_width = 100)]
struct Program {
    #[command(subcommand)]
    command: Command,
}

const ABOUT: &str = "Photographs and cameras: poses and points by adjustment, new views, panoramas and domes, rectified \
façades, warped pictures, projected points, wire frames, camera files of other programs";

const AFTER: &str = "\
Image coordinates are pixels from the top-left corner of the top-left pixel, x right, y down; its \
centre is (0.5, 0.5). World coordinates are in any one unit of length. Cameras, planes and scenes \
are JSON files; docs/formats.md describes them. Folders of outputs that are not there are made.

Exit codes: 0 done; 1 failed (an old output is left as it was); 2 wrong usage, as an output that is \
an input too.";

#[derive(Debug, Subcommand)]
enum Command {
    Render(command::render::Arguments),
    Rectify(command::rectify::Arguments),
    Reproject(command::reproject::Arguments),
    Warp(command::warp::Arguments),
    Resect(command::resect::Arguments),
    Intersect(command::intersect::Arguments),
    Adjust(command::adjust::Arguments),
    Project(command::project::Arguments),
    Overlay(command::overlay::Arguments),
    Convert(command::convert::Arguments),
}

fn main() -> ExitCode {
    let program = match Program::try_parse() {
        Ok(program) => program,
        Err(error) => return refuse(&error),
    };
    let result = match program.command {
        Command::Render(arguments) => arguments.run(),
        Command::Rectify(arguments) => arguments.run(),
        Command::Reproject(arguments) => arguments.run(),
        Command::Warp(arguments) => arguments.run(),
        Command::Resect(arguments) => arguments.run(),
        Command::Intersect(arguments) => arguments.run(),
        Command::Adjust(arguments) => arguments.run(),
        Command::Project(arguments) => arguments.run(),
        Command::Overlay(arguments) => arguments.run(),
        Command::Convert(arguments) => arguments.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            command::say(&format!("error: {error}"));
            ExitCode::from(if error.is::<command::UsageError>() { USAGE } else { FAILURE })
        }
    }
}

/// Prints help where it was asked for, and what is wrong with the command line as one line.
fn refuse(error: &clap::Error) -> ExitCode {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        // A reader that went away has what it wanted.
        drop(error.print());
        return ExitCode::SUCCESS;
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        drop(std::io::stderr().write_all(error.to_string().as_bytes()));
        return ExitCode::from(USAGE);
    }
    let text = error.to_string();
    let first = text.split("\n\n").next().unwrap_or_default();
    let line = first.split_whitespace().collect::<Vec<_>>().join(" ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    command::say(&format!("error: {line}; `--help` tells more"));
    ExitCode::from(USAGE)
}
