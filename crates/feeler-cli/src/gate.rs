//! `feeler gate`.

use crate::{Bad, Outcome, write_error};
use feeler::query::Options;
use feeler_gate::{FeelerEngine, Gate, Progress, run as run_gate};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where `report.json` and `report.md` go.
    #[arg(long, default_value = "target/gate")]
    out: PathBuf,
    /// One suite alone.
    #[arg(long)]
    suite: Option<String>,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    corpora: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    // indicatif draws on a terminal only.
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:30} {pos}/{len}") {
        bar.set_style(style);
    }
    let mut progress = |p: &Progress| {
        bar.set_length(p.total as u64);
        bar.set_position(p.done as u64);
        if bar.message() != p.suite {
            bar.set_message(p.suite.clone());
        }
    };
    let mut engine = FeelerEngine::new(Options::default());
    let gate = Gate {
        corpus: &args.corpora,
        suite: args.suite.as_deref(),
        tolerance: 0.0,
    };
    let report = run_gate(&mut engine, &gate, &mut progress);
    bar.finish_and_clear();
    let report = report.map_err(|e| Bad(e.to_string()))?;
    report
        .write(&args.out)
        .map_err(|e| Bad(format!("{}: {e}", args.out.display())))?;
    let mut out = std::io::stdout().lock();
    write!(out, "{}", report.table()).map_err(write_error)?;
    write!(out, "\n{}", report.shortfalls()).map_err(write_error)?;
    let verdict = if report.passed() { "passed" } else { "FAILED" };
    let folder = args.out.display();
    writeln!(
        out,
        "gate {verdict}; see {folder}/report.md and report.json"
    )
    .map_err(write_error)?;
    Ok(if report.passed() {
        Outcome::Good
    } else {
        Outcome::Short
    })
}
