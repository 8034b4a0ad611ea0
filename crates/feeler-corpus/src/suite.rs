//! Suites of queries with their truth, as files.

use crate::files::{COMPRESSED, read_text, write_text};
use crate::query::{Query, QueryError, QueryLine};
use crate::truth::{Truth, TruthHeader};
use crate::{ModelError, bytes_hash};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The folder of a corpus that holds the models.
pub const MODELS: &str = "models";
const SUITE_FILE: &str = "suite.json";
const QUERIES: &str = ".jsonl";
const TRUTH: &str = ".truth.jsonl";

/// What a suite must not exceed. What is left out is 0, or for errors and time not held
/// against anything.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ceilings {
    /// Wrong answers.
    #[serde(default)]
    pub wrong: usize,
    /// Answers that the stored truth cannot judge.
    #[serde(default)]
    pub indeterminate: usize,
    /// Answers with a bound wider than asked, or none.
    #[serde(default)]
    pub undecided: usize,
    /// Answers of which nothing was proven.
    #[serde(default)]
    pub unbounded: usize,
    /// Worst error of a decided answer in ulp of the true value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_ulp: Option<f64>,
    /// Worst error of a decided answer in model units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_length: Option<f64>,
    /// Worst relative error of a first derivative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub derivative_error: Option<f64>,
}

/// `suite.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteFile {
    /// What the suite is about.
    pub description: String,
    /// What it must not exceed.
    pub ceilings: Ceilings,
}

/// A query file of a suite, not yet read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QueryFile {
    /// `NAME.jsonl` or `NAME.jsonl.gz`.
    pub queries: PathBuf,
    /// `NAME.truth.jsonl`, compressed where the queries are.
    pub truth: PathBuf,
}

/// A folder of queries and their truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Suite {
    /// The folder's name.
    pub name: String,
    /// What `suite.json` says.
    pub file: SuiteFile,
    /// Its query files, by name.
    pub files: Vec<QueryFile>,
}

/// One query of a corpus.
#[derive(Clone, Debug, PartialEq)]
pub struct CorpusQuery {
    /// The query as written.
    pub line: QueryLine,
    /// The query, checked.
    pub query: Query,
    /// The model, a path from the corpus's `models` folder.
    pub model: String,
    /// The line's number in its file, from 1.
    pub number: usize,
}

/// What is wrong with a corpus. Each message is one line that names the place and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum CorpusError {
    /// A file or folder cannot be read.
    #[error("{}: {error}; check the path and its permissions", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// A file says what cannot be understood.
    #[error("{}:{number}: {error}", path.display())]
    Json {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        number: usize,
        /// Why.
        error: serde_json::Error,
    },
    /// A query that is refused.
    #[error("{}:{number}: {error}", path.display())]
    Query {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        number: usize,
        /// Why.
        error: QueryError,
    },
    /// A query without a model.
    #[error("{}:{number}: the query names no model", path.display())]
    NoModel {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        number: usize,
    },
    /// A model that cannot be read.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A truth that was made for something else.
    #[error("{}: made for other {what}; run `cargo xtask truth`", path.display())]
    Stale {
        /// The truth file.
        path: PathBuf,
        /// What has changed.
        what: String,
    },
    /// No suite there.
    #[error("{}: no suite{} there (a folder with {SUITE_FILE})", path.display(), name.as_ref().map(|n| format!(" `{n}`")).unwrap_or_default())]
    NoSuite {
        /// The corpus.
        path: PathBuf,
        /// The suite asked for.
        name: Option<String>,
    },
}

fn read(path: &Path) -> Result<String, CorpusError> {
    read_text(path).map_err(|error| CorpusError::Io {
        path: path.to_path_buf(),
        error,
    })
}

fn entries(path: &Path) -> Result<Vec<PathBuf>, CorpusError> {
    let io = |error| CorpusError::Io {
        path: path.to_path_buf(),
        error,
    };
    let mut all = Vec::new();
    for entry in std::fs::read_dir(path).map_err(io)? {
        all.push(entry.map_err(io)?.path());
    }
    all.sort();
    Ok(all)
}

/// The suites of a corpus by name, or the one named.
pub fn suites(corpus: &Path, name: Option<&str>) -> Result<Vec<Suite>, CorpusError> {
    let mut found = Vec::new();
    for folder in entries(corpus)? {
        let suite_file = folder.join(SUITE_FILE);
        let own = folder.file_name().unwrap_or_default().to_string_lossy();
        if !suite_file.is_file() || name.is_some_and(|n| n != own) {
            continue;
        }
        let file =
            serde_json::from_str(&read(&suite_file)?).map_err(|error| CorpusError::Json {
                number: error.line(),
                path: suite_file.clone(),
                error,
            })?;
        let mut files = Vec::new();
        for path in entries(&folder)? {
            files.extend(QueryFile::at(path));
        }
        found.push(Suite {
            name: own.into_owned(),
            file,
            files,
        });
    }
    if found.is_empty() {
        return Err(CorpusError::NoSuite {
            path: corpus.to_path_buf(),
            name: name.map(str::to_owned),
        });
    }
    Ok(found)
}

