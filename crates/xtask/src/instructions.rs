//! `cargo xtask instructions`: how many instructions a handful of queries take, held against the stored counts.
//!
//! Counts of valgrind's tool callgrind hardly change from run to run or with what else the machine does, so they may gate where times may
//! not. They do change with the compiler, so the stored ones are kept for each compiler and target by themselves; under a compiler that
//! has none, those of the merge base with the main branch are counted in a worktree of its own, and held against. (The
//! crate gungraun does the same and more, but needs a runner program of its own version to be installed besides valgrind; counting one
//! function takes one option of callgrind.)

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use xtask_test::root;

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
    /// Only build what is counted: what is built is not built again later.
    #[arg(long, conflicts_with = "refresh")]
    build_only: bool,
}

/// Counts, and compares with or stores the counts of this compiler.
pub(crate) fn run(args: &Args) -> Result<(), String> {
    let root = root();
    if args.build_only {
        return build(&root, &target(&root));
    }
    let compiler = compiler()?;
    let path = root.join(STORED);
    let mut stored: Stored = match std::fs::read_to_string(&path) {
        Ok(text) => serde_json::from_str(&text).map_err(|e| format!("{STORED}: {e}"))?,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Stored::new(),
        Err(e) => return Err(format!("{STORED}: {e}")),
    };
    let counted = count_all(&root, &target(&root))?;
    if args.refresh {
        stored.insert(compiler.clone(), counted);
        let text = serde_json::to_string_pretty(&stored).map_err(|e| e.to_string())?;
        std::fs::write(&path, text + "\n").map_err(|e| format!("{STORED}: {e}"))?;
        println!("stored for {compiler} in {STORED}");
        return Ok(());
    }
    let before = match stored.remove(&compiler) {
        Some(before) => before,
        None => {
            println!("    {STORED} has no counts for {compiler} (`{REFRESH}` stores them)");
            let folder = target(&root).join("base");
            match of_base(&root, &folder, &counted) {
                Ok(before) => before,
                Err(why) => {
                    println!("SKIPPED: no earlier commit to hold the counts against: {why}");
                    return Ok(());
                }
            }
        }
    };
    let (lines, verdict) = compare(&before, &counted);
    lines.iter().for_each(|l| println!("{l}"));
    verdict
}

/// The counts of the base, of those that are still counted: what is gone since was taken out on purpose.
fn of_base(
    root: &Path,
    folder: &Path,
    now: &BTreeMap<String, u64>,
) -> Result<BTreeMap<String, u64>, String> {
    let base = worktree(root, folder)?;
    println!("    held against those of the commit {base}, counted now");
    let counted = count_all(folder, &folder.join("target"));
    let mut before = counted.map_err(|e| format!("in {}: {e}", folder.display()))?;
    before.retain(|name, _| now.contains_key(name));
    Ok(before)
}

/// What git says of a folder, without the line's end.
fn git(folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let out = Command::new("git")
        .arg("-C")
        .arg(folder)
        .args(arguments)
        // A hook of git's has set them, to mean its own.
        .env_remove("GIT_DIR")
        .env_remove("GIT_WORK_TREE")
        .env_remove("GIT_INDEX_FILE")
        .output()
        .map_err(|e| format!("git cannot be started: {e}"))?;
    if out.status.success() {
        return Ok(String::from_utf8_lossy(&out.stdout).trim().to_owned());
    }
    let said = String::from_utf8_lossy(&out.stderr);
    Err(format!("`git {}`: {}", arguments.join(" "), said.trim()))
}

/// The commit where this branch left the main one, there or here; on the main branch itself the commit before.
fn base(root: &Path) -> Result<String, String> {
    let head = git(root, &["rev-parse", "HEAD"])?;
    let mut merge_base = Err("there is no main branch".to_owned());
    for main in ["origin/main", "main"] {
        merge_base = merge_base.or_else(|_| git(root, &["merge-base", "HEAD", main]));
    }
    match merge_base {
        Ok(base) if base != head => Ok(base),
        Ok(_) => git(root, &["rev-parse", "--verify", "HEAD^"]),
        Err(why) => Err(why),
    }
    .map_err(|e| format!("{e}; a clone with its history has one"))
}

