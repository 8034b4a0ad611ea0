//! `cargo xtask mutants`: a seeded sample of small changes to some modules of the kernel, each asked of the kernel crate's own tests.
//!
//! The changes are those of cargo-mutants (operators, returned values, guards and arms of `match`: `list`). It builds for each; here all of the sample
//! are written into a copy of the tree (`target/mutants/tree`) at once, each behind a switch, as [`crate::plant`] does with its mistakes, and what does
//! not compile so is taken out. Each test runs once alone to tell which changes it reaches; then each change is asked of the tests that reach it, the quickest
//! first, until one fails or takes ten times as long. Property tests have one seed.

mod ask;
mod list;

use crate::plant::{artifacts, lay, read};
use crate::random::Random;
use ask::{Test, Verdict};
use list::{Mutant, mutants, with_switches};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use xtask_test::root;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folders of the kernel's sources.
    #[arg(long, default_values = ["numeric", "nurbs", "trim"])]
    module: Vec<String>,
    /// Changes of each that compile.
    #[arg(long, default_value_t = 100)]
    sample: usize,
    /// Another one gives another sample.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many are asked at a time.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Leave out tests that take more seconds than that (they are named).
    #[arg(long, default_value_t = 20.0)]
    longest: f64,
    /// Seconds of tests for each change.
    #[arg(long, default_value_t = 600.0)]
    budget: f64,
    /// Ask only about those that the last run left (`target/mutants/left.txt`), of whatever sample they were: as far as their functions are the same.
    #[arg(long)]
    left: bool,
    /// Ask only tests whose names hold this, or one of these.
    #[arg(long)]
    tests: Vec<String>,
    /// Only list the sample, before it is compiled.
    #[arg(long)]
    list: bool,
}

const KERNEL: &str = "crates/feeler/src/lib.rs";
const SOURCES: &str = "crates/feeler/src";

pub(crate) fn run(args: &Args) -> Result<(), String> {
    let place = root().join("target/mutants");
    let (tree, left) = (place.join("tree"), place.join("left.txt"));
    let mut samples: Vec<(&str, Vec<Mutant>, usize)> = Vec::new();
    for module in &args.module {
        let (all, count) = shuffled(module, args.seed)?;
        samples.push((module, all, count));
    }
    if args.list {
        for m in samples
            .iter()
            .flat_map(|(_, all, _)| all.iter().take(args.sample))
        {
            println!("{} (line {})", m.name, m.line);
        }
        return Ok(());
    }
    let mut sample = args.sample;
    if args.left {
        let text =
            std::fs::read_to_string(&left).map_err(|e| format!("{}: {e}", left.display()))?;
        let names: BTreeSet<&str> = text.lines().collect();
        for (_, all, _) in &mut samples {
            all.retain(|m| names.contains(m.name.as_str()));
        }
        sample = usize::MAX;
        let found: usize = samples.iter().map(|(_, all, _)| all.len()).sum();
        println!("==> {found} of {} that were left are there", names.len());
    }
    println!("==> build");
    let chosen = compiled(&samples, sample, &tree, &place.join("refused.txt"))?;
    let folder = tree.join("crates/feeler");
    let programs = artifacts(&mut cargo(&tree, "test --no-run --lib --test *"))?;
    let mut all = Vec::new();
    for (_, _, program) in &programs {
        all.extend(ask::tests(&folder, program)?);
    }
    let named = |t: &Test| args.tests.iter().any(|word| t.name.contains(word.as_str()));
    all.retain(|t| args.tests.is_empty() || named(t));
    println!("==> {} tests, each alone", all.len());
    let mut tests = Vec::new();
    for mut test in all {
        if test.learn(&folder, &place.join("reached.txt"))? {
            tests.push(test);
        } else {
            println!("    left out: {} fails without a change", test.name);
        }
    }
    tests.sort_by_key(|t| t.usual);
    let seconds = |t: &Test| t.usual.as_secs_f64();
    println!(
        "    {:.0} s",
        tests.iter().map(seconds).fold(0.0, std::ops::Add::add)
    );
    for test in tests.extract_if(.., |t| t.usual.as_secs_f64() > args.longest) {
        println!("    left out: {} ({:.0} s)", test.name, seconds(&test));
    }
    let asked: Vec<(usize, &Mutant)> = (1..).zip(chosen.iter()).collect();
    println!("==> {} changes", asked.len());
    let verdicts = ask_all(args, &folder, &tests, &asked)?;
    let mut names = String::new();
    for (module, _, count) in &samples {
        let of = |m: &Mutant| m.file.starts_with(&format!("{SOURCES}/{module}/"));
        let all: Vec<_> = asked
            .iter()
            .zip(&verdicts)
            .filter(|((_, m), _)| of(m))
            .collect();
        let is_caught = |v: &Verdict| matches!(v, Verdict::Caught(_));
        let caught = all.iter().filter(|(_, v)| is_caught(v)).count();
        let [low, high] = interval(caught, all.len());
        println!(
            "\n{module}: {caught} of {} caught ({:.0} to {:.0} %), of {count} in all; left:",
            all.len(),
            100.0 * low,
            100.0 * high
        );
        for ((_, m), verdict) in all.iter().filter(|(_, v)| !is_caught(v)) {
            let tests = match verdict {
                Verdict::Left(0) => "no test reaches it".to_owned(),
                Verdict::Left(n) => format!("{n} tests"),
                Verdict::LeftInTime(n, of) => format!("{n} of {of} tests, for want of time"),
                Verdict::Caught(_) => continue,
            };
            println!("    {} (line {}; {tests})", m.name, m.line);
            names += &format!("{}\n", m.name);
        }
    }
    std::fs::write(&left, names).map_err(|e| format!("{}: {e}", left.display()))
}