impl QueryFile {
    /// The query file of this path, if its name says that it is one.
    fn at(queries: PathBuf) -> Option<Self> {
        let name = queries.file_name()?.to_str()?;
        let (plain, compressed) = match name.strip_suffix(COMPRESSED) {
            Some(plain) => (plain, COMPRESSED),
            None => (name, ""),
        };
        let stem = plain.strip_suffix(QUERIES)?;
        if plain.ends_with(TRUTH) {
            return None;
        }
        let truth = queries.with_file_name(format!("{stem}{TRUTH}{compressed}"));
        Some(Self { queries, truth })
    }

    /// The name of the file of queries.
    pub fn name(&self) -> String {
        let name = self.queries.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// The queries in order, and the hash of the file.
    pub fn queries(&self) -> Result<(Vec<CorpusQuery>, String), CorpusError> {
        let text = read(&self.queries)?;
        let mut all = Vec::new();
        for (i, text) in text.lines().enumerate() {
            let number = i + 1;
            let query = |error| CorpusError::Query {
                path: self.queries.clone(),
                number,
                error,
            };
            let line = QueryLine::parse(text).map_err(query)?;
            let checked = line.query().map_err(query)?;
            let Some(model) = line.model.clone() else {
                return Err(CorpusError::NoModel {
                    path: self.queries.clone(),
                    number,
                });
            };
            all.push(CorpusQuery {
                line,
                query: checked,
                model,
                number,
            });
        }
        Ok((all, bytes_hash(text.as_bytes())))
    }

    /// The stored truth, which must be that of query files with this hash and be as many.
    pub fn truth(
        &self,
        queries: usize,
        hash: &str,
    ) -> Result<(TruthHeader, Vec<Truth>), CorpusError> {
        let text = read(&self.truth)?;
        let json = |number: usize| {
            move |error| CorpusError::Json {
                path: self.truth.clone(),
                number,
                error,
            }
        };
        let stale = |what: &str| CorpusError::Stale {
            path: self.truth.clone(),
            what: what.to_owned(),
        };
        let mut lines = text.lines();
        let header: TruthHeader =
            serde_json::from_str(lines.next().unwrap_or_default()).map_err(json(1))?;
        if header.queries != hash {
            return Err(stale("queries"));
        }
        let all = lines
            .enumerate()
            .map(|(i, line)| serde_json::from_str(line).map_err(json(i + 2)))
            .collect::<Result<Vec<_>, _>>()?;
        if all.len() != queries {
            return Err(stale("queries"));
        }
        Ok((header, all))
    }

    /// Writes the truth, the whole of it or nothing.
    pub fn write_truth(&self, header: &TruthHeader, truths: &[Truth]) -> Result<(), CorpusError> {
        let mut text = serde_json::to_string(header).unwrap_or_default();
        text.push('\n');
        for truth in truths {
            text.push_str(&serde_json::to_string(truth).unwrap_or_default());
            text.push('\n');
        }
        write_text(&self.truth, &text).map_err(|error| CorpusError::Io {
            path: self.truth.clone(),
            error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::trim::Side;

    #[test]
    fn queries_and_truth_are_read_compressed_or_not() {
        let folder = std::env::temp_dir().join(format!("feeler-suite-{}", std::process::id()));
        let suite = folder.join("some");
        std::fs::create_dir_all(&suite).unwrap();
        std::fs::write(
            suite.join(SUITE_FILE),
            r#"{"description": "d", "ceilings": {}}"#,
        )
        .unwrap();
        let text = "{\"model\":\"m\",\"side\":{\"face\":0,\"uv\":[0.0,0.1]}}\n";
        for name in ["a.jsonl", "b.jsonl.gz"] {
            write_text(&suite.join(name), text).unwrap();
        }
        let found = suites(&folder, Some("some")).unwrap();
        assert_eq!(found[0].files.len(), 2);
        let header = TruthHeader {
            oracle: "o".to_owned(),
            queries: bytes_hash(text.as_bytes()),
            models: Default::default(),
        };
        let truth = [Truth::Side {
            side: Side::Inside,
            in_gap: Some(true),
        }];
        for (file, name) in found[0]
            .files
            .iter()
            .zip(["a.truth.jsonl", "b.truth.jsonl.gz"])
        {
            let (queries, hash) = file.queries().unwrap();
            assert_eq!((queries.len(), &hash), (1, &header.queries));
            file.write_truth(&header, &truth).unwrap();
            assert!(suite.join(name).exists());
            assert_eq!(file.truth(1, &hash).unwrap().1, truth);
            assert!(file.truth(2, &hash).is_err());
            assert!(file.truth(1, "other").is_err());
        }
        // Truth files are no query files.
        assert_eq!(suites(&folder, None).unwrap()[0].files, found[0].files);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
