//! Tests of the copy, what each reaches, and asking them about one change.

use crate::plant::MEMORY;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The number of the change that is switched on, or [`LEARN`].
pub(super) const SWITCH: &str = "FEELER_MUTANT";
/// Where the copy's kernel writes the numbers that it reaches.
const REACHED: &str = "FEELER_REACHED";
const LEARN: &str = "learn";

/// What takes this many times as long as without a change, and [`SPARE`] more, counts as caught: a change may keep a search from ending.
pub(super) const SLOWER: u32 = 10;
/// Other programs take the machine at times.
const SPARE: Duration = Duration::from_secs(5);
/// Without a change.
const LONGEST: Duration = Duration::from_secs(900);

/// What the copy's kernel asks: whether that change is switched on. `count` is more than the largest number.
pub(super) fn switch(count: usize) -> String {
    format!(
        r#"
#[inline]
pub(crate) fn mutant(n: usize) -> bool {{
    use std::sync::atomic::{{AtomicBool, AtomicUsize, Ordering}};
    const UNKNOWN: usize = usize::MAX;
    const LEARN: usize = usize::MAX - 1;
    static ON: AtomicUsize = AtomicUsize::new(UNKNOWN);
    static SEEN: [AtomicBool; {count}] = [const {{ AtomicBool::new(false) }}; {count}];
    #[cold]
    fn slow(n: usize, on: usize) -> bool {{
        if on == UNKNOWN {{
            let value = std::env::var("{SWITCH}").unwrap_or_default();
            let on = if value == "{LEARN}" {{ LEARN }} else {{ value.parse().unwrap_or(0) }};
            ON.store(on, Ordering::Relaxed);
            return on == n || (on == LEARN && slow(n, on));
        }}
        if !SEEN[n].swap(true, Ordering::Relaxed) {{
            use std::io::Write;
            let path = std::env::var("{REACHED}").expect("a path");
            let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
            file.expect("a file").write_all(format!("{{n}}\n").as_bytes()).expect("written");
        }}
        false
    }}
    let on = ON.load(Ordering::Relaxed);
    on == n || (on >= LEARN && slow(n, on))
}}
"#
    )
}

/// One test.
#[derive(Debug)]
pub(super) struct Test {
    program: PathBuf,
    pub(super) name: String,
    /// How long it takes without a change, alone.
    pub(super) usual: Duration,
    /// The changes it reaches.
    pub(super) reaches: BTreeSet<usize>,
}

/// What became of a change.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    /// By that test.
    Caught(String),
    /// All tests that reach it passed: so many.
    Left(usize),
    /// So did those that there was time for, of so many.
    LeftInTime(usize, usize),
}

enum End {
    Passed,
    Failed,
    Slow,
}

/// The tests of a program.
pub(super) fn tests(folder: &Path, program: &Path) -> Result<Vec<Test>, String> {
    let output = Command::new(program)
        .args(["--list", "--format", "terse"])
        .current_dir(folder)
        .output()
        .map_err(|e| format!("{}: {e}", program.display()))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let names = text.lines().filter_map(|l| l.strip_suffix(": test"));
    Ok(names
        .map(|name| Test {
            program: program.to_owned(),
            name: name.to_owned(),
            usual: Duration::ZERO,
            reaches: BTreeSet::new(),
        })
        .collect())
}

impl Test {
    /// Runs it without a change: how long it takes, what it reaches. Whether it passes.
    pub(super) fn learn(&mut self, folder: &Path, scratch: &Path) -> Result<bool, String> {
        let _ = std::fs::remove_file(scratch);
        let begun = Instant::now();
        let end = self.run(folder, LEARN, Some(scratch), LONGEST)?;
        self.usual = begun.elapsed();
        let text = std::fs::read_to_string(scratch).unwrap_or_default();
        self.reaches = text.lines().filter_map(|l| l.parse().ok()).collect();
        Ok(matches!(end, End::Passed))
    }

    fn run(
        &self,
        folder: &Path,
        switch: &str,
        reached: Option<&Path>,
        limit: Duration,
    ) -> Result<End, String> {
        use std::os::unix::process::CommandExt;
        let mut command = Command::new("sh");
        command
            .args(["-c", &format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\"")])
            .arg(&self.program)
            .args([&self.name, "--exact", "--test-threads=1"])
            .current_dir(folder)
            .env(SWITCH, switch)
            .env("PROPTEST_RNG_SEED", "1")
            .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "1")
            .env("PROPTEST_MAX_SHRINK_ITERS", "0")
            .env("RUST_BACKTRACE", "0")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0);
        if let Some(path) = reached {
            command.env(REACHED, path);
        }
        let mut child = command
            .spawn()
            .map_err(|e| format!("{} cannot be started: {e}", self.program.display()))?;
        wait(&mut child, limit).map_err(|e| format!("{}: {e}", self.name))
    }
}

fn wait(child: &mut Child, limit: Duration) -> std::io::Result<End> {
    let begun = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(if status.success() {
                End::Passed
            } else {
                End::Failed
            });
        }
        if begun.elapsed() > limit {
            let group = format!("-{}", child.id());
            let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
            child.wait()?;
            return Ok(End::Slow);
        }
        std::thread::sleep(pause);
        pause = (2 * pause).min(Duration::from_millis(50));
    }
}

/// Asks the tests, the quickest first, about a change, as long as there is time.
pub(super) fn ask(
    folder: &Path,
    tests: &[Test],
    number: usize,
    budget: Duration,
) -> Result<Verdict, String> {
    let begun = Instant::now();
    let reach: Vec<&Test> = tests
        .iter()
        .filter(|t| t.reaches.contains(&number))
        .collect();
    for (i, test) in reach.iter().enumerate() {
        if begun.elapsed() > budget {
            return Ok(Verdict::LeftInTime(i, reach.len()));
        }
        let limit = SLOWER * test.usual + SPARE;
        match test.run(folder, &number.to_string(), None, limit)? {
            End::Passed => {}
            End::Failed => return Ok(Verdict::Caught(test.name.clone())),
            End::Slow => return Ok(Verdict::Caught(format!("{}, not done in time", test.name))),
        }
    }
    Ok(Verdict::Left(reach.len()))
}
