//! What campaigns find, as scenes; and the oracle on what they kept.

use crate::truth::{oracle_of, truth_of};
use feeler::query::Options;
use feeler_corpus::{MODELS, Model, Verdict, judge};
use feeler_fuzz::{Scene, Target};
use feeler_gate::{Engine, FeelerEngine, asked, model_size};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Writes a scene into a corpus: the model, and its queries at the end of the target's file.
pub(super) fn write(out: &Path, target: &Target, name: &str, scene: &Scene) -> Result<(), String> {
    let io = |path: &Path| {
        let path = path.display().to_string();
        move |e: std::io::Error| format!("{path}: {e}")
    };
    let model = format!("found/{name}.json.gz");
    let path = out.join(MODELS).join(&model);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(io(folder))?;
    }
    Model::write(&path, std::slice::from_ref(&scene.brep), None).map_err(|e| e.to_string())?;
    let folder = out.join("found");
    std::fs::create_dir_all(&folder).map_err(io(&folder))?;
    let suite = folder.join("suite.json");
    if !suite.exists() {
        let content = "{\n  \"description\": \"scenes that campaigns of fuzzing found\",\n  \
                       \"ceilings\": {\n    \"wrong\": 0,\n    \"indeterminate\": 0\n  }\n}\n";
        std::fs::write(&suite, content).map_err(io(&suite))?;
    }
    let file = folder.join(format!("{}.jsonl", target.name));
    let mut text = std::fs::read_to_string(&file).unwrap_or_default();
    for q in &scene.queries {
        let mut line = q.clone();
        line.model = Some(model.clone());
        let line = line.to_text();
        if !text.lines().any(|l| l == line) {
            text += &line;
            text.push('\n');
        }
    }
    std::fs::write(&file, text).map_err(io(&file))
}

/// What became of the inputs that were kept for their coverage.
#[derive(Debug, Default)]
pub(super) struct Held {
    /// Queries with a truth.
    pub(super) judged: usize,
    /// Queries for which the oracle has none.
    pub(super) open: usize,
    /// Inputs that the campaign itself gave to the second method whole, and of these those with fewer boxes, for their degree.
    pub(super) whole: [usize; 2],
    /// Inputs that there was no time for.
    pub(super) left: usize,
    /// What contradicts the oracle: the file, and why.
    pub(super) wrong: Vec<(PathBuf, String)>,
}

/// Puts inputs to the oracle, until the time is over.
pub(super) fn hold(target: &Target, folder: &Path, limit: Duration) -> Held {
    let mut held = Held::default();
    let Some(kind) = target.kind else {
        return held;
    };
    let begun = Instant::now();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|e| e.path()).collect();
    paths.sort();
    for path in &paths {
        let bytes = std::fs::read(path).unwrap_or_default();
        if let Some(fewer) = target.is_whole(&bytes) {
            held.whole[0] += 1;
            held.whole[1] += usize::from(fewer);
        }
    }
    for path in paths {
        if begun.elapsed() > limit {
            held.left += 1;
            continue;
        }
        let bytes = std::fs::read(&path).unwrap_or_default();
        let Some(scene) = Scene::decode(kind, &bytes) else {
            continue;
        };
        if let Err(why) = one(&scene, &path, &mut held) {
            held.wrong.push((path, why));
        }
    }
    held
}

fn one(scene: &Scene, path: &Path, held: &mut Held) -> Result<(), String> {
    let model = Model {
        path: path.to_path_buf(),
        breps: vec![scene.brep.clone()],
    };
    let size = model_size(&model);
    let mut engine = FeelerEngine::new(Options::default());
    engine.open(&model)?;
    let Ok(oracle) = oracle_of(&model) else {
        held.open += scene.queries.len();
        return Ok(());
    };
    for line in &scene.queries {
        let Ok(query) = line.query() else { continue };
        let Ok(truth) = truth_of(&oracle, &query, size) else {
            held.open += 1;
            continue;
        };
        let answer = engine.answer(&query);
        let found = judge(&asked(&query, size, 0.0), &answer.body, &truth);
        held.judged += 1;
        if found.verdict == Verdict::Wrong {
            let why = found.reason.unwrap_or_default();
            return Err(format!("{why}\n{}", line.to_text()));
        }
    }
    Ok(())
}
