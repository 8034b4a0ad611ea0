//! `feeler report`: error against run time, and all that a reader needs to trust it.
//!
//! | module | holds |
//! |---|---|
//! | `contender` | engines at their settings |
//! | `measure` | what each gives on samples of the suites: errors, verdicts, times, interleaved |
//! | `balls` | Table 1 of the thesis |
//! | `extremes` | the field's cases of stress, with their conditioning |
//! | `left_out` | what it saves to leave work out |
//! | `numbers` | quantiles |
//! | `about` | machine, compiler, commit |
//! | `plot` | SVG |
//! | `table` | what is shown as tables |
//! | `page`, `summary` | the page in HTML, the summary in Markdown |

mod about;
mod balls;
mod contender;
mod extremes;
mod left_out;
mod measure;
mod numbers;
mod page;
mod plot;
mod summary;
mod table;

pub use about::About;
pub use balls::{BALLS, BallCell, BallRow};
pub use contender::Contender;
pub use extremes::Extreme;
pub use left_out::LeftOut;
pub use measure::{Plan, Point, TOLERANCE};
pub use numbers::Spread;

use crate::cases::{Models, cases};
use feeler_corpus::{CorpusError, suites};
use measure::{measure, sample, truth_width};
use serde::Serialize;
use std::path::Path;

/// The part of Table 1, native and as NURBS.
const BALL_JOINT: [&str; 2] = [
    "thesis/ball_joint_cavity.3dm",
    "thesis/ball_joint_cavity_nurbs.3dm",
];

/// What all engines gave on one suite.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SuiteStudy {
    /// The suite.
    pub suite: String,
    /// What it is about.
    pub description: String,
    /// How many queries it has.
    pub queries: usize,
    /// The widest truth of a separation in the sample, in model units: no error below it is seen.
    pub floor: Option<f64>,
    /// A point an engine and setting.
    pub points: Vec<Point>,
}

/// Everything measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// Where and of what.
    pub about: About,
    /// How much.
    pub plan: Plan,
    /// By suite.
    pub suites: Vec<SuiteStudy>,
    /// Table 1 of the thesis.
    pub balls: Vec<BallRow>,
    /// What it saves to leave work out.
    pub left_out: Vec<LeftOut>,
    /// The field's cases of stress.
    pub extremes: Vec<Extreme>,
    /// What is not in it, and why.
    pub omissions: Vec<String>,
}

/// How far a study has come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyProgress {
    /// What is at work.
    pub what: String,
    /// Steps done in it.
    pub done: usize,
    /// Steps in it.
    pub total: usize,
}

/// Measures the contenders on a corpus, or on one suite of it and nothing else. `balls` are those of Table 1, which may be others; `omissions` are said in the
/// report along with what is found to be missing on the way.
///
/// # Errors
/// The corpus cannot be read, or its truth was made for other queries or BREPs.
pub fn study(
    corpus: &Path,
    suite: Option<&str>,
    mut contenders: Vec<Contender>,
    balls: Vec<Contender>,
    plan: Plan,
    omissions: Vec<String>,
    progress: &mut dyn FnMut(&StudyProgress),
) -> Result<Study, CorpusError> {
    let mut models = Models::new();
    let mut studies = Vec::new();
    for suite in suites(corpus, suite)? {
        let cases = cases(corpus, &suite, &mut models)?;
        let chosen = sample(cases.len(), plan.sample);
        let total = chosen.len();
        let mut tick = |done: usize| {
            progress(&StudyProgress {
                what: suite.name.clone(),
                done,
                total,
            });
        };
        tick(0);
        let floor = chosen
            .iter()
            .filter_map(|i| truth_width(&cases[*i].truth))
            .reduce(f64::max);
        studies.push(SuiteStudy {
            points: measure(
                &mut contenders,
                corpus,
                &cases,
                &chosen,
                &models,
                &plan,
                &mut tick,
            ),
            suite: suite.name.clone(),
            description: suite.file.description.clone(),
            queries: cases.len(),
            floor,
        });
    }
    let (mut rows, mut saved, mut hard) = (Vec::new(), Vec::new(), Vec::new());
    if suite.is_none() {
        rows = ball_rows(corpus, balls, &plan, progress)?;
        hard = extremes::extremes(corpus, &mut models, plan.seconds, &mut |done, total| {
            progress(&StudyProgress {
                what: "cases of stress".to_owned(),
                done,
                total,
            });
        })?;
        let mut done = 0;
        saved = left_out::compare(corpus, &mut models, &plan, &mut || {
            done += 1;
            progress(&StudyProgress {
                what: "what is left out".to_owned(),
                done,
                total: left_out::COUNT,
            });
        })?;
    }
    Ok(Study {
        about: About::here(corpus),
        plan,
        suites: studies,
        balls: rows,
        left_out: saved,
        extremes: hard,
        omissions,
    })
}

fn ball_rows(
    corpus: &Path,
    contenders: Vec<Contender>,
    plan: &Plan,
    progress: &mut dyn FnMut(&StudyProgress),
) -> Result<Vec<BallRow>, CorpusError> {
    let mut rows = Vec::new();
    let total = contenders.len() * BALL_JOINT.len();
    for mut contender in contenders {
        for (k, model) in BALL_JOINT.into_iter().enumerate() {
            progress(&StudyProgress {
                what: "Table 1 of the thesis".to_owned(),
                done: rows.len(),
                total,
            });
            // The mesh of one is as good as that of the other.
            if k == 0 || contender.engine.triangles().is_none() {
                rows.push(balls::row(&mut contender, corpus, model, plan)?);
            }
        }
    }
    Ok(rows)
}

impl Study {
    /// Writes `report.html`, `report.md` and `report.json` into a folder, which is made if need be.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let json = serde_json::to_string_pretty(self)?;
        std::fs::write(folder.join("report.json"), json + "\n")?;
        std::fs::write(folder.join("report.md"), self.summary())?;
        std::fs::write(folder.join("report.html"), self.page())
    }

    /// The engines' names in the order of their first use.
    fn engines(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for point in self.suites.iter().flat_map(|s| &s.points) {
            if !names.contains(&point.engine) {
                names.push(point.engine.clone());
            }
        }
        names
    }
}