/// The changes of a module in the order of a seed; how many there are.
fn shuffled(module: &str, seed: u64) -> Result<(Vec<Mutant>, usize), String> {
    let folder = root().join(SOURCES).join(module);
    let mut files = Vec::new();
    let mut folders = vec![folder];
    while let Some(folder) = folders.pop() {
        let entries =
            std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        for path in entries.flatten().map(|e| e.path()) {
            // Tests in files of their own.
            if path.file_stem().is_some_and(|s| s == "tests") {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    let mut all = Vec::new();
    for path in &files {
        let name = path
            .strip_prefix(root())
            .unwrap_or(path)
            .display()
            .to_string();
        all.extend(mutants(&name, &read(&name)?)?);
    }
    // D. E. Knuth, "The Art of Computer Programming" 2, 3.4.2, algorithm P.
    let mut random = Random::new(&format!("{module} {seed}"));
    for i in (1..all.len()).rev() {
        all.swap(i, random.below(i + 1));
    }
    let count = all.len();
    Ok((all, count))
}

fn cargo(tree: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO"));
    command
        .args(arguments.split_whitespace())
        .args([
            "-p",
            "feeler",
            "--profile",
            "ci",
            "--quiet",
            "--message-format=json",
        ])
        .current_dir(tree)
        .env("CARGO_TARGET_DIR", root().join("target/mutants/build"));
    command
}

/// Of each module the first that compile, laid out in the tree; the number of each is its place, from 1. Those that do not are kept in a file, so that the
/// next run need not build in vain (to ask the compiler anew, delete it).
fn compiled(
    samples: &[(&str, Vec<Mutant>, usize)],
    wanted: usize,
    tree: &Path,
    refused: &Path,
) -> Result<Vec<Mutant>, String> {
    let known = std::fs::read_to_string(refused).unwrap_or_default();
    let mut bad: BTreeSet<String> = known.lines().map(str::to_owned).collect();
    loop {
        let mut chosen: Vec<Mutant> = Vec::new();
        for (_, all, _) in samples {
            let good = all.iter().filter(|m| !bad.contains(&m.name));
            chosen.extend(good.take(wanted).cloned());
        }
        let mut of_file: BTreeMap<&str, Vec<(usize, &Mutant)>> = BTreeMap::new();
        for (number, m) in (1..).zip(&chosen) {
            of_file.entry(&m.file).or_default().push((number, m));
        }
        let mut changed =
            BTreeMap::from([(KERNEL, read(KERNEL)? + &ask::switch(chosen.len() + 1))]);
        let mut places: BTreeMap<&str, Vec<(Range<usize>, usize)>> = BTreeMap::new();
        for (file, some) in of_file {
            let (text, where_) = with_switches(&read(file)?, &some);
            changed.insert(file, text);
            places.insert(file, where_);
        }
        lay(tree, &changed)?;
        let output = cargo(tree, "check")
            .stderr(Stdio::inherit())
            .output()
            .map_err(|e| format!("cargo cannot be started: {e}"))?;
        if output.status.success() {
            let all: Vec<&str> = bad.iter().map(String::as_str).collect();
            std::fs::write(refused, all.join("\n"))
                .map_err(|e| format!("{}: {e}", refused.display()))?;
            println!("    {} that do not compile are left out", bad.len());
            return Ok(chosen);
        }
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let before = bad.len();
        for (file, at) in text.lines().flat_map(errors) {
            let near = places.get(file.as_str()).and_then(|p| blamed(p, &at));
            bad.extend(near.and_then(|n| chosen.get(n - 1)).map(|m| m.name.clone()));
        }
        if bad.len() == before {
            let told = text
                .lines()
                .filter_map(|l| serde_json::from_str::<Value>(l).ok());
            let told: Vec<String> = told
                .filter_map(|v| Some(v["message"]["rendered"].as_str()?.to_owned()))
                .collect();
            return Err(format!(
                "does not compile, through none of the changes:\n{}",
                told.concat()
            ));
        }
    }
}

/// Places that an error of the compiler names, if the line is one.
fn errors(line: &str) -> Vec<(String, Range<usize>)> {
    let Ok(v) = serde_json::from_str::<Value>(line) else {
        return Vec::new();
    };
    if v["message"]["level"] != "error" {
        return Vec::new();
    }
    let spans = v["message"]["spans"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    let place = |s: &Value| {
        let number = |name: &str| s[name].as_u64().and_then(|n| usize::try_from(n).ok());
        let file = s["file_name"].as_str()?.to_owned();
        Some((file, number("byte_start")?..number("byte_end")?))
    };
    spans.iter().filter_map(place).collect()
}

/// The change whose text holds a place.
fn blamed(places: &[(Range<usize>, usize)], at: &Range<usize>) -> Option<usize> {
    let within = places
        .iter()
        .find(|(r, _)| r.start <= at.start && at.start < r.end);
    within.map(|(_, n)| *n)
}

fn ask_all(
    args: &Args,
    folder: &Path,
    tests: &[Test],
    asked: &[(usize, &Mutant)],
) -> Result<Vec<Verdict>, String> {
    let budget = Duration::from_secs_f64(args.budget.max(0.0));
    let begun = Instant::now();
    let next = AtomicUsize::new(0);
    let verdicts: Mutex<BTreeMap<usize, Result<Verdict, String>>> = Mutex::default();
    std::thread::scope(|scope| {
        for _ in 0..args.jobs.max(1) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some((number, m)) = asked.get(i) else {
                        break;
                    };
                    let verdict = ask::ask(folder, tests, *number, budget);
                    let said = match &verdict {
                        Ok(Verdict::Caught(by)) => format!("caught by {by}"),
                        Ok(_) => "LEFT".to_owned(),
                        Err(e) => e.clone(),
                    };
                    println!(
                        "{:>5.0} s {:>4} {} (line {}): {said}",
                        begun.elapsed().as_secs_f64(),
                        i + 1,
                        m.name,
                        m.line
                    );
                    let mut all = verdicts.lock().unwrap_or_else(|e| e.into_inner());
                    all.insert(i, verdict);
                }
            });
        }
    });
    let all = verdicts.into_inner().unwrap_or_else(|e| e.into_inner());
    all.into_values().collect()
}

