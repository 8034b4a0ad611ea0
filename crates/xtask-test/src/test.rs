//! `cargo xtask test`: everything that must hold before a change lands.

use crate::{root, setup};
use std::path::Path;
use std::process::Command;
use std::thread::JoinHandle;
use std::time::Instant;

/// The features that run batches on several threads, and build the experiments in Rapier and Rapier with its threads. The same in all steps: with
/// others much of what is built for one would be built again for the next.
const FEATURES: &str = "feeler/rayon,feeler-cli/simulate,feeler-rapier/parallel";

/// The features that build the oracle.
const ORACLE: &str = "feeler-oracle/cgal,xtask/cgal";

/// The first build's answers to the corpora, which the second build's are held against.
const ANSWERS: &str = "target/gate/answers.txt";

/// Installs what is missing and runs all checks, in order of what fails fastest.
///
/// # Errors
/// What failed, or could not be installed or started.
pub fn run() -> Result<(), String> {
    let root = root();
    let here = std::env::current_exe().map_err(|e| format!("this program's path: {e}"))?;
    // Where it will be once it has been built with the oracle.
    let program = here.with_file_name("xtask");
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
        &mut cargo(&format!(
            "clippy --profile ci --workspace --all-targets --quiet --features {FEATURES} -- -D warnings"
        )),
    )?;
    step(
        "clippy with the oracle",
        &mut cargo(&format!(
            "clippy --profile ci --workspace --all-targets --quiet --features {FEATURES},{ORACLE} -- -D warnings"
        )),
    )?;
    step(
        "documentation",
        cargo(&format!(
            // With the examples also their dependencies are those that clippy has checked.
            "doc --profile ci --workspace --lib --bins --examples --no-deps --quiet --features {FEATURES}"
        ))
        .env("RUSTDOCFLAGS", "-D warnings"),
    )?;
    step(
        "the tests, the tasks and the program, with the oracle",
        &mut cargo(&format!(
            // All at once: of other features of some crates there would be another build of all that needs them.
            "build --profile ci --workspace --bins --tests --quiet --features {FEATURES},{ORACLE}"
        )),
    )?;
    let other_builds = build_beside(&root, &program);
    let test = |targets: &str| {
        let mut command = cargo(&format!(
            "test --profile ci --workspace {targets} --features {FEATURES},{ORACLE}"
        ));
        if let Some(python) = &python {
            command.env("FEELER_PYTHON", python);
        }
        command
    };
    let tested = step(
        "unit, property, oracle and snapshot tests",
        // Without the targets named it would build the examples as well, whose code clippy has checked.
        &mut test("--lib --bins --tests"),
    );
    // Should one have failed, its step says so below; and none goes on where a test has.
    let _ = other_builds.join();
    tested?;
    step("doctests", &mut test("--doc"))?;
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
        Command::new(program.with_file_name("feeler")).args(["gate", "--answers", ANSWERS]),
    )?;
    step(
        "the same bits from another build",
        &mut own(&format!("bits --answers {ANSWERS}")),
    )?;
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

/// Builds what two later steps count and compare, while tests leave a core idle: some of them take but one.
fn build_beside(root: &Path, program: &Path) -> JoinHandle<()> {
    let (root, program) = (root.to_path_buf(), program.to_path_buf());
    std::thread::spawn(move || {
        for task in ["instructions", "bits"] {
            let mut command = Command::new("nice");
            command.args(["-n", "19"]).arg(&program);
            // Where it fails the step itself builds, or says why it cannot.
            let _ = { command.args([task, "--build-only"]) }
                .current_dir(&root)
                .status();
        }
    })
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

fn available(program: &str) -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|p| p.join(program).is_file()))
}
