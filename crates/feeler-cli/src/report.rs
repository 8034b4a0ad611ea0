//! `feeler report`.

use crate::{Bad, Outcome};
use feeler_gate::EngineChoice;
use feeler_gate::study::{Contender, Plan, StudyProgress, study};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::Command;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where `report.html`, `report.md` and `report.json` go.
    #[arg(long, default_value = "target/report")]
    out: PathBuf,
    /// A small sample: within a minute.
    #[arg(long)]
    quick: bool,
    /// An engine to stand beside the kernel, as for `feeler gate`; may be given several times. Without: the algorithms of the
    /// 2014 thesis, and triangle meshes in parry.
    #[arg(long)]
    engine: Vec<String>,
    /// One suite alone, and nothing but it.
    #[arg(long)]
    suite: Option<String>,
    /// How many queries of each suite are asked [default: 400; 16 with --quick].
    #[arg(long, value_name = "COUNT")]
    sample: Option<usize>,
    /// How many seconds an engine may spend on one model of a suite [default: 10; 0.05 with --quick].
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    seconds: Option<f64>,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    corpora: PathBuf,
}

const QUICK: Plan = Plan {
    sample: 16,
    repetitions: 3,
    seconds: 0.05,
};
const WHOLE: Plan = Plan {
    sample: 400,
    repetitions: 5,
    seconds: 10.0,
};

/// Accuracies of the kernel, as parts of the model's size; then full.
const QUICK_DIAL: [f64; 3] = [1e-3, 1e-6, 1e-9];
const WHOLE_DIAL: [f64; 6] = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];

/// The other engines, where none are named.
const QUICK_OTHERS: [&str; 4] = ["thesis", "parry:180", "parry:30", "parry:10"];
const WHOLE_OTHERS: [&str; 7] = [
    "thesis",
    "thesis:100",
    "parry:180",
    "parry:30",
    "parry:10",
    "parry:3",
    "parry:1",
];

/// OCCT behind the query protocol.
const OCCT: &str = include_str!("../../feeler-gate/engines/occt.py");
/// Names the interpreter that has OCCT, where it is not `python3`.
const OCCT_PYTHON: &str = "FEELER_OCCT_PYTHON";
/// The program of `crates/feeler-peers`, and its libraries.
const PEERS: (&str, [&str; 2]) = ("feeler-peers", ["truck", "curvo"]);

/// Engines outside that are there: name, setting, command line. What is not there is said.
fn outside(out: &Path, omissions: &mut Vec<String>) -> Vec<(String, String, String)> {
    let mut found = Vec::new();
    let python = std::env::var(OCCT_PYTHON).unwrap_or_else(|_| "python3".to_owned());
    let version = Command::new(&python)
        .args(["-c", "import OCP; print(OCP.__version__)"])
        .output();
    let script = out.join("occt.py");
    match version {
        Ok(version) if version.status.success() => {
            let written = std::fs::create_dir_all(out).and_then(|()| std::fs::write(&script, OCCT));
            match written {
                Ok(()) => found.push((
                    "OCCT".to_owned(),
                    String::from_utf8_lossy(&version.stdout).trim().to_owned(),
                    line(&[&python, &script.to_string_lossy()]),
                )),
                Err(e) => omissions.push(format!("OCCT: {}: {e}", script.display())),
            }
        }
        _ => omissions.push(format!(
            "OCCT is absent: `{python}` does not import OCP; `pip install cadquery-ocp`, or name an interpreter in {OCCT_PYTHON}"
        )),
    }
    let (program, libraries) = PEERS;
    let beside = std::env::current_exe().ok();
    let beside = beside.and_then(|p| Some(p.parent()?.join(program)));
    match beside.filter(|p| p.exists()) {
        Some(path) => found.extend(libraries.map(|library| {
            let command = line(&[&path.to_string_lossy(), library]);
            (library.to_owned(), "surfaces".to_owned(), command)
        })),
        None => omissions.push(format!(
            "{} are absent: build crates/{program} into the same target folder",
            libraries.join(" and ")
        )),
    }
    found
}

/// A command line of these words.
fn line(words: &[&str]) -> String {
    let quoted = |w: &&str| format!("'{}'", w.replace('\'', "'\\''"));
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// What no run contains unless asked.
const OMISSIONS: [&str; 2] = [
    "parry at 0.1 degrees: 13 million triangles and 2 GB for the ball joint; `--engine parry:0.1`",
    "stiff time stepping (stress case C20): it needs a physics engine around the queries",
];

/// The kernel over its dial, with surfaces as they are and as NURBS; in the long report without each shortcut, too.
fn feeler(quick: bool) -> Vec<Contender> {
    let dial: &[f64] = if quick { &QUICK_DIAL } else { &WHOLE_DIAL };
    let dial = || dial.iter().map(|p| Some(*p)).chain([None]);
    let mut all: Vec<Contender> = dial().map(Contender::feeler).collect();
    if quick {
        all.push(Contender::nurbs(None));
    } else {
        all.extend(dial().map(Contender::nurbs));
        all.extend(Contender::less());
    }
    all
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok();
    seconds
        .filter(|s| s.is_finite() && *s > 0.0)
        .ok_or_else(|| "a positive number of seconds".to_owned())
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
    let mut contenders = feeler(args.quick);
    let mut balls = vec![Contender::feeler(Some(1e-12)), Contender::feeler(None)];
    let mut omissions: Vec<String> = OMISSIONS.map(str::to_owned).to_vec();
    let others: Vec<String> = match (args.engine.is_empty(), args.quick) {
        (false, _) => args.engine.clone(),
        (true, true) => QUICK_OTHERS.map(str::to_owned).to_vec(),
        (true, false) => WHOLE_OTHERS.map(str::to_owned).to_vec(),
    };
    for name in &others {
        let choice = EngineChoice::by_name(name).map_err(Bad)?;
        // One for the suites, one for the balls: each holds a model of its own.
        match (Contender::other(&choice), Contender::other(&choice)) {
            (Ok(one), Ok(another)) => {
                contenders.push(one);
                balls.push(another);
            }
            (Err(why), _) | (_, Err(why)) => omissions.push(why),
        }
    }
    if args.engine.is_empty() && args.quick {
        omissions
            .push("OCCT, truck and curvo: in the long report, where they are there".to_owned());
    }
    if args.engine.is_empty() && !args.quick {
        for (name, setting, command) in outside(&args.out, &mut omissions) {
            let choice = EngineChoice::Command(command);
            for into in [&mut contenders, &mut balls] {
                match Contender::other(&choice) {
                    Ok(one) => into.push(Contender {
                        name: name.clone(),
                        setting: setting.clone(),
                        ..one
                    }),
                    Err(why) => omissions.push(why),
                }
            }
        }
    }
    let usual = if args.quick { QUICK } else { WHOLE };
    let plan = Plan {
        sample: args.sample.unwrap_or(usual.sample),
        seconds: args.seconds.unwrap_or(usual.seconds),
        ..usual
    };
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