/// The interval of C. J. Clopper and E. S. Pearson (Biometrika 26, 1934) for a share, 95 %.
fn interval(caught: usize, of: usize) -> [f64; 2] {
    // The chance of so many or more at a share.
    let at_least = |k: usize, share: f64| -> f64 {
        let mut sum = 0.0;
        for j in k..=of {
            let chosen: f64 = (0..j)
                .map(|i| ((of - i) as f64 / (j - i) as f64).ln())
                .sum();
            let power = |x: f64, n: usize| if n == 0 { 0.0 } else { n as f64 * x.ln() };
            sum += (chosen + power(share, j) + power(1.0 - share, of - j)).exp();
        }
        sum
    };
    let share_with = |k: usize, chance: f64| -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        // As often as an f64 has digits.
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            if at_least(k, middle) < chance {
                low = middle
            } else {
                high = middle
            }
        }
        low
    };
    let low = if caught == 0 {
        0.0
    } else {
        share_with(caught, 0.025)
    };
    let high = if caught == of {
        1.0
    } else {
        share_with(caught + 1, 0.975)
    };
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R's `binom.test`.
    #[test]
    fn clopper_and_pearson() {
        for (k, n, low, high) in [
            (7, 10, 0.3475, 0.9333),
            (0, 10, 0.0, 0.3085),
            (10, 10, 0.6915, 1.0),
            (1, 2, 0.0126, 0.9874),
        ] {
            let [a, b] = interval(k, n);
            assert!(
                (a - low).abs() < 1e-4 && (b - high).abs() < 1e-4,
                "{k} of {n}: {a} {b}"
            );
        }
    }

    #[test]
    fn errors_are_blamed_on_the_change_that_they_are_in() {
        let line = r#"{"reason":"compiler-message","message":{"level":"error","spans":[{"file_name":"a.rs","byte_start":12,"byte_end":14}]}}"#;
        let all = errors(line);
        assert_eq!(all, [("a.rs".to_owned(), 12..14)]);
        assert_eq!(blamed(&[(0..5, 1), (10..20, 2)], &all[0].1), Some(2));
        assert_eq!(blamed(&[(0..5, 1)], &all[0].1), None);
        assert!(errors("{}").is_empty());
    }

    #[test]
    fn a_seed_gives_a_sample() {
        let names = |seed| -> Vec<String> {
            let (all, _) = shuffled("numeric", seed).unwrap();
            all.iter().take(20).map(|m| m.name.clone()).collect()
        };
        assert_eq!(names(1), names(1));
        assert_ne!(names(1), names(2));
    }
}
