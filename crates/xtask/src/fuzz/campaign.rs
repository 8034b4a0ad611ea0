//! Building, running and telling.

use super::guard::{Guard, STILL};
use super::{Args, found, seeds};
use feeler_fuzz::{LARGEST_INPUT, Scene, Target};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};
use xtask_test::root;

/// Seconds that one input may take: a hundred times a slow one.
const TIMEOUT: u32 = 60;
/// MB that a process may take.
const MEMORY: u32 = 3000;
/// Seconds for making one finding smaller.
const SMALLER: u32 = 30;
/// Findings of one target that are made smaller.
const MOST: usize = 8;

/// Of findings that are none when their input is run again.
const NOT_AGAIN: &str = ", and not again";

/// What a campaign on one target came to.
#[derive(Debug, Default)]
struct Told {
    seconds: f64,
    /// Of these, those of the first pass through what there was, in which nothing new is tried.
    first_pass: f64,
    executions: u64,
    coverage: u64,
    corpus: u64,
    /// Processes that stood still and were ended.
    still: usize,
    /// The first line of each kind of finding, and an input.
    findings: BTreeMap<String, PathBuf>,
    oracle: found::Held,
}

pub(super) fn run(args: &Args, chosen: &[Target]) -> Result<(), String> {
    let root = root();
    let mut all = Vec::new();
    for &target in chosen {
        let program = build(args, &target, &root)?;
        let told = campaign(args, &target, &root, &program)?;
        all.push((target, program, told));
    }
    let mut scenes = 0;
    for (target, program, told) in &all {
        for (why, input) in told.findings.iter().take(MOST) {
            println!("\n{}: {why}", target.name);
            // What is not found again would be run a hundred thousand times: of one input the engine counts runs, and not the time.
            let small = match why.ends_with(NOT_AGAIN) {
                true => input.clone(),
                false => smaller(program, input),
            };
            scenes += usize::from(keep(args, target, &small)?);
        }
        for (input, why) in &told.oracle.wrong {
            println!("\n{}: against the oracle: {why}", target.name);
            scenes += usize::from(keep(args, target, input)?);
        }
    }
    summary(args, &all, scenes)
}

/// Writes an input as a scene of the corpus of findings, if it makes one.
fn keep(args: &Args, target: &Target, input: &Path) -> Result<bool, String> {
    println!("    input {}", input.display());
    let bytes = std::fs::read(input).unwrap_or_default();
    let Some(scene) = target.kind.and_then(|k| Scene::decode(k, &bytes)) else {
        return Ok(false);
    };
    let name = input.file_name().unwrap_or_default().to_string_lossy();
    let name = format!("{}-{name}", target.name);
    found::write(&args.out, target, &name, &scene)?;
    Ok(true)
}

fn summary(args: &Args, all: &[(Target, PathBuf, Told)], scenes: usize) -> Result<(), String> {
    println!(
        "\n{:<16}{:>8}{:>12}{:>12}{:>8}{:>10}{:>8}{:>10}{:>16}",
        "target",
        "minutes",
        "first pass",
        "executions",
        "a s",
        "coverage",
        "kept",
        "findings",
        "oracle"
    );
    let mut found = 0;
    for (target, _, t) in all {
        found += t.findings.len() + t.oracle.wrong.len();
        println!(
            "{:<16}{:>8.1}{:>12.1}{:>12}{:>8.0}{:>10}{:>8}{:>10}{:>16}",
            target.name,
            t.seconds / 60.0,
            t.first_pass / 60.0,
            t.executions,
            t.executions as f64 / (t.seconds - t.first_pass).max(1.0),
            t.coverage,
            t.corpus,
            t.findings.len() + t.oracle.wrong.len(),
            format!("{} of {}", t.oracle.judged, t.oracle.judged + t.oracle.open),
        );
    }
    println!(
        "\nfirst pass: minutes through what there was, not in the rate; kept: inputs with coverage of their own; oracle: how many of their queries have a truth, all held against it{}",
        match all.iter().map(|(_, _, t)| t.oracle.left).sum::<usize>() {
            0 => String::new(),
            n => format!(" ({n} inputs were left out: --oracle-minutes)"),
        }
    );
    for (target, _, t) in all {
        if t.still > 0 {
            println!(
                "{}: {} processes of the engine stood still for {} s and were ended (each is among its crashes, and no finding)",
                target.name,
                t.still,
                STILL.as_secs()
            );
        }
        let whole = t.oracle.whole;
        if whole > 0 {
            println!(
                "{}: of the kept inputs {whole} were given to the second method whole",
                target.name
            );
        }
        let d = t.oracle.distances;
        if d.asked > 0 {
            println!(
                "    of {} distances in them {} are bound to no less than a thousandth of the model; {} were asked for with fewer boxes, as of high degree",
                d.asked, d.wide, d.fewer
            );
        }
    }
    if found == 0 {
        return Ok(());
    }
    if scenes > 0 {
        let truth = crate::truth::of_corpus(&args.out);
        if let Err(e) = truth {
            println!("the oracle's truth of the scenes: {e}");
        }
        println!(
            "\n{scenes} scenes; again by: cargo run --release -- gate --corpora {}",
            args.out.display()
        );
    }
    Err(format!("{found} findings"))
}

