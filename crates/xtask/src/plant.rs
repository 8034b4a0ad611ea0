//! `cargo xtask plant`: mistakes put into the kernel one at a time, and who notices.
//!
//! The mistakes stand in `plants.txt`. Each is put into a copy of the tree (`target/plant/tree`), which keeps a build folder of its
//! own, so that from one to the next little is built again. Four watchers are asked: the kernel's unit tests (`cargo test -p feeler --lib`),
//! its property tests and tests of whole queries (`--test '*'`), the smoke of the fuzz targets, and the gate. A mistake that does not
//! compile is no mistake.

use crate::test::root;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Only mistakes whose words hold this.
    #[arg(long)]
    only: Option<String>,
    /// Only list them.
    #[arg(long)]
    list: bool,
    /// Inputs of each fuzz target.
    #[arg(long, default_value_t = 400)]
    inputs: usize,
    /// Seconds after which a watcher counts as having noticed: a mistake may keep a search from ending.
    #[arg(long, default_value_t = 300)]
    patience: u64,
}

const PLANTS: &str = include_str!("../plants.txt");

/// A mistake.
#[derive(Debug, PartialEq)]
struct Plant<'a> {
    name: &'a str,
    file: &'a str,
    old: Vec<&'a str>,
    new: Vec<&'a str>,
}

fn plants(text: &str) -> Result<Vec<Plant<'_>>, String> {
    let mut all: Vec<Plant<'_>> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let at = |what: &str| format!("plants.txt:{}: {what}", i + 1);
        let Some((mark, rest)) = line.split_once(' ') else {
            return Err(at("a mark and words"));
        };
        if mark == "=" {
            all.push(Plant {
                name: rest,
                file: "",
                old: Vec::new(),
                new: Vec::new(),
            });
            continue;
        }
        let plant = all.last_mut().ok_or_else(|| at("begin with `= name`"))?;
        match mark {
            "@" => plant.file = rest,
            "-" => plant.old.push(rest.trim()),
            "+" => plant.new.push(rest.trim()),
            _ => return Err(at("a line begins with =, @, - or +")),
        }
    }
    Ok(all)
}

impl Plant<'_> {
    /// The file's text with the mistake in it.
    fn applied(&self, text: &str) -> Result<String, String> {
        let lines: Vec<&str> = text.lines().collect();
        let count = self.old.len();
        let starts: Vec<usize> = (0..lines.len().saturating_sub(count.max(1) - 1))
            .filter(|i| (0..count).all(|k| lines[i + k].trim() == self.old[k]))
            .collect();
        match starts[..] {
            [at] if count > 0 && self.old != self.new => {
                let mut out: Vec<&str> = lines[..at].to_vec();
                out.extend(&self.new);
                out.extend(&lines[at + count..]);
                Ok(out.join("\n") + "\n")
            }
            _ => Err(format!(
                "`{}`: its lines are {} times in {}; correct plants.txt",
                self.name,
                starts.len(),
                self.file
            )),
        }
    }
}

/// Who may notice.
const WATCHERS: [&str; 4] = ["unit", "property", "fuzz", "gate"];

pub(crate) fn run(args: &Args) -> Result<(), String> {
    let all = plants(PLANTS)?;
    let chosen: Vec<&Plant<'_>> = all
        .iter()
        .filter(|p| args.only.as_deref().is_none_or(|o| p.name.contains(o)))
        .collect();
    if args.list {
        for p in &chosen {
            println!("{:<60} {}", p.name, p.file);
        }
        return Ok(());
    }
    let root = root();
    let place = root.join("target/plant");
    let tree = place.join("tree");
    copy(&root, &tree)?;
    // What is wrong without any mistake would count for all of them.
    println!("==> without a mistake");
    let watched = watch(args, &tree, &place)?;
    if let Some(i) = (0..WATCHERS.len()).find(|i| watched[*i]) {
        return Err(format!("`{}` fails without any mistake", WATCHERS[i]));
    }
    let mut table = Vec::new();
    for plant in &chosen {
        let path = tree.join(plant.file);
        let text =
            std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let planted = plant.applied(&text)?;
        let write = |text: &str| {
            std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
        };
        write(&planted)?;
        let begun = Instant::now();
        let watched = watch(args, &tree, &place);
        write(&text)?;
        let line = match &watched {
            Ok(w) => (0..WATCHERS.len()).fold(String::new(), |s, i| {
                s + &format!("{:>10}", if w[i] { "noticed" } else { "-" })
            }),
            Err(e) => format!("  {e}"),
        };
        println!(
            "{:<52}{line}   {:.0} s",
            plant.name,
            begun.elapsed().as_secs_f64()
        );
        table.push((plant.name, watched));
    }
    summary(&table)
}

