//! Who may notice a mistake, and asking them: programs, each ended at the first thing it finds wrong.

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Who may notice: unit tests of the kernel, its tests of properties and whole queries (`--test '*'`), the fuzz targets, the gate.
pub(super) const WATCHERS: [&str; 4] = ["unit", "property", "fuzz", "gate"];

/// What the scratch copy's kernel reads: the number of the mistake that is switched on.
pub(super) const SWITCH: &str = "FEELER_PLANTED";

/// A mistake may make a program ask for ever more memory: what it may have, in KiB.
pub(crate) const MEMORY: u64 = 8 << 20;

/// A suite that is not asked: its lists of contacts take as long as all others.
const LEFT_OUT: &str = "contacts";

/// Queries of each suite that are asked first.
const SAMPLE: &str = "200";

/// A program that may notice.
#[derive(Debug)]
pub(super) struct Watcher {
    /// Which of `WATCHERS`.
    pub(super) of: usize,
    /// Asked only about what fewer than two of `WATCHERS` have noticed without it: it takes long.
    pub(super) is_late: bool,
    name: String,
    program: PathBuf,
    arguments: Vec<String>,
    /// How long it takes where there is no mistake.
    usual: Duration,
}

/// What was built: its kind, its name and where it is.
pub(crate) fn artifacts(cargo: &mut Command) -> Result<Vec<(String, String, PathBuf)>, String> {
    let done = cargo
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("cargo cannot be started: {e}"))?;
    if !done.status.success() {
        return Err("does not compile".to_owned());
    }
    let text = String::from_utf8_lossy(&done.stdout);
    let artifact = |line: &str| {
        let v: Value = serde_json::from_str(line).ok()?;
        let path = v["executable"].as_str()?.into();
        let kind = v["target"]["kind"][0].as_str()?.to_owned();
        Some((kind, v["target"]["name"].as_str()?.to_owned(), path))
    };
    Ok(text.lines().filter_map(artifact).collect())
}

/// Builds the tree, and says who may be asked.
pub(super) fn build(tree: &Path, target: &Path, inputs: usize) -> Result<Vec<Watcher>, String> {
    let cargo = |arguments: &str| {
        let mut command = Command::new(env!("CARGO"));
        command
            .args(arguments.split_whitespace())
            .args(["--profile", "ci", "--quiet", "--message-format=json"])
            .current_dir(tree)
            .env("CARGO_TARGET_DIR", target)
            .env("RUSTFLAGS", "--cap-lints=allow");
        command
    };
    let tests = artifacts(&mut cargo("test --no-run -p feeler --lib --test *"))?;
    let programs = "build -p feeler-cli -p xtask --bin feeler --example smoke";
    let programs = artifacts(&mut cargo(programs))?;
    let mut all = Vec::new();
    let mut add = |of: usize, name: &str, program: &Path, arguments: &[&str], is_late: bool| {
        all.push(Watcher {
            of,
            is_late,
            name: name.to_owned(),
            program: program.to_owned(),
            arguments: arguments.iter().map(|a| (*a).to_owned()).collect(),
            usual: Duration::ZERO,
        });
    };
    for (kind, name, path) in &tests {
        let of = if kind == "test" { 1 } else { 0 };
        add(of, name, path, &["--test-threads=1"], false);
    }
    let corpora = tree.join("corpora");
    let suites = feeler_corpus::suites(&corpora, None).map_err(|e| e.to_string())?;
    for (_, name, path) in &programs {
        if name == "smoke" {
            add(2, name, path, &[&inputs.to_string()], false);
        } else {
            let out = target.join("gate").display().to_string();
            for suite in suites.iter().filter(|s| s.name != LEFT_OUT) {
                let mut asked = vec!["gate", "--jobs", "1", "--out", &out, "--suite", &suite.name];
                add(3, &format!("{}, all", suite.name), path, &asked, true);
                asked.extend(["--sample", SAMPLE]);
                add(3, &suite.name, path, &asked, false);
            }
        }
    }
    Ok(all)
}

impl Watcher {
    /// Measures how long it takes without a mistake.
    ///
    /// # Errors
    /// What it finds wrong all the same: it would count for every mistake.
    pub(super) fn settle(&mut self, tree: &Path) -> Result<(), String> {
        let begun = Instant::now();
        let found = self.run(tree, 0, Duration::from_secs(1800))?;
        self.usual = begun.elapsed();
        match found {
            None => Ok(()),
            Some(what) => Err(format!("{what}, without any mistake")),
        }
    }

    /// What it takes without a mistake.
    pub(super) fn usual(&self) -> Duration {
        self.usual
    }

    /// What it finds wrong where this mistake is switched on, if anything. Taking six times as long as without it, and no less than half a
    /// minute more, is wrong, too: a mistake may keep a search from ending.
    pub(super) fn ask(&self, tree: &Path, switch: usize) -> Result<Option<String>, String> {
        self.run(tree, switch, 6 * self.usual + Duration::from_secs(30))
    }

    fn run(&self, tree: &Path, switch: usize, limit: Duration) -> Result<Option<String>, String> {
        use std::os::unix::process::CommandExt;
        let of_tests = self.of <= 1;
        let folder = if of_tests { "crates/feeler" } else { "." };
        // In a group of its own, which is ended as a whole.
        let mut child = Command::new("sh")
            .args(["-c", &format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\"")])
            .arg(&self.program)
            .args(&self.arguments)
            .current_dir(tree.join(folder))
            .env(SWITCH, switch.to_string())
            // The same cases every time; what one mistake fails must not be tried with the next.
            .env("PROPTEST_RNG_SEED", "1")
            .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "1")
            .env("PROPTEST_MAX_SHRINK_ITERS", "0")
            .env("RUST_BACKTRACE", "0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .process_group(0)
            .spawn()
            .map_err(|e| format!("{} cannot be started: {e}", self.program.display()))?;
        let (tell, told) = channel();
        let out = child.stdout.take();
        let reader = std::thread::spawn(move || {
            let lines = out.map(BufReader::new).into_iter().flat_map(BufRead::lines);
            for line in lines.map_while(Result::ok) {
                let _ = tell.send(line);
            }
        });
        let end = Instant::now() + limit;
        let found = loop {
            let left = end.saturating_duration_since(Instant::now());
            match told.recv_timeout(left) {
                Ok(line) => {
                    let test = line.strip_prefix("test ").filter(|_| of_tests);
                    if let Some(test) = test.and_then(|l| l.strip_suffix(" ... FAILED")) {
                        break Some(format!("{}: {test}", self.name));
                    }
                }
                Err(RecvTimeoutError::Timeout) => {
                    break Some(format!("{}: not done in time", self.name));
                }
                Err(RecvTimeoutError::Disconnected) => {
                    let status = child.wait().map_err(|e| e.to_string())?;
                    break (!status.success()).then(|| format!("{}: {status}", self.name));
                }
            }
        };
        let group = format!("-{}", child.id());
        if child.try_wait().map_err(|e| e.to_string())?.is_none() {
            let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
            let _ = child.wait();
        }
        let _ = reader.join();
        Ok(found)
    }
}
