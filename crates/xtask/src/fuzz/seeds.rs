//! What a campaign starts from: the corpora.

use feeler::query::Probe;
use feeler_corpus::{Ask, MODELS, Model, QueryLine, suites};
use feeler_fuzz::{Kind, LARGEST_INPUT, Scene, Target};
use std::collections::BTreeMap;
use std::path::Path;

/// Queries of one scene.
const QUERIES: usize = 4;

fn kind(ask: &Ask) -> Kind {
    match ask {
        Ask::Side(..) => Kind::Side,
        Ask::Contact(Probe::Sphere(_)) | Ask::Arrival(..) => Kind::Sphere,
        Ask::Contact(Probe::HalfSpace(_)) => Kind::HalfSpace,
        Ask::Line(_) | Ask::Inside(_) => Kind::Line,
        Ask::Evaluate(..) => Kind::Evaluate,
        Ask::Split(_) => Kind::Split,
    }
}

/// Writes seeds of a target into a folder; how many.
pub(super) fn write(target: &Target, corpora: &Path, folder: &Path) -> Result<usize, String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut all: Vec<Vec<u8>> = match target.name {
        "read_3dm" => files(&corpora.join(MODELS).join("thesis"), "3dm"),
        "read_brep" => files(&corpora.join(MODELS).join("thesis"), "brep"),
        "read_step" => files(&corpora.join(MODELS).join("step"), "step"),
        "queries" => queries(corpora)?,
        _ => match target.kind {
            Some(kind) => scenes(corpora, kind)?,
            None => Vec::new(),
        },
    };
    all.retain(|bytes| bytes.len() <= LARGEST_INPUT);
    // Bytes of the structured form too: the engine knows nothing of it.
    all.extend((0..200).map(|n| feeler_fuzz::input(7, n)));
    for (i, bytes) in all.iter().enumerate() {
        let path = folder.join(format!("{i:04}"));
        std::fs::write(&path, bytes).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(all.len())
}

fn files(folder: &Path, extension: &str) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|e| e.path());
    let mut paths: Vec<_> = paths
        .filter(|p| p.extension().is_some_and(|e| e == extension))
        .collect();
    paths.sort();
    paths.iter().filter_map(|p| std::fs::read(p).ok()).collect()
}

/// By model, what asks this.
fn asked(corpora: &Path, of: Option<Kind>) -> Result<BTreeMap<String, Vec<QueryLine>>, String> {
    let text = |e: feeler_corpus::CorpusError| e.to_string();
    let mut all: BTreeMap<String, Vec<QueryLine>> = BTreeMap::new();
    for suite in suites(corpora, None).map_err(text)? {
        for file in &suite.files {
            for q in file.queries().map_err(text)?.0 {
                if of.is_none_or(|k| k == kind(&q.query.ask)) {
                    let mut line = q.line;
                    line.model = None;
                    all.entry(q.model).or_default().push(line);
                }
            }
        }
    }
    Ok(all)
}

fn queries(corpora: &Path) -> Result<Vec<Vec<u8>>, String> {
    let all = asked(corpora, None)?;
    let some = all.values().filter_map(|lines| lines.first());
    Ok(some.map(|l| l.to_text().into_bytes()).collect())
}

fn scenes(corpora: &Path, kind: Kind) -> Result<Vec<Vec<u8>>, String> {
    let mut all = Vec::new();
    for (name, mut queries) in asked(corpora, Some(kind))? {
        let path = corpora.join(MODELS).join(&name);
        let model = Model::load(&path, None).map_err(|e| e.to_string())?;
        let [brep] = &model.breps[..] else { continue };
        queries.truncate(QUERIES);
        let scene = Scene {
            brep: brep.clone(),
            queries,
        };
        all.push(scene.to_text().into_bytes());
    }
    Ok(all)
}
