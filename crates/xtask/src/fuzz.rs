//! `cargo xtask fuzz TARGET|all`: campaigns of libFuzzer on the targets in `fuzz/`.
//!
//! The engine is built with the flags that cargo-fuzz passes, so that the stable toolchain serves and nothing need be installed; cargo-fuzz
//! in `fuzz/` works as well. What a run keeps for its coverage stays in `fuzz/corpus/TARGET`, and the next one starts from it; each of
//! those inputs is then put to the oracle, too. What is found is made smaller and written to a corpus of its own (`--out`), with
//! the oracle's truth, so that the gate repeats it.

#[cfg(feature = "cgal")]
mod campaign;
#[cfg(feature = "cgal")]
mod found;
#[cfg(feature = "cgal")]
mod guard;
pub(crate) mod instrument;
mod seeds;

use feeler_fuzz::{TARGETS, Target, target};
use std::path::PathBuf;

pub(crate) fn run(args: &Args) -> Result<(), String> {
    let chosen: Vec<Target> = match target(&args.target) {
        Some(one) => vec![one],
        None => TARGETS.to_vec(),
    };
    if let Some(folder) = &args.seeds {
        for target in &chosen {
            let corpora = xtask_test::root().join("corpora");
            let count = seeds::write(target, &corpora, &folder.join(target.name))?;
            println!("{}: {count} seeds", target.name);
        }
        return Ok(());
    }
    #[cfg(feature = "cgal")]
    return campaign::run(args, &chosen);
    #[cfg(not(feature = "cgal"))]
    crate::truth::again_with_oracle()
}

#[derive(Debug, clap::Args)]
#[cfg_attr(
    not(feature = "cgal"),
    allow(dead_code, reason = "read by the build with the oracle")
)]
pub(crate) struct Args {
    /// A target (`side`, `sphere`, `half_space`, `line`, `evaluate`, `split`, `read_3dm`, `read_brep`, `read_step`, `queries`, `oracle_boundary`), or `all`.
    #[arg(value_parser = known)]
    target: String,
    /// How long each target runs.
    #[arg(long, default_value_t = 5.0)]
    minutes: f64,
    /// How many processes at a time.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Under the address sanitizer: three times slower. It is no option of stable rustc; `RUSTC_BOOTSTRAP=1` is set for it.
    #[arg(long)]
    asan: bool,
    /// How many minutes the oracle may spend afterwards on the inputs that were kept for their coverage, new ones first, then a sample: a quarter of
    /// `--minutes` if not told.
    #[arg(long)]
    oracle_minutes: Option<f64>,
    /// Of what earlier runs kept, keep only inputs that reach what no others do: a pass through all of them, after which that of each campaign is
    /// shorter.
    #[arg(long)]
    minimise: bool,
    /// Run nothing: write the seeds into this folder, a folder for each target.
    #[arg(long, value_name = "FOLDER")]
    seeds: Option<PathBuf>,
    /// Where findings are written, as a corpus.
    #[arg(long, default_value = "target/fuzz/found")]
    out: PathBuf,
}

fn known(name: &str) -> Result<String, String> {
    if name == "all" || target(name).is_some() {
        Ok(name.to_owned())
    } else {
        let all = TARGETS.map(|t| t.name);
        Err(format!(
            "no such target; there are {}, or all",
            all.join(", ")
        ))
    }
}

#[cfg(test)]
mod tests {
    use feeler_fuzz::{TARGETS, smoke};

    /// A few seconds in all: fewer of what takes longer.
    fn wanted(name: &str) -> usize {
        match name {
            "side" | "evaluate" => 150,
            "oracle_boundary" => 40,
            _ => 60,
        }
    }

    #[test]
    fn nothing_is_found_by_a_few_inputs_of_each_target() {
        for target in &TARGETS {
            let wanted = wanted(target.name);
            let done = smoke(target, 1, wanted).unwrap();
            println!("{}: {done:?}", target.name);
            // Without the oracle one target has nothing to call.
            if target.name != "oracle_boundary" || cfg!(feature = "cgal") {
                assert_eq!(done.checked, wanted, "{}: {done:?}", target.name);
            }
        }
    }
}
