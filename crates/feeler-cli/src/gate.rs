//! `feeler gate`.

use crate::{Bad, Outcome, write_error};
use clap::ValueEnum;
use feeler_gate::{
    Engine, EngineChoice, Gate, ModelForm, ProcessEngine, ProcessOptions, Progress, Report,
    run as run_gate,
};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::Write;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where `report.json` and `report.md` go.
    #[arg(long, default_value = "target/gate")]
    out: PathBuf,
    /// One suite alone.
    #[arg(long)]
    suite: Option<String>,
    /// About so many queries of each suite alone, spread over it.
    #[arg(long, value_name = "COUNT")]
    sample: Option<usize>,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    corpora: PathBuf,
    /// `feeler`, `feeler:WAY` (`nurbs`, `no-closed-forms`, ...), `parry:DEGREES`, `thesis`, `thesis:STARTS`, or a command line that speaks the
    /// query protocol.
    #[arg(long, value_name = "ENGINE", default_value = "feeler", value_parser = EngineChoice::by_name)]
    engine: EngineChoice,
    /// How far a value without bounds may be off, as a part of the model's size; it takes the place of
    /// the ceilings on errors. 0 for engines that give bounds [default: 0 for `feeler`, 1e-9 for others].
    #[arg(long, value_name = "PART", value_parser = part)]
    tolerance: Option<f64>,
    /// Seconds that an engine outside may take for an answer; then it is started again, and the query counts as
    /// refused. It has ten times that to start.
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    timeout: Duration,
    /// An earlier report.json: what became worse since is named and decides instead of the ceilings. The worst error
    /// may double; better is never worse, and times do not count.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Where to write the report as JUnit XML.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Where to write every answer: a line each, with the query's file and line. Equal lines are equal bits.
    #[arg(long, value_name = "FILE")]
    answers: Option<PathBuf>,
    /// How many models are asked about at a time, each on a thread of its own; times are best with 1 [default: one a core
    /// for the engines in the program, 1 for a command, which may use threads of its own].
    #[arg(long, value_name = "COUNT")]
    jobs: Option<NonZero<usize>>,
    /// What an engine outside reads.
    #[arg(long, value_enum, default_value_t = Models::Json)]
    models: Models,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Models {
    /// Our own model files, written to the folder `models` of --out.
    Json,
    /// The files of the corpus as they are.
    File,
}

/// Held against engines whose answers have no bounds: what an application in f64 can use (a micrometre
/// on a kilometre), a million times its rounding.
const TOLERANCE: f64 = 1e-9;
/// More time to start than for an answer.
const START: u32 = 10;

fn part(text: &str) -> Result<f64, String> {
    let part = text.parse::<f64>().ok();
    part.filter(|p| (0.0..1.0).contains(p))
        .ok_or_else(|| "a part of the size, from 0 and below 1".to_owned())
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| *s > 0.0);
    seconds
        .and_then(|s| Duration::try_from_secs_f64(s).ok())
        .filter(|d| d.checked_mul(START).is_some())
        .ok_or_else(|| "a positive number of seconds".to_owned())
}

impl Args {
    fn engine(&self) -> Result<Box<dyn Engine>, Bad> {
        let found = match &self.engine {
            EngineChoice::Command(line) => {
                let options = ProcessOptions {
                    timeout: self.timeout,
                    start_timeout: self.timeout * START,
                    models: match self.models {
                        Models::Json => ModelForm::Json(self.out.join("models")),
                        Models::File => ModelForm::File,
                    },
                };
                ProcessEngine::new(line, options).map(|e| Box::new(e) as Box<dyn Engine>)
            }
            built_in => built_in.engine(),
        };
        found.map_err(|e| Bad(format!("--engine: {e}")))
    }

    /// How many engines work at a time.
    fn jobs(&self) -> usize {
        let usual = || match self.engine {
            EngineChoice::Command(_) => NonZero::<usize>::MIN,
            _ => std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN),
        };
        self.jobs.unwrap_or_else(usual).get()
    }
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
    // Read first: it may be the file that is written at the end.
    let file = |path: &Path, e: std::io::Error| Bad(format!("{}: {e}", path.display()));
    let before = match &args.baseline {
        Some(path) => Some(Report::read(path).map_err(|e| file(path, e))?),
        None => None,
    };
    let mut engines = (0..args.jobs())
        .map(|_| args.engine())
        .collect::<Result<Vec<_>, Bad>>()?;
    let mut each: Vec<&mut dyn Engine> = Vec::new();
    for engine in &mut engines {
        each.push(engine.as_mut());
    }
    let tolerance = match args.engine.certifies() {
        true => 0.0,
        false => TOLERANCE,
    };
    let gate = Gate {
        corpus: &args.corpora,
        suite: args.suite.as_deref(),
        tolerance: args.tolerance.unwrap_or(tolerance),
        sample: args.sample,
        answers: args.answers.is_some(),
    };
    let report = run_gate(&mut each, &gate, &mut progress);
    bar.finish_and_clear();
    let report = report.map_err(|e| Bad(e.to_string()))?;
    report.write(&args.out).map_err(|e| file(&args.out, e))?;
    if let Some(path) = &args.answers {
        report.write_answers(path).map_err(|e| file(path, e))?;
    }
    let comparison = before.map(|before| report.against(&before, args.suite.is_none()));
    if let Some(path) = &args.junit {
        report
            .write_junit(path, comparison.as_ref())
            .map_err(|e| file(path, e))?;
    }
    let mut out = std::io::stdout().lock();
    write!(out, "{}", report.table()).map_err(write_error)?;
    write!(out, "\n{}", report.shortfalls()).map_err(write_error)?;
    let passed = match &comparison {
        Some(comparison) => {
            write!(out, "{}", comparison.text()).map_err(write_error)?;
            comparison.passed()
        }
        None => report.passed(),
    };
    let verdict = if passed { "passed" } else { "FAILED" };
    let folder = args.out.display();
    writeln!(
        out,
        "gate {verdict}; see {folder}/report.md and report.json"
    )
    .map_err(write_error)?;
    Ok(if passed {
        Outcome::Good
    } else {
        Outcome::Short
    })
}