/// Builds a target; in a folder of its own, since cargo does not know that the compiler is wrapped.
fn build(args: &Args, target: &Target, root: &Path) -> Result<PathBuf, String> {
    let mut folder = root.join("target/fuzz/build");
    let wrapper = std::env::current_exe().map_err(|e| format!("this program's path: {e}"))?;
    let mut command = Command::new(env!("CARGO"));
    command.args(["build", "--release", "--quiet", "--bin", target.name]);
    let mut built = "release".to_owned();
    if args.asan {
        folder.push("asan");
        let host = crate::sanitize::host()?;
        command
            .env("RUSTC_BOOTSTRAP", "1")
            .env("RUSTFLAGS", "-Zsanitizer=address")
            // With a target named, flags do not reach build scripts.
            .args(["--target", &host]);
        built = format!("{host}/release");
    }
    println!("==> {}: building", target.name);
    command
        .current_dir(root.join("fuzz"))
        .arg("--target-dir")
        .arg(&folder)
        .env("RUSTC_WRAPPER", wrapper)
        .env(super::instrument::VARIABLE, "1");
    if target.name == "oracle_boundary" {
        command.args(["--features", "cgal"]);
    }
    let status = command
        .status()
        .map_err(|e| format!("cargo cannot be started: {e}"))?;
    if status.success() {
        Ok(folder.join(built).join(target.name))
    } else {
        Err(format!("{}: cannot be built (see above)", target.name))
    }
}

