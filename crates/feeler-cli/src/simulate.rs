//! `feeler simulate`.

use crate::{Bad, Outcome};
use feeler_rapier::experiment::{Extent, NAMES, run as experiment};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Which experiment: `ball-joint` and `shift-gate` (the thesis's, 5.1 and 5.2), `rolling` (without bumps), `stiff` (penalty contact), `balls` (time per step).
    #[arg(value_parser = NAMES)]
    name: String,
    /// Where the page (`NAME.md`) and its plots go.
    #[arg(long, default_value = "target/simulate")]
    out: PathBuf,
    /// Coarse meshes and short runs: within a minute.
    #[arg(long)]
    quick: bool,
    /// The corpus.
    #[arg(long, default_value = "corpora")]
    corpora: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<Outcome, Bad> {
    let extent = if args.quick {
        Extent::Quick
    } else {
        Extent::Whole
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
    let path = args.out.join(format!("{}.md", args.name));
    std::fs::write(&path, &found.page).map_err(|e| written(&path, e))?;
    println!("{}", path.display());
    Ok(Outcome::Good)
}
