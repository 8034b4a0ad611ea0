//! rustc as cargo calls it for a campaign: the kernel, its readers and the targets tell the engine which branches they take; everything
//! else is compiled as ever.
//!
//! The exact references would otherwise fill the corpus with inputs that are new to big integers alone, at half the speed.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

/// Set where this program is cargo's wrapper of rustc.
pub(crate) const VARIABLE: &str = "FEELER_FUZZ_WRAPPER";

/// What tells the engine which branches an input took: LLVM's SanitizerCoverage, as cargo-fuzz asks for it.
const COVERAGE: [&str; 7] = [
    "--cfg=fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "-Cllvm-args=-simplifycfg-branch-fold-threshold=0",
];
const CRATES: [&str; 4] = ["feeler", "feeler_io", "feeler_corpus", "feeler_fuzz"];

/// Calls rustc (the first argument) with the others, and more for our crates.
pub(crate) fn wrapped(arguments: Vec<OsString>) -> ExitCode {
    let Some((rustc, rest)) = arguments.split_first() else {
        return ExitCode::FAILURE;
    };
    let names = rest.windows(2).filter(|w| w[0] == "--crate-name");
    let ours = names.into_iter().any(|w| CRATES.iter().any(|c| w[1] == *c));
    let mut command = Command::new(rustc);
    command.args(rest);
    if ours {
        command.args(COVERAGE);
    }
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}
