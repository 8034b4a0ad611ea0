//! Runs `reference.py` and reads what it prints.

use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::Command;

#[derive(Deserialize)]
pub(crate) struct File {
    pub(crate) file: String,
    pub(crate) objects: usize,
    pub(crate) breps: Vec<Brep>,
    pub(crate) surfaces: Vec<SurfaceObject>,
    pub(crate) curves: Vec<Curve>,
}

#[derive(Deserialize)]
pub(crate) struct Brep {
    pub(crate) object: usize,
    pub(crate) counts: Counts,
    pub(crate) loops: Vec<Vec<Trim>>,
    pub(crate) faces: Vec<Face>,
    pub(crate) edges: Vec<Vec<[f64; 3]>>,
    pub(crate) vertices: Vec<[f64; 3]>,
}

#[derive(Debug, Deserialize, PartialEq)]
pub(crate) struct Counts {
    pub(crate) faces: usize,
    pub(crate) loops: usize,
    pub(crate) trims: usize,
    pub(crate) edges: usize,
    pub(crate) vertices: usize,
}

#[derive(Deserialize)]
pub(crate) struct Trim {
    pub(crate) edge: i64,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

#[derive(Deserialize)]
pub(crate) struct Face {
    pub(crate) reversed: bool,
    #[serde(flatten)]
    pub(crate) surface: Surface,
}

#[derive(Deserialize)]
pub(crate) struct Surface {
    pub(crate) domain: [f64; 4],
    /// u, v, x, y, z.
    pub(crate) points: Vec<[f64; 5]>,
}

#[derive(Deserialize)]
pub(crate) struct SurfaceObject {
    pub(crate) object: usize,
    #[serde(flatten)]
    pub(crate) surface: Surface,
}

#[derive(Deserialize)]
pub(crate) struct Curve {
    pub(crate) object: usize,
    pub(crate) points: Vec<[f64; 3]>,
}

/// Python with rhino3dm; `None`, said aloud, where there is none. `FEELER_PYTHON` names the interpreter (default `python3`).
pub(crate) fn python() -> Option<Command> {
    let python = std::env::var_os("FEELER_PYTHON");
    let required = python.is_some();
    let python = python.unwrap_or_else(|| "python3".into());
    let available = Command::new(&python)
        .args(["-c", "import rhino3dm"])
        .output()
        .is_ok_and(|o| o.status.success());
    if available {
        return Some(Command::new(&python));
    }
    // Named explicitly, it must be there.
    assert!(!required, "FEELER_PYTHON has no rhino3dm: {python:?}");
    eprintln!("SKIPPED: no python3 with rhino3dm (pip install rhino3dm, or set FEELER_PYTHON)");
    None
}

/// What rhino3dm reads from `files`, in their order; `None` where there is none.
pub(crate) fn read(files: &[PathBuf]) -> Option<Vec<File>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("import/reference.py");
    let output = python()?
        .arg(script)
        .args(files)
        .output()
        .expect("python runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "reference.py failed: {errors}");
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    let parsed: Vec<File> = lines
        .lines()
        .map(|l| serde_json::from_str(l).expect("a line of reference.py"))
        .collect();
    assert_eq!(parsed.len(), files.len(), "one line a file");
    Some(parsed)
}
