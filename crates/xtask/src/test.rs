//! `cargo xtask test`: everything that must hold before a change lands.

use crate::{bits, setup};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// The features that build the oracle, run batches on several threads, and build the experiments in Rapier and Rapier with its threads.
const FEATURES: &str =
    "feeler-oracle/cgal,xtask/cgal,feeler/rayon,feeler-cli/simulate,feeler-rapier/parallel";

/// Installs what is missing and runs all checks, in order of what fails fastest.
pub(crate) fn run() -> Result<(), String> {
    let root = root();
    // Where it will be once it has been built with the oracle; asked for before that takes its place.
    let program = std::env::current_exe().map_err(|e| format!("this program's path: {e}"))?;
    setup::install_packages()?;
    let python = setup::python(&root);
    let start = Instant::now();
    let mut steps = 0;
    let mut step = |what: &str, command: &mut Command| {
        println!("==> {what}");
        let begun = Instant::now();
        let status = command
            .current_dir(&root)
            .status()
            .map_err(|e| format!("{what}: cannot be started: {e}"))?;
        steps += 1;
        println!("    {what}: {:.0} s", begun.elapsed().as_secs_f64());
        if status.success() {
            Ok(())
        } else {
            Err(format!("{what} failed"))
        }
    };
    let cargo = |arguments: &str| {
        let mut command = Command::new(env!("CARGO"));
        command.args(arguments.split_whitespace());
        command
    };
    step("formatting", &mut cargo("fmt --all --check"))?;
    step(
        "clippy without the oracle",
        &mut cargo(
            "clippy --profile ci --package feeler-oracle --package xtask --all-targets --quiet -- -D warnings",
        ),
    )?;
    step(
        "clippy with the oracle",
        &mut cargo(&format!(
            "clippy --profile ci --workspace --all-targets --quiet --features {FEATURES} -- -D warnings"
        )),
    )?;
    step(
        "documentation",
        cargo("doc --profile ci --workspace --no-deps --quiet").env("RUSTDOCFLAGS", "-D warnings"),
    )?;
    let mut tests = cargo(&format!(
        "test --profile ci --workspace --features {FEATURES}"
    ));
    if let Some(python) = &python {
        tests.env("FEELER_PYTHON", python);
    }
    step(
        "unit, property, oracle and snapshot tests, doctests",
        &mut tests,
    )?;
    step(
        "this program with the oracle",
        &mut cargo(&format!(
            // With the tests: of other features of some crates there would be another build of all that needs them.
            "build --profile ci --workspace --bins --tests --quiet --features {FEATURES}"
        )),
    )?;
    let own = |arguments: &str| {
        let mut command = Command::new(&program);
        command.args(arguments.split_whitespace());
        command
    };
    step(
        "a sample of the truth, computed again",
        &mut own("truth --check"),
    )?;
    step(
        "a sample of the truth against the second method",
        &mut own("truth --verify --sample 4"),
    )?;
    step("instructions of some queries", &mut own("instructions"))?;
    // As `cargo run --release -- gate`, but for another build of everything.
    step(
        "the gate",
        Command::new(program.with_file_name("feeler")).args(["gate", "--answers", bits::ANSWERS]),
    )?;
    step("the same bits from another build", &mut own("bits"))?;
    release_is_free_of_the_oracle(&root)?;
    if available("cargo-deny") {
        step(
            "licences and advisories",
            &mut cargo("deny --config .deny.toml check licenses bans sources"),
        )?;
    } else {
        println!("SKIPPED: cargo-deny is not installed (`cargo install cargo-deny`).");
    }
    let minutes = start.elapsed().as_secs_f64() / 60.0;
    println!("xtask test: all {steps} steps passed in {minutes:.1} minutes");
    Ok(())
}

/// The program must not depend on the oracle, whose libraries are under the LGPL.
fn release_is_free_of_the_oracle(root: &Path) -> Result<(), String> {
    let tree = Command::new(env!("CARGO"))
        .args("tree --package feeler-cli --edges normal --prefix none".split(' '))
        .current_dir(root)
        .output()
        .map_err(|e| format!("cargo tree cannot be started: {e}"))?;
    let text = String::from_utf8_lossy(&tree.stdout);
    if !tree.status.success() || !text.contains("feeler-gate") {
        return Err("cargo tree failed".to_owned());
    }
    if text.contains("feeler-oracle") {
        return Err("the program depends on the oracle (`cargo tree -p feeler-cli`)".to_owned());
    }
    println!("==> the program does not depend on the oracle");
    Ok(())
}

/// The workspace's folder.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}

fn available(program: &str) -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|p| p.join(program).is_file()))
}
