//! Where and of what a study was made.

use serde::Serialize;
use std::path::Path;
use std::process::Command;

/// Where and of what a study was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct About {
    /// The processor's own name.
    pub processor: String,
    /// How many threads it runs at once; one is used.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Of this program.
    pub version: String,
    /// The compiler that made it.
    pub compiler: String,
    /// The commit checked out in the folder of the corpus, with a `+` if files were changed since.
    pub commit: String,
}

impl About {
    /// Of this machine and this program; what cannot be found out is `unknown`.
    pub fn here(corpus: &Path) -> Self {
        let unknown = || "unknown".to_owned();
        let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let processor = cpuinfo
            .lines()
            .find_map(|l| l.strip_prefix("model name"))
            .map(|l| l.trim_start_matches([' ', '\t', ':']).to_owned());
        let git = |arguments: &[&str]| {
            let output = Command::new("git")
                .arg("-C")
                .arg(corpus)
                .args(arguments)
                .output()
                .ok()?;
            let text = String::from_utf8(output.stdout).ok()?;
            output.status.success().then(|| text.trim().to_owned())
        };
        let commit = git(&["rev-parse", "--short=12", "HEAD"]).map(|c| {
            let changed = git(&["status", "--porcelain"]).is_none_or(|s| !s.is_empty());
            format!("{c}{}", if changed { "+" } else { "" })
        });
        Self {
            processor: processor.unwrap_or_else(unknown),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            compiler: env!("FEELER_COMPILER").to_owned(),
            commit: commit.unwrap_or_else(unknown),
        }
    }
}
