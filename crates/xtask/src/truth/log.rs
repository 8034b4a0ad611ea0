//! Results of a run that has not ended, so that the next one goes on from there.

use feeler_corpus::{Truth, bytes_hash};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// A file of truths, a line each, appended to as they are found. Each is known by a key made of all that
/// it depends on: the oracle's sources, the model, and the query.
pub(crate) struct Log {
    path: PathBuf,
    file: Mutex<File>,
    known: HashMap<String, Truth>,
}

#[derive(Serialize, Deserialize)]
struct Line {
    key: String,
    truth: Truth,
}

/// What a truth depends on.
pub(crate) fn key(sources: &str, model: &str, query: &str) -> String {
    bytes_hash(format!("{sources}\n{model}\n{query}").as_bytes())
}

impl Log {
    /// The log at this path; new if there is none. A last line that was cut off is dropped.
    pub(crate) fn open(path: &Path) -> Result<Self, String> {
        let fail = |e: std::io::Error| format!("{}: {e}", path.display());
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(fail)?;
        }
        let mut known = HashMap::new();
        let mut whole = 0;
        // What is no text is no log of ours: begun again.
        if let Ok(text) = std::fs::read_to_string(path) {
            for line in text.split_inclusive('\n') {
                let read = line.strip_suffix('\n').map(serde_json::from_str::<Line>);
                let Some(Ok(line_read)) = read else { break };
                known.insert(line_read.key, line_read.truth);
                whole += line.len();
            }
        }
        let file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(path)
            .map_err(fail)?;
        file.set_len(whole as u64).map_err(fail)?;
        Ok(Self {
            path: path.to_path_buf(),
            file: Mutex::new(file),
            known,
        })
    }

    /// What an earlier run found.
    pub(crate) fn get(&self, key: &str) -> Option<&Truth> {
        self.known.get(key)
    }

    /// Keeps a truth. A full disk loses it for the next run, not for this one.
    pub(crate) fn add(&self, key: String, truth: &Truth) {
        let line = Line {
            key,
            truth: truth.clone(),
        };
        let mut text = serde_json::to_string(&line).unwrap_or_default();
        text.push('\n');
        if let Ok(mut file) = self.file.lock() {
            // One write, so that lines of two threads do not mix.
            let _ = file.write_all(text.as_bytes());
        }
    }

    /// The run has ended and its results are kept elsewhere.
    pub(crate) fn remove(self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// A hash of the sources that decide a truth, so that the results of an older oracle are not taken for
/// those of this one.
pub(crate) fn sources_hash(root: &Path) -> Result<String, String> {
    let mut files = Vec::new();
    for folder in [
        "cpp",
        "crates/feeler-oracle/src",
        "crates/feeler/src",
        "crates/xtask/src/truth.rs",
        "Cargo.lock",
    ] {
        collect(&root.join(folder), &mut files)?;
    }
    files.sort();
    let mut all = String::new();
    for path in files {
        let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let name = path.strip_prefix(root).unwrap_or(&path);
        all += &format!("{} {}\n", name.display(), bytes_hash(&bytes));
    }
    Ok(bytes_hash(all.as_bytes()))
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let fail = |e: std::io::Error| format!("{}: {e}", path.display());
    if !path.is_dir() {
        files.push(path.to_path_buf());
        return Ok(());
    }
    for entry in std::fs::read_dir(path).map_err(fail)? {
        collect(&entry.map_err(fail)?.path(), files)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth(n: usize) -> Truth {
        Truth::Unknown {
            why: format!("reason {n}"),
        }
    }

    #[test]
    fn a_killed_run_is_gone_on_with() {
        let folder = std::env::temp_dir().join(format!("feeler-log-{}", std::process::id()));
        let path = folder.join("suite/queries.log");
        let log = Log::open(&path).unwrap();
        for n in 0..3 {
            log.add(format!("key {n}"), &truth(n));
        }
        assert!(log.get("key 0").is_none(), "only what earlier runs found");
        drop(log);
        // Killed while writing the last line.
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() - 5]).unwrap();
        let log = Log::open(&path).unwrap();
        assert_eq!(log.get("key 1"), Some(&truth(1)));
        assert_eq!(log.get("key 2"), None);
        log.add("key 2".to_owned(), &truth(2));
        drop(log);
        let log = Log::open(&path).unwrap();
        assert_eq!(log.get("key 2"), Some(&truth(2)));
        log.remove();
        assert!(!path.exists());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_key_tells_all_it_depends_on_apart() {
        let keys = [
            key("a", "b", "c"),
            key("x", "b", "c"),
            key("a", "x", "c"),
            key("a", "b", "x"),
        ];
        for i in 0..keys.len() {
            for j in 0..i {
                assert_ne!(keys[i], keys[j]);
            }
        }
    }
}