fn summary(table: &[(&str, Result<[bool; 4], String>)]) -> Result<(), String> {
    println!(
        "\n{:<52}{}",
        "mistake",
        WATCHERS.map(|w| format!("{w:>10}")).concat()
    );
    let mut by_count: BTreeMap<usize, usize> = BTreeMap::new();
    let mut each = [0; 4];
    let mut few = Vec::new();
    for (name, watched) in table {
        match watched {
            Ok(w) => {
                let marks = w.map(|x| format!("{:>10}", if x { "noticed" } else { "-" }));
                println!("{name:<52}{}", marks.concat());
                let count = w.iter().filter(|x| **x).count();
                *by_count.entry(count).or_default() += 1;
                for i in 0..4 {
                    each[i] += usize::from(w[i]);
                }
                if count < 2 {
                    few.push(*name);
                }
            }
            Err(e) => println!("{name:<52}  {e}"),
        }
    }
    println!(
        "{:<52}{}",
        "noticed, of all",
        each.map(|n| format!("{n:>10}")).concat()
    );
    for (count, n) in &by_count {
        println!("{n} noticed by {count} of the four");
    }
    if few.is_empty() {
        Ok(())
    } else {
        Err(format!("noticed by fewer than two: {}", few.join("; ")))
    }
}

/// The tracked files, and those not yet tracked. A file that is the same stays as it is, so that nothing is built for it.
fn copy(root: &Path, tree: &Path) -> Result<(), String> {
    let listed = Command::new("git")
        .args([
            "ls-files",
            "--cached",
            "--others",
            "--exclude-standard",
            "-z",
        ])
        .current_dir(root)
        .output()
        .map_err(|e| format!("git cannot be started: {e}"))?;
    for name in String::from_utf8_lossy(&listed.stdout).split('\0') {
        let (from, to) = (root.join(name), tree.join(name));
        let Ok(bytes) = std::fs::read(&from) else {
            continue;
        };
        if std::fs::read(&to).is_ok_and(|old| old == bytes) {
            continue;
        }
        let io = |e: std::io::Error| format!("{}: {e}", to.display());
        std::fs::create_dir_all(to.parent().unwrap_or(tree)).map_err(io)?;
        std::fs::write(&to, bytes).map_err(io)?;
    }
    Ok(())
}

/// Which of the watchers notice; an error where it does not compile.
fn watch(args: &Args, tree: &Path, place: &Path) -> Result<[bool; 4], String> {
    let cargo = |arguments: &str| {
        let mut command = Command::new(env!("CARGO"));
        command
            .args(arguments.split_whitespace())
            .current_dir(tree)
            .env("CARGO_TARGET_DIR", place.join("build"))
            // Little changes from one mistake to the next.
            .env("CARGO_INCREMENTAL", "1")
            .env("CARGO_PROFILE_RELEASE_DEBUG", "0")
            .env("CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS", "true")
            .env("CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS", "true")
            .env("RUSTFLAGS", "--cap-lints=allow")
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        command
    };
    let built = [
        "test --release --no-run -p feeler",
        "build --release -p xtask --example smoke",
        "build --release -p feeler-cli",
    ];
    for arguments in built {
        let status = cargo(arguments).status();
        if !status
            .map_err(|e| format!("cargo cannot be started: {e}"))?
            .success()
        {
            return Err(format!("does not compile (cargo {arguments})"));
        }
    }
    let limit = Duration::from_secs(args.patience);
    let release = place.join("build/release");
    let program = |path: PathBuf, arguments: &[String]| {
        let mut command = Command::new(path);
        command
            .args(arguments)
            .current_dir(tree)
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        command
    };
    let inputs = [args.inputs.to_string()];
    let gate = ["gate".to_owned()];
    let commands = [
        cargo("test --release -p feeler --lib"),
        cargo("test --release -p feeler --test *"),
        program(release.join("examples/smoke"), &inputs),
        program(release.join("feeler"), &gate),
    ];
    let mut noticed = [false; 4];
    for (i, command) in commands.into_iter().enumerate() {
        noticed[i] = !passes(command, limit)?;
    }
    Ok(noticed)
}

/// Whether a command ends well in time.
fn passes(mut command: Command, limit: Duration) -> Result<bool, String> {
    use std::os::unix::process::CommandExt;
    // In a group of its own, which is ended as a whole.
    let mut child = command
        .process_group(0)
        .spawn()
        .map_err(|e| format!("cannot be started: {e}"))?;
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            return Ok(status.success());
        }
        if begun.elapsed() > limit {
            let group = format!("-{}", child.id());
            let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
            let _ = child.wait();
            return Ok(false);
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mistake_finds_its_lines_once() {
        let all = plants(PLANTS).unwrap();
        assert!(all.len() >= 30, "{}", all.len());
        for plant in &all {
            let path = root().join(plant.file);
            let text = std::fs::read_to_string(&path).unwrap();
            let planted = plant.applied(&text).unwrap();
            assert_ne!(planted, text, "{}", plant.name);
        }
    }

    #[test]
    fn lines_that_are_not_there_or_twice_are_refused() {
        let text = "= a\n@ f\n- x;\n+ y;\n";
        let plant = &plants(text).unwrap()[0];
        assert_eq!(plant.applied("a\n    x;\nb\n").unwrap(), "a\ny;\nb\n");
        assert!(plant.applied("a\nb\n").is_err());
        assert!(plant.applied("x;\nx;\n").is_err());
        assert!(plants("- x\n").is_err());
    }
}
