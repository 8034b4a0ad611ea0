//! Experiments: the ball joint and the shift gate of the 2014 thesis, and rolling without bumps, in Rapier; stiff contact by an integrator of
//! its own.
//!
//! Each gives a [`Finding`]: a page of Markdown, plots, and nothing that is not measured or a closed form.

mod ball_joint;
mod balls;
mod geneva;
mod plot;
mod rolling;
mod sheet;
mod shift_gate;
mod stiff;
mod world;

use feeler::brep::Brep;
use feeler_corpus::{ContactsLine, QueryLine, SphereLine};
use feeler_io::{ObjectKind, read_file};
use std::path::Path;

/// What an experiment found.
#[derive(Clone, Debug, Default)]
pub struct Finding {
    /// A page in Markdown that refers to the plots.
    pub page: String,
    /// Plots: file name and SVG.
    pub plots: Vec<(String, String)>,
    /// What is to be seen in space.
    pub scenes: Vec<Scene>,
}

/// A part of an experiment and where others touched it, as queries that a picture may ask.
#[derive(Clone, Debug)]
pub struct Scene {
    /// A file name without its ending.
    pub name: String,
    /// The part.
    pub brep: Brep,
    /// Probes in the part's frame.
    pub queries: Vec<QueryLine>,
}

/// How much of it is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Seconds: coarse meshes, short runs. For tests.
    Quick,
    /// Minutes.
    Whole,
    /// The same, and what takes gigabytes and most of an hour: the ball joint's mesh of 0.1 degrees.
    Finest,
}

/// The names of the experiments.
pub const NAMES: [&str; 6] = [
    "ball-joint",
    "balls",
    "geneva",
    "rolling",
    "shift-gate",
    "stiff",
];

/// Runs an experiment; `models` is the folder `corpora/models`, `progress` hears of each run.
///
/// # Errors
/// In one line: there is no such experiment, or a part cannot be read or cut into triangles.
pub fn run(
    name: &str,
    models: &Path,
    extent: Extent,
    progress: &mut dyn FnMut(&str),
) -> Result<Finding, String> {
    let mut finding = match name {
        "ball-joint" => ball_joint::run(models, extent, progress),
        "balls" => balls::run(extent, progress),
        "geneva" => geneva::run(models, extent, progress),
        "rolling" => rolling::run(extent, progress),
        "shift-gate" => shift_gate::run(models, extent, progress),
        "stiff" => stiff::run(models, extent, progress),
        _ => Err(format!(
            "there is no experiment {name}: give one of {}",
            NAMES.join(", ")
        )),
    }?;
    for scene in &finding.scenes {
        let file = format!("{}.html", scene.name);
        if !finding.page.contains(&file) {
            let what = format!(
                "\n[The part with the ball in {} places]({file})\n",
                scene.queries.len()
            );
            finding.page += &what;
        }
    }
    Ok(finding)
}

/// The first BREP of a part of the thesis.
fn part(models: &Path, file: &str) -> Result<Brep, String> {
    let path = models.join("thesis").join(file);
    let document = read_file(&path).map_err(|e| e.to_string())?;
    let brep = document.objects.into_iter().find_map(|o| match o.kind {
        ObjectKind::Brep(brep) => Some(brep),
        _ => None,
    });
    brep.ok_or_else(|| format!("{}: no BREP in it", path.display()))
}

/// A ball as a query, with all that is known of its contacts up to a distance.
fn ball_query(name: &str, center: [f64; 3], radius: f64, prediction: f64) -> QueryLine {
    QueryLine {
        id: Some(name.into()),
        sphere: Some(SphereLine { center, radius }),
        contacts: Some(ContactsLine::All),
        prediction: Some(prediction),
        ..QueryLine::default()
    }
}

/// Most places of one run in a picture.
const DRAWN: usize = 12;

/// A part and the balls of a run on it, spread over its places, the first and the last among them; with what is within a hundredth of the radius.
fn drawn(name: &str, brep: Brep, radius: f64, places: &[[f64; 3]]) -> Scene {
    let count = places.len().min(DRAWN);
    let queries = (0..count).map(|k| {
        let place = k * (places.len() - 1) / (count - 1).max(1);
        let name = format!("place {} of {}", place + 1, places.len());
        ball_query(&name, places[place], radius, 0.01 * radius)
    });
    Scene {
        name: name.to_owned(),
        queries: queries.collect(),
        brep,
    }
}

/// The median; NaN of nothing.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
    [mean, square.sqrt()]
}

/// A number for a table.
fn short(x: f64) -> String {
    if x == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&x.abs()) {
        let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.2e}")
    }
}

/// A table in Markdown.
fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<String> = head.iter().map(|h| (*h).to_owned()).collect();
    let rule: Vec<String> = head.iter().map(|_| "---".to_owned()).collect();
    let rows: String = rows.iter().map(|r| line(r)).collect();
    line(&head) + &line(&rule) + &rows
}
