//! `cargo xtask bits`: the program built a second time with other code generation, and its answers to all stored queries held
//! against those of the first build, bit for bit.
//!
//! The first is what `cargo xtask test` built: optimisation of level 2, checks of overflow and assertions, for any processor of the
//! architecture. The second has level 1, no checks, and, where this processor has them, fused multiply-add and wider vectors. It asks
//! on one thread more, too.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;
use xtask_test::root;

/// The profile of the second build.
const PROFILE: &str = "other";
/// The level of x86-64 with FMA and AVX2.
const LEVEL: &str = "x86-64-v3";
/// Where the first build's answers are.
const ANSWERS: &str = "target/gate/answers.txt";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The answers of the first build, from its `feeler gate --answers FILE`.
    #[arg(long, value_name = "FILE", default_value = ANSWERS)]
    answers: PathBuf,
    /// Only build the program the second time: what is built is not built again later.
    #[arg(long)]
    build_only: bool,
}

/// Builds, asks, and compares.
pub(crate) fn run(args: &Args) -> Result<(), String> {
    let root = root();
    let folder = PathBuf::from("target").join(PROFILE);
    let flags = if has_level() {
        format!("-Ctarget-cpu={LEVEL}")
    } else {
        println!(
            "SKIPPED: this processor is none of {LEVEL}; the second build differs in its optimisation alone."
        );
        String::new()
    };
    let build = Command::new(env!("CARGO"))
        .args("build --quiet --package feeler-cli --profile".split(' '))
        .arg(PROFILE)
        .arg("--target-dir")
        .arg(&folder)
        .env("CARGO_ENCODED_RUSTFLAGS", flags)
        .current_dir(&root)
        .status();
    if !build.is_ok_and(|s| s.success()) {
        return Err("the second build failed".to_owned());
    }
    if args.build_only {
        return Ok(());
    }
    let read = |path: &PathBuf| {
        std::fs::read_to_string(root.join(path)).map_err(|e| format!("{}: {e}", path.display()))
    };
    let first = read(&args.answers).map_err(|e| {
        format!("{e}; write them by `cargo run --release -- gate --answers {ANSWERS}`")
    })?;
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
    let answers = folder.join("answers.txt");
    // None of an earlier build's, should there be no new ones.
    let _ = std::fs::remove_file(root.join(&answers));
    let program = folder.join(PROFILE).join("feeler");
    let gate = Command::new(root.join(&program))
        .args(["gate", "--jobs", &(cores + 1).to_string()])
        .arg("--out")
        .arg(folder.join("gate"))
        .arg("--answers")
        .arg(&answers)
        .current_dir(&root)
        .output()
        .map_err(|e| format!("{}: {e}", program.display()))?;
    // Of the first build it is known whether its answers are right: here what differs says more than which are wrong.
    let second = read(&answers)
        .map_err(|e| format!("{e}: {}", String::from_utf8_lossy(&gate.stderr).trim()))?;
    let count = compare(&first, &second)?;
    println!("    {count} answers are the same, bit for bit");
    Ok(())
}

/// Whether code for that level runs here: what it may use of the instructions that the programming language can ask about.
fn has_level() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("f16c")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("movbe");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

/// How many answers both have, or an error with the first of each file of queries that differs.
fn compare(first: &str, second: &str) -> Result<usize, String> {
    let mut count = 0;
    // File, how many differ, and the first.
    let mut files: Vec<(&str, usize, String)> = Vec::new();
    let (mut a, mut b) = (first.lines(), second.lines());
    loop {
        let (a, b) = match (a.next(), b.next()) {
            (None, None) => break,
            (Some(a), Some(b)) => (a, b),
            _ => return Err("the builds were asked different numbers of queries".to_owned()),
        };
        count += 1;
        if a == b {
            continue;
        }
        let place = a.split('\t').next().unwrap_or(a);
        if b.split('\t').next() != Some(place) {
            return Err(format!("the builds were asked other queries: at {place}"));
        }
        let file = place.rsplit_once(':').map_or(place, |(file, _)| file);
        match files.iter_mut().find(|f| f.0 == file) {
            Some(found) => found.1 += 1,
            None => files.push((file, 1, format!("  first:  {a}\n  second: {b}"))),
        }
    }
    if count == 0 {
        return Err("there are no answers".to_owned());
    }
    if files.is_empty() {
        return Ok(count);
    }
    let mut text = "two builds answer differently".to_owned();
    for (file, differ, shown) in files {
        let _ = write!(text, "\n{file}: {differ} answers; the first:\n{shown}");
    }
    Err(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: &str =
        "a/x.jsonl:1\t{\"side\":\"inside\"}\na/x.jsonl:2\t{\"t\":0.1}\nb/y.jsonl:1\t{\"t\":0.0}\n";

    #[test]
    fn every_bit_counts() {
        assert_eq!(compare(FIRST, FIRST), Ok(3));
        let error = compare(FIRST, &FIRST.replace("0.1", "0.10000000000000002")).unwrap_err();
        assert!(error.contains("a/x.jsonl: 1 answers"), "{error}");
        assert!(error.contains("a/x.jsonl:2\t{\"t\":0.10000000000000002}"));
        assert!(!error.contains("b/y.jsonl"), "{error}");
        // The sign of zero does, too.
        let error = compare(FIRST, &FIRST.replace("0.0", "-0.0")).unwrap_err();
        assert!(error.contains("b/y.jsonl: 1 answers"), "{error}");
    }

    #[test]
    fn what_cannot_be_compared_fails() {
        assert!(compare("", "").is_err());
        assert!(compare(FIRST, "").is_err());
        assert!(compare(FIRST, &FIRST.replace("x.jsonl:1", "x.jsonl:3")).is_err());
    }
}
