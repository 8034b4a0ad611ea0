//! rustc as cargo calls it for a campaign: the kernel, its readers and the targets tell the engine which branches they take; everything
//! else is compiled as ever.
//!
//! Operands of comparisons are told by the readers and the targets alone, whose words and numbers the engine tries elsewhere. In the kernel, whose
//! inner loops compare floats and indices, telling them took 61 % of the time of `sphere` and 12 % of that of `side`.
//!
//! The exact references would otherwise fill the corpus with inputs that are new to big integers alone, at half the speed.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

/// Set where this program is cargo's wrapper of rustc.
pub(crate) const VARIABLE: &str = "FEELER_FUZZ_WRAPPER";

/// What tells the engine which branches an input took: LLVM's SanitizerCoverage, as cargo-fuzz asks for it.
const COVERAGE: [&str; 6] = [
    "--cfg=fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-simplifycfg-branch-fold-threshold=0",
];
const COMPARES: &str = "-Cllvm-args=-sanitizer-coverage-trace-compares";
const KERNEL: &str = "feeler";
const OTHERS: [&str; 3] = ["feeler_io", "feeler_corpus", "feeler_fuzz"];

/// Calls rustc (the first argument) with the others, and more for our crates.
pub(crate) fn wrapped(arguments: Vec<OsString>) -> ExitCode {
    let Some((rustc, rest)) = arguments.split_first() else {
        return ExitCode::FAILURE;
    };
    let mut names = rest.windows(2).filter(|w| w[0] == "--crate-name");
    let name = names.next().map(|w| &w[1]);
    let is_kernel = name.is_some_and(|n| n == KERNEL);
    let is_other = name.is_some_and(|n| OTHERS.iter().any(|c| n == c));
    let mut command = Command::new(rustc);
    command.args(rest);
    if is_kernel || is_other {
        command.args(COVERAGE);
    }
    if is_other {
        command.arg(COMPARES);
    }
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}