/// A number after a word in a line of the engine.
fn after(line: &str, word: &str) -> Option<u64> {
    let rest = &line[line.find(word)? + word.len()..];
    let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// Findings of one kind say the same but for their numbers.
fn without_numbers(line: &str) -> String {
    let mut text = String::new();
    let mut number = false;
    for c in line.chars() {
        let part = c.is_ascii_digit() || (number && matches!(c, '.' | 'e' | '-' | '+'));
        if !part {
            text.push(c);
        } else if !number {
            text.push('#');
        }
        number = part;
    }
    text
}

fn campaign(args: &Args, target: &Target, root: &Path, program: &Path) -> Result<Told, String> {
    let seeds = root.join("target/fuzz/seeds").join(target.name);
    let count = seeds::write(target, &root.join("corpora"), &seeds)?;
    let corpus = root.join("fuzz/corpus").join(target.name);
    let artifacts = root.join("fuzz/artifacts").join(target.name);
    for folder in [&corpus, &artifacts] {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    if args.minimise {
        minimise(target, program, &corpus, root)?;
    }
    let seconds = (60.0 * args.minutes).max(1.0) as u64;
    println!("==> {}: {seconds} s from {count} seeds", target.name);
    let (begun, started) = (Instant::now(), SystemTime::now());
    let mut child = Command::new(program)
        .arg(format!("-fork={}", args.jobs.max(1)))
        .args(["-ignore_crashes=1", "-ignore_timeouts=1", "-ignore_ooms=1"])
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-max_len={LARGEST_INPUT}"))
        .arg(format!("-timeout={TIMEOUT}"))
        .arg(format!("-rss_limit_mb={MEMORY}"))
        .arg(format!("-artifact_prefix={}/", artifacts.display()))
        .arg(&corpus)
        .arg(&seeds)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| format!("{}: {e}", program.display()))?;
    let guard = Guard::over(&child, STILL);
    let mut told = Told::default();
    let mut shown = Instant::now();
    let output = child.stderr.take().into_iter();
    for line in output.flat_map(|e| BufReader::new(e).lines()) {
        let Ok(line) = line else { break };
        if line.contains("starting to fuzz") {
            told.first_pass = begun.elapsed().as_secs_f64();
        }
        let Some(n) = after(&line, "#").filter(|_| line.starts_with('#')) else {
            continue;
        };
        told.executions = told.executions.max(n);
        told.coverage = told.coverage.max(after(&line, "cov: ").unwrap_or(0));
        told.corpus = told.corpus.max(after(&line, "corp: ").unwrap_or(0));
        if shown.elapsed() > Duration::from_secs(10) {
            shown = Instant::now();
            let bad = line.split("oom/timeout/crash: ").nth(1).unwrap_or("0/0/0");
            println!(
                "    {:>5.0} s: {n} executions, coverage {}, {} kept, oom/timeout/crash {}",
                begun.elapsed().as_secs_f64(),
                told.coverage,
                told.corpus,
                bad.split(' ').next().unwrap_or(bad)
            );
        }
    }
    let _ = child.wait();
    told.still = guard.count();
    told.seconds = begun.elapsed().as_secs_f64();
    told.findings = findings(target, program, &artifacts, started);
    let minutes = args.oracle_minutes.unwrap_or(0.25 * args.minutes);
    let limit = Duration::from_secs_f64(60.0 * minutes.max(0.0));
    told.oracle = found::hold(target, &corpus, started, limit);
    Ok(told)
}

/// Runs the engine to its end, under a guard.
fn guarded(command: &mut Command) -> std::io::Result<Output> {
    let child = command.spawn()?;
    let guard = Guard::over(&child, STILL);
    let output = child.wait_with_output();
    guard.count();
    output
}

/// Keeps of a folder only what the engine needs for all that it reaches.
fn minimise(target: &Target, program: &Path, corpus: &Path, root: &Path) -> Result<(), String> {
    let count = |folder: &Path| std::fs::read_dir(folder).map_or(0, Iterator::count);
    let before = count(corpus);
    if before == 0 {
        return Ok(());
    }
    let told = |path: &Path| {
        let path = path.display().to_string();
        move |e: std::io::Error| format!("{path}: {e}")
    };
    let fewer = root.join("target/fuzz/fewer").join(target.name);
    if fewer.exists() {
        std::fs::remove_dir_all(&fewer).map_err(told(&fewer))?;
    }
    std::fs::create_dir_all(&fewer).map_err(told(&fewer))?;
    println!("==> {}: one pass through {before} kept inputs", target.name);
    let begun = Instant::now();
    let output = guarded(
        Command::new(program)
            .arg("-merge=1")
            .arg(format!("-max_len={LARGEST_INPUT}"))
            .arg(format!("-timeout={TIMEOUT}"))
            .arg(format!("-rss_limit_mb={MEMORY}"))
            .args([&fewer, corpus])
            .stdout(Stdio::null())
            .stderr(Stdio::null()),
    )
    .map_err(told(program))?;
    let after = count(&fewer);
    if !output.status.success() || after == 0 {
        return Err(format!(
            "{}: the engine cannot merge {}",
            target.name,
            corpus.display()
        ));
    }
    // The old ones stay until the new ones are there.
    let old = corpus.with_extension("old");
    std::fs::rename(corpus, &old).map_err(told(&old))?;
    std::fs::rename(&fewer, corpus).map_err(told(corpus))?;
    std::fs::remove_dir_all(&old).map_err(told(&old))?;
    println!(
        "    {after} left after {:.0} s",
        begun.elapsed().as_secs_f64()
    );
    Ok(())
}

/// What the engine left in a folder since a time, by what is said when it is run again: one input of each kind.
fn findings(
    target: &Target,
    program: &Path,
    folder: &Path,
    since: SystemTime,
) -> BTreeMap<String, PathBuf> {
    let mut all = BTreeMap::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|e| e.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let finding = ["crash-", "timeout-", "oom-"]
            .iter()
            .any(|k| name.starts_with(k));
        let time = path.metadata().and_then(|m| m.modified());
        if !finding || time.is_ok_and(|t| t < since) {
            continue;
        }
        let run = guarded(
            Command::new(program)
                .arg(format!("-timeout={TIMEOUT}"))
                .arg(&path)
                .stdout(Stdio::null())
                .stderr(Stdio::piped()),
        );
        let text = run.map(|o| String::from_utf8_lossy(&o.stderr).into_owned());
        let text = text.unwrap_or_default();
        let why = reason(&text, target);
        // What is not found again took long, or much memory, beside other work.
        let kind = name.split('-').next().unwrap_or_default().to_owned();
        all.entry(why.map_or(kind + NOT_AGAIN, without_numbers))
            .or_insert_with(|| path.clone());
    }
    all
}