/// Makes a folder the worktree of the base, or turns the one that is there to it.
fn worktree(root: &Path, folder: &Path) -> Result<String, String> {
    let base = base(root)?;
    if folder.join(".git").exists() {
        git(folder, &["checkout", "--force", "--detach", &base])?;
    } else {
        let path = folder.to_string_lossy();
        // Also where the folder of an earlier one was removed.
        git(
            root,
            &["worktree", "add", "--force", "--detach", &path, &base],
        )?;
    }
    match folder.join("crates/feeler/examples/counted.rs").exists() {
        true => Ok(base),
        false => Err(format!("the commit {base} has no example `counted`")),
    }
}

/// The folder that cargo builds into.
fn target(root: &Path) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR");
    target.map_or_else(|| root.join("target"), |t| root.join(t))
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

fn build(root: &Path, target: &Path) -> Result<(), String> {
    let build = Command::new(env!("CARGO"))
        .args("build --release --quiet --package feeler --example counted".split(' '))
        .arg("--target-dir")
        .arg(target)
        .current_dir(root)
        .status();
    if !build.is_ok_and(|s| s.success()) {
        return Err("the example `counted` of the crate feeler cannot be built".to_owned());
    }
    Ok(())
}

fn count_all(root: &Path, target: &Path) -> Result<BTreeMap<String, u64>, String> {
    build(root, target)?;
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

    /// Commits on a main branch and beside it, a folder without git, and a shallow clone.
    #[test]
    fn the_base_is_where_the_branch_left() {
        let folder = std::env::temp_dir().join(format!("feeler-base-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        let (root, shallow) = (folder.join("root"), folder.join("shallow"));
        std::fs::create_dir_all(&root).unwrap();
        // Of which no folder above is under git.
        if git(&root, &["rev-parse", "HEAD"]).is_ok() || git(&root, &["init"]).is_err() {
            eprintln!("SKIPPED: no git, or all is under git");
            return;
        }
        let git = |arguments: &[&str]| git(&root, arguments).unwrap();
        assert!(base(&root).is_err(), "no commit");
        let commit = || {
            let name = ["-c", "user.name=x", "-c", "user.email=x@y"];
            let name = [&name[..], &["-c", "commit.gpgsign=false"]].concat();
            let message = ["commit", "--allow-empty", "--quiet", "-m", "x"];
            git(&[&name[..], &message[..]].concat());
            git(&["rev-parse", "HEAD"])
        };
        git(&["checkout", "--quiet", "-b", "main"]);
        let first = commit();
        assert!(base(&root).is_err(), "no commit before");
        let second = commit();
        assert_eq!(base(&root), Ok(first));
        git(&["checkout", "--quiet", "-b", "branch"]);
        commit();
        let last = commit();
        assert_eq!(base(&root), Ok(second.clone()));
        // A commit of the main branch here which is not there yet.
        git(&["update-ref", "refs/remotes/origin/main", &second]);
        git(&["branch", "--force", "main", &last]);
        assert_eq!(base(&root), Ok(second));
        assert!(
            worktree(&root, &folder.join("worktree"))
                .unwrap_err()
                .contains("has no example")
        );

        let from = format!("file://{}", root.display());
        let to = shallow.to_string_lossy();
        git(&["clone", "--quiet", "--depth", "1", &from, &to]);
        assert!(base(&shallow).unwrap_err().contains("history"));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn totals_of_callgrind() {
        let text = "events: Ir\nfn=(1) x\n0 5\ntotals: 12345\n";
        assert_eq!(total(text), Some(12345));
        assert_eq!(total("events: Ir\n"), None);
    }
}
