//! The models that files are written of.

use feeler_io::{Document, Object, ObjectKind};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

fn find(dir: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(dir) else {
        return;
    };
    let mut paths: Vec<_> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            find(&path, found);
        } else if path
            .extension()
            .is_some_and(|e| e == "3dm" || e == "brep" || e == "step")
        {
            found.push(path);
        }
    }
}

/// The corpus's models, and those of `../shared/models` (or `FEELER_MODELS`) where they are.
pub(crate) fn models() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut found = Vec::new();
    find(&root.join("corpora/models"), &mut found);
    let shared = std::env::var_os("FEELER_MODELS");
    find(
        &shared.map_or_else(|| root.join("../shared/models"), PathBuf::from),
        &mut found,
    );
    found
}

/// The objects that a file is written of.
pub(crate) fn wanted(document: &Document) -> Vec<Cow<'_, Object>> {
    let own = document.objects.iter().enumerate();
    let own = own.filter(|(_, o)| !o.block_member);
    let all = own.flat_map(|(i, _)| document.parts(i));
    let all = all.filter(|o| {
        !matches!(
            o.kind,
            ObjectKind::Mesh | ObjectKind::Other(_) | ObjectKind::Refused { .. }
        )
    });
    all.collect()
}
