//! The program `feeler`: what is in a part, contact queries with proven bounds, and the gate.
//!
//! Exit codes: 2 for bad input, bad usage, or any query line refused (the others are still
//! answered); else 1 if something is undecided or short of its bound; else 0.
#![forbid(unsafe_code)]

mod contact;
mod convert;
mod gate;
mod health;
mod inspect;
mod plan;
mod report;
#[cfg(feature = "simulate")]
mod simulate;
mod study;
mod view;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Measures gaps and overlaps between probes and solids of trimmed NURBS faces, with proven bounds.
#[derive(Debug, Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// What is in a file: objects, faces, surface and curve types, trims, units, defects.
    Inspect(inspect::Args),
    /// Answers contact queries: one from the command line, or a line of JSON each from standard
    /// input.
    Contact(contact::Args),
    /// Writes a model as .3dm or .brep: BREPs, surfaces and curves in their native form, number by number; in other units if asked.
    Convert(convert::Args),
    /// The kernel as an engine outside: the query protocol on standard input and output. The first line is
    /// {"model": "PATH", "object": 0, "accuracy": 1e-9 or "full"}, of which only the model must be there; then queries, as
    /// `feeler contact --help` lists them.
    Engine,
    /// Holds the kernel's answers against the stored truth of a corpus.
    Gate(gate::Args),
    /// Measures error against run time of several engines on a corpus, and writes a page of plots and tables.
    Report(report::Args),
    /// Which types of surfaces and curves occur in a folder of parts: tables and a plot.
    Study(study::Args),
    /// Shows a model and the answers to queries about it: one page to turn and zoom in a browser, or binary glTF.
    View(view::Args),
    /// Runs an experiment in Rapier: the thesis's ball joint, or rolling without bumps.
    #[cfg(feature = "simulate")]
    Simulate(simulate::Args),
}

/// How a command ended, when nothing stopped it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// All is well.
    Good,
    /// Something is undecided or short of its bound.
    Short,
    /// A query line or an object of a file was refused; it has been said on standard error.
    Refused,
}

/// Bad input: one line that names the file, the place and the remedy.
struct Bad(String);

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    let outcome = match cli.command {
        Command::Inspect(args) => inspect::run(&args),
        Command::Contact(args) => contact::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Engine => contact::serve(),
        Command::Gate(args) => gate::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Study(args) => study::run(&args),
        Command::View(args) => view::run(&args),
        #[cfg(feature = "simulate")]
        Command::Simulate(args) => simulate::run(&args),
    };
    match outcome {
        Ok(Outcome::Good) => ExitCode::SUCCESS,
        Ok(Outcome::Short) => ExitCode::from(1),
        Ok(Outcome::Refused) => ExitCode::from(2),
        Err(Bad(line)) => {
            eprintln!("error: {}", line.replace('\n', " "));
            ExitCode::from(2)
        }
    }
}

/// Help and version as clap prints them; any other complaint in one line.
fn usage(error: &clap::Error) -> ExitCode {
    let help = ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if !error.use_stderr() || error.kind() == help {
        error.exit();
    }
    let text = error.to_string();
    // clap says what is wrong in its first paragraph, what it would rather see after it.
    let what: Vec<&str> = text
        .lines()
        .take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more"))
        .map(str::trim)
        .filter(|l| !l.is_empty())
        .collect();
    eprintln!("{}; see `feeler help`", what.join(" "));
    ExitCode::from(2)
}

/// Writing to a pipe that was closed ends the command like any other bad input.
fn write_error(error: std::io::Error) -> Bad {
    Bad(format!("standard output: {error}"))
}
