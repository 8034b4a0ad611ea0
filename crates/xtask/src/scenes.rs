//! `cargo xtask scenes`: the corpus's queries, from fixed seeds, and the models that are made here.

mod analytic;
mod cases;
mod loops;
mod models;
mod shapes;
mod stress;
mod trims;

use feeler::brep::Brep;
use feeler_corpus::{Ceilings, MODELS, Model, QueryLine, SuiteFile, write_text};
use std::path::Path;

/// A model and what is asked of it.
pub(crate) struct Scene {
    /// The model: a path from the corpus's `models` folder; or, with BREPs, the name of the file to
    /// write them to.
    pub(crate) name: String,
    /// The model's BREPs, where it is made here.
    pub(crate) breps: Vec<Brep>,
    /// The queries.
    pub(crate) queries: Vec<QueryLine>,
}

/// Scenes with a subject.
pub(crate) struct Suite {
    /// The folder.
    pub(crate) name: &'static str,
    /// For `suite.json`.
    pub(crate) description: &'static str,
    /// The scenes.
    pub(crate) scenes: Vec<Scene>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// One suite alone.
    #[arg(long)]
    suite: Option<String>,
}

pub(crate) fn run(corpus: &Path, args: &Args) -> Result<(), String> {
    let mut suites = models::kinds(corpus)?;
    suites.extend([
        models::ball_joint(),
        models::splits(corpus)?,
        models::parts(corpus)?,
        models::flush(corpus)?,
        models::many_pieces(corpus)?,
        models::options(corpus)?,
        models::grazing(corpus)?,
        models::round_lines(corpus)?,
        analytic::suite(corpus)?,
        trims::suite()?,
        stress::suite()?,
        cases::suite()?,
    ]);
    let mut total = 0;
    for suite in &suites {
        if args.suite.as_ref().is_none_or(|s| s == suite.name) {
            let count = write(corpus, suite)?;
            println!(
                "{}: {count} queries of {} models",
                suite.name,
                suite.scenes.len()
            );
            total += count;
        }
    }
    println!("{total} queries written; now run `cargo xtask truth --prune`");
    Ok(())
}

/// Writes models and queries; `suite.json` only where there is none, for its ceilings are set by hand.
fn write(corpus: &Path, suite: &Suite) -> Result<usize, String> {
    let folder = corpus.join(suite.name);
    let fail = |e: std::io::Error| format!("{}: {e}", folder.display());
    std::fs::create_dir_all(&folder).map_err(fail)?;
    let mut text = String::new();
    let mut count = 0;
    for scene in &suite.scenes {
        let mut model = scene.name.clone();
        if !scene.breps.is_empty() {
            model = format!("{}/{}.json.gz", suite.name, scene.name);
            let path = corpus.join(MODELS).join(&model);
            let parent = path.parent().unwrap_or(&path);
            std::fs::create_dir_all(parent).map_err(fail)?;
            Model::write(&path, &scene.breps, None).map_err(|e| e.to_string())?;
        }
        for query in &scene.queries {
            let line = QueryLine {
                model: Some(model.clone()),
                ..query.clone()
            };
            // What no engine takes is no query: overflow, or a normal that is none.
            if line.query().is_ok() {
                text += &(line.to_text() + "\n");
                count += 1;
            }
        }
    }
    write_text(&folder.join("queries.jsonl.gz"), &text).map_err(fail)?;
    let path = folder.join("suite.json");
    if !path.exists() {
        let file = SuiteFile {
            description: suite.description.to_owned(),
            ceilings: Ceilings::default(),
        };
        let text = serde_json::to_string_pretty(&file).map_err(|e| e.to_string())?;
        write_text(&path, &(text + "\n")).map_err(fail)?;
    }
    Ok(count)
}
