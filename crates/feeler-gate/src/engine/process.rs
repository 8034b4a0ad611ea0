//! Engines outside the process: programs that speak the query protocol.
//!
//! A program is started for each model. The first line it reads names the model, the first it writes
//! introduces it; then it reads a query a line and writes an answer a line. Each query carries an `id` of
//! ours, which its answer must repeat, so that a line that came too late is never taken for another answer.
//!
//! Whatever the program does, the run goes on: an answer that does not come in time, is none, or cannot
//! come because the program has ended, makes the query count as refused. A program that
//! ended or was killed is started again with the same model at the next query.
//!
//! Times of queries include the way through two pipes, some ten microseconds.

mod running;

use super::Engine;
use feeler_corpus::{Answer, Body, Model, Query, QueryLine};
use running::{Running, Silence};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// In which form a program gets its models.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModelForm {
    /// As our own model files, not compressed, written into this folder: what a .3dm file holds after import,
    /// so that a program need read one format only.
    Json(PathBuf),
    /// The files of the corpus as they are: `.3dm`, `.json` and `.json.gz`.
    File,
}

/// How a program is treated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProcessOptions {
    /// How long it may take for an answer; then it is killed.
    pub timeout: Duration,
    /// How long it may take to introduce itself, which includes reading and preparing the model.
    pub start_timeout: Duration,
    /// What it reads.
    pub models: ModelForm,
}

impl Default for ProcessOptions {
    /// 30 s an answer: over ten times the slowest seen of another system (OCCT 8.0: 2.15 s for a ball in the middle of its socket), and
    /// ten times that to start.
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(30),
            start_timeout: Duration::from_secs(300),
            models: ModelForm::Json(PathBuf::from("target/gate/models")),
        }
    }
}

/// The first line that a program writes. Fields beyond these are its own affair.
#[derive(Clone, Debug, Deserialize)]
struct Introduction {
    engine: String,
    version: String,
    faces: usize,
    /// The kinds of queries it treats, by the protocol's words; all of them where it does not say.
    treats: Option<Vec<String>>,
}

/// The words of all kinds of queries.
const KINDS: [&str; 7] = [
    "sphere",
    "half_space",
    "line",
    "side",
    "inside",
    "evaluate",
    "split",
];

/// A program as an engine.
#[derive(Debug)]
pub struct ProcessEngine {
    line: String,
    words: Vec<String>,
    options: ProcessOptions,
    /// The first line for the open model, and how many faces that has.
    model: Option<(Value, usize)>,
    /// None between its end and the next query.
    running: Option<Running>,
    /// The latest introduction.
    introduction: Option<Introduction>,
    /// Why it could not be started again for the open model; it is not tried twice.
    broken: Option<String>,
    queries: u64,
}

impl ProcessEngine {
    /// An engine started by this command line, split into words as a shell would; no shell is run.
    ///
    /// # Errors
    /// No words, or no such program: it is started once to see, and ended at once.
    pub fn new(line: &str, options: ProcessOptions) -> Result<Self, String> {
        let words = shlex::split(line)
            .filter(|w| !w.is_empty())
            .ok_or_else(|| {
                format!("`{line}`: no command line; check its quotes, or give `sh -c '...'`")
            })?;
        drop(Running::start(&words)?);
        Ok(Self {
            line: line.to_owned(),
            words,
            options,
            model: None,
            running: None,
            introduction: None,
            broken: None,
            queries: 0,
        })
    }

    /// Starts the program with the open model and reads its introduction.
    fn start(&mut self) -> Result<(), String> {
        let (first, faces) = self.model.as_ref().ok_or("no model is open")?;
        let mut running = Running::start(&self.words)?;
        running.send(first.to_string());
        let within = self.options.start_timeout;
        let line = match running.line(Instant::now() + within) {
            Ok(line) => line,
            Err(Silence::Late) => return Err(format!("no first line within {within:?}")),
            Err(Silence::Ended) => return Err(format!("before its first line {}", running.end())),
        };
        let introduction = introduction(&line)?;
        if introduction.faces != *faces {
            return Err(format!(
                "it counts {} faces, and the model has {faces}",
                introduction.faces
            ));
        }
        self.introduction = Some(introduction);
        self.running = Some(running);
        Ok(())
    }

    fn ask(&mut self, query: &Query) -> Result<Body, String> {
        if let Some(why) = &self.broken {
            return Err(why.clone());
        }
        if self.running.is_none()
            && let Err(why) = self.start()
        {
            let why = format!("not started again: {why}");
            self.broken = Some(why.clone());
            return Err(why);
        }
        let Some(running) = &mut self.running else {
            return Err("not running".to_owned());
        };
        self.queries += 1;
        let id = self.queries;
        let mut line = QueryLine::from(query);
        line.id = Some(id.into());
        running.send(line.to_text());
        let within = self.options.timeout;
        let deadline = Instant::now() + within;
        loop {
            let text = match running.line(deadline) {
                Ok(text) => text,
                Err(silence) => {
                    let why = match silence {
                        Silence::Late => format!("no answer within {within:?}; killed"),
                        Silence::Ended => running.end(),
                    };
                    // Dropping kills.
                    self.running = None;
                    return Err(why);
                }
            };
            match whose(&text, id) {
                Whose::Past => {}
                Whose::This => {
                    let answer = Answer::read(&text, query).map_err(|e| e.to_string())?;
                    return Ok(answer.body);
                }
                Whose::Nobodys => return Err("the answer does not repeat the query's id".into()),
            }
        }
    }

