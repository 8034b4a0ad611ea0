//! `feeler simulate`.

use crate::{Bad, Outcome};
use feeler::query::Options;
use feeler_corpus::Model;
use feeler_gate::FeelerEngine;
use feeler_rapier::experiment::{Extent, NAMES, Scene, run as experiment};
use feeler_view::{Fineness, View};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Which experiment: `ball-joint`, `shift-gate` and `geneva` (the thesis's, 5.1 to 5.3), `rolling` (without bumps), `stiff` (penalty contact), `balls` (time per step).
    #[arg(value_parser = NAMES)]
    name: String,
    /// Where the page (`NAME.md`), its plots and views go.
    #[arg(long, default_value = "target/simulate")]
    out: PathBuf,
    /// Coarse meshes and short runs: within a minute.
    #[arg(long)]
    quick: bool,
    /// The finest mesh, too: 0.1 degrees for the ball joint, gigabytes and most of an hour.
    #[arg(long, conflicts_with = "quick")]
    finest: bool,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    corpora: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    let extent = match (args.quick, args.finest) {
        (true, _) => Extent::Quick,
        (_, true) => Extent::Finest,
        _ => Extent::Whole,
    };
    let models = args.corpora.join("models");
    let found = experiment(&args.name, &models, extent, &mut |what| eprintln!("{what}"));
    let found = found.map_err(Bad)?;
    let written = |path: &PathBuf, error| Bad(format!("{}: {error}", path.display()));
    std::fs::create_dir_all(&args.out).map_err(|e| written(&args.out, e))?;
    for (name, svg) in &found.plots {
        let path = args.out.join(name);
        std::fs::write(&path, svg).map_err(|e| written(&path, e))?;
    }
    for scene in found.scenes {
        let path = args.out.join(format!("{}.html", scene.name));
        let page = view(scene).map_err(|e| Bad(format!("{}: {e}", path.display())))?;
        std::fs::write(&path, page).map_err(|e| written(&path, e))?;
    }
    let path = args.out.join(format!("{}.md", args.name));
    std::fs::write(&path, &found.page).map_err(|e| written(&path, e))?;
    println!("{}", path.display());
    Ok(Outcome::Good)
}

/// The page that shows a scene.
fn view(scene: Scene) -> Result<String, String> {
    let model = Model {
        path: PathBuf::from(&scene.name),
        breps: vec![scene.brep],
    };
    let mut view = View::new(&scene.name, &model, &Fineness::default())?;
    let mut engine = FeelerEngine::new(Options::default());
    let lines = scene.queries.into_iter().map(Ok);
    view.ask(&model, &mut engine, (1..).zip(lines))?;
    Ok(view.page())
}