/// The line that tells most of why a run ended: a target's own, the sanitizer's or a panic's, the engine's.
fn reason<'a>(text: &'a str, target: &Target) -> Option<&'a str> {
    let own = format!("{}: ", target.name);
    let said = |l: &&str| l.starts_with(&own) || l.starts_with("memory: ");
    let others = [
        "panicked at",
        "ERROR: libFuzzer",
        "SUMMARY: AddressSanitizer",
    ];
    let other = |l: &&str| others.iter().any(|o| l.contains(o));
    text.lines().find(said).or_else(|| text.lines().find(other))
}

/// A shorter input with a finding, as far as the engine gets.
fn smaller(program: &Path, input: &Path) -> PathBuf {
    let name = input.file_name().unwrap_or_default().to_string_lossy();
    let out = input.with_file_name(format!("small-{name}"));
    let _ = guarded(
        Command::new(program)
            .args(["-minimize_crash=1", "-runs=100000"])
            .arg(format!("-max_total_time={SMALLER}"))
            .arg(format!("-timeout={TIMEOUT}"))
            .arg(format!("-exact_artifact_path={}", out.display()))
            .arg(input)
            .stdout(Stdio::null())
            .stderr(Stdio::null()),
    );
    if out.is_file() {
        out
    } else {
        input.to_path_buf()
    }
}

#[cfg(test)]
mod tests {
    use super::{after, reason, without_numbers};

    #[test]
    fn lines_of_the_engine() {
        let line =
            "#8192: cov: 4312 ft: 9001 corp: 214 exec/s 910 oom/timeout/crash: 0/0/1 time: 9s";
        assert_eq!(after(line, "#"), Some(8192));
        assert_eq!(after(line, "cov: "), Some(4312));
        assert_eq!(after(line, "corp: "), Some(214));
        assert_eq!(after("#8192 INITED", "cov: "), None);
    }

    #[test]
    fn findings_of_one_kind_have_one_name() {
        let a = without_numbers("side: 1.5e-3 is 12 off");
        assert_eq!(a, without_numbers("side: 27 is 1e300 off"));
        assert_ne!(a, without_numbers("side: 27 is 1e300 on"));
    }

    #[test]
    fn reasons_of_the_target_of_the_sanitizer_and_of_the_engine() {
        let target = feeler_fuzz::target("side").unwrap();
        let said = |text: &str| reason(text, &target).map(str::to_owned);
        assert_eq!(said("INFO: Seed: 7\nExecuted input in 3 ms\n"), None);
        let engine = "==7== ERROR: libFuzzer: deadly signal\nSUMMARY: libFuzzer: deadly signal";
        let panic = format!("thread 'main' panicked at src/a.rs:1:2:\n{engine}");
        assert_eq!(said(&panic).unwrap(), panic.lines().next().unwrap());
        assert_eq!(said(engine).unwrap(), engine.lines().next().unwrap());
        let own = format!("side: 3 is wrong\n{panic}");
        assert_eq!(said(&own).unwrap(), "side: 3 is wrong");
        // Not its first line, in which addresses differ between runs.
        let place = "SUMMARY: AddressSanitizer: heap-buffer-overflow src/a.rs:1:109 in a::main";
        let memory = format!(
            "==7==ERROR: AddressSanitizer: heap-buffer-overflow on address 0x7b8736fe003b\n{place}"
        );
        assert_eq!(said(&memory).unwrap(), place);
    }
}
