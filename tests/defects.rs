//! What [`Brep::defects`](feeler::brep::Brep::defects) says of real parts, against what is known
//! of them from their writers.

use feeler::brep::{Defect, Severity};
use feeler_io::{ObjectKind, read_file};
use std::path::{Path, PathBuf};

/// The models beside the project (or at `FEELER_MODELS`); says so where there are none.
fn models(folder: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/models");
    let root = std::env::var_os("FEELER_MODELS").map_or(beside, PathBuf::from);
    let path = root.join(folder);
    if path.is_dir() {
        return Some(path);
    }
    eprintln!("SKIPPED: no models at {}", path.display());
    None
}

fn defects(path: &Path) -> Vec<Defect> {
    let document = read_file(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    document
        .objects
        .iter()
        .filter_map(|o| match &o.kind {
            ObjectKind::Brep(brep) => Some(brep.defects()),
            _ => None,
        })
        .flatten()
        .collect()
}

/// Parts made by construction fit to rounding; those that Rhino and OCCT made by intersecting surfaces fit
/// to the tolerances that they wrote beside them.
#[test]
fn deviations_are_those_that_files_admit() {
    if let Some(thesis) = models("thesis/3dm") {
        for name in [
            "cube",
            "cube_corner_cut",
            "cylinder_nurbs",
            "ball_joint_socket",
            "geneva4_wheel",
        ] {
            let found = defects(&thesis.join(name).with_extension("3dm"));
            assert_eq!(found, [], "{name}");
        }
        for name in ["sheet_trimmed", "shift_gate_straight"] {
            let found = defects(&thesis.join(name).with_extension("3dm"));
            // Deviations there are, but within tolerance.
            assert!(
                found
                    .iter()
                    .any(|d| matches!(d, Defect::EdgeOffSurface { .. })),
                "{name}"
            );
            assert!(
                found.iter().all(|d| d.severity() == Severity::Note),
                "{name}"
            );
        }
    }
    if let Some(real) = models("real") {
        for name in ["v3_T-Joint2_slim", "v4_MechPartA"] {
            let found = defects(&real.join(name).with_extension("3dm"));
            assert!(
                found
                    .iter()
                    .any(|d| matches!(d, Defect::EdgeOffSurface { .. })),
                "{name}"
            );
            for d in found {
                assert_eq!(d.severity(), Severity::Note, "{name}: {d}");
            }
        }
    }
}

/// Whether a part is closed is for its edges to say: MechPartA is a solid, the sheet is not.
#[test]
fn open_borders_are_found() {
    let borders = |path: &Path| {
        let found = defects(path);
        found
            .iter()
            .filter(|d| matches!(d, Defect::BoundaryEdge { .. }))
            .count()
    };
    if let Some(thesis) = models("thesis/3dm") {
        assert_eq!(borders(&thesis.join("sheet_untrimmed.3dm")), 4);
        assert_eq!(borders(&thesis.join("cube.3dm")), 0);
    }
    if let Some(real) = models("real") {
        assert_eq!(borders(&real.join("v4_MechPartA.3dm")), 0);
    }
}
