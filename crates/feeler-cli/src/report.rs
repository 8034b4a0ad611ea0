//! `feeler report`.

use crate::{Bad, Outcome};
use feeler_gate::study::{Contender, Plan, StudyProgress, study};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where `report.html`, `report.md` and `report.json` go.
    #[arg(long, default_value = "target/report")]
    out: PathBuf,
    /// A small sample: within a minute.
    #[arg(long)]
    quick: bool,
    /// One suite alone, and nothing but it.
    #[arg(long)]
    suite: Option<String>,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    corpora: PathBuf,
}

const QUICK: Plan = Plan {
    sample: 40,
    repetitions: 3,
    seconds: 0.3,
};
const WHOLE: Plan = Plan {
    sample: 400,
    repetitions: 5,
    seconds: 10.0,
};

/// Accuracies of the kernel, as parts of the model's size; then full.
const QUICK_DIAL: [f64; 3] = [1e-3, 1e-6, 1e-9];
const WHOLE_DIAL: [f64; 6] = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];

fn feeler(quick: bool) -> Vec<Contender> {
    let dial: &[f64] = if quick { &QUICK_DIAL } else { &WHOLE_DIAL };
    let dial = dial.iter().map(|p| Contender::feeler(Some(*p)));
    dial.chain([Contender::feeler(None)]).collect()
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    // indicatif draws on a terminal only.
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:30} {pos}/{len}") {
        bar.set_style(style);
    }
    let mut progress = |p: &StudyProgress| {
        bar.set_length(p.total as u64);
        bar.set_position(p.done as u64);
        if bar.message() != p.what {
            bar.set_message(p.what.clone());
        }
    };
    let contenders = feeler(args.quick);
    let balls = vec![Contender::feeler(Some(1e-12)), Contender::feeler(None)];
    let omissions = Vec::new();
    let plan = if args.quick { QUICK } else { WHOLE };
    let found = study(
        &args.corpora,
        args.suite.as_deref(),
        contenders,
        balls,
        plan,
        omissions,
        &mut progress,
    );
    bar.finish_and_clear();
    let found = found.map_err(|e| Bad(e.to_string()))?;
    found
        .write(&args.out)
        .map_err(|e| Bad(format!("{}: {e}", args.out.display())))?;
    println!(
        "see {}/report.html, report.md and report.json",
        args.out.display()
    );
    Ok(Outcome::Good)
}
