//! `cargo xtask instructions`: how many instructions a handful of queries take, held against the stored counts.
//!
//! Counts of valgrind's tool callgrind hardly change from run to run or with what else the machine does, so they may gate where times may
//! not. They do change with the compiler, so the stored ones are kept for each compiler and target by themselves. (The
//! crate gungraun does the same and more, but needs a runner program of its own version to be installed besides valgrind; counting one
//! function takes one option of callgrind.)

use crate::test::root;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A count so many percent above the stored one fails.
const MOST_RISE: u64 = 5;
/// A count this much smaller is worth storing: what was gained is then kept.
const WORTH_STORING: f64 = 0.05;
/// Counts by query, by compiler and target.
type Stored = BTreeMap<String, BTreeMap<String, u64>>;

const STORED: &str = "crates/feeler/benches/instructions.json";
const REFRESH: &str = "cargo xtask instructions --refresh";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Store the counts as they are now, for this compiler.
    #[arg(long)]
    refresh: bool,
}

/// Counts, and compares with or stores the counts of this compiler.
pub(crate) fn run(args: &Args) -> Result<(), String> {
    let root = root();
    let compiler = compiler()?;
    let path = root.join(STORED);
    let mut stored: Stored = match std::fs::read_to_string(&path) {
        Ok(text) => serde_json::from_str(&text).map_err(|e| format!("{STORED}: {e}"))?,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Stored::new(),
        Err(e) => return Err(format!("{STORED}: {e}")),
    };
    let counted = count_all(&root)?;
    if args.refresh {
        stored.insert(compiler.clone(), counted);
        let text = serde_json::to_string_pretty(&stored).map_err(|e| e.to_string())?;
        std::fs::write(&path, text + "\n").map_err(|e| format!("{STORED}: {e}"))?;
        println!("stored for {compiler} in {STORED}");
        return Ok(());
    }
    let Some(before) = stored.get(&compiler) else {
        println!("SKIPPED: {STORED} has no counts for {compiler}; store them by `{REFRESH}`.");
        return Ok(());
    };
    let (lines, verdict) = compare(before, &counted);
    lines.iter().for_each(|l| println!("{l}"));
    verdict
}

/// A line a query, and an error that names what has become dearer.
fn compare(
    before: &BTreeMap<String, u64>,
    now: &BTreeMap<String, u64>,
) -> (Vec<String>, Result<(), String>) {
    let mut lines = Vec::new();
    let mut dearer = Vec::new();
    let mut cheaper = false;
    for (name, count) in now {
        let Some(old) = before.get(name) else {
            lines.push(format!("    {name}: {count}, new"));
            continue;
        };
        let change = *count as f64 / *old as f64 - 1.0;
        lines.push(format!("    {name}: {count}, {:+.1} %", 100.0 * change));
        // In integers: a rise by just as much is none too many, however it would round.
        let most = u128::from(*old) * u128::from(100 + MOST_RISE);
        if u128::from(*count) * 100 > most {
            dearer.push(format!(
                "{name} takes {:.1} % more instructions ({count}, was {old})",
                100.0 * change
            ));
        }
        cheaper |= change < -WORTH_STORING;
    }
    for name in before.keys().filter(|n| !now.contains_key(*n)) {
        dearer.push(format!("{name} is no longer counted"));
    }
    if cheaper {
        lines.push(format!("    some became cheaper: keep that by `{REFRESH}`"));
    }
    if dearer.is_empty() {
        return (lines, Ok(()));
    }
    let what = dearer.join("; ");
    let error = format!(
        "{what}; more than {MOST_RISE} % fails. Find out why, or, if it is worth its price, store it by `{REFRESH}` and say so in the \
         commit message"
    );
    (lines, Err(error))
}