    /// The path by which the program gets a model.
    fn path_of(&self, model: &Model) -> Result<PathBuf, String> {
        let ModelForm::Json(folder) = &self.options.models else {
            return Ok(model.path.clone());
        };
        /// So many hexadecimal digits of the hash tell models of one name apart.
        const DIGITS: usize = 12;
        let hash = model.hash();
        let stem = model.path.file_name().unwrap_or_default().to_string_lossy();
        let stem = stem.split('.').next().unwrap_or_default();
        let name = format!("{stem}-{}", hash.get(..DIGITS).unwrap_or(&hash));
        // Several engines may write it at once: each writes its own, and all of them are the same.
        static WRITTEN: AtomicU64 = AtomicU64::new(0);
        let nth = WRITTEN.fetch_add(1, Ordering::Relaxed);
        let own = folder.join(format!("{name}.{}-{nth}.json", std::process::id()));
        let path = folder.join(format!("{name}.json"));
        let unwritten = |e: String| format!("the model cannot be written: {e}");
        std::fs::create_dir_all(folder).map_err(|e| unwritten(e.to_string()))?;
        Model::write(&own, &model.breps, None).map_err(|e| unwritten(e.to_string()))?;
        std::fs::rename(&own, &path).map_err(|e| unwritten(e.to_string()))?;
        Ok(path)
    }
}

enum Whose {
    /// The answer to this query, or no answer at all, which is charged to it.
    This,
    /// The answer to a query before, which came after what was charged to that one.
    Past,
    /// An answer that does not say to what.
    Nobodys,
}

fn whose(text: &str, id: u64) -> Whose {
    let Ok(fields) = serde_json::from_str::<Map<String, Value>>(text) else {
        return Whose::This;
    };
    match fields.get("id").map(Value::as_u64) {
        Some(Some(of)) if of == id => Whose::This,
        Some(Some(of)) if of < id => Whose::Past,
        // A program that could not read the query cannot know its id.
        None if fields.contains_key("error") => Whose::This,
        _ => Whose::Nobodys,
    }
}

fn introduction(line: &str) -> Result<Introduction, String> {
    /// How much of a line that is no introduction is shown.
    const SHOWN: usize = 80;
    let shown: String = line.chars().take(SHOWN).collect();
    let Ok(fields) = serde_json::from_str::<Map<String, Value>>(line) else {
        return Err(format!(
            "its first line is not an object of JSON: `{shown}`"
        ));
    };
    if let Some(error) = fields.get("error") {
        let error = error
            .as_str()
            .map_or_else(|| error.to_string(), str::to_owned);
        return Err(error);
    }
    let introduction: Introduction = serde_json::from_value(Value::Object(fields))
        .map_err(|e| format!("its first line does not introduce it: {e}: `{shown}`"))?;
    let treats = introduction.treats.iter().flatten();
    if let Some(unknown) = treats.into_iter().find(|t| !KINDS.contains(&t.as_str())) {
        let known = KINDS.join(", ");
        return Err(format!("it treats `{unknown}`, which is none of {known}"));
    }
    Ok(introduction)
}

impl Engine for ProcessEngine {
    fn name(&self) -> String {
        match &self.introduction {
            Some(i) => format!("{} {}", i.engine, i.version),
            None => self.line.clone(),
        }
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        if let Some(running) = self.running.take() {
            running.stop();
        }
        self.broken = None;
        let path = self.path_of(model)?;
        let first = json!({"model": path.to_string_lossy(), "accuracy": "full"});
        self.model = Some((first, model.faces()));
        self.start()
    }

    fn answer(&mut self, query: &Query) -> Answer {
        Answer {
            id: query.id.clone(),
            body: self
                .ask(query)
                .unwrap_or_else(|error| Body::Error { error }),
        }
    }

    fn treats(&self, query: &Query) -> bool {
        let treats = self.introduction.as_ref().and_then(|i| i.treats.as_ref());
        treats.is_none_or(|all| all.iter().any(|t| t == query.ask.word()))
    }

    fn repeats(&self, query: &Query) -> Option<String> {
        let (first, _) = self.model.as_ref()?;
        let query = QueryLine::from(query).to_text();
        // Both are JSON: they hold no NUL, which alone cannot be quoted.
        let [first, query] =
            [&first.to_string(), &query].map(|text| shlex::try_quote(text).map(|t| t.into_owned()));
        let line = &self.line;
        Some(format!(
            "printf '%s\\n' {} {} | {line}",
            first.ok()?,
            query.ok()?
        ))
    }
}

impl Drop for ProcessEngine {
    fn drop(&mut self) {
        if let Some(running) = self.running.take() {
            running.stop();
        }
    }
}
