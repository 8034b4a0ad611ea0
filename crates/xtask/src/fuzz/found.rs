//! What campaigns find, as scenes; and the oracle on what they kept.

use crate::truth::{oracle_of, truth_of};
use feeler::query::Options;
use feeler_corpus::{MODELS, Model, Verdict, judge};
use feeler_fuzz::{Distances, Scene, Target};
use feeler_gate::{Engine, FeelerEngine, asked, model_size};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

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
    /// Inputs that the campaign itself gave to the second method whole.
    pub(super) whole: usize,
    /// Of some of these, how well it knows the distances that they ask for.
    pub(super) distances: Distances,
    /// Inputs that there was no time for.
    pub(super) left: usize,
    /// What contradicts the oracle: the file, and why.
    pub(super) wrong: Vec<(PathBuf, String)>,
}

/// Inputs whose distances are asked for again, to count wide bounds.
const ASKED_AGAIN: usize = 16;

/// The inputs of a folder, those since a time first, otherwise in an order that is another one whenever their number is: whoever has no time for all has
/// a sample of them.
fn in_turn(folder: &Path, since: SystemTime) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths: Vec<PathBuf> = entries.map(|e| e.path()).collect();
    let count = paths.len() as u64;
    let mut keyed: Vec<_> = paths
        .into_iter()
        .map(|path| {
            let time = path.metadata().and_then(|m| m.modified());
            let is_old = time.is_ok_and(|t| t < since);
            // FNV-1a.
            let name = path.file_name().unwrap_or_default().as_encoded_bytes();
            let count = count.to_le_bytes();
            let key = count
                .iter()
                .chain(name)
                .fold(0xcbf2_9ce4_8422_2325, |h: u64, b| {
                    (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3)
                });
            (is_old, key, path)
        })
        .collect();
    keyed.sort();
    keyed.into_iter().map(|(_, _, path)| path).collect()
}

/// Puts inputs to the oracle, those since a time first, until `limit` is over.
pub(super) fn hold(target: &Target, folder: &Path, since: SystemTime, limit: Duration) -> Held {
    let mut held = Held::default();
    let Some(kind) = target.kind else {
        return held;
    };
    let paths = in_turn(folder, since);
    for path in &paths {
        let bytes = std::fs::read(path).unwrap_or_default();
        if !target.is_whole(&bytes) {
            continue;
        }
        held.whole += 1;
        if held.whole <= ASKED_AGAIN {
            let more = target.distances(&bytes);
            let all = &mut held.distances;
            all.asked += more.asked;
            all.wide += more.wide;
            all.fewer += more.fewer;
        }
    }
    let begun = Instant::now();
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

#[cfg(test)]
mod tests {
    use super::in_turn;
    use std::time::{Duration, SystemTime};

    #[test]
    fn new_inputs_first_and_then_a_sample() {
        let folder = std::env::temp_dir().join(format!("feeler-in-turn-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let write = |name: String, age: u64| {
            let file = std::fs::File::create(folder.join(name)).unwrap();
            let time = SystemTime::now() - Duration::from_secs(age);
            file.set_modified(time).unwrap();
        };
        let since = SystemTime::now() - Duration::from_secs(100);
        for i in 0..20 {
            write(format!("old-{i:02}"), 1000);
        }
        write("new-0".to_owned(), 10);
        let names = || -> Vec<String> {
            let all = in_turn(&folder, since);
            let name =
                |p: &std::path::PathBuf| p.file_name().unwrap().to_string_lossy().into_owned();
            all.iter().map(name).collect()
        };
        let first = names();
        assert_eq!((first.len(), first[0].as_str()), (21, "new-0"));
        assert!(!first[1..].is_sorted());
        // With one more the old ones come in another order.
        write("new-1".to_owned(), 10);
        let second = names();
        assert!(second[..2].iter().all(|n| n.starts_with("new")));
        assert_ne!(first[1..], second[2..]);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