/// The compiler and its target: what a stored count holds for.
fn compiler() -> Result<String, String> {
    let out = Command::new("rustc")
        .arg("-vV")
        .output()
        .map_err(|e| format!("rustc cannot be started: {e}"))?;
    let text = String::from_utf8_lossy(&out.stdout);
    let field = |name: &str| {
        let line = text.lines().find_map(|l| l.strip_prefix(name));
        line.map(str::trim)
    };
    match (field("release:"), field("host:")) {
        (Some(release), Some(host)) => Ok(format!("{release} {host}")),
        _ => Err("`rustc -vV` says neither release nor host".to_owned()),
    }
}

fn count_all(root: &Path) -> Result<BTreeMap<String, u64>, String> {
    let build = Command::new(env!("CARGO"))
        .args("build --release --quiet --package feeler --example counted".split(' '))
        .current_dir(root)
        .status();
    if !build.is_ok_and(|s| s.success()) {
        return Err("the example `counted` of the crate feeler cannot be built".to_owned());
    }
    let target = std::env::var_os("CARGO_TARGET_DIR");
    let target = target.map_or_else(|| root.join("target"), PathBuf::from);
    let program = target.join("release/examples/counted");
    let names = Command::new(&program)
        .output()
        .map_err(|e| format!("{}: {e}", program.display()))?;
    let names = String::from_utf8_lossy(&names.stdout).into_owned();
    let file = target.join("counted.callgrind");
    let mut out = BTreeMap::new();
    for name in names.lines() {
        out.insert(name.to_owned(), count(&program, name, &file)?);
    }
    if out.is_empty() {
        return Err("the example `counted` lists no queries".to_owned());
    }
    Ok(out)
}

/// The instructions within the function `counted_queries`.
fn count(program: &Path, name: &str, file: &Path) -> Result<u64, String> {
    let run = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg("--toggle-collect=*counted_queries*")
        .arg(format!("--callgrind-out-file={}", file.display()))
        .arg(program)
        .arg(name)
        .output()
        .map_err(|e| format!("valgrind cannot be started ({e}); install it"))?;
    let said = String::from_utf8_lossy(&run.stderr);
    if !run.status.success() {
        return Err(format!("valgrind failed on {name}: {said}"));
    }
    let text = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    match total(&text) {
        Some(count) if count > 0 => Ok(count),
        _ => Err(format!("callgrind counted nothing for {name}: {said}")),
    }
}

/// The sum of a file of callgrind's.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix("totals:"))?;
    line.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(of: &[(&str, u64)]) -> BTreeMap<String, u64> {
        of.iter().map(|(n, c)| ((*n).to_owned(), *c)).collect()
    }

    #[test]
    fn a_rise_fails_and_a_fall_does_not() {
        let before = counts(&[("a", 1000), ("b", 1000)]);
        assert!(compare(&before, &before).1.is_ok());
        let (lines, verdict) = compare(&before, &counts(&[("a", 1050), ("b", 10)]));
        assert!(verdict.is_ok());
        assert!(lines.iter().any(|l| l.contains(REFRESH)), "{lines:?}");
        let (_, verdict) = compare(&before, &counts(&[("a", 1051), ("b", 1000)]));
        let error = verdict.unwrap_err();
        assert!(error.starts_with("a takes 5.1 % more"), "{error}");
        assert!(
            error.contains(REFRESH) && !error.contains("b takes"),
            "{error}"
        );
    }

    #[test]
    fn what_is_no_longer_counted_fails_and_what_is_new_does_not() {
        let one = counts(&[("a", 1000)]);
        let two = counts(&[("a", 1000), ("b", 1)]);
        assert!(compare(&one, &two).1.is_ok());
        assert!(compare(&two, &one).1.is_err());
    }

    #[test]
    fn totals_of_callgrind() {
        let text = "events: Ir\nfn=(1) x\n0 5\ntotals: 12345\n";
        assert_eq!(total(text), Some(12345));
        assert_eq!(total("events: Ir\n"), None);
    }
}
